//! Lights, materials and environments as a scene file says them.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::error::Fault;
use super::scene_file::refuse_special;
use super::spec::{AxesSpec, EnvironmentSpec, GlassSpec, LightSpec, MaterialSpec};
use crate::{Absorption, Alpha, Cone, Environment, Finish, Light, Material, Matter, Pigment};

/// Refractive index where none is given: window glass, plastics.
const USUAL_IOR: f32 = 1.5;

pub(super) fn light(spec: &LightSpec) -> Result<Light, Fault> {
    Ok(match *spec {
        LightSpec::Ambient { strength } => Light::Ambient { strength: strength.0.as_vec3() },
        LightSpec::Sun { toward, strength, size_deg } => {
            let size = size_deg.unwrap_or(0.0).to_radians();
            Light::sun_of_size(DVec3::from_array(toward), strength.0.as_vec3(), size)?
        }
        LightSpec::Point { at, strength } => {
            Light::Point { at: finite(at)?, strength: strength.0.as_vec3(), cone: None }
        }
        LightSpec::Spot { at, look_at, strength, inner_deg, outer_deg } => {
            let at = finite(at)?;
            let cone = Cone::new(finite(look_at)? - at, inner_deg.to_radians(), outer_deg.to_radians())?;
            Light::Point { at, strength: strength.0.as_vec3(), cone: Some(cone) }
        }
    })
}

fn finite(place: [f64; 3]) -> Result<DVec3, Fault> {
    let place = DVec3::from_array(place);
    if place.is_finite() { Ok(place) } else { Fault::says("a place must be finite") }
}

pub(super) fn material(name: &str, spec: &MaterialSpec) -> Result<(Material, Finish), Fault> {
    let is_glossy = spec.metallic.is_some() || spec.roughness.is_some();
    let pigment = match (&spec.color, &spec.checker) {
        (Some(_), Some(_)) => return Fault::says("give a color or a checker, not both"),
        (None, None) if spec.glass.is_some() => Pigment::Constant(Vec3::ONE),
        (None, None) if spec.emission.is_none() => return Fault::says("give a color, a checker or an emission"),
        (None, None) => Pigment::Constant(Vec3::ZERO),
        (Some(color), None) => Pigment::Constant(color.0.as_vec3()),
        (None, Some(checker)) => Pigment::Checker {
            colors: checker.colors.map(|color| color.0.as_vec3()),
            side: checker.side,
            axes: match checker.axes {
                AxesSpec::Xz => [0, 2],
                AxesSpec::Xy => [0, 1],
                AxesSpec::Yz => [1, 2],
            },
        },
    };
    let matter = match spec.glass {
        Some(_) if is_glossy || spec.ior.is_some() => {
            return Fault::says("glass is no metal, and its numbers go inside: glass = { ior = 1.5, roughness = 0.2 }");
        }
        Some(glass) => Matter::Glass {
            ior: glass.ior.unwrap_or(USUAL_IOR),
            thin: glass.thin,
            roughness: glass.roughness,
            absorption: absorption(&glass)?,
        },
        None if is_glossy => Matter::Glossy {
            metallic: spec.metallic.unwrap_or(0.0),
            roughness: spec.roughness.unwrap_or(0.0),
            ior: spec.ior.unwrap_or(USUAL_IOR),
        },
        None if spec.ior.is_some() => return Fault::says("an ior needs a roughness"),
        None => Matter::Matte,
    };
    if spec.area_light && spec.emission.is_none() {
        return Fault::says("an area light needs an emission");
    }
    let emission = spec.emission.map_or(Vec3::ZERO, |emission| emission.0.as_vec3());
    let finish = Finish {
        name: name.to_owned(),
        matter,
        alpha: if spec.opacity.is_some() { Alpha::Blend } else { Alpha::Opaque },
        opacity: spec.opacity.unwrap_or(1.0),
        is_light: spec.area_light,
        ..Finish::default()
    };
    Ok((Material { pigment, emission }, finish))
}

/// What glass takes away inside.
fn absorption(glass: &GlassSpec) -> Result<Option<Absorption>, Fault> {
    match (glass.attenuation_color, glass.attenuation_distance) {
        (None, None) => Ok(None),
        (Some(_), Some(_)) if glass.thin => {
            Fault::says("thin glass has no inside that could absorb; leave out thin or attenuation")
        }
        (Some(color), Some(distance)) => Ok(Some(Absorption::new(color.0.as_vec3(), distance)?)),
        _ => Fault::says("glass that absorbs needs both attenuation_color and attenuation_distance"),
    }
}

/// Reads the picture of all directions that lies at a path: OpenEXR or Radiance HDR.
pub(super) fn environment(spec: &EnvironmentSpec, path: &Path) -> Result<Environment, Fault> {
    let cannot = |reason: String| Fault::Says(format!("cannot take {path:?}: {reason}"));
    refuse_special(path).map_err(|error| cannot(error.to_string()))?;
    let extension = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let (width, height, mut texels) = match extension.as_deref() {
        Some("exr") => exr(path).map_err(|error| cannot(error.to_string()))?,
        Some("hdr") => hdr(path).map_err(|error| cannot(error.to_string()))?,
        _ => return Err(cannot("an environment is an .exr or .hdr".to_owned())),
    };
    let strength = spec.strength.map_or(Vec3::ONE, |strength| strength.0.as_vec3());
    if !(strength.is_finite() && strength.min_element() >= 0.0) {
        return Fault::says("the strength of an environment must be 0 or more, and finite");
    }
    texels.iter_mut().for_each(|texel| *texel *= strength);
    Ok(Environment::new(width, height, texels, spec.rotate_deg.to_radians())?)
}

type Texels = (usize, usize, Vec<Vec3>);

fn exr(path: &Path) -> Result<Texels, rgbd::ReadError> {
    let options = rgbd::ReadOptions { max_pixels: Environment::MOST_TEXELS as u64, ..Default::default() };
    let picture = rgbd::read_picture(path, &options)?.value;
    let window = picture.window();
    let texels = window.pixels().map(|(x, y)| Vec3::from_slice(&picture.at(x, y)[..3])).collect();
    Ok((window.width as usize, window.height as usize, texels))
}

fn hdr(path: &Path) -> Result<Texels, image::ImageError> {
    let mut reader = image::ImageReader::open(path)?;
    reader.set_format(image::ImageFormat::Hdr);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(1 << 30);
    reader.limits(limits);
    let picture = reader.decode()?.into_rgb32f();
    let texels = picture.pixels().map(|pixel| Vec3::from_array(pixel.0)).collect();
    Ok((picture.width() as usize, picture.height() as usize, texels))
}

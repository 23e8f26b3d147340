//! Materials of glTF 2.0.

use glam::{Mat2, Vec2, Vec3};
use gltf::image::Source;
use gltf::material::AlphaMode;
use gltf::texture::WrappingMode;

use super::gltf_access;
use super::resources::Resources;
use crate::{Absorption, Alpha, Encoding, Finish, Material, Matter, Pigment, TextureMap, Wrap};

/// Reads materials, with the pictures that they name.
pub(super) struct Materials<'a> {
    pub(super) resources: &'a mut Resources,
    pub(super) buffers: &'a [Vec<u8>],
}

impl Materials<'_> {
    /// Base colour, metallic-roughness, emission, normals and alpha.
    ///
    /// What is rough all over (1) and no metal is taken as matte: its coat would add a pale, nearly even sheen.
    pub(super) fn read(&mut self, source: &gltf::Material<'_>) -> (Material, Finish) {
        let base = source.pbr_metallic_roughness();
        let [r, g, b, opacity] = base.base_color_factor().map(clean);
        let strength = clean(source.emissive_strength().unwrap_or(1.0));
        let emission = Vec3::from_array(source.emissive_factor().map(clean)) * strength;
        let mut material = Material { pigment: Pigment::Constant(Vec3::new(r, g, b)), emission };
        let mut finish = Finish {
            name: source.name().unwrap_or_default().to_owned(),
            color_map: base.base_color_texture().and_then(|info| self.map(&info, Encoding::Color)),
            opacity: opacity.min(1.0),
            alpha: match source.alpha_mode() {
                AlphaMode::Opaque => Alpha::Opaque,
                AlphaMode::Mask => Alpha::Mask(source.alpha_cutoff().unwrap_or(0.5)),
                AlphaMode::Blend => Alpha::Blend,
            },
            is_light: emission != Vec3::ZERO,
            is_double_sided: source.double_sided(),
            ..Finish::default()
        };
        if source.unlit() {
            // Its colour is what is seen
            material = Material::glowing(Vec3::new(r, g, b));
            finish.emission_map = finish.color_map.clone();
            finish.is_light = false;
            return (material, finish);
        }
        if emission != Vec3::ZERO {
            finish.emission_map = source.emissive_texture().and_then(|info| self.map(&info, Encoding::Color));
        }
        finish.normal_map = source.normal_texture().and_then(|normal| {
            let map = self.picture(&normal.texture(), normal.tex_coord(), Encoding::Data)?;
            Some((map, normal.scale()))
        });

        // How it reflects
        let [metallic, roughness] = [base.metallic_factor(), base.roughness_factor()].map(|x| clean(x).min(1.0));
        let surface_map = base.metallic_roughness_texture();
        let ior = clean(source.ior().unwrap_or(1.5)).clamp(1.0, 4.0);
        let ior = source.specular().map_or(ior, |specular| {
            // A coat that reflects less or more is one of another index
            let color = specular.specular_color_factor().map(clean);
            let factor = clean(specular.specular_factor()) * (color[0] + color[1] + color[2]) / 3.0;
            let f0 = (((ior - 1.0) / (ior + 1.0)).powi(2) * factor).min(0.36);
            (1.0 + f0.sqrt()) / (1.0 - f0.sqrt())
        });
        let transmission = source.transmission().map_or(0.0, |transmission| clean(transmission.transmission_factor()));
        let is_matte = metallic == 0.0 && (roughness >= 1.0 && surface_map.is_none() || ior <= 1.0);
        if transmission >= 0.5 {
            let ior = source.ior().map_or(1.5, clean).clamp(1.0, 4.0);
            let volume = source.volume().filter(|volume| clean(volume.thickness_factor()) > 0.0);
            let absorption = volume.as_ref().and_then(|volume| {
                // A distance that is not finite stands for glass that absorbs nothing
                let color = Vec3::from_array(volume.attenuation_color().map(|x| clean(x).min(1.0)));
                Absorption::new(color, volume.attenuation_distance()).ok()
            });
            finish.matter = Matter::Glass { ior, thin: volume.is_none(), roughness, absorption };
            finish.surface_map = surface_map.and_then(|info| self.map(&info, Encoding::Data));
        } else if !is_matte {
            finish.matter = Matter::Glossy { metallic, roughness, ior };
            finish.surface_map = surface_map.and_then(|info| self.map(&info, Encoding::Data));
        }
        (material, finish)
    }

    fn map(&mut self, info: &gltf::texture::Info<'_>, encoding: Encoding) -> Option<TextureMap> {
        let transform = info.texture_transform();
        let set = transform.as_ref().and_then(gltf::texture::TextureTransform::tex_coord).unwrap_or(info.tex_coord());
        let mut map = self.picture(&info.texture(), set, encoding)?;
        if let Some(transform) = transform {
            map.scale = turned_and_scaled(transform.rotation(), transform.scale());
            map.offset = Vec2::from_array(transform.offset());
        }
        Some(map)
    }

    fn picture(&mut self, texture: &gltf::Texture<'_>, set: u32, encoding: Encoding) -> Option<TextureMap> {
        let source = texture.source();
        let buffers = self.buffers;
        let picture = match source.source() {
            Source::Uri { uri, .. } => {
                let name = if uri.starts_with("data:") { format!("image {}", source.index()) } else { uri.to_owned() };
                self.resources.texture(&name, encoding, |own| own.read_uri(uri))?
            }
            Source::View { view, .. } => {
                let name = format!("image {}", source.index());
                let bytes = |_: &Resources| {
                    let bytes = gltf_access::bytes(&view, buffers).ok_or("it reaches beyond its buffer")?;
                    Ok(bytes.to_vec())
                };
                self.resources.texture(&name, encoding, bytes)?
            }
        };
        let sampler = texture.sampler();
        let wrap = |mode: WrappingMode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        };
        let wrap = [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())];
        Some(TextureMap { wrap, set: set as usize, ..TextureMap::new(picture) })
    }
}

/// What KHR_texture_transform does to coordinates but for the offset: scales, then turns them counter-clockwise in the picture,
/// in which v goes down.
fn turned_and_scaled(rotation: f32, [x, y]: [f32; 2]) -> Mat2 {
    let (sine, cosine) = rotation.sin_cos();
    Mat2::from_cols(Vec2::new(cosine, -sine) * x, Vec2::new(sine, cosine) * y)
}

/// A factor that can be one.
fn clean(x: f32) -> f32 {
    if x.is_finite() { x.max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_scaled_and_then_turned() {
        let map = turned_and_scaled(std::f32::consts::FRAC_PI_2, [2.0, 3.0]);
        // To the right becomes up; down becomes to the right
        assert!((map * Vec2::X - Vec2::new(0.0, -2.0)).length() < 1e-6);
        assert!((map * Vec2::Y - Vec2::new(3.0, 0.0)).length() < 1e-6);
    }
}

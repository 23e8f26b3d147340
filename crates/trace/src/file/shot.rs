//! A shot: camera, lens and film of a picture, from what the file says.

use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Nakane, Pose, ThinLens};

use super::error::Fault;
use super::spec::{ApertureSpec, CameraSpec, FilmSpec, FocusSpec, IrisSpec, LensSpec, ShiftSpec, WindowSpec};
use crate::Exposure;

/// One picture to take of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// What the file says about it.
    pub description: String,
    /// The camera, in scene units.
    pub camera: Camera,
    /// The lens behind it, in scene units; unknown where the file gives a bare plane of focus.
    pub lens: Option<ThinLens>,
    /// When its shutter is open, and how the camera moves meanwhile; the camera above is that of the middle.
    pub exposure: Exposure,
}

/// The three tables that make a shot.
#[derive(Debug, Clone, Default)]
pub(crate) struct ShotTables {
    pub(crate) camera: CameraSpec,
    pub(crate) lens: LensSpec,
    pub(crate) film: FilmSpec,
}

impl ShotTables {
    /// Whether there is anything in them.
    pub(crate) fn is_given(&self) -> bool {
        self.camera.position.is_some() || self.film.size.is_some()
    }

    /// The shot, as its shutter is not open any time; `metres_per_unit` is needed where millimetres are given.
    pub(crate) fn resolve(&self, description: &str, metres_per_unit: Option<f64>) -> Result<Shot, Fault> {
        let pose = pose(&self.camera)?;
        let millimetre = metres_per_unit.map(|metres| 1e-3 / metres);
        let lengths = Lengths::new(&self.lens, millimetre)?;
        let (focus, lens) = focus(&self.lens, &pose, &lengths)?;
        let lens = lens.map(|lens| with_aperture(lens, &self.lens)).transpose()?;
        let iris = iris(&self.lens, lens.as_ref())?;
        let image_distance = lens.map(|lens| lens.image_distance()).or(lengths.image);
        let film = film(&self.film, &self.lens, image_distance, millimetre)?;
        let camera = Camera { pose, film, focus, iris }.with_cat_eye(self.lens.cat_eye.unwrap_or(0.0))?;
        // A tilted iris must not be seen from its edge
        if film.corners().into_iter().any(|q| iris.normal().dot(q.extend(1.0)) <= 0.0) {
            return Fault::says(
                "a corner of the picture looks at the iris edge-on; tilt less, shift less or narrow the window",
            );
        }
        Ok(Shot { description: description.to_owned(), camera, lens, exposure: Exposure::default() })
    }
}

fn pose(spec: &CameraSpec) -> Result<Pose, Fault> {
    let Some(position) = spec.position.map(DVec3::from_array) else {
        return Fault::says("the camera needs a position");
    };
    let up = spec.up.map_or(DVec3::Y, DVec3::from_array);
    match (spec.look_at, spec.right, spec.forward) {
        (Some(target), None, None) => Ok(Pose::look_at(position, DVec3::from_array(target), up)?),
        (None, Some(right), Some(forward)) => {
            Ok(Pose::new(position, DVec3::from_array(right), up, DVec3::from_array(forward))?)
        }
        _ => Fault::says("the camera needs look_at (and perhaps up), or all of right, up and forward"),
    }
}

/// Focal length and image distance in scene units, where given.
struct Lengths {
    focal: Option<f64>,
    image: Option<f64>,
}

impl Lengths {
    fn new(spec: &LensSpec, millimetre: Option<f64>) -> Result<Self, Fault> {
        let length = |what: &str, mm: Option<f64>, units: Option<f64>| match (mm, units, millimetre) {
            (Some(_), Some(_), _) => Fault::says(format!("{what} is given twice, in mm and in scene units")),
            (Some(_), None, None) => Fault::says(format!("{what}_mm needs metres_per_unit at the top of the file")),
            (Some(mm), None, Some(millimetre)) => Ok(Some(mm * millimetre)),
            (None, units, _) => Ok(units),
        };
        Ok(Self {
            focal: length("focal_length", spec.focal_length_mm, spec.focal_length)?,
            image: length("image_distance", spec.image_distance_mm, spec.image_distance)?,
        })
    }
}

/// The plane of focus, and the lens that makes it if enough is known; a pinhole as yet.
fn focus(spec: &LensSpec, pose: &Pose, lengths: &Lengths) -> Result<(Focus, Option<ThinLens>), Fault> {
    let is_turned = spec.tilt_deg.is_some() || spec.swing_deg.is_some();
    let plane = match spec.focus {
        None => return focus_of_lens(spec, lengths),
        Some(FocusSpec::Infinity) => return focus_at(f64::INFINITY, spec, lengths),
        Some(FocusSpec::Distance(distance)) => return focus_at(distance, spec, lengths),
        Some(FocusSpec::Plane { point, normal }) => {
            Focus::from_world_plane(pose, DVec3::from_array(point), DVec3::from_array(normal))?
        }
        Some(FocusSpec::Nakane { theta_deg, distance }) => Nakane::new(theta_deg.to_radians(), distance)?.focus()?,
        Some(FocusSpec::W(w)) => Focus::new(DVec3::from_array(w))?,
    };
    if is_turned {
        return Fault::says(
            "a plane of focus and a tilt or swing are given; leave one out: each follows from the other",
        );
    }
    let lens = match (lengths.focal, lengths.image) {
        (None, None) => None,
        (Some(focal), None) => Some(ThinLens::of_focal_length(&plane, focal, f64::INFINITY)?),
        (None, Some(image)) => Some(ThinLens::at_image_distance(&plane, image, f64::INFINITY)?),
        (Some(_), Some(_)) => {
            return Fault::says(
                "a plane of focus fixes the image distance of a focal length; leave one of the three out",
            );
        }
    };
    Ok((plane, lens))
}

/// Everything about the lens is given, and the plane of focus follows.
fn focus_of_lens(spec: &LensSpec, lengths: &Lengths) -> Result<(Focus, Option<ThinLens>), Fault> {
    let (Some(focal), Some(image)) = (lengths.focal, lengths.image) else {
        return Fault::says("the lens needs a focus, or both its focal length and its image distance");
    };
    let lens = turned(ThinLens::new(focal, f64::INFINITY, image)?, spec)?;
    Ok((lens.focus(), Some(lens)))
}

/// Focus on the optical axis, at a planar depth that may be infinite.
fn focus_at(distance: f64, spec: &LensSpec, lengths: &Lengths) -> Result<(Focus, Option<ThinLens>), Fault> {
    let lens = match (lengths.focal, lengths.image) {
        (Some(_), Some(_)) => {
            return Fault::says("focal length, image distance and focus distance are given; leave one out");
        }
        (Some(focal), None) => {
            turned(ThinLens::new(focal, f64::INFINITY, focal)?, spec)?.focused_at(DVec2::ZERO, distance)?
        }
        (None, Some(image)) => {
            // 1/z = n.z/F - 1/v
            let straight = turned(ThinLens::new(image, f64::INFINITY, image)?, spec)?;
            let focal = straight.axis().z / (1.0 / distance + 1.0 / image);
            turned(ThinLens::new(focal, f64::INFINITY, image)?, spec)?
        }
        (None, None) if spec.tilt_deg.unwrap_or(0.0) == 0.0 && spec.swing_deg.unwrap_or(0.0) == 0.0 => {
            return Ok((Focus::at_depth(distance)?, None));
        }
        (None, None) => return Fault::says("a tilted lens needs its focal length or image distance"),
    };
    Ok((lens.focus(), Some(lens)))
}

fn turned(lens: ThinLens, spec: &LensSpec) -> Result<ThinLens, Fault> {
    let [tilt, swing] = [spec.tilt_deg, spec.swing_deg].map(|angle| angle.unwrap_or(0.0).to_radians());
    Ok(lens.tilted(tilt, swing)?)
}

fn with_aperture(lens: ThinLens, spec: &LensSpec) -> Result<ThinLens, Fault> {
    Ok(match spec.aperture {
        None | Some(ApertureSpec::Pinhole) => lens,
        Some(ApertureSpec::FNumber(number)) => lens.with_f_number(number)?,
        Some(ApertureSpec::Radius(radius)) => lens.with_aperture_radius(radius)?,
    })
}

fn iris(spec: &LensSpec, lens: Option<&ThinLens>) -> Result<Iris, Fault> {
    let radius = match (spec.aperture, lens) {
        (None | Some(ApertureSpec::Pinhole), _) => 0.0,
        (Some(ApertureSpec::Radius(radius)), _) => radius,
        (Some(ApertureSpec::FNumber(_)), Some(lens)) => lens.aperture_radius(),
        (Some(ApertureSpec::FNumber(_)), None) => {
            return Fault::says("an f-number needs the focal length or the image distance; or give aperture.radius");
        }
    };
    let shape = match spec.blades {
        None => ApertureShape::Disc,
        Some(blades) => ApertureShape::polygon(blades.count, blades.rotation_deg.to_radians())?,
    };
    let normal = match (spec.iris, lens) {
        (Some(IrisSpec::Upright), _) | (None, None) => DVec3::Z,
        (Some(IrisSpec::Normal(normal)), _) => DVec3::from_array(normal),
        (Some(IrisSpec::Tilted) | None, Some(lens)) => lens.axis(),
        (Some(IrisSpec::Tilted), None) => {
            return Fault::says(
                "the lens axis is unknown; give its focal length or image distance, or iris = \"upright\"",
            );
        }
    };
    Ok(Iris::new(normal, radius, shape)?.squeezed(spec.anamorphic.unwrap_or(1.0))?)
}

fn film(film: &FilmSpec, lens: &LensSpec, image_distance: Option<f64>, millimetre: Option<f64>) -> Result<Film, Fault> {
    let Some([width, height]) = film.size else { return Fault::says("the film needs a size in pixels") };
    let over_sensor = |what: &str| match image_distance {
        Some(v) => Ok(1.0 / v),
        None => Fault::says(format!("{what} needs the lens's focal length or image distance")),
    };
    let over_millimetres = |what: &str| match millimetre {
        Some(millimetre) => Ok(millimetre * over_sensor(what)?),
        None => Fault::says(format!("{what} needs metres_per_unit at the top of the file")),
    };
    let centred = |size: [f64; 2], scale: f64| {
        let half = 0.5 * scale * DVec2::from_array(size);
        Film::new(-half, half, width, height)
    };
    let straight = match film.window {
        None => return Fault::says("the film needs a window: fov_deg, sensor_mm, sensor or q"),
        Some(WindowSpec::FovDeg(fov)) => Film::from_fov(fov.to_radians(), width, height)?,
        Some(WindowSpec::SensorMm(size)) => centred(size, over_millimetres("window.sensor_mm")?)?,
        Some(WindowSpec::Sensor(size)) => centred(size, over_sensor("window.sensor")?)?,
        Some(WindowSpec::Q([left, bottom, right, top])) => {
            Film::new(DVec2::new(left, bottom), DVec2::new(right, top), width, height)?
        }
    };
    let shift = match lens.shift {
        None => DVec2::ZERO,
        Some(ShiftSpec::Q(shift)) => DVec2::from_array(shift),
        Some(ShiftSpec::Mm(shift)) => over_millimetres("shift.mm")? * DVec2::from_array(shift),
    };
    let film = straight.shifted(shift);
    // Check the moved edges too
    Ok(Film::new(film.min(), film.max(), width, height)?)
}

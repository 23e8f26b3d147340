//! What a lens setting means, as values; words and JSON are two ways to write them.

use glam::DVec2;
use optics::{Camera, DepthRange, Focus, KernelModel, Nakane, OpticsError, Reading, ThinLens};
use serde::{Serialize, Serializer};

use crate::lens_options::Chosen;

/// A depth beyond this many metres is infinity: what is left of it is rounding.
const INFINITELY_FAR_M: f64 = 1e9;

/// A number that may be infinite, which JSON cannot say: there it is the string "inf".
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Number(pub(super) f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_infinite() { serializer.serialize_str("inf") } else { serializer.serialize_f64(self.0) }
    }
}

/// What is to be said beside the lens itself.
pub(super) struct Asked {
    /// Shift of the picture, right and rise.
    pub(super) shift_mm: DVec2,
    /// Radius of the circle of confusion that counts as sharp.
    pub(super) coc_radius_px: f64,
    /// Depth of the nearest thing, metres.
    pub(super) nearest: Option<f64>,
    /// What tilt and swing were found from, unless they were typed.
    pub(super) tilt_follows_from: Option<&'static str>,
}

/// All that is said.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) lens: Lens,
    pub(super) picture: Picture,
    pub(super) plane_of_focus: Plane,
    pub(super) depth_of_field: DepthOfField,
    pub(super) blur: Blur,
}

/// How the lens stands.
#[derive(Debug, Serialize)]
pub(super) struct Lens {
    pub(super) focal_length_mm: f64,
    pub(super) f_number: Number,
    pub(super) effective_f_number: Number,
    pub(super) aperture_radius_mm: f64,
    pub(super) image_distance_mm: f64,
    pub(super) tilt_deg: f64,
    pub(super) swing_deg: f64,
    pub(super) total_tilt_deg: f64,
    pub(super) tilt_follows_from: Option<&'static str>,
}

/// What the picture shows.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub(super) size_px: [u32; 2],
    pub(super) field_of_view_deg: [f64; 2],
    /// Right, rise.
    pub(super) shift_mm: [f64; 2],
}

/// The plane of sharp focus.
#[derive(Debug, Serialize)]
pub(super) struct Plane {
    /// Null where it is behind the camera.
    pub(super) depth_on_axis_m: Option<Number>,
    pub(super) angle_from_sensor_deg: f64,
    /// The plane is w . P = 1; x right, y up, z depth.
    pub(super) w_per_m: [f64; 3],
    pub(super) nakane: Option<Angle>,
    pub(super) hinge: Option<Hinge>,
    pub(super) scheimpflug_line: Option<Scheimpflug>,
    /// The ends of the part inside the picture, column and row.
    pub(super) vanishing_line_px: Option<[[f64; 2]; 2]>,
    /// Whether any pixel has a sharp depth in front of the camera.
    pub(super) is_in_the_picture: bool,
}

/// Nakane et al.'s angle of the plane of focus from the optical axis, and the distance where it crosses it.
#[derive(Debug, Serialize)]
pub(super) struct Angle {
    pub(super) theta_deg: f64,
    pub(super) distance_m: f64,
}

/// The line on which the plane of focus turns, beside the lens.
#[derive(Debug, Serialize)]
pub(super) struct Hinge {
    pub(super) distance_m: f64,
    /// Its point nearest to the lens centre: right, up.
    pub(super) nearest_point_m: [f64; 2],
}

/// The line where the planes of sensor, lens and focus meet.
#[derive(Debug, Serialize)]
pub(super) struct Scheimpflug {
    /// Its point nearest to the optical axis, from the lens centre: right, up, depth (the sensor's, so negative).
    pub(super) nearest_point_mm: [f64; 3],
}

/// What is sharp enough.
#[derive(Debug, Serialize)]
pub(super) struct DepthOfField {
    pub(super) coc_radius_px: f64,
    pub(super) on_axis: Limits,
    pub(super) top: Limits,
    pub(super) bottom: Limits,
    pub(super) left: Limits,
    pub(super) right: Limits,
    /// To each side of the plane of focus where the axis meets it, parallel to the sensor; null without tilt.
    pub(super) wedge_half_width_m: Option<f64>,
}

/// Depths along one ray; null where they are behind the camera.
#[derive(Debug, Serialize)]
pub(super) struct Limits {
    pub(super) near_m: Option<Number>,
    pub(super) sharp_m: Option<Number>,
    pub(super) far_m: Option<Number>,
}

/// How large things blur over the picture.
#[derive(Debug, Serialize)]
pub(super) struct Blur {
    pub(super) largest_of_sky_diameter_px: f64,
    /// Null where no nearest depth was given and none follows from the focus.
    pub(super) scene: Option<Scene>,
}

/// Everything from the nearest depth to infinity.
#[derive(Debug, Serialize)]
pub(super) struct Scene {
    pub(super) nearest_m: f64,
    pub(super) largest_diameter_px: f64,
    pub(super) kernel: String,
    pub(super) kernel_reason: String,
    pub(super) disc_error_px: Number,
    pub(super) ellipse_error_px: Number,
    pub(super) overscan_columns_px: Number,
    pub(super) overscan_rows_px: Number,
}

impl Report {
    /// What a lens and its camera, in metres, amount to.
    pub(super) fn new(chosen: &Chosen, asked: &Asked) -> Result<Self, OpticsError> {
        let Chosen { camera, lens } = chosen;
        let plane_of_focus = Plane::new(camera, lens);

        // Take half the nearest sharp depth for the nearest thing where nothing else is known
        let [_, nearest_sharp] = camera.focus.inverse_depth_range(&camera.film);
        let half_way = || depth(nearest_sharp).filter(|depth| depth.0.is_finite()).map(|depth| 0.5 * depth.0);
        let scene = match asked.nearest.or_else(half_way) {
            Some(nearest) => Some(Scene::new(camera, &DepthRange::new(nearest, f64::INFINITY)?)),
            None => None,
        };
        let sky = camera.film.corners().map(|q| 2.0 * camera.coc_radius_px(q, 0.0).abs());
        let blur = Blur { largest_of_sky_diameter_px: sky.into_iter().fold(0.0, f64::max), scene };

        Ok(Self {
            lens: Lens::new(lens, asked.tilt_follows_from),
            picture: Picture::new(camera, asked.shift_mm),
            depth_of_field: DepthOfField::new(camera, asked.coc_radius_px, plane_of_focus.depth_on_axis_m)?,
            plane_of_focus,
            blur,
        })
    }
}

impl Lens {
    fn new(lens: &ThinLens, tilt_follows_from: Option<&'static str>) -> Self {
        Self {
            focal_length_mm: lens.focal_length() * 1e3,
            f_number: Number(lens.f_number()),
            effective_f_number: Number(lens.effective_f_number()),
            aperture_radius_mm: lens.aperture_radius() * 1e3,
            image_distance_mm: lens.image_distance() * 1e3,
            tilt_deg: lens.tilt().to_degrees(),
            swing_deg: lens.swing().to_degrees(),
            total_tilt_deg: lens.total_tilt().to_degrees(),
            tilt_follows_from,
        }
    }
}

impl Picture {
    fn new(camera: &Camera, shift_mm: DVec2) -> Self {
        let (film, angle) = (&camera.film, |q: f64| q.atan().to_degrees());
        let (min, max) = (film.min(), film.max());
        Self {
            size_px: [film.width(), film.height()],
            field_of_view_deg: [angle(max.x) - angle(min.x), angle(max.y) - angle(min.y)],
            shift_mm: shift_mm.to_array(),
        }
    }
}

impl Plane {
    fn new(camera: &Camera, lens: &ThinLens) -> Self {
        let (focus, film) = (&camera.focus, &camera.film);
        let is_tilted = focus.hinge_distance() < INFINITELY_FAR_M;
        let vanishing_line = focus.vanishing_line().filter(|_| is_tilted).and_then(|line| line.clipped(film));
        Self {
            depth_on_axis_m: depth(focus.inverse_depth(DVec2::ZERO)),
            angle_from_sensor_deg: if is_tilted { focus.angle_from_sensor().to_degrees() } else { 0.0 },
            w_per_m: focus.w().to_array(),
            nakane: nakane(focus),
            hinge: focus.hinge().filter(|_| is_tilted).map(|line| Hinge {
                distance_m: focus.hinge_distance(),
                nearest_point_m: line.point.truncate().to_array(),
            }),
            scheimpflug_line: lens
                .scheimpflug_line()
                .filter(|_| is_tilted)
                .map(|line| Scheimpflug { nearest_point_mm: (line.point * 1e3).to_array() }),
            vanishing_line_px: vanishing_line.map(|ends| ends.map(|q| film.pixel_from_q(q).to_array())),
            is_in_the_picture: film.corners().iter().any(|&q| depth(focus.inverse_depth(q)).is_some()),
        }
    }
}

impl DepthOfField {
    fn new(camera: &Camera, coc_radius_px: f64, on_axis: Option<Number>) -> Result<Self, OpticsError> {
        let wedge = camera.wedge(coc_radius_px)?;
        let limits = |q: DVec2| {
            let sharp_m = depth(camera.focus.inverse_depth(q));
            let (near_m, far_m) = match wedge.limits(q) {
                Some((near, far)) => (depth(near.recip()), depth(far.recip())),
                None => (None, None),
            };
            Limits { near_m, sharp_m, far_m }
        };
        let (min, max) = (camera.film.min(), camera.film.max());
        let middle = 0.5 * (min + max);
        let is_tilted = camera.focus.hinge_distance() < INFINITELY_FAR_M;
        let half_width = on_axis.filter(|_| is_tilted).map(|depth| wedge.half_width(depth.0));
        Ok(Self {
            coc_radius_px,
            on_axis: limits(DVec2::ZERO),
            top: limits(DVec2::new(middle.x, max.y)),
            bottom: limits(DVec2::new(middle.x, min.y)),
            left: limits(DVec2::new(min.x, middle.y)),
            right: limits(DVec2::new(max.x, middle.y)),
            wedge_half_width_m: half_width.filter(|&width| width < INFINITELY_FAR_M),
        })
    }
}

impl Scene {
    fn new(camera: &Camera, depths: &DepthRange) -> Self {
        let choice = KernelModel::choose(camera, Reading::Gather, depths, KernelModel::DEFAULT_TOLERANCE_PX);
        let overscan = camera.overscan(depths);
        Self {
            nearest_m: depths.near(),
            largest_diameter_px: 2.0 * camera.largest_coc_radius_px(depths),
            kernel: choice.model.to_string(),
            kernel_reason: choice.to_string(),
            disc_error_px: Number(choice.disc_error_px),
            ellipse_error_px: Number(choice.ellipse_error_px),
            overscan_columns_px: Number(overscan.left.max(overscan.right).ceil()),
            overscan_rows_px: Number(overscan.top.max(overscan.bottom).ceil()),
        }
    }
}

/// The depth of an inverse depth; `None` behind the camera.
fn depth(inverse_depth: f64) -> Option<Number> {
    if inverse_depth.abs() < INFINITELY_FAR_M.recip() {
        return Some(Number(f64::INFINITY));
    }
    (inverse_depth > 0.0).then(|| Number(inverse_depth.recip()))
}

/// The plane in Nakane et al.'s terms, where it crosses the axis at a finite distance and is not swung.
fn nakane(focus: &Focus) -> Option<Angle> {
    let plane = Nakane::of(focus).filter(|plane| plane.distance() < INFINITELY_FAR_M)?;
    Some(Angle { theta_deg: plane.theta().to_degrees(), distance_m: plane.distance() })
}

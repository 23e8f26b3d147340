//! The camera value: what rays need, and nothing derived.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Film, Focus, Iris, Pose};

/// A camera whose lens may tilt, swing and shift.
///
/// It holds the pose, the window of q with its size in pixels, the plane of focus and the iris. Focal length, f-number,
/// tilt and the like are constructors into it and queries out of it, never fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Where it stands.
    pub pose: Pose,
    /// What its picture shows.
    pub film: Film,
    /// What it holds sharp.
    pub focus: Focus,
    /// What its rays pass through.
    pub iris: Iris,
}

/// A ray from a point of the iris into the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensRay {
    /// Where it leaves the lens.
    pub origin: DVec3,
    /// Where it goes; its z in camera space is about 1, it is not normalised.
    pub direction: DVec3,
    /// What its radiance counts; 1 for a thin lens.
    pub weight: f64,
}

impl Camera {
    /// The camera-space ray of pixel direction `q` through the lens point of `u` in [0, 1)^2.
    ///
    /// Origin L, direction (q, 1) - w(q) L: no division, and no special case where w(q) is 0 or negative. `_time` is
    /// for lenses that move. `None` if the lens blocks the ray: it would have to leave backwards.
    #[must_use]
    pub fn ray(&self, q: DVec2, u: DVec2, _time: f64) -> Option<LensRay> {
        let q1 = q.extend(1.0);
        // Leaves forward iff the pixel does not look at the lens edge-on
        if self.iris.normal().dot(q1) <= 0.0 {
            return None;
        }
        let origin = self.iris.point(u);
        let direction = q1 - self.focus.w().dot(q1) * origin;
        Some(LensRay { origin, direction, weight: 1.0 })
    }

    /// The same ray in world space.
    #[must_use]
    pub fn world_ray(&self, q: DVec2, u: DVec2, time: f64) -> Option<LensRay> {
        let ray = self.ray(q, u, time)?;
        Some(LensRay {
            origin: self.pose.point_to_world(ray.origin),
            direction: self.pose.direction_to_world(ray.direction),
            weight: ray.weight,
        })
    }

    /// The same camera with its iris closed to a pinhole.
    #[must_use]
    pub fn pinhole(&self) -> Self {
        Self { iris: Iris::pinhole(), ..*self }
    }

    /// Half width and half height in pixels of the blur of a unit of defocus, for an iris that stands upright: half sizes
    /// of the iris times pixels per unit of q.
    #[must_use]
    pub fn pixels_per_defocus(&self) -> DVec2 {
        self.iris.half_sizes() * self.film.pixels_per_q()
    }

    /// Radius of the circle of confusion in pixels (the wider axis) of a surface at `inverse_depth` seen at pixel q,
    /// signed: positive on the lens's side of the plane of focus.
    #[must_use]
    pub fn coc_radius_px(&self, q: DVec2, inverse_depth: f64) -> f64 {
        self.pixels_per_defocus().max_element() * self.focus.defocus(q, inverse_depth)
    }
}

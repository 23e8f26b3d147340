//! The camera value: what rays need, and nothing derived.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Film, Focus, Iris, OpticsError, Pose, error::in_range};

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
    /// for lenses that move. `None` if the lens blocks the ray: it would have to leave backwards, or its cat's eye is closed
    /// there. A pixel is the mean over what is open: nothing gets darker towards the border.
    #[must_use]
    pub fn ray(&self, q: DVec2, u: DVec2, _time: f64) -> Option<LensRay> {
        let q1 = q.extend(1.0);
        // Leaves forward iff the pixel does not look at the lens edge-on
        if self.iris.normal().dot(q1) <= 0.0 {
            return None;
        }
        let origin = self.iris.open_point(q, u)?;
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

    /// The same camera with a cat's eye: at the corners of the film of an untilted, unshifted lens the second rim is moved by
    /// `strength` (0 to 1) radii, less towards the centre.
    ///
    /// It grows with the tangent to the axis of the iris: a shifted film sees more of it on one side, a tilted iris takes it
    /// along. Half of it leaves 69 % of the lens open in the corner, all of it 39 %.
    pub fn with_cat_eye(self, strength: f64) -> Result<Self, OpticsError> {
        in_range("strength of the cat's eye", strength, "0 to 1", |strength| (0.0..=1.0).contains(&strength))?;
        let half_diagonal = 0.5 * (self.film.max() - self.film.min()).length();
        Ok(Self { iris: self.iris.with_cat_eye((strength / half_diagonal).min(1e6))?, ..self })
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

//! The plane of focus as Nakane et al. give it: an angle from the optical axis, at a distance.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::{Focus, OpticsError, error::in_range};

/// The plane of focus that crosses the optical axis at distance U under the angle theta; no swing.
///
/// w = (0, -1/(U tan theta), 1/U). Theta is a right angle for an untilted lens. Positive theta puts the hinge below the
/// lens, and the plane rises away from it (a small theta is nearly a floor); negative theta puts the hinge above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nakane {
    theta: f64,
    distance: f64,
}

impl Nakane {
    /// From theta (radians, not 0, at most a right angle either way) and U (positive).
    pub fn new(theta: f64, distance: f64) -> Result<Self, OpticsError> {
        let is_angle = |x: f64| x != 0.0 && x.abs() <= FRAC_PI_2;
        in_range("angle of the plane of focus from the axis, in radians", theta, "in +-pi/2 and not 0", is_angle)?;
        in_range("distance of the plane of focus on the axis", distance, "positive", |x| x > 0.0)?;
        Ok(Self { theta, distance })
    }

    /// From theta, the lens tilt (radians, of the same sign) and the image distance v: U = v (1/(tan theta tan tilt) - 1),
    /// Scheimpflug's rule solved for U.
    pub fn from_lens_tilt(theta: f64, tilt: f64, image_distance: f64) -> Result<Self, OpticsError> {
        in_range("tilt in radians", tilt, "between -pi/2 and pi/2, and not 0", |x| x != 0.0 && x.abs() < FRAC_PI_2)?;
        in_range("image distance", image_distance, "positive", |v| v > 0.0)?;
        let cotangents = ((FRAC_PI_2 - theta).tan()) * ((FRAC_PI_2 - tilt).tan());
        Self::new(theta, image_distance * (cotangents - 1.0))
    }

    /// What a plane of focus is in these terms; `None` if it is swung, or does not cross the axis in front of the lens.
    #[must_use]
    pub fn of(focus: &Focus) -> Option<Self> {
        const ROUNDING: f64 = 1e-12; // what rotating into camera space leaves of a swing of 0
        let w = focus.w();
        let is_swung = w.x.abs() > ROUNDING * w.length();
        if is_swung || w.z <= 0.0 {
            return None;
        }
        // atan(w_z / -w_y), with the right angle of an untilted plane positive
        let theta = if w.y > 0.0 { -w.z.atan2(w.y) } else { w.z.atan2(-w.y) };
        Self::new(theta, w.z.recip()).ok()
    }

    /// Angle of the plane of focus from the optical axis, radians.
    #[must_use]
    pub fn theta(&self) -> f64 {
        self.theta
    }

    /// Distance U at which it crosses the axis.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The plane of focus.
    pub fn focus(&self) -> Result<Focus, OpticsError> {
        let cotangent = self.theta.cos() / self.theta.sin();
        Focus::new(DVec3::new(0.0, -cotangent, 1.0) / self.distance)
    }

    /// The lens tilt that they print, radians: tan tilt = v/((U + v) tan theta) (Scheimpflug's rule).
    #[must_use]
    pub fn lens_tilt(&self, image_distance: f64) -> f64 {
        let v = image_distance;
        (v * self.theta.cos() / ((self.distance + v) * self.theta.sin())).atan()
    }

    /// Angle between the lens *plane* and the optical axis, radians: their eq. 3, atan((U + f) tan theta / f) with f our
    /// v. The tilt they print is the right angle (of theta's sign) less this.
    #[must_use]
    pub fn lens_plane_angle(&self, image_distance: f64) -> f64 {
        ((self.distance + image_distance) * self.theta.tan() / image_distance).atan()
    }
}

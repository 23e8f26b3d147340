//! Depth of field: the wedge through the hinge in which everything is sharp enough.

use glam::{DVec2, DVec3};

use crate::{Camera, Focus, OpticsError};

/// All points that blur to at most a given circle of confusion: |1/z - w(q)| <= delta.
///
/// Its limits are the planes w +- delta z, which meet the plane of focus in the hinge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wedge {
    focus: Focus,
    delta: f64,
}

impl Wedge {
    /// Around a plane of focus, from the tolerated defocus `delta` (inverse depth, 0 to `+inf`).
    pub fn new(focus: Focus, delta: f64) -> Result<Self, OpticsError> {
        if delta.is_nan() || delta < 0.0 {
            let (what, wanted) = ("tolerated defocus", "0 or positive (infinity for a pinhole)");
            return Err(OpticsError::OutOfRange { what, value: delta, wanted });
        }
        Ok(Self { focus, delta })
    }

    /// Tolerated defocus, inverse depth; `+inf` for a pinhole.
    #[must_use]
    pub fn delta(&self) -> f64 {
        self.delta
    }

    /// Near and far limit of what is sharp at a pixel: 1/(w(q) + delta) and 1/(w(q) - delta).
    ///
    /// Far is `+inf` where w(q) <= delta, near is 0 for a pinhole. `None` where nothing in front of the camera is sharp.
    #[must_use]
    pub fn limits(&self, q: DVec2) -> Option<(f64, f64)> {
        let w = self.focus.inverse_depth(q);
        let (near, far) = (w + self.delta, w - self.delta);
        (near >= 0.0).then(|| (near.abs().recip(), if far > 0.0 { far.recip() } else { f64::INFINITY }))
    }

    /// The near limit as a plane; `None` for a pinhole, which has none.
    #[must_use]
    pub fn near_plane(&self) -> Option<Focus> {
        Focus::new(self.focus.w() + DVec3::Z * self.delta).ok()
    }

    /// The far limit as a plane; `None` for a pinhole, which has none.
    #[must_use]
    pub fn far_plane(&self) -> Option<Focus> {
        Focus::new(self.focus.w() - DVec3::Z * self.delta).ok()
    }

    /// Hyperfocal depth 1/delta: an untilted camera focused there is sharp from half of it to infinity.
    #[must_use]
    pub fn hyperfocal_depth(&self) -> f64 {
        self.delta.recip()
    }

    /// How far the wedge reaches to each side of the plane of focus at a depth, measured parallel to the sensor, across
    /// the hinge: z J delta, which is J at the hyperfocal depth (Merklinger 1993). `+inf` if untilted.
    #[must_use]
    pub fn half_width(&self, depth: f64) -> f64 {
        depth * self.delta * self.focus.hinge_distance()
    }
}

impl Camera {
    /// The wedge in which the circle of confusion has at most a *radius* of `coc_radius_px` pixels (of the wider axis):
    /// delta = c/(R s).
    pub fn wedge(&self, coc_radius_px: f64) -> Result<Wedge, OpticsError> {
        if coc_radius_px.is_nan() || coc_radius_px < 0.0 {
            let (what, wanted) = ("tolerated circle of confusion in pixels", "0 or positive");
            return Err(OpticsError::OutOfRange { what, value: coc_radius_px, wanted });
        }
        // A pinhole is sharp everywhere, whatever is asked
        if self.iris.radius() == 0.0 {
            return Wedge::new(self.focus, f64::INFINITY);
        }
        Wedge::new(self.focus, coc_radius_px / self.pixels_per_defocus().max_element())
    }
}

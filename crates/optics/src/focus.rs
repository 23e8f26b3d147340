//! The plane of sharp focus as one vector: w . P = 1.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{OpticsError, Pose, error::in_range};

/// The plane of sharp focus `w . P = 1` in camera space, in 1 / scene units.
///
/// A pixel q is sharp at depth `1 / w(q)` with `w(q) = w . (q, 1)`: positive in front of the camera, zero at infinity,
/// negative behind the camera (nothing is sharp, and the blur grows on).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Focus {
    w: DVec3,
}

impl Focus {
    /// A raw w; each part must be finite.
    pub fn new(w: DVec3) -> Result<Self, OpticsError> {
        for part in w.to_array() {
            in_range("inverse depth of focus w", part, "finite", |_| true)?;
        }
        Ok(Self { w })
    }

    /// A plane parallel to the sensor at `depth`; `+inf` focuses at infinity.
    pub fn at_depth(depth: f64) -> Result<Self, OpticsError> {
        if depth.is_nan() || depth <= 0.0 {
            return Err(OpticsError::OutOfRange { what: "depth of focus", value: depth, wanted: "positive" });
        }
        Self::new(DVec3::new(0.0, 0.0, 1.0 / depth))
    }

    /// The plane through a world point with a world normal.
    pub fn from_world_plane(pose: &Pose, point: DVec3, normal: DVec3) -> Result<Self, OpticsError> {
        let n_camera = pose.direction_to_camera(normal);
        let height = n_camera.dot(pose.point_to_camera(point));
        in_range("distance of the plane of focus from the lens centre", height, "not zero", |h| h != 0.0)?;
        Self::new(n_camera / height)
    }

    /// The vector itself.
    #[must_use]
    pub fn w(&self) -> DVec3 {
        self.w
    }

    /// Inverse depth of focus of a pixel.
    #[must_use]
    pub fn inverse_depth(&self, q: DVec2) -> f64 {
        self.w.dot(q.extend(1.0))
    }

    /// Signed defocus D = 1/z - w(p) of a point at `inverse_depth` seen by pixel q; positive on the lens's side.
    #[must_use]
    pub fn defocus(&self, q: DVec2, inverse_depth: f64) -> f64 {
        inverse_depth - self.inverse_depth(q)
    }
}

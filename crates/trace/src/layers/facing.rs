//! Which hits of rays through one pixel lie on the same surface.

use glam::{DVec2, DVec3};
use optics::Camera;

use crate::Hit;

/// How far a hit's inverse depth may lie from the plane that touches the surface, over itself.
const SAME_SURFACE: f64 = 0.01;

/// A point of a surface in camera space, and the plane that touches it there: on that the inverse depth is affine in the
/// direction q.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// Inverse depth of the point; 0 for the sky.
    pub(super) inverse: f64,
    /// The plane's inverse depth is the product of this and (q, 1).
    plane: DVec3,
}

impl Facing {
    /// Of a hit, or of the sky.
    pub(super) fn new(camera: &Camera, hit: Option<&Hit>) -> Self {
        hit.map_or(Self { inverse: 0.0, plane: DVec3::ZERO }, |hit| {
            let point = camera.pose.point_to_camera(hit.point);
            let normal = camera.pose.direction_to_camera(hit.normal);
            Self { inverse: 1.0 / point.z, plane: normal / normal.dot(point) }
        })
    }

    /// Inverse depth of the plane in a direction.
    pub(super) fn plane_at(&self, q: DVec2) -> f64 {
        self.plane.dot(q.extend(1.0))
    }

    /// Whether a hit in a direction lies on another surface than this plane.
    pub(super) fn is_other(&self, q: DVec2, inverse: f64) -> bool {
        !is_close(self.plane_at(q), inverse)
    }

    /// Whether a hit lies on the same surface: on this plane, or as far away, as at the rim of what is round.
    pub(super) fn meets(&self, q: DVec2, inverse: f64) -> bool {
        is_close(self.plane_at(q), inverse) || is_close(self.inverse, inverse)
    }
}

fn is_close(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_SURFACE * a.max(b)
}

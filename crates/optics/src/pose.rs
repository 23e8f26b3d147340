//! Where a camera stands and looks.

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use crate::OpticsError;

/// Rotation and position of a camera in a right-handed, y-up world.
///
/// The three axes are perpendicular unit vectors; camera space (right, up, forward) is left-handed, so
/// `right x up = -forward` in the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Pose {
    /// Lens centre in world space, in scene units.
    pub position: DVec3,
    /// Camera x in world space.
    pub right: DVec3,
    /// Camera y in world space.
    pub up: DVec3,
    /// Camera z (depth) in world space.
    pub forward: DVec3,
}

impl Pose {
    /// At the world's origin, looking along -z, y up.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, right: DVec3::X, up: DVec3::Y, forward: DVec3::NEG_Z };

    /// A pose from its axes, which must be perpendicular unit vectors within 1e-6 and left-handed as stated above.
    pub fn new(position: DVec3, right: DVec3, up: DVec3, forward: DVec3) -> Result<Self, OpticsError> {
        const LOOSE: f64 = 1e-6; // what a file with float matrices may be off by
        if !(position.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite()) {
            return Err(OpticsError::NotAFrame("an axis or the position is not finite"));
        }
        if [right, up, forward].iter().any(|axis| (axis.length() - 1.0).abs() > LOOSE) {
            return Err(OpticsError::NotAFrame("an axis is not of length 1"));
        }
        if right.dot(up).abs().max(right.dot(forward).abs()).max(up.dot(forward).abs()) > LOOSE {
            return Err(OpticsError::NotAFrame("two axes are not perpendicular"));
        }
        if right.cross(up).dot(forward) > 0.0 {
            return Err(OpticsError::NotAFrame("the picture would be mirrored (right x up must be -forward)"));
        }
        Ok(Self { position, right, up, forward })
    }

    /// A camera at `position` that looks at `target`, with `up_hint` pointing upwards in the picture.
    pub fn look_at(position: DVec3, target: DVec3, up_hint: DVec3) -> Result<Self, OpticsError> {
        let forward = (target - position).try_normalize();
        let forward = forward.ok_or(OpticsError::NotAFrame("position and target are the same point"))?;
        let right = forward.cross(up_hint).try_normalize();
        let right = right.ok_or(OpticsError::NotAFrame("the up direction is along the view"))?;
        Self::new(position, right, right.cross(forward), forward)
    }

    /// 4x4 matrix from camera to world space (determinant -1).
    #[must_use]
    pub fn world_from_camera(&self) -> DMat4 {
        DMat4::from_cols(
            self.right.extend(0.0),
            self.up.extend(0.0),
            self.forward.extend(0.0),
            self.position.extend(1.0),
        )
    }

    /// 4x4 matrix from world to camera space (determinant -1).
    #[must_use]
    pub fn camera_from_world(&self) -> DMat4 {
        let rows = [self.right, self.up, self.forward].map(|axis| axis.extend(-axis.dot(self.position)));
        DMat4::from_cols(rows[0], rows[1], rows[2], DVec4::W).transpose()
    }

    /// A camera-space direction in world space.
    #[must_use]
    pub fn direction_to_world(&self, d_camera: DVec3) -> DVec3 {
        self.right * d_camera.x + self.up * d_camera.y + self.forward * d_camera.z
    }

    /// A camera-space point in world space.
    #[must_use]
    pub fn point_to_world(&self, p_camera: DVec3) -> DVec3 {
        self.position + self.direction_to_world(p_camera)
    }

    /// A world-space direction in camera space.
    #[must_use]
    pub fn direction_to_camera(&self, d_world: DVec3) -> DVec3 {
        DVec3::new(d_world.dot(self.right), d_world.dot(self.up), d_world.dot(self.forward))
    }

    /// A world-space point in camera space; its z is the planar depth.
    #[must_use]
    pub fn point_to_camera(&self, p_world: DVec3) -> DVec3 {
        self.direction_to_camera(p_world - self.position)
    }
}

/// The pose as it stands in a file; checked before it becomes one.
#[derive(Deserialize)]
struct Written {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl TryFrom<Written> for Pose {
    type Error = OpticsError;

    fn try_from(written: Written) -> Result<Self, OpticsError> {
        Self::new(written.position, written.right, written.up, written.forward)
    }
}

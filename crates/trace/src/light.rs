//! What shines on a scene.

use glam::{DVec3, Vec3};

use crate::SceneError;

/// A light of the base shading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Reaches everything equally: adds `Kd x strength`.
    Ambient {
        /// Strength per channel.
        strength: Vec3,
    },
    /// Parallel light with hard shadows: adds `Kd x strength x max(0, n . toward)`; no 1/pi.
    Sun {
        /// Unit vector towards the light, world space.
        toward: DVec3,
        /// Strength per channel.
        strength: Vec3,
    },
}

impl Light {
    /// A sun in the direction `toward`, of any length but 0.
    pub fn sun(toward: DVec3, strength: Vec3) -> Result<Self, SceneError> {
        let wanted = "a finite vector, not 0";
        let length = toward.length();
        let toward = toward.try_normalize();
        let toward = toward.ok_or(SceneError::OutOfRange { what: "direction to a light", value: length, wanted })?;
        Ok(Self::Sun { toward, strength })
    }

    /// Its strength per channel.
    pub(crate) fn strength(&self) -> Vec3 {
        match *self {
            Self::Ambient { strength } | Self::Sun { strength, .. } => strength,
        }
    }
}

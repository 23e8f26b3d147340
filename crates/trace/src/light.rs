//! What shines on a scene.

use glam::{DVec3, Vec3};

use crate::SceneError;

/// A light.
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
    /// A sun of a size: a disc infinitely far away that is as bright as that, with soft shadows. It is seen, in mirrors and through
    /// glass too.
    Disc {
        /// Unit vector towards its middle, world space.
        toward: DVec3,
        /// Strength per channel.
        strength: Vec3,
        /// From its middle to its rim as it is seen, in radians, above 0 and below pi / 2.
        radius: f64,
    },
    /// Light from one point, with hard shadows: adds `Kd x strength x max(0, n . l) / distance^2`, in a cone or all around.
    Point {
        /// Where it stands, world space.
        at: DVec3,
        /// Strength per channel at distance 1.
        strength: Vec3,
        /// Where it shines, if not everywhere.
        cone: Option<Cone>,
    },
}

/// The cone of a spotlight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit vector from the light along its axis.
    axis: DVec3,
    /// Cosines of the angles from the axis up to which it shines fully, and from which on not at all.
    cosines: [f64; 2],
}

impl Cone {
    /// A cone around `axis` (of any length but 0) that shines fully within the angle `inner` and not beyond `outer` (radians,
    /// 0 <= inner <= outer <= pi).
    pub fn new(axis: DVec3, inner: f64, outer: f64) -> Result<Self, SceneError> {
        let wanted = "a finite vector, not 0";
        let value = axis.length();
        let axis = axis.try_normalize().ok_or(SceneError::OutOfRange { what: "axis of a light", value, wanted })?;
        if !(0.0 <= inner && inner <= outer && outer <= std::f64::consts::PI) {
            let wanted = "0 <= inner <= outer <= 180 degrees";
            return Err(SceneError::OutOfRange { what: "inner angle of a light's cone", value: inner, wanted });
        }
        Ok(Self { axis, cosines: [inner.cos(), outer.cos()] })
    }

    /// Share of the strength in a unit direction away from the light (KHR_lights_punctual).
    pub(crate) fn share(&self, direction: DVec3) -> f64 {
        let [inner, outer] = self.cosines;
        let share = ((self.axis.dot(direction) - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
        share * share
    }
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

    /// The same of an angular diameter in radians: 0, or at most pi / 2. That of the sun is 0.0093 (0.53 degrees).
    pub fn sun_of_size(toward: DVec3, strength: Vec3, diameter: f64) -> Result<Self, SceneError> {
        if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&diameter) {
            let (what, wanted) = ("size of a sun in degrees", "0 to 90");
            return Err(SceneError::OutOfRange { what, value: diameter.to_degrees(), wanted });
        }
        match Self::sun(toward, strength)? {
            // Less is as good as nothing, and brighter than numbers go
            Self::Sun { toward, strength } if diameter > 1e-4 => {
                Ok(Self::Disc { toward, strength, radius: 0.5 * diameter })
            }
            sun => Ok(sun),
        }
    }

    /// Its strength per channel.
    pub(crate) fn strength(&self) -> Vec3 {
        match *self {
            Self::Ambient { strength }
            | Self::Sun { strength, .. }
            | Self::Disc { strength, .. }
            | Self::Point { strength, .. } => strength,
        }
    }
}

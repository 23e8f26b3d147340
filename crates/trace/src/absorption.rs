//! What glass takes away from light on its way through.

use glam::Vec3;

use crate::SceneError;

/// The law of Beer and Lambert, as glTF's KHR_materials_volume says it: white light has this colour after that distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Absorption {
    color: Vec3,
    distance: f32,
}

impl Absorption {
    /// What is left of white (0 to 1 per channel) after a distance in scene units (above 0).
    pub fn new(color: Vec3, distance: f32) -> Result<Self, SceneError> {
        if let Some(value) = color.to_array().into_iter().find(|x| !(0.0..=1.0).contains(x)) {
            let (what, wanted) = ("attenuation colour of glass", "0 to 1");
            return Err(SceneError::OutOfRange { what, value: f64::from(value), wanted });
        }
        if !(distance > 0.0 && distance.is_finite()) {
            let (what, wanted) = ("attenuation distance of glass", "positive and finite");
            return Err(SceneError::OutOfRange { what, value: f64::from(distance), wanted });
        }
        Ok(Self { color, distance })
    }

    /// What is left after a distance.
    pub(crate) fn passing(&self, distance: f64) -> Vec3 {
        let share = (distance / f64::from(self.distance)).clamp(0.0, 1e6) as f32;
        self.color.powf(share)
    }
}

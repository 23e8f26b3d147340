//! How far forecasts are trusted.

use crate::{Rung, Tolerance};

/// Constants that were fitted on the scene `simple` alone.
pub(crate) struct Calibration;

impl Calibration {
    /// What an error is multiplied by before it is held against a tolerance, so that a tolerance is missed seldom.
    pub(crate) fn margin(rung: &Rung, tolerance: &Tolerance) -> f64 {
        let _ = (rung, tolerance);
        1.0
    }
}

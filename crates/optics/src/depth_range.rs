//! How near and how far a scene reaches.

use crate::{OpticsError, error::in_range};

/// The depths of all that is seen: from `near` to `far`, where a sky is at `+inf`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    near: f64,
    far: f64,
}

impl DepthRange {
    /// From `near` (positive, finite) to `far` (at least `near`, `+inf` with a sky).
    pub fn new(near: f64, far: f64) -> Result<Self, OpticsError> {
        in_range("nearest depth", near, "positive and finite", |z| z > 0.0 && z.recip().is_finite())?;
        if far.is_nan() || far < near {
            let wanted = "at least the nearest depth (infinity with a sky)";
            return Err(OpticsError::OutOfRange { what: "farthest depth", value: far, wanted });
        }
        Ok(Self { near, far })
    }

    /// The same range with a sky behind it.
    #[must_use]
    pub fn with_sky(self) -> Self {
        Self { far: f64::INFINITY, ..self }
    }

    /// The nearest depth.
    #[must_use]
    pub fn near(&self) -> f64 {
        self.near
    }

    /// The farthest depth; `+inf` with a sky.
    #[must_use]
    pub fn far(&self) -> f64 {
        self.far
    }

    /// Inverse depth of the farthest and of the nearest: least first.
    #[must_use]
    pub fn inverse(&self) -> [f64; 2] {
        [self.far.recip(), self.near.recip()]
    }
}

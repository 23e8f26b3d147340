//! The oval that a squeezed iris, or pixels that are not square, make of a disc.

use optics::Camera;

/// The footprint of an upright iris in pixels: half its height over the radius of the disc that is as large. Half its width
/// is the inverse of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Oval(pub(crate) f32);

impl Oval {
    /// The oval of a camera's iris, squeezed or not, in its pixels, square or not.
    pub(crate) fn of(camera: &Camera) -> Self {
        let half_sizes = camera.iris.proportions() * camera.film.pixels_per_q();
        Self((half_sizes.y / half_sizes.x).sqrt() as f32)
    }

    /// Whether a disc will do.
    pub(crate) fn is_round(self) -> bool {
        (self.0 - 1.0).abs() < 5e-4
    }

    /// Its longer half axis over the radius; at least 1.
    pub(crate) fn longer(self) -> f32 {
        self.0.max(1.0 / self.0)
    }

    /// As high as this one is high, or as wide as it is wide, but with the longer half axis given.
    pub(crate) fn with_longer(self, longer: f32) -> Self {
        Self(if self.0 > 1.0 { longer } else { 1.0 / longer })
    }

    /// Variances along x and y of a pixel in it, where that of a disc's would be `variance`.
    pub(crate) fn variances(self, variance: f64) -> [f64; 2] {
        [self.0.recip(), self.0].map(|half| variance * f64::from(half * half))
    }
}

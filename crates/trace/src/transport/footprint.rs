//! How much of a surface a ray stands for.

/// Share of a pixel's width that a texture is softened by. The mean over the pixel comes from its samples; one of many needs
/// less than the whole pixel, and the iris is never counted: what lies out of focus is blurred by rays alone.
const SHARE: f64 = 0.5;

/// Width at the start, and growth for each unit of the ray's parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Footprint {
    width: f64,
    growth: f64,
}

impl Footprint {
    /// Of a pixel of the given size in q, along a camera ray whose parameter is the depth.
    pub(crate) fn of_pixel(size: f64) -> Self {
        Self { width: 0.0, growth: SHARE * size }
    }

    /// Of a ray that sees as finely as one can.
    pub(crate) const SHARP: Self = Self { width: 0.0, growth: 0.0 };

    /// The width at a ray's parameter.
    pub(crate) fn at(&self, t: f64) -> f64 {
        self.width + self.growth * t
    }

    /// What goes on from there along a ray of unit direction; the last one's had the length `length`, and it was spread by
    /// a lobe.
    pub(crate) fn scattered(&self, t: f64, length: f64, spread: f32) -> Self {
        // A lobe seen by few rays: a tenth of its width each
        Self { width: self.at(t), growth: (self.growth / length).max(0.1 * f64::from(spread)) }
    }
}

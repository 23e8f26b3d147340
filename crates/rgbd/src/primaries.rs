//! The colours that R, G and B stand for.

/// CIE xy chromaticities of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Red x, y.
    pub red: [f32; 2],
    /// Green x, y.
    pub green: [f32; 2],
    /// Blue x, y.
    pub blue: [f32; 2],
    /// White x, y.
    pub white: [f32; 2],
}

impl Primaries {
    /// Rec. 709 / sRGB primaries with D65 white, OpenEXR's default.
    pub const REC709: Self = Self { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };
}

impl Default for Primaries {
    fn default() -> Self {
        Self::REC709
    }
}

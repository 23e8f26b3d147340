//! How a file is to be understood where it does not say so itself.

use optics::Film;

use crate::DepthConvention;

/// What to take from a file and how; the default leaves all to detection.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// The layer or part to take colour from, e.g. `ViewLayer.Combined`; an empty name is the unnamed layer.
    pub color: Option<String>,
    /// The channel to take depth from, e.g. `depth.Z`, or `PART/CHANNEL` in a file of many parts.
    pub depth: Option<String>,
    /// The view (eye) to take.
    pub view: Option<String>,
    /// What the depth channel holds.
    pub convention: DepthConvention,
    /// The distances that the stored numbers 0 and 1 stand for, where depth is normalised: the first may be the farther one.
    pub depth_range: Option<[f32; 2]>,
    /// A stored depth that means that nothing was hit, so that the pixel is infinitely far; it may be NaN. Infinity, 1e10 and
    /// above, and the largest half mean so anyway.
    pub background: Option<f32>,
    /// The film, for depths along the ray; the file's own camera comes first.
    pub film: Option<Film>,
    /// Metres in one unit of depth, in place of what the file says.
    pub metres_per_unit: Option<f64>,
    /// Windows of more pixels than this are refused before anything is allocated for them.
    pub max_pixels: u64,
}

impl ReadOptions {
    /// 2^27 pixels, a picture of 16384 x 8192.
    pub const MAX_PIXELS: u64 = 1 << 27;
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            color: None,
            depth: None,
            view: None,
            convention: DepthConvention::Planar,
            depth_range: None,
            background: None,
            film: None,
            metres_per_unit: None,
            max_pixels: Self::MAX_PIXELS,
        }
    }
}

//! A piece of a surface at a pixel, beside the first layer's own.

/// What a pixel holds besides its first surface: the near part of a silhouette, a hidden surface, a guessed background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fragment {
    /// Row-major index of the pixel in the view's window.
    pub(crate) index: u32,
    /// How much of the pixel it fills, above 0 and up to 1.
    pub(crate) cover: f32,
    /// 1/z in 1 / scene units.
    pub(crate) inverse_depth: f32,
    /// Whether it is the near part of a silhouette, before the pixel's first surface.
    pub(crate) is_before: bool,
    /// Change of inverse depth per pixel in x and y.
    pub(crate) slope: [f32; 2],
    /// Premultiplied with the cover.
    pub(crate) rgba: [f32; 4],
    /// How far its colour may be off, root mean square over channels; 0 where it is known.
    pub(crate) doubt: f32,
}

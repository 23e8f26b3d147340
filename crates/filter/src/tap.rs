//! A piece of surface on its way into a tile, and how much of a pixel's iris it fills there.

use crate::{
    forest::Piece,
    kernel::{Kernel, KernelTable, ellipse_share},
    lens_map::PixelLens,
};

/// Radius in pixels from which the slope of a surface counts; it counts in full one pixel later.
pub(crate) const SLOPE_FROM: f32 = 0.5;

/// The weight of a piece around a reference point, as a function of the offset to it and of the defocus.
///
/// The kernel changes with the focus from pixel to pixel; over a few pixels it is affine in it, to second order in the
/// change over the radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weight {
    /// The kernel at the reference point, times the cover, and its change per pixel of defocus.
    pub(crate) kernel: Kernel,
    pub(crate) change: Kernel,
    /// The slope factor is 1 + slope . offset.
    pub(crate) slope: [f32; 2],
    /// A lens point, for an iris of radius 1, is this times the offset; and its change per pixel of defocus.
    pub(crate) to_lens: f32,
    pub(crate) to_lens_change: f32,
    /// How far lens points are told apart: not at all where the blur is smaller than a pixel. 0 to 1.
    pub(crate) trust: f32,
    /// How sharply, per unit of lens radius.
    pub(crate) sharpness: f32,
    /// -1 where the iris is upside down.
    pub(crate) sign: f32,
    /// The share of the mirrored outline.
    pub(crate) mirror: f32,
    /// What its offset in iris coordinates is multiplied by along x, and divided by along y.
    pub(crate) stretch: f32,
    /// How much of the lens's departure from an upright iris it is drawn with.
    pub(crate) ellipse: f32,
    /// Signed radius of the blur in pixels.
    pub(crate) defocus: f32,
}

impl Weight {
    #[inline(always)]
    pub(crate) fn new(table: &KernelTable, piece: &Piece, lens: &PixelLens, max_radius: f32) -> Self {
        let defocus = lens.scale * (piece.inverse_depth - lens.focus);
        let radius = defocus.abs().min(max_radius);
        let (kernel, change) = table.of_squares(radius, piece.size);
        let sign = if defocus < 0.0 { -1.0 } else { 1.0 };
        let nothing = Kernel { a: 0.0, b: 0.0, weight: 0.0 };
        let per_defocus = if defocus.abs() < max_radius { sign * piece.cover } else { 0.0 };

        // A sloped surface counts by the part of the iris it fills; not where the footprint is too small to have one
        let trust = (radius - SLOPE_FROM).clamp(0.0, 1.0);
        let inverse = if trust > 0.0 { sign / defocus.abs().max(SLOPE_FROM) } else { 0.0 };
        let slope = piece.slope.map(|s| -trust * lens.scale * s * inverse);
        Self {
            kernel: nothing.plus(&kernel, piece.cover),
            change: nothing.plus(&change, per_defocus),
            slope,
            to_lens: inverse,
            to_lens_change: -inverse * inverse,
            trust,
            sharpness: (0.5 * radius).clamp(0.5, 4.0),
            sign,
            mirror: table.mirror(radius / piece.size),
            stretch: table.stretch(radius / piece.size),
            ellipse: ellipse_share(radius / piece.size),
            defocus,
        }
    }

    /// The same around a point where the defocus is `by` pixels more and the offsets are from `x`, `y` farther on.
    #[inline(always)]
    pub(crate) fn moved(&self, by: f32) -> Self {
        Self {
            kernel: self.kernel.plus(&self.change, by),
            to_lens: self.to_lens + by * self.to_lens_change,
            defocus: self.defocus + by,
            ..*self
        }
    }
}

//! Taps where the lens is the same all over a tile: each has one kernel for all pixels, and the footprints are discs.
//!
//! An untilted lens is like that, and a tap then takes fewer operations than in [`add_up`](crate::row::add_up), half as many bytes, and two rows at once where
//! vectors hold sixteen: together a fifth of the filter's time at 1280x720 and 40 px (`benches/results/2026-11-26-filter-speed.md`).

use fearless_simd::prelude::*;

use crate::{
    forest::Piece,
    row::{COLUMNS, Hidden, LANES, Sums},
    tap::Weight,
};

/// A piece that touches a tile; a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct EvenTap {
    x: f32,
    y: f32,
    /// How far its weight reaches, in pixels.
    reach: f32,
    /// The kernel, slope factor and lens points of [`Weight`].
    a: f32,
    b: f32,
    weight: f32,
    slope: [f32; 2],
    to_lens: f32,
    trust: f32,
    sharpness: f32,
    /// Colour as if it filled its pixels, and doubt.
    rgba: [f32; 4],
    doubt: f32,
}

impl EvenTap {
    pub(crate) fn new(piece: &Piece, weight: &Weight, reach: f32) -> Self {
        let &Piece { x, y, rgba, doubt, .. } = piece;
        let &Weight { kernel, slope, to_lens, trust, sharpness, .. } = weight;
        Self {
            x,
            y,
            reach,
            a: kernel.a,
            b: kernel.b,
            weight: kernel.weight,
            slope,
            to_lens,
            trust,
            sharpness,
            rgba,
            doubt,
        }
    }

    /// The same with its place relative to `center`.
    #[inline(always)]
    pub(crate) fn relative_to(&self, [x, y]: [f32; 2]) -> Self {
        Self { x: self.x - x, y: self.y - y, ..*self }
    }
}

/// The pixels that are gathered at once: the offsets of each from the centre of the block, and how far their rows lie from
/// `middle`.
pub(crate) struct Places<V> {
    x: V,
    y: V,
    middle: f32,
    half: f32,
}

impl<V> Places<V> {
    /// Eight pixels `step` apart in each of the rows at `ys`.
    #[inline(always)]
    pub(crate) fn new<S: Simd, const ROWS: usize>(simd: S, step: f32, ys: [f32; ROWS]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let (mut x, mut y) = (V::splat(simd, 0.0), V::splat(simd, 0.0));
        for (row, place) in ys.into_iter().enumerate() {
            for (i, column) in COLUMNS.into_iter().enumerate() {
                (x[row * LANES + i], y[row * LANES + i]) = (column * step, place);
            }
        }
        let [first, last] = [ys[0], ys[ROWS - 1]];
        Self { x, y, middle: 0.5 * (first + last), half: 0.5 * (last - first) }
    }
}

/// Adds up a slab, with regard to what is `hidden`.
#[inline(always)]
pub(crate) fn add_up_even<S: Simd, V: SimdFloat<S, Element = f32>, const DOUBT: bool>(
    simd: S,
    taps: &[EvenTap],
    at: &Places<V>,
    hidden: Option<&Hidden<V>>,
) -> Sums<V> {
    let mut sums = Sums::new(simd);
    for tap in taps {
        if (tap.y - at.middle).abs() - at.half > tap.reach {
            continue;
        }
        let [dx, dy] = [V::splat(simd, tap.x) - at.x, V::splat(simd, tap.y) - at.y];
        let squared = dx.mul_add(dx, dy * dy);
        let mut share = squared.mul_add(-tap.b, tap.a).max(0.0).min(tap.weight);
        let slope = dx.mul_add(tap.slope[0], dy.mul_add(tap.slope[1], 1.0));
        share *= slope.max(0.5).min(2.0);
        if let Some(hidden) = hidden {
            share *= hidden.open([dx, dy], V::splat(simd, tap.to_lens), (tap.sharpness, tap.trust));
        }

        sums.add::<S, DOUBT>(share, tap.rgba, tap.doubt);
        let point = share * (tap.to_lens * tap.trust);
        sums.lens = [point.mul_add(dx, sums.lens[0]), point.mul_add(dy, sums.lens[1])];
    }
    sums
}

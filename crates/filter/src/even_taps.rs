//! Taps where the lens is the same all over a tile: each has one kernel for all pixels, and the footprints are discs.
//!
//! An untilted lens is like that, and a tap then takes half as many operations as in [`add_up`](crate::row::add_up).

use fearless_simd::{f32x8, prelude::*};

use crate::{
    forest::Piece,
    row::{Hidden, Sums},
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

/// Adds up a slab for eight pixels in a row, with regard to what is `hidden`.
#[inline(always)]
pub(crate) fn add_up_even<S: Simd, const DOUBT: bool>(
    simd: S,
    taps: &[EvenTap],
    (x, y): (f32x8<S>, f32),
    hidden: Option<&Hidden<S>>,
) -> Sums<S> {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let mut sums = Sums { full: zero, rgba: [zero; 4], lens: [zero; 2], doubt: zero };
    for tap in taps {
        let dy = tap.y - y;
        if dy.abs() > tap.reach {
            continue;
        }
        let dx = f32x8::splat(simd, tap.x) - x;
        let of_row = f32x8::splat(simd, tap.a - tap.b * dy * dy);
        let mut share = (dx * dx).mul_add(-tap.b, of_row).max(0.0).min(tap.weight);
        let slope = dx.mul_add(tap.slope[0], f32x8::splat(simd, tap.slope[1] * dy + 1.0));
        share *= slope.max(0.5).min(2.0);
        if let Some(hidden) = hidden {
            let along = dx.mul_add(hidden.direction[0], hidden.direction[1] * dy) * tap.to_lens;
            let open = ((hidden.edge - along) * tap.sharpness + 0.5).max(0.0).min(1.0);
            share *= (hidden.strength * tap.trust).mul_add(open - 1.0, one);
        }

        sums.full += share;
        for (sum, c) in sums.rgba.iter_mut().zip(tap.rgba) {
            *sum = share.mul_add(c, *sum);
        }
        if DOUBT {
            sums.doubt = share.mul_add(tap.doubt, sums.doubt);
        }
        let point = share * (tap.to_lens * tap.trust);
        sums.lens = [point.mul_add(dx, sums.lens[0]), point.mul_add(dy, sums.lens[1])];
    }
    sums
}

//! Eight pixels of a row gather their neighbours, in the widest vectors that the processor has.
//!
//! Per neighbour and pixel this takes some 25 operations on vectors of eight; the plain twin is `plain.rs`.

use std::f32::consts::{FRAC_PI_4, PI};

use fearless_simd::{f32x8, prelude::*};

use crate::{
    cat_eye::Eye,
    kernel::{Kernel, KernelTable},
    lens_map::PixelLens,
    outline::Outline,
    tap::Weight,
};

/// Pixels across.
pub(crate) const LANES: usize = 8;

/// Where they lie around their middle.
pub(crate) const COLUMNS: [f32; LANES] = [-3.5, -2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5];

/// A piece as the pixels of a block see it; places relative to the block's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockTap {
    pub(crate) x: f32,
    pub(crate) y: f32,
    /// How far its weight reaches, in pixels.
    pub(crate) reach: f32,
    pub(crate) weight: Weight,
    /// Where the focus changes over the block by much of the blur radius: the cover and the side of the piece, from which
    /// each pixel takes a kernel of its own.
    pub(crate) steep: Option<[f32; 2]>,
    /// Colour as if it filled its pixels, and doubt.
    pub(crate) rgba: [f32; 4],
    pub(crate) doubt: f32,
}

/// What the pixels of a block share.
pub(crate) struct Shared<'a> {
    /// The lens at the block's centre.
    pub(crate) lens: &'a PixelLens,
    pub(crate) table: &'a KernelTable,
    /// Largest blur radius in pixels.
    pub(crate) max_radius: f32,
}

/// The pieces up to `end` from the end of the slab before; slabs come nearest first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slab {
    pub(crate) bin: i32,
    pub(crate) end: usize,
}

/// What a row of eight pixels gathered.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Row {
    /// Red, green, blue, alpha; not yet divided by `full`.
    pub(crate) rgba: [[f32; LANES]; 4],
    /// How full the iris is, 0 to 1.
    pub(crate) full: [f32; LANES],
    /// Doubt, not yet divided by `full`.
    pub(crate) doubt: [f32; LANES],
}

/// How a footprint is drawn around a pixel.
pub(crate) trait Footprint: Copy + Sync {
    /// Whether a second rim covers a part of the lens.
    const IS_CUT: bool = false;

    /// Whether it is a disc on the pixels.
    const IS_ROUND: bool = false;

    /// The footprint over a row of pixels, each with its eye.
    #[inline(always)]
    fn over_row(&self, _: impl FnOnce() -> [Eye; LANES]) -> Self {
        *self
    }

    /// The weight of a tap at an offset (x right, y down); `by` is what its defocus is more at each pixel.
    fn weight<S: Simd>(
        &self,
        tap: &BlockTap,
        shared: &Shared,
        x: f32x8<S>,
        y: f32x8<S>,
        kernel: &Lanes<S>,
        by: f32x8<S>,
    ) -> f32x8<S>;

    /// A lens point as one of a disc that stands for what is open.
    #[inline(always)]
    fn on_disc<S: Simd>(&self, point: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
        point
    }

    /// An offset in pixels as one in iris coordinates, where every footprint is as wide as high.
    fn to_iris<S: Simd>(&self, lens: &PixelLens, x: f32x8<S>, y: f32x8<S>) -> [f32x8<S>; 2];
}

/// A kernel for each lane.
pub(crate) struct Lanes<S: Simd> {
    a: f32x8<S>,
    b: f32x8<S>,
    weight: f32x8<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S, kernel: &Kernel, change: &Kernel, defocus: f32x8<S>) -> Self {
        let lane = |at: f32, by: f32| f32x8::splat(simd, by).mul_add(defocus, f32x8::splat(simd, at));
        Self { a: lane(kernel.a, change.a), b: lane(kernel.b, change.b), weight: lane(kernel.weight, change.weight) }
    }

    /// Each lane's own kernel: the focus may cross the piece, where the affine one would fall below 0.
    fn steep(simd: S, shared: &Shared, weight: &Weight, [cover, size]: [f32; 2], defocus: &[f32; LANES]) -> Self {
        let [mut a, mut b, mut full] = [[0.0; LANES]; 3];
        for (i, by) in defocus.iter().enumerate() {
            let radius = (weight.defocus + by).abs().min(shared.max_radius);
            let (kernel, _) = shared.table.of_squares(radius, size);
            (a[i], b[i], full[i]) = (cover * kernel.a, cover * kernel.b, cover * kernel.weight);
        }
        let [a, b, weight] = [a, b, full].map(|lanes| f32x8::from_slice(simd, &lanes));
        Self { a, b, weight }
    }

    #[inline(always)]
    pub(crate) fn at(&self, metric: f32x8<S>) -> f32x8<S> {
        (self.a - self.b * metric).max(0.0).min(self.weight)
    }
}

/// A full disc, not foreshortened.
#[derive(Clone, Copy)]
pub(crate) struct Round;

impl Footprint for Round {
    const IS_ROUND: bool = true;

    #[inline(always)]
    fn weight<S: Simd>(
        &self,
        _: &BlockTap,
        _: &Shared,
        x: f32x8<S>,
        y: f32x8<S>,
        kernel: &Lanes<S>,
        _: f32x8<S>,
    ) -> f32x8<S> {
        kernel.at(x.mul_add(x, y * y))
    }

    #[inline(always)]
    fn to_iris<S: Simd>(&self, _: &PixelLens, x: f32x8<S>, y: f32x8<S>) -> [f32x8<S>; 2] {
        [x, y]
    }
}

/// Any iris, foreshortened and skewed or not.
#[derive(Clone, Copy)]
pub(crate) struct Shaped<'a>(pub(crate) &'a Outline);

impl Shaped<'_> {
    /// An offset in the coordinates in which the footprint of a tap is drawn.
    #[inline(always)]
    pub(crate) fn offset<S: Simd>(&self, tap: &BlockTap, lens: &PixelLens, x: f32x8<S>, y: f32x8<S>) -> [f32x8<S>; 2] {
        let m = lens.drawn(tap.weight.ellipse);
        let [mut u, mut v] = [x * m[0] + y * m[1], x * m[2] + y * m[3]];
        // Undo the skew where the footprint is large enough to have a shape
        if lens.skew != [0.0; 2] && tap.weight.defocus.abs() > 0.5 {
            let lean = (u * lens.skew[0] + v * lens.skew[1]) * (tap.weight.ellipse / tap.weight.defocus) + 1.0;
            let lean = lean.max(0.5).min(2.0);
            (u, v) = (u / lean, v / lean);
        }
        [u * (tap.weight.sign * tap.weight.stretch), v * (tap.weight.sign / tap.weight.stretch)]
    }

    /// The weight of a tap there.
    #[inline(always)]
    pub(crate) fn weight_at<S: Simd>(&self, tap: &BlockTap, [u, v]: [f32x8<S>; 2], kernel: &Lanes<S>) -> f32x8<S> {
        match self.0 {
            Outline::Disc => kernel.at(u.mul_add(u, v * v)),
            Outline::Polygon { normals, .. } => {
                let side = |n: &[f32; 2]| u * n[0] + v * n[1];
                let first = side(&normals[0]);
                let (high, low) = normals[1..].iter().fold((first, first), |(high, low), n| {
                    let side = side(n);
                    (high.max(side), low.min(side))
                });
                let weight = kernel.at(high);
                if tap.weight.mirror == 0.0 {
                    return weight;
                }
                // The mirrored outline's metric is that of the opposite offset
                (kernel.at(-low) - weight) * tap.weight.mirror + weight
            }
        }
    }
}

impl Footprint for Shaped<'_> {
    #[inline(always)]
    fn weight<S: Simd>(
        &self,
        tap: &BlockTap,
        shared: &Shared,
        x: f32x8<S>,
        y: f32x8<S>,
        kernel: &Lanes<S>,
        _: f32x8<S>,
    ) -> f32x8<S> {
        self.weight_at(tap, self.offset(tap, shared.lens, x, y), kernel)
    }

    #[inline(always)]
    fn to_iris<S: Simd>(&self, lens: &PixelLens, x: f32x8<S>, y: f32x8<S>) -> [f32x8<S>; 2] {
        let m = &lens.to_iris;
        [x * m[0] + y * m[1], x * m[2] + y * m[3]]
    }
}

/// What a slab adds up while its taps pass.
pub(crate) struct Sums<V> {
    pub(crate) full: V,
    pub(crate) rgba: [V; 4],
    /// Weight times lens point.
    pub(crate) lens: [V; 2],
    pub(crate) doubt: V,
}

impl<V> Sums<V> {
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let zero = V::splat(simd, 0.0);
        Self { full: zero, rgba: [zero; 4], lens: [zero; 2], doubt: zero }
    }

    /// Adds a tap's colour by its share.
    #[inline(always)]
    pub(crate) fn add<S: Simd, const DOUBT: bool>(&mut self, share: V, rgba: [f32; 4], doubt: f32)
    where
        V: SimdFloat<S, Element = f32>,
    {
        self.full += share;
        for (sum, c) in self.rgba.iter_mut().zip(rgba) {
            *sum = share.mul_add(c, *sum);
        }
        if DOUBT {
            self.doubt = share.mul_add(doubt, self.doubt);
        }
    }
}

/// The part of the lens that nearer things hide: the points beyond `edge` in a direction.
pub(crate) struct Hidden<V> {
    pub(crate) direction: [V; 2],
    pub(crate) edge: V,
    /// How far the hidden points lie on one side, 0 to 1.
    pub(crate) strength: V,
}

impl<V> Hidden<V> {
    /// From the share of the lens that is hidden and the sum of share times lens point: a half plane that hides as much,
    /// believed as far as its centroid is that of a half plane.
    #[inline(always)]
    fn new<S: Simd>(simd: S, [share, x, y]: [V; 3]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let length = x.mul_add(x, y * y).sqrt();
        let scale = V::splat(simd, 1.0) / length.max(1e-12);
        // The chord at distance t cuts (acos t - t sqrt(1 - t^2)) / pi off the unit disc; this is its inverse within 0.01
        let open = (share * -2.0 + 1.0).max(-1.0).min(1.0);
        let edge = open * (open * open * (1.0 - FRAC_PI_4) + FRAC_PI_4);
        let half = (edge * -1.0).mul_add(edge, V::splat(simd, 1.0)).max(0.0);
        let moment = half * half.sqrt() * (2.0 / (3.0 * PI));
        let strength = (length / moment.max(1e-3)).min(1.0);
        Self { direction: [x * scale, y * scale], edge, strength }
    }

    /// The share of a tap that is not hidden, which is seen through the lens point `to_lens` times (u, v).
    #[inline(always)]
    pub(crate) fn open<S: Simd>(&self, [u, v]: [V; 2], to_lens: V, (sharpness, trust): (f32, f32)) -> V
    where
        V: SimdFloat<S, Element = f32>,
    {
        let along = u.mul_add(self.direction[0], v * self.direction[1]) * to_lens;
        let open = ((self.edge - along) * sharpness + 0.5).max(0.0).min(1.0);
        (self.strength * trust).mul_add(open - 1.0, 1.0)
    }
}

/// Gathers the pixels of a vector, nearest slab first, until the iris of each is full.
///
/// `add_up` adds up the taps of a slab, of which a part of the lens may be hidden.
#[inline(always)]
pub(crate) fn fill_irises<S: Simd, V: SimdFloat<S, Element = f32>>(
    simd: S,
    slabs: &[Slab],
    add_up: impl Fn(std::ops::Range<usize>, Option<&Hidden<V>>) -> Sums<V>,
) -> Irises<V> {
    let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
    let (mut full, mut rgba, mut doubt) = (zero, [zero; 4], zero);
    // What hides the slabs to come, and the last slab, which hides only what does not touch it
    let (mut seen, mut last, mut last_bin) = ([zero; 3], [zero; 3], V::splat(simd, f32::MAX));
    let mut start = 0;
    for slab in slabs {
        if full.simd_ge(1.0).all_true() {
            break;
        }
        let part = start..slab.end;
        start = slab.end;

        // The last slab hides this one if there is a gap between them
        let bin = slab.bin as f32;
        let is_apart = (last_bin - bin).simd_gt(1.0);
        for (seen, last) in seen.iter_mut().zip(&mut last) {
            *seen += is_apart.select(*last, zero);
            *last = is_apart.select(zero, *last);
        }
        let sums = if seen[0].simd_gt(1e-4).any_true() {
            add_up(part, Some(&Hidden::new(simd, seen)))
        } else {
            add_up(part, None)
        };

        // Let it in as far as the iris is open
        let is_there = sums.full.simd_gt(0.0);
        if !is_there.any_true() {
            continue;
        }
        let taken = sums.full.min(one - full);
        let share = is_there.select(taken / sums.full.max(f32::MIN_POSITIVE), zero);
        full += taken;
        for (rgba, sum) in rgba.iter_mut().zip(sums.rgba) {
            *rgba = sum.mul_add(share, *rgba);
        }
        doubt = sums.doubt.mul_add(share, doubt);
        let new = [taken, sums.lens[0] * share, sums.lens[1] * share];
        for ((seen, last), new) in seen.iter_mut().zip(&mut last).zip(new) {
            *seen += is_there.select(*last, zero);
            *last = is_there.select(new, *last);
        }
        last_bin = is_there.select(V::splat(simd, bin), last_bin);
    }

    Irises { rgba, full, doubt }
}

/// What the pixels of a vector gathered, as in [`Row`].
pub(crate) struct Irises<V> {
    rgba: [V; 4],
    full: V,
    doubt: V,
}

impl<V> Irises<V> {
    /// The row of its pixels from `start` on.
    #[inline(always)]
    pub(crate) fn row<S: Simd>(&self, start: usize) -> Row
    where
        V: SimdFloat<S, Element = f32>,
    {
        let lanes = |v: &V| *v.as_slice()[start..].first_chunk().expect("eight lanes from a multiple of eight on");
        Row { rgba: [0, 1, 2, 3].map(|c| lanes(&self.rgba[c])), full: lanes(&self.full), doubt: lanes(&self.doubt) }
    }
}

/// Adds up a slab: doubt if it is wanted, lens points if another slab comes, with regard to what is `hidden` or not.
///
/// `defocus` is what the defocus of everything is more at each pixel than at the block's centre, in pixels.
#[inline(always)]
pub(crate) fn add_up<S: Simd, F: Footprint, const DOUBT: bool, const LENS: bool>(
    simd: S,
    footprint: &F,
    shared: &Shared,
    taps: &[BlockTap],
    (x, y): (f32x8<S>, f32),
    by: &[f32; LANES],
    hidden: Option<&Hidden<f32x8<S>>>,
) -> Sums<f32x8<S>> {
    let (mut sums, defocus) = (Sums::<f32x8<S>>::new(simd), f32x8::from_slice(simd, by));
    for tap in taps {
        let dy = tap.y - y;
        if dy.abs() > tap.reach {
            continue;
        }
        let weight = &tap.weight;
        let (dx, dy) = (f32x8::splat(simd, tap.x) - x, f32x8::splat(simd, dy));
        let kernel = match tap.steep {
            None => Lanes::new(simd, &weight.kernel, &weight.change, defocus),
            Some(piece) => Lanes::steep(simd, shared, weight, piece, by),
        };
        let mut share = footprint.weight(tap, shared, dx, dy, &kernel, defocus);

        // Count a sloped surface by the part of the iris it fills
        let slope = f32x8::splat(simd, weight.slope[0]).mul_add(dx, dy * weight.slope[1] + 1.0);
        share *= slope.max(0.5).min(2.0);

        // Leave out the part of the lens that nearer things hide
        let [mut u, mut v] = footprint.to_iris(shared.lens, dx, dy);
        let mut to_lens =
            f32x8::splat(simd, weight.to_lens_change).mul_add(defocus, f32x8::splat(simd, weight.to_lens));
        if F::IS_CUT {
            [u, v] = footprint.on_disc([u * to_lens, v * to_lens]);
            to_lens = f32x8::splat(simd, 1.0);
        }
        if let Some(hidden) = hidden {
            share *= hidden.open([u, v], to_lens, (weight.sharpness, weight.trust));
        }

        sums.add::<S, DOUBT>(share, tap.rgba, tap.doubt);
        if LENS {
            let point = share * to_lens * weight.trust;
            sums.lens = [point.mul_add(u, sums.lens[0]), point.mul_add(v, sums.lens[1])];
        }
    }
    sums
}

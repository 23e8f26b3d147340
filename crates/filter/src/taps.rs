//! What may touch a tile, and what of it may touch a block.

use fearless_simd::{f32x8, f32x16, prelude::*};
use rgbd::PixelWindow;

use crate::{
    cells::Range,
    even_taps::{EvenTap, Places, add_up_even},
    forest::Piece,
    gather::Gather,
    lens_map::PixelLens,
    row::{BlockTap, COLUMNS, Footprint, Irises, LANES, Row, Shared, Slab, add_up, fill_irises},
    tap::Weight,
    view_lens::TileLens,
};

/// Depth of a slab in pixels of blur radius: surfaces nearer to each other do not hide one another.
pub(crate) const SLAB_PX: f32 = 0.5;

/// A merged square stands for its pixels where the blur radius is at least this many of its sides.
pub(crate) const SIDES_PER_RADIUS: f32 = 5.0;

/// Weights are affine in the focus over a tile where the radius changes by at most this share, or this many pixels.
const STEADY_SHARE: f32 = 0.04;
const STEADY_PX: f32 = 0.02;

/// Over a block they are where it changes by at most this share, or by as many pixels as above; else each pixel has its
/// own.
const STEEP_SHARE: f32 = 0.08;

/// Rows of a block by the spread of the defocus over its tile in pixels: weights are affine in the focus over a block.
pub(crate) fn block_rows(spread: f32) -> u32 {
    match spread {
        s if s <= 0.25 => 8,
        s if s <= 1.0 => 4,
        _ => 2,
    }
}

/// How a piece touches a tile.
#[derive(Clone, Copy)]
struct Touch {
    /// Whether its weight serves the whole tile.
    is_steady: bool,
    bin: i32,
    reach: f32,
}

/// What a thread keeps of taps from tile to tile.
#[derive(Default)]
pub(crate) struct Taps {
    /// The pieces, colour as if each filled its pixels.
    pieces: Vec<Piece>,
    /// Their weights around the tile's centre; where the lens is the same all over the tile, the taps instead.
    weights: Vec<Weight>,
    unsorted: Vec<EvenTap>,
    touches: Vec<Touch>,
    /// The taps, nearest slab first.
    order: Vec<u32>,
    counts: Vec<u32>,
    /// Places and reaches in that order.
    xs: Vec<f32>,
    ys: Vec<f32>,
    reaches: Vec<f32>,
    /// Such taps in that order.
    even: Vec<EvenTap>,
    /// Those of a block, of one kind or the other.
    block: Vec<BlockTap>,
    even_block: Vec<EvenTap>,
    slabs: Vec<Slab>,
}

impl Taps {
    /// Whether there is no light in them.
    pub(crate) fn are_black(&self) -> bool {
        self.pieces.iter().all(|piece| piece.rgba == [0.0; 4])
    }
}

/// Eight receiving places in each of some rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockGrid {
    pub(crate) first: [f32; 2],
    /// Pixels from one to the next.
    pub(crate) step: f32,
    pub(crate) rows: u32,
    /// Whether no edge is in sight, so that nothing hides anything.
    pub(crate) is_plain: bool,
}

impl Gather<'_> {
    /// Collects what may touch a tile, nearest slab first.
    #[inline(always)]
    pub(crate) fn collect<F: Footprint>(&self, tile: PixelWindow, lens: &TileLens, scratch: &mut Taps) {
        let Taps { pieces, weights, touches, order, counts, xs, ys, reaches, unsorted, even, .. } = scratch;
        let is_even = F::IS_ROUND && lens.is_even;
        pieces.clear();
        weights.clear();
        unsorted.clear();
        touches.clear();
        let reach = |range: [f32; 2]| lens.reach(range, self.max_radius);
        let serves = |piece: &Piece| {
            self.merge && lens.least_radius(piece.range).min(self.max_radius) >= SIDES_PER_RADIUS * piece.size
        };
        // Slabs stand at fixed depths; beyond the limit of the blur they are all one
        let slab = |s: f32| whole((s * self.px / SLAB_PX).clamp(-1e9, 1e9));
        let far = |by: f32| {
            slab(lens.center.focus + by * (self.max_radius + lens.spread + 4.0) / lens.center.scale.max(1e-30))
        };
        let (lowest, highest) = (far(-1.0), far(1.0));
        // The smallest square has sides of two pixels
        let merges = |range: Range| lens.largest_radius(range) >= SIDES_PER_RADIUS * 2.0;
        self.forest.visit(tile, &reach, &serves, &merges, &mut |piece| {
            let weight = Weight::new(&self.table, piece, &lens.center, self.max_radius);
            let is_steady = lens.spread <= STEADY_PX
                || (self.merge && lens.spread <= STEADY_SHARE * weight.defocus.abs() && weight.defocus.abs() > 3.0);
            let bin = slab(piece.inverse_depth).clamp(lowest, highest);
            let reach = reach(piece.range) + 0.5 * (piece.size - 1.0) * 1.5;
            let share = 1.0 / piece.cover;
            let mut piece = *piece;
            piece.rgba = piece.rgba.map(|c| c * share);
            if is_even {
                unsorted.push(EvenTap::new(&piece, &weight, reach));
            } else {
                weights.push(weight);
            }
            pieces.push(piece);
            touches.push(Touch { is_steady, bin, reach });
        });

        // Sort by slab, nearest first; within a slab the order is that of the visit
        let (low, high) =
            touches.iter().fold((i32::MAX, i32::MIN), |(low, high), tap| (low.min(tap.bin), high.max(tap.bin)));
        order.clear();
        order.resize(touches.len(), 0);
        if touches.is_empty() || i64::from(high) - i64::from(low) > 1 << 16 {
            order.iter_mut().enumerate().for_each(|(i, place)| *place = i as u32);
            order.sort_by_key(|&i| std::cmp::Reverse(touches[i as usize].bin));
        } else {
            counts.clear();
            counts.resize((high - low) as usize + 2, 0);
            touches.iter().for_each(|tap| counts[(high - tap.bin) as usize + 1] += 1);
            (1..counts.len()).for_each(|i| counts[i] += counts[i - 1]);
            for (i, tap) in touches.iter().enumerate() {
                let place = &mut counts[(high - tap.bin) as usize];
                order[*place as usize] = i as u32;
                *place += 1;
            }
        }

        // Lay out what finds the taps of a block
        [&mut *xs, &mut *ys, &mut *reaches].into_iter().for_each(Vec::clear);
        for &i in order.iter() {
            xs.push(pieces[i as usize].x);
            ys.push(pieces[i as usize].y);
            reaches.push(touches[i as usize].reach);
        }
        even.clear();
        if is_even {
            even.extend(order.iter().map(|&i| unsorted[i as usize]));
        }
        // Fill the last vector with what touches nothing
        let whole = order.len().next_multiple_of(LANES);
        [xs, ys, reaches].into_iter().for_each(|values| values.resize(whole, -1e9));
    }

    /// One block of a tile; `put` takes a row's index and what it gathered, if it is wanted.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    pub(crate) fn block<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        tile_lens: &TileLens,
        block: BlockGrid,
        is_wanted: impl Fn(u32) -> bool,
        scratch: &mut Taps,
        mut put: impl FnMut(u32, &Row),
    ) {
        let BlockGrid { first: [x, y], step, rows, is_plain } = block;
        let half = [0.5 * step * (LANES - 1) as f32, 0.5 * step * (rows as f32 - 1.0)];
        let center = [x + half[0], y + half[1]];
        let lens_at = |x: f32, y: f32| self.lens.at(f64::from(x), f64::from(y));
        let lens = lens_at(center[0], center[1]);

        // What the defocus is more at each pixel than at the centre
        let defocus = |x: f32, y: f32| lens.scale * (lens.focus - lens_at(x, y).focus);
        let corner = defocus(x, y);
        let (across, down) = (defocus(x + step, y) - corner, defocus(x, y + step) - corner);
        let spread = 3.5 * across.abs() + 0.5 * (rows as f32 - 1.0) * down.abs();
        self.find(simd, tile_lens, &lens, (center, half, spread), is_plain, scratch);

        let shared = Shared { lens: &lens, table: &self.table, max_radius: self.max_radius };
        let Taps { even, block, even_block, slabs, .. } = scratch;
        if !even.is_empty() {
            let place = |row: u32| row as f32 * step - half[1];
            // Two rows at once where a vector holds them
            if S::f32s::LEN >= 2 * LANES {
                for row in (0..rows).step_by(2).filter(|&row| is_wanted(row) || is_wanted(row + 1)) {
                    let at = Places::<f32x16<S>>::new(simd, step, [place(row), place(row + 1)]);
                    let found = gather_even::<_, _, DOUBT>(simd, slabs, even_block, &at);
                    for k in (0..2).filter(|&k| is_wanted(row + k)) {
                        put(row + k, &found.row(k as usize * LANES));
                    }
                }
            } else {
                for row in (0..rows).filter(|&row| is_wanted(row)) {
                    let at = Places::<f32x8<S>>::new(simd, step, [place(row)]);
                    put(row, &gather_even::<_, _, DOUBT>(simd, slabs, even_block, &at).row(0));
                }
            }
            return;
        }
        let columns = f32x8::from_slice(simd, &COLUMNS) * step;
        for row in (0..rows).filter(|&row| is_wanted(row)) {
            let place = (columns, row as f32 * step - half[1]);
            let mut by = [0.0; LANES];
            for (i, by) in by.iter_mut().enumerate() {
                *by = corner + across * i as f32 + down * row as f32;
            }
            let eye = |i: usize| self.lens.eye_at(f64::from(x + step * i as f32), f64::from(y + step * row as f32));
            let footprint = footprint.over_row(|| std::array::from_fn(eye));
            let gathered = fill_irises(
                simd,
                slabs,
                #[inline(always)]
                |part, hidden| {
                    let taps = &block[part];
                    if slabs.len() == 1 {
                        add_up::<S, F, DOUBT, false>(simd, &footprint, &shared, taps, place, &by, hidden)
                    } else {
                        add_up::<S, F, DOUBT, true>(simd, &footprint, &shared, taps, place, &by, hidden)
                    }
                },
            );
            put(row, &gathered.row(0));
        }
    }

    /// Finds the taps that may touch a block, given by its centre, its pixels' largest offsets from there, and how far the
    /// defocus differs from that at the centre. If the block is plain they are one slab, of the first surface alone.
    #[inline(always)]
    fn find<S: Simd>(
        &self,
        simd: S,
        tile_lens: &TileLens,
        lens: &PixelLens,
        (center, half, spread): ([f32; 2], [f32; 2], f32),
        is_plain: bool,
        scratch: &mut Taps,
    ) {
        let Taps { pieces, weights, touches, order, xs, ys, reaches, even, block, even_block, slabs, .. } = scratch;
        block.clear();
        even_block.clear();
        slabs.clear();
        let by = tile_lens.center.scale * (tile_lens.center.focus - lens.focus);
        let mut last_bin = i32::MAX;
        for chunk in (0..order.len()).step_by(LANES) {
            let part = chunk..chunk + LANES;
            let mut hits = touching(simd, &xs[part.clone()], &ys[part.clone()], &reaches[part], center, half);
            while hits != 0 {
                let i = chunk + hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let at = order[i] as usize;
                let (piece, tap) = (&pieces[at], touches[at]);
                if is_plain && !piece.is_first {
                    continue;
                }
                let bin = if is_plain { 0 } else { tap.bin };
                if bin != last_bin {
                    if last_bin != i32::MAX {
                        slabs.push(Slab { bin: last_bin, end: block.len() + even_block.len() });
                    }
                    last_bin = bin;
                }
                if let Some(tap) = even.get(i) {
                    even_block.push(tap.relative_to(center));
                    continue;
                }
                let weight = if tap.is_steady {
                    weights[at].moved(by)
                } else {
                    Weight::new(&self.table, piece, lens, self.max_radius)
                };
                block.push(BlockTap {
                    x: piece.x - center[0],
                    y: piece.y - center[1],
                    reach: tap.reach,
                    weight,
                    steep: (spread > STEEP_SHARE * weight.defocus.abs().max(STEADY_PX / STEEP_SHARE))
                        .then_some([piece.cover, piece.size]),
                    rgba: piece.rgba,
                    doubt: piece.doubt,
                });
            }
        }
        if last_bin != i32::MAX {
            slabs.push(Slab { bin: last_bin, end: block.len() + even_block.len() });
        }
    }
}

/// Gathers the pixels at some places from even taps.
#[inline(always)]
fn gather_even<S: Simd, V: SimdFloat<S, Element = f32>, const DOUBT: bool>(
    simd: S,
    slabs: &[Slab],
    taps: &[EvenTap],
    at: &Places<V>,
) -> Irises<V> {
    fill_irises(
        simd,
        slabs,
        #[inline(always)]
        |part, hidden| add_up_even::<S, V, DOUBT>(simd, &taps[part], at, hidden),
    )
}

/// The largest whole number that is no larger than `value`.
#[inline(always)]
fn whole(value: f32) -> i32 {
    let cut = value as i32;
    cut - i32::from(cut as f32 > value)
}

/// Which of eight taps may touch the block around `center`, a bit for each.
#[inline(always)]
fn touching<S: Simd>(simd: S, xs: &[f32], ys: &[f32], reaches: &[f32], center: [f32; 2], half: [f32; 2]) -> u64 {
    #[inline(always)]
    fn gap<S: Simd>(simd: S, values: &[f32], center: f32, half: f32) -> f32x8<S> {
        ((f32x8::from_slice(simd, values) - center).abs() - half).max(0.0)
    }
    let (dx, dy, reach) =
        (gap(simd, xs, center[0], half[0]), gap(simd, ys, center[1], half[1]), f32x8::from_slice(simd, reaches));
    (dx * dx + dy * dy).simd_le(reach * reach.abs()).to_bitmask()
}

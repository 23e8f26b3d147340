//! Eight cells of two rows sum up their neighbours, in vectors.

use fearless_simd::{f32x8, prelude::*};

use crate::row::LANES;

/// Cells of a row that a vector may start at, and the room for it.
pub(crate) const STARTS: usize = 128;
pub(crate) const SPAN: usize = STARTS + LANES;

/// The sum of the weights, then red, green, blue and alpha, divided by it.
pub(crate) const CHANNELS: usize = 5;

/// Neighbours that are summed up beforehand.
const GROUP: usize = 4;

/// A row of cells: kernels that are 1 inside, `min(max(a - b m, 0), 1)` of the metric m of an offset in cells, and weights.
pub(crate) struct Row {
    pub(crate) a: [f32; SPAN],
    pub(crate) b: [f32; SPAN],
    pub(crate) weight: [f32; SPAN],
    /// Colour times weight.
    pub(crate) rgba: [[f32; SPAN]; 4],
    /// Weight and colour of each cell and the `GROUP` - 1 after it, where `inside` is positive.
    groups: [[f32; SPAN]; CHANNELS],
    /// Change of a per cell of defocus.
    pub(crate) turn: [f32; SPAN],
    /// One over the defocus, no more than 1.
    pub(crate) inverse: [f32; SPAN],
    /// The share of the outline that is upside down.
    pub(crate) mirrored: [f32; SPAN],
    /// How much of an ellipse is drawn as if the iris were upright.
    pub(crate) upright: [f32; SPAN],
    /// Offsets of a larger metric receive nothing from this row.
    pub(crate) limit: f32,
    /// At offsets of no larger metric all kernels of this row are 1; 0 where that is not known.
    inside: f32,
}

impl Default for Row {
    fn default() -> Self {
        let line = [0.0; SPAN];
        Self {
            a: line,
            b: line,
            weight: line,
            rgba: [line; 4],
            groups: [line; CHANNELS],
            turn: line,
            inverse: line,
            mirrored: line,
            upright: line,
            limit: 0.0,
            inside: 0.0,
        }
    }
}

impl Row {
    /// Forgets what its first `count` cells and the vector after them hold.
    pub(crate) fn clear(&mut self, count: usize) {
        let Self { a, b, weight, rgba, groups: _, turn, inverse, mirrored, upright, limit, inside } = self;
        [*limit, *inside] = [0.0; 2];
        for line in [a, b, weight, turn, inverse, mirrored, upright].into_iter().chain(rgba) {
            line[..(count + LANES).min(SPAN)].fill(0.0);
        }
    }

    /// Sums up groups of neighbours, for kernels that depend on the metric alone: what lies within all of them needs no look at
    /// each. The cells `from..to` of `count` are there.
    #[inline(always)]
    pub(crate) fn group(&mut self, (from, to): (usize, usize), count: usize, channels: usize) {
        let inside = self.a[from..to].iter().zip(&self.b[from..to]).fold(f32::INFINITY, |inside, (a, b)| {
            let own = (a - 1.0) / b;
            if own < inside { own } else { inside }
        });
        // A group fits into two cells to each side
        self.inside = if inside >= 4.0 && inside.is_finite() { inside } else { 0.0 };
        if self.inside == 0.0 {
            return;
        }
        let end = (count + LANES).min(SPAN) - GROUP + 1;
        let lines = std::iter::once(&self.weight).chain(&self.rgba[..channels - 1]);
        for (group, line) in self.groups.iter_mut().zip(lines) {
            for (group, cells) in group[..end].iter_mut().zip(line.windows(GROUP)) {
                *group = (cells[0] + cells[1]) + (cells[2] + cells[3]);
            }
        }
    }
}

/// Where a neighbour lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Offset {
    /// Metric of its offset, and of the opposite one.
    pub(crate) metric: f32,
    pub(crate) mirrored: f32,
    /// What both are more for an upright iris.
    pub(crate) upright: [f32; 2],
    /// What its defocus is more, for the focus of the receiving cell, in cells.
    pub(crate) bend: f32,
    /// w R e_z . u of the exact footprint.
    pub(crate) skew: f32,
}

/// A neighbour that two rows receive from.
type Pair = [Offset; 2];

/// Neighbours in one row, from `start` to `end` in `pairs`; all of `inside` have a share of 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    first: usize,
    start: usize,
    inside: [usize; 2],
    end: usize,
}

/// A run of the filter, cells to each side, and the lens.
pub(crate) type OffsetsKey = (u64, i32, [f32; 9]);

/// Of which neighbours cells receive, row by row.
#[derive(Debug, Default)]
pub(crate) struct Offsets {
    /// Cells to each side.
    pub(crate) reach: i32,
    /// What they were made for.
    pub(crate) key: Option<OffsetsKey>,
    /// For each row from `-reach` to `reach + 1` below the upper cell: where its first neighbour stands in a row that
    /// starts `reach` before the cell, and its neighbours in `pairs`.
    rows: Vec<Span>,
    pairs: Vec<Pair>,
    /// Of each pair the least metric, of either orientation, and the largest that is not mirrored.
    least: Vec<f32>,
    largest: Vec<f32>,
}

impl Offsets {
    /// Takes the offsets that are wanted, up to `reach` in each direction.
    pub(crate) fn fill(&mut self, reach: i32, offset: impl Fn(i32, i32) -> (Offset, bool)) {
        self.reach = reach;
        self.rows.clear();
        self.pairs.clear();
        for dy in -reach..=reach + 1 {
            let is_wanted = |dx: &i32| {
                let upper = dy <= reach && offset(*dx, dy).1;
                upper || (dy > -reach && offset(*dx, dy - 1).1)
            };
            let first = (-reach..=reach).find(is_wanted).unwrap_or(0);
            let last = (first..=reach).rev().find(is_wanted).unwrap_or(first - 1);
            let start = self.pairs.len();
            self.pairs.extend((first..=last).map(|dx| [offset(dx, dy).0, offset(dx, dy - 1).0]));
            let end = self.pairs.len();
            self.rows.push(Span { first: (first + reach) as usize, start, inside: [end; 2], end });
        }
        let least = |[upper, lower]: &Pair| upper.metric.min(upper.mirrored).min(lower.metric).min(lower.mirrored);
        self.least.clear();
        self.least.extend(self.pairs.iter().map(least));
        self.largest.clear();
        self.largest.extend(self.pairs.iter().map(|[upper, lower]| upper.metric.max(lower.metric)));
    }

    /// Of which neighbours cells receive from certain rows, the first of which lies `reach` above them: without those at
    /// both ends that lie beyond a row's limit.
    pub(crate) fn spans(&self, rows: &[Row], spans: &mut Vec<Span>) {
        spans.clear();
        spans.extend(rows.iter().zip(&self.rows).map(|(row, span)| {
            let is_near = |&metric: &f32| metric <= row.limit;
            let least = &self.least[span.start..span.end];
            let Some(before) = least.iter().position(is_near) else {
                return Span { inside: [span.start; 2], end: span.start, ..*span };
            };
            let after = least.iter().rev().position(is_near).unwrap_or(0);
            let (start, end) = (span.start + before, span.end - after);
            let inside = self.inside(row, start, end);
            Span { first: span.first + before, start, inside, end }
        }));
    }

    /// Which of the pairs lie inside all kernels of a row, in whole groups.
    fn inside(&self, row: &Row, start: usize, end: usize) -> [usize; 2] {
        if row.inside == 0.0 {
            return [end; 2];
        }
        // An outline is convex: whatever lies between two that are inside is so too
        let (largest, is_inside) = (&self.largest[start..end], |&metric: &f32| metric <= row.inside);
        let Some(from) = largest.iter().position(is_inside) else { return [end; 2] };
        let last = largest.iter().rposition(is_inside).unwrap_or(from);
        let groups = (last + 1 - from) / GROUP;
        [start + from, start + from + groups * GROUP]
    }
}

/// What the eight cells from column `x` on receive, in two rows; `rows` starts `reach` above the upper one. Alpha is left out
/// if all is `OPAQUE`.
#[inline(always)]
pub(crate) fn sum<S: Simd, const BENT: bool, const ELLIPTIC: bool, const ODD: bool, const OPAQUE: bool>(
    simd: S,
    rows: &[Row],
    spans: &[Span],
    offsets: &Offsets,
    x: usize,
) -> [[f32x8<S>; CHANNELS]; 2] {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let channels = if OPAQUE { CHANNELS - 1 } else { CHANNELS };
    let mut sums = [[zero; CHANNELS]; 2];
    for (row, span) in rows.iter().zip(spans) {
        // The mask tells the compiler that the vector lies within the line
        let start = |k: usize| (x + span.first + k - span.start) & (STARTS - 1);
        if !BENT {
            let mut groups = [zero; CHANNELS];
            for k in (span.inside[0]..span.inside[1]).step_by(GROUP) {
                let i = start(k);
                for (sum, line) in groups[..channels].iter_mut().zip(&row.groups) {
                    *sum += f32x8::from_slice(simd, &line[i..i + LANES]);
                }
            }
            for sums in &mut sums {
                sums.iter_mut().zip(&groups[..channels]).for_each(|(sum, group)| *sum += *group);
            }
        }
        let [inside, outside] = if BENT { [span.end; 2] } else { span.inside };
        for k in (span.start..inside).chain(outside..span.end) {
            let pair = &offsets.pairs[k];
            let i = start(k);
            let at = |line: &[f32; SPAN]| f32x8::from_slice(simd, &line[i..i + LANES]);
            let (a, b) = (at(&row.a), at(&row.b));
            for (sums, offset) in sums.iter_mut().zip(pair) {
                let cover = |metric: f32, upright: f32| {
                    let mut metric = f32x8::splat(simd, metric);
                    if ELLIPTIC {
                        metric = at(&row.upright).mul_add(f32x8::splat(simd, upright), metric);
                        let lean = at(&row.inverse) * (one - at(&row.upright)) * offset.skew;
                        metric *= lean.mul_add(lean * 3.0 - 2.0, one);
                    }
                    let mut cover = (-b).mul_add(metric, a);
                    if BENT {
                        cover = at(&row.turn).mul_add(f32x8::splat(simd, offset.bend), cover);
                    }
                    cover.max(0.0).min(1.0)
                };
                let mut share = cover(offset.metric, offset.upright[0]);
                if ODD {
                    share = (cover(offset.mirrored, offset.upright[1]) - share).mul_add(at(&row.mirrored), share);
                }
                if BENT {
                    // 1 / (1 + change of the defocus)^3, to second order
                    let change = at(&row.inverse) * offset.bend;
                    share *= change.mul_add(change * 6.0 - 3.0, one);
                }
                sums[0] = share.mul_add(at(&row.weight), sums[0]);
                for (sum, line) in sums[1..channels].iter_mut().zip(&row.rgba) {
                    *sum = share.mul_add(at(line), *sum);
                }
            }
        }
    }

    sums
}

/// Sums as they are put: colours divided by the sum of the weights. Alpha is 1 if all is `OPAQUE`.
#[inline(always)]
pub(crate) fn divided<S: Simd>(simd: S, mut sums: [f32x8<S>; CHANNELS], is_opaque: bool) -> [[f32; LANES]; CHANNELS] {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let is_there = sums[0].simd_gt(0.0);
    // A quotient and no product, so that alpha is 1 in the same bits whether it is summed up or known
    let total = is_there.select(sums[0], one);
    sums[1..].iter_mut().for_each(|sum| *sum /= total);
    if is_opaque {
        sums[CHANNELS - 1] = is_there.select(one, zero);
    }
    let mut result = [[0.0; LANES]; CHANNELS];
    result.iter_mut().zip(sums).for_each(|(result, sum)| sum.store_slice(result));
    result
}

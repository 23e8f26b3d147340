//! The lattice at work: cells sum up what is laid out around them, and pixels are interpolated between the cells.

use fearless_simd::{f32x8, prelude::*};
use rgbd::PixelWindow;

use crate::{
    lattice::{LAST_LEVEL, Lattice, Plan},
    lattice_sum::{CHANNELS, Offsets, Row, Span, divided, sum},
    outline::Outline,
    row::LANES,
    upsample::{MARGIN, upsample},
    view_lens::TileLens,
};

/// What a thread keeps from tile to tile.
#[derive(Default)]
pub(crate) struct LatticeScratch {
    rows: Vec<Row>,
    /// By level.
    offsets: [Offsets; LAST_LEVEL as usize + 1],
    spans: Vec<Span>,
    sums: [Vec<f32>; CHANNELS],
    totals: [Vec<f32>; CHANNELS],
}

impl Lattice<'_> {
    /// Sums up the blocks of a tile without an edge in sight. `put` takes eight pixels of a row: how full the iris is
    /// (above 0 where anything is received, and true only if that is wanted: `OPEN`), and the colour.
    #[inline(always)]
    pub(crate) fn sum_up<S: Simd, const OPEN: bool>(
        &self,
        simd: S,
        plan: &Plan,
        lens: &TileLens,
        scratch: &mut LatticeScratch,
        mut put: impl FnMut(i32, i32, &[[f32; LANES]; CHANNELS]),
    ) {
        let (part, level) = (plan.part, plan.finest);
        let is_wanted = |x: i32, y: i32| !self.in_sight.at(x, y);
        if plan.finest < plan.coarsest {
            self.add_up_levels(simd, plan, lens, scratch);
            self.put_totals::<S, OPEN>(simd, part, lens, &scratch.totals, put);
            return;
        }
        let width = self.each_cell(
            simd,
            plan,
            (level, OPEN),
            lens,
            scratch,
            #[inline(always)]
            |rows, (x, y), (i, to), planes, sums| {
                let mut sums = divided(simd, sums, self.is_opaque);
                if OPEN {
                    // The weights were divided by the blur radius
                    let full = sums[0].iter_mut().zip(&rows.inverse[i..]).filter(|(_, own)| **own != 0.0);
                    full.for_each(|(full, own)| *full = (*full / own.abs()).min(1.0));
                }
                if level == 0 {
                    put(x, y, &sums);
                } else {
                    let sums = planes.iter_mut().zip(sums);
                    sums.for_each(|(plane, sums)| plane[to..to + LANES].copy_from_slice(&sums));
                }
            },
        );
        if level > 0 {
            upsample(part, level, &scratch.sums, width, is_wanted, put);
        }
    }

    /// Adds up the sums of all levels of a plan, each surface in cells that its blur allows.
    #[inline(always)]
    fn add_up_levels<S: Simd>(&self, simd: S, plan: &Plan, lens: &TileLens, scratch: &mut LatticeScratch) {
        let part = plan.part;
        for total in &mut scratch.totals {
            total.clear();
            total.resize(part.area(), 0.0);
        }
        for level in plan.finest..=plan.coarsest {
            let mut totals = std::mem::take(&mut scratch.totals);
            let width = self.each_cell(
                simd,
                plan,
                (level, false),
                lens,
                scratch,
                #[inline(always)]
                |_, (x, y), (_, to), planes, sums| {
                    let to = if level == 0 { part.index(x, y) } else { to };
                    let planes = if level == 0 { &mut totals } else { planes };
                    planes.iter_mut().zip(sums).for_each(|(plane, sum)| sum.store_slice(&mut plane[to..to + LANES]));
                },
            );
            if level > 0 {
                // Weights are divided by the blur radius in cells
                let share = 1.0 / (1 << level) as f32;
                let is_wanted = |x: i32, y: i32| !self.in_sight.at(x, y);
                upsample(part, level, &scratch.sums, width, is_wanted, |x, y, sums| {
                    let at = part.index(x, y);
                    for (total, sums) in totals.iter_mut().zip(sums) {
                        total[at..at + LANES].iter_mut().zip(sums).for_each(|(total, sum)| *total += share * sum);
                    }
                });
            }
            scratch.totals = totals;
        }
    }

    /// Puts what all levels add up to.
    #[inline(always)]
    fn put_totals<S: Simd, const OPEN: bool>(
        &self,
        simd: S,
        part: PixelWindow,
        lens: &TileLens,
        totals: &[Vec<f32>; CHANNELS],
        mut put: impl FnMut(i32, i32, &[[f32; LANES]; CHANNELS]),
    ) {
        for y in part.y..part.y_end() {
            for x in (part.x..part.x_end()).step_by(LANES).filter(|&x| !self.in_sight.at(x, y)) {
                let at = part.index(x, y);
                let sums = [0, 1, 2, 3, 4].map(|c| f32x8::from_slice(simd, &totals[c][at..at + LANES]));
                let mut sums = divided(simd, sums, self.is_opaque);
                if OPEN {
                    for (full, x) in sums[0].iter_mut().zip(x..) {
                        *full = (*full * self.radius_of(0, x, y, lens).max(1.0)).min(1.0);
                    }
                }
                put(x, y, &sums);
            }
        }
    }

    /// Sums up the cells of one level of a plan, eight of two rows at a time. `take` receives for each row the one that it
    /// was laid out in, the first cell's place, its columns there and among the sums, the sums of the level, and the eight
    /// cells' own. Returns how many sums there are to a row.
    #[inline(always)]
    fn each_cell<S: Simd>(
        &self,
        simd: S,
        plan: &Plan,
        (level, open): (u32, bool),
        lens: &TileLens,
        scratch: &mut LatticeScratch,
        mut take: impl FnMut(&Row, (i32, i32), (usize, usize), &mut [Vec<f32>; CHANNELS], [f32x8<S>; CHANNELS]),
    ) -> usize {
        let (part, side) = (plan.part, 1 << level);
        let margin = if level == 0 { 0 } else { MARGIN };
        let [columns, lines] = [part.width, part.height].map(|length| length as i32 / side + 2 * margin);
        let first = (part.x / side - margin, part.y / side - margin);
        let LatticeScratch { rows, offsets, spans, sums: planes, .. } = scratch;
        let offsets = &mut offsets[level as usize];
        self.offsets(lens, plan.largest_on(level), offsets);
        let reach = offsets.reach;

        // Lay out what the cells receive from
        let is_elliptic = lens.center.is_elliptic() || lens.center.skew != [0.0; 2];
        let is_bent = lens.focus_slope != [0.0; 2] || is_elliptic || self.is_odd();
        let (width, height) = ((columns + 2 * reach) as usize, (lines + 2 * reach + 1) as usize);
        rows.resize_with(height.max(rows.len()), Row::default);
        for (j, row) in rows[..height].iter_mut().enumerate() {
            let start = (first.0 - reach, first.1 - reach + j as i32);
            if is_bent {
                self.lay_out::<true>(plan, (level, open), start, width, lens, row);
            } else {
                self.lay_out::<false>(plan, (level, open), start, width, lens, row);
            }
        }

        let width = (columns as usize).next_multiple_of(LANES);
        planes.iter_mut().for_each(|plane| plane.resize(width * (lines as usize + 1), 0.0));
        for j in (0..lines).step_by(2) {
            let rows = &rows[j as usize..(j + 2 * reach + 2) as usize];
            offsets.spans(rows, spans);
            for i in (0..columns).step_by(LANES) {
                if level == 0 && self.in_sight.at(part.x + i, part.y + j) {
                    continue;
                }
                let sums = self.sum(simd, (rows, spans, offsets), i as usize, [is_bent, is_elliptic]);
                for (row, sums) in sums.into_iter().enumerate() {
                    let place = (part.x + i, part.y + j + row as i32);
                    let to = (j as usize + row) * width + i as usize;
                    take(&rows[reach as usize + row], place, ((i + reach) as usize, to), planes, sums);
                }
            }
        }
        width
    }

    /// Whether the outline upside down is another one.
    fn is_odd(&self) -> bool {
        match &self.outline {
            Outline::Disc => false,
            Outline::Polygon { normals, .. } => normals.len() % 2 == 1,
        }
    }

    #[inline(always)]
    fn sum<S: Simd>(
        &self,
        simd: S,
        (rows, spans, offsets): (&[Row], &[Span], &Offsets),
        x: usize,
        [is_bent, is_elliptic]: [bool; 2],
    ) -> [[f32x8<S>; CHANNELS]; 2] {
        let kind = (is_bent, is_elliptic, self.is_odd());
        match (kind, self.is_opaque) {
            ((false, ..), true) => sum::<S, false, false, false, true>(simd, rows, spans, offsets, x),
            ((false, ..), false) => sum::<S, false, false, false, false>(simd, rows, spans, offsets, x),
            ((true, false, false), true) => sum::<S, true, false, false, true>(simd, rows, spans, offsets, x),
            ((true, false, false), false) => sum::<S, true, false, false, false>(simd, rows, spans, offsets, x),
            ((true, true, false), true) => sum::<S, true, true, false, true>(simd, rows, spans, offsets, x),
            ((true, true, false), false) => sum::<S, true, true, false, false>(simd, rows, spans, offsets, x),
            ((true, _, true), true) => sum::<S, true, true, true, true>(simd, rows, spans, offsets, x),
            ((true, _, true), false) => sum::<S, true, true, true, false>(simd, rows, spans, offsets, x),
        }
    }
}

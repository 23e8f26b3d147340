//! The lattice at work: kernels are laid out, summed up, and interpolated between the cells.

use fearless_simd::{f32x8, prelude::*};
use rgbd::PixelWindow;

use crate::{
    kernel::{ellipse_share, mirrored_share},
    lattice::{LAST_LEVEL, Lattice, Plan, STEPS, reach_in_cells},
    lattice_sum::{CHANNELS, Offset, Offsets, Row, SPAN, Span, divided, sum},
    lens_map::PixelLens,
    outline::Outline,
    row::LANES,
    surface::finite,
    upsample::{MARGIN, upsample},
    view_lens::TileLens,
};

/// The limit of a row from which nothing is received.
const NOTHING: f32 = -1.0;

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

    /// Lays out `count` cells of a row, starting at `first`.
    #[inline(always)]
    fn lay_out<const BENT: bool>(
        &self,
        plan: &Plan,
        (level, open): (u32, bool),
        first: (i32, i32),
        count: usize,
        lens: &TileLens,
        row: &mut Row,
    ) {
        let level_ref = level.checked_sub(1).map(|i| &self.levels[i as usize]);
        let window = level_ref.map_or(self.surface.window, |level| level.window);
        let from = (window.x - first.0).clamp(0, count as i32) as usize;
        let to = (window.x_end() - first.0).clamp(0, count as i32) as usize;
        let is_there = (window.y..window.y_end()).contains(&first.1) && from < to;
        if !is_there || from > 0 || to < count {
            row.clear(count);
        }
        if !is_there {
            return;
        }
        let start = window.index(first.0 + from as i32, first.1);
        let part = start..start + (to - from);
        let inverse_depth = level_ref.map_or(&self.surface.inverse_depth, |level| &level.inverse_depth);

        // Blur radii in cells, for the focus at the cells themselves
        let side = (1 << level) as f32;
        let center = |k: i32| (k as f32 + 0.5) * side - 0.5;
        let per_cell = lens.focus_slope[0] * side;
        let at_start = lens.focus_at(center(first.0), center(first.1)) + per_cell * from as f32;
        let (scale, limit) = (lens.center.scale / side, self.max_radius / side);
        let less = if level == 0 { 0.0 } else { (1.0 - 1.0 / (side * side)) / (12.0 * self.variance) };
        let mut radii = [0.0; SPAN];
        let (radii, inverse) = (&mut radii[..to - from], &mut row.inverse[from..to]);
        let mut row_radius = 0.0_f32;
        for (i, ((radius, inverse), &s)) in
            radii.iter_mut().zip(&mut *inverse).zip(&inverse_depth[part.clone()]).enumerate()
        {
            let defocus = scale * (s - (at_start + per_cell * i as f32));
            let cut = defocus.abs().min(limit);
            *radius = if level == 0 { cut } else { (cut * cut - less).max(0.25).sqrt() };
            row_radius = if *radius > row_radius { *radius } else { row_radius };
            *inverse = defocus;
        }

        // Other levels take what this one does not
        let (mut others, largest) = ([false; SPAN], plan.largest_on(level));
        let others = &mut others[..to - from];
        if plan.finest < plan.coarsest {
            self.mark_others(plan, level, (first.0 + from as i32, first.1), lens, others);
            if others.iter().all(|&is_other| is_other) {
                row.limit = NOTHING;
                return;
            }
            let own = radii.iter().zip(&*others).filter(|(_, is_other)| !**is_other);
            row_radius = own.fold(0.0, |most, (&radius, _)| if radius > most { radius } else { most });
        }

        // Edges and weights from the table, kernels from the edges
        let last = (self.table.len() - 1) as f32;
        let [edges, changes] = &mut [[0.0; SPAN]; 2];
        let (edges, changes) = (&mut edges[..to - from], &mut changes[..to - from]);
        let cells = radii.iter().zip(&mut *edges).zip(&mut *changes).zip(&mut row.weight[from..to]);
        for (((&own, edge), change), weight) in cells {
            let place = (own * STEPS).min(last);
            let k = place as usize;
            let t = place - k as f32;
            let Some(&[first_edge, edge_change, first_weight, weight_change]) = self.table.get(k) else { continue };
            *edge = first_edge + t * edge_change;
            *weight = first_weight + t * weight_change;
            if BENT {
                *change = edge_change;
            }
        }
        for ((a, b), &edge) in row.a[from..to].iter_mut().zip(&mut row.b[from..to]).zip(&*edges) {
            [*a, *b] = self.outline.ramp(edge);
        }
        if BENT {
            let cells = row.turn[from..to].iter_mut().zip(&*edges).zip(&*changes).zip(&row.b[from..to]);
            for ((((turn, &edge), &change), &b), &defocus) in cells.zip(&*inverse) {
                let per_cell = STEPS * change * b * self.outline.metric_change(edge);
                *turn = if defocus.abs() > limit { 0.0 } else { per_cell.copysign(defocus) };
            }
            for ((mirrored, &defocus), &own) in row.mirrored[from..to].iter_mut().zip(&*inverse).zip(&*radii) {
                let mirror = mirrored_share(own);
                *mirrored = if defocus < 0.0 { 1.0 - mirror } else { mirror };
            }
            for (upright, &own) in row.upright[from..to].iter_mut().zip(&*radii) {
                *upright = 1.0 - ellipse_share(own);
            }
        }
        for (i, _) in others.iter().enumerate().filter(|(_, is_other)| **is_other) {
            let at = from + i;
            (row.a[at], row.b[at], row.turn[at], row.weight[at]) = (1.0, 0.0, 0.0, 0.0);
        }
        if BENT || open {
            for (inverse, own) in inverse.iter_mut().zip(&*radii) {
                *inverse = (1.0 / own.max(1.0)).copysign(*inverse);
            }
        }

        // The focus changes on the way to a receiving cell
        let bend = lens.focus_slope[0].hypot(lens.focus_slope[1]) * lens.center.scale;
        row.limit = self.metric_limit((row_radius * (1.0 + 1.5 * bend) + 2.0 * bend).min(largest), &lens.center);

        // Colours by weight; nobody asks for an alpha that is 1
        let channels = if self.is_opaque { 3 } else { 4 };
        match level_ref {
            None => {
                let data = self.colors[0].window();
                let start = data.index(first.0 + from as i32, first.1);
                for (out, plane) in row.rgba[..channels].iter_mut().zip(self.colors) {
                    let values = &plane.values()[start..start + (to - from)];
                    let weighted = out[from..to].iter_mut().zip(&row.weight[from..to]).zip(values);
                    if self.is_finite {
                        weighted.for_each(|((out, weight), c)| *out = weight * c);
                    } else {
                        weighted.for_each(|((out, weight), &c)| *out = weight * finite(c));
                    }
                }
            }
            Some(level) => {
                for (weight, cover) in row.weight[from..to].iter_mut().zip(&level.cover[part.clone()]) {
                    *weight *= cover;
                }
                for (out, plane) in row.rgba[..channels].iter_mut().zip(&level.rgba) {
                    let values = &plane[part.clone()];
                    for ((out, weight), &c) in out[from..to].iter_mut().zip(&row.weight[from..to]).zip(values) {
                        *out = weight * c;
                    }
                }
            }
        }
        if !BENT {
            row.group((from, to), count, channels + 1);
        }
    }

    /// Marks those of the cells from `x` on in a row that a coarser level of the plan takes, or a finer one.
    #[inline(always)]
    fn mark_others(&self, plan: &Plan, level: u32, (x, y): (i32, i32), lens: &TileLens, others: &mut [bool]) {
        if level > plan.finest {
            others.iter_mut().zip(x..).for_each(|(is_other, x)| *is_other = !self.allows(level, x, y, lens));
        }
        let end = x + others.len() as i32;
        for coarser in level + 1..=plan.coarsest {
            let shift = coarser - level;
            for cell in x >> shift..=(end - 1) >> shift {
                if self.allows(coarser, cell, y >> shift, lens) {
                    let [from, to] = [cell, cell + 1].map(|cell| ((cell << shift).clamp(x, end) - x) as usize);
                    others[from..to].fill(true);
                }
            }
        }
    }

    /// The metric beyond which a kernel of a radius in cells is 0.
    #[inline(always)]
    fn metric_limit(&self, radius: f32, lens: &PixelLens) -> f32 {
        let skew = lens.skew[0].hypot(lens.skew[1]);
        let entry = self.table[((radius * STEPS).ceil() as usize).min(self.table.len() - 1)];
        let [a, b] = self.outline.ramp(entry[0]);
        (a / b) * (1.0 + skew) * (1.0 + skew) + 0.5
    }

    /// The offsets that a blur of at most `largest` cells reaches over; those that are there stay where they are the same.
    fn offsets(&self, lens: &TileLens, largest: f32, offsets: &mut Offsets) {
        let center = &lens.center;
        let reach = reach_in_cells(lens, largest);
        let bend = lens.focus_slope.map(|s| s * center.scale);
        let PixelLens { to_iris: [a, b, c, d], upright, skew: [along, across], .. } = *center;
        let key = (self.run, reach, [a, b, c, d, upright, along, across, bend[0], bend[1]]);
        if offsets.key == Some(key) {
            return;
        }

        // What the largest blur of this reach needs
        let wider = lens.stretch * (1.0 + center.skew[0].hypot(center.skew[1]));
        let limit = self.metric_limit(reach as f32 / wider - 1.0, center);
        let is_disc = matches!(self.outline, Outline::Disc);
        let metrics = |dx: i32, dy: i32| {
            let (x, y) = (dx as f32, dy as f32);
            let m = &center.to_iris;
            let (u, v) = (m[0] * x + m[1] * y, m[2] * x + m[3] * y);
            let skew = center.skew[0] * u + center.skew[1] * v;
            let bend = bend[0] * x + bend[1] * y;
            let less = if is_disc { bend * bend } else { 0.0 };
            let [upright, .., down] = center.drawn(0.0);
            let [metric, mirrored] = [self.outline.metric(u, v), self.outline.metric(-u, -v)];
            let [a, b] = [upright * x, down * y];
            Offset {
                metric: metric - less,
                mirrored: mirrored - less,
                upright: [self.outline.metric(a, b) - metric, self.outline.metric(-a, -b) - mirrored],
                bend,
                skew,
            }
        };
        offsets.fill(reach, |dx, dy| {
            let offset = metrics(dx, dy);
            let least = offset.metric.min(offset.mirrored);
            (offset, least <= limit)
        });
        offsets.key = Some(key);
    }
}

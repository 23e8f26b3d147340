//! What the cells of a lattice receive from: rows of kernels and colours, and at which offsets.

use crate::{
    kernel::{ellipse_share, mirrored_share},
    lattice::{Lattice, Plan, STEPS, reach_in_cells},
    lattice_sum::{Offset, Offsets, Row, SPAN},
    lens_map::PixelLens,
    outline::Outline,
    surface::finite,
    view_lens::TileLens,
};

/// The limit of a row from which nothing is received.
const NOTHING: f32 = -1.0;

impl Lattice<'_> {
    /// Lays out `count` cells of a row, starting at `first`.
    #[inline(always)]
    pub(crate) fn lay_out<const BENT: bool>(
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
    pub(crate) fn offsets(&self, lens: &TileLens, largest: f32, offsets: &mut Offsets) {
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

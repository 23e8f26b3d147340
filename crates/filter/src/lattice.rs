//! Rung 3 where no edge is in sight: a plain sum over a lattice of cells.
//!
//! On one continuous surface nothing is hidden, so neither order nor lens points matter, and the gather of
//! [`gather`](crate::gather) becomes the mean of the neighbours' colours by their weights. Of the slope factor `d0 / d` only
//! the neighbour's 1/d is left, since d0 is the receiving pixel's own defocus wherever the neighbour lies.
//!
//! The cells are pixels, or squares of 2, 4, ... pixels of which the least blur radius around spans at least
//! [`SIDES_PER_RADIUS`]. Then the sum is only taken at the centres of the cells, and what lies between is interpolated.

use fearless_simd::prelude::*;
use rayon::prelude::*;
use rgbd::{PixelWindow, Plane};

use crate::{
    cells::{BLOCK, Cells, EMPTY, InSight, Range, blocks_of, joined},
    color_pyramid::ColorLevel,
    kernel::{KernelTable, Outline},
    lattice_sum::{CHANNELS, Offset, Offsets, Row, SPAN, Span, sum},
    lens_map::PixelLens,
    row::LANES,
    surface::{Surface, finite},
    upsample::{MARGIN, upsample},
    view_lens::{TileLens, ViewLens},
};

/// How many sides of a cell the least blur radius spans.
pub(crate) const SIDES_PER_RADIUS: f32 = 8.0;

/// Blurs of more cells are left to the gather, which finds a size for each piece.
const MOST_CELLS: i32 = 36;

/// Where the defocus of a thing changes by more than this from pixel to pixel, in pixels of radius, kernels of less than the
/// second are left to the gather.
const STEEP_FOCUS: f32 = 0.02;
const LEAST_RADIUS_WHERE_STEEP: f32 = 2.0;

/// Table entries per cell of radius.
const STEPS: f32 = 32.0;

/// Coarsest level.
const LAST_LEVEL: u32 = 5;

/// The first surface as a lattice.
pub(crate) struct Lattice<'a> {
    cells: &'a Cells,
    in_sight: InSight,
    surface: &'a Surface,
    /// The picture that the surface was made of, as it came.
    colors: &'a [Plane; 4],
    levels: Vec<ColorLevel>,
    outline: Outline,
    /// Whether all alpha is 1, and all colour finite.
    is_opaque: bool,
    is_finite: bool,
    /// By radius: start and slope of the ramp for a kernel that is 1 inside, weight, share of the mirrored outline.
    table: Vec<[f32; 4]>,
    variance: f32,
    max_radius: f32,
    range: Range,
}

/// What a thread keeps from tile to tile.
#[derive(Default)]
pub(crate) struct LatticeScratch {
    rows: Vec<Row>,
    offsets: Offsets,
    spans: Vec<Span>,
    sums: [Vec<f32>; CHANNELS],
}

/// How a tile is summed up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plan {
    /// Cells of 2^level pixels.
    level: u32,
    /// Largest blur radius in pixels.
    largest: f32,
}

impl<'a> Lattice<'a> {
    /// The lattice of a view's first `surface`; the blur is cut to the first of the limits in pixels, and there is none
    /// larger than the second.
    pub(crate) fn new(
        lens: &ViewLens<'a>,
        surface: &'a Surface,
        cells: &'a Cells,
        table: &KernelTable,
        limits: [f32; 2],
    ) -> Self {
        let colors = lens.view.frame().layers()[0].color.planes();
        let in_sight = in_sight(lens, cells, limits[0].min(limits[1]));
        let variance = lens.camera.iris.shape().variance() as f32;
        let [max_radius, largest_radius] = limits;

        // Halve the surface as often as the blur allows
        let base = |y: i32| {
            let (window, data) = (surface.window, colors[0].window());
            let start = window.index(window.x, y);
            let from = data.index(window.x, y);
            let rgba = [0, 1, 2, 3].map(|c| &colors[c].values()[from..from + window.width as usize]);
            (&surface.inverse_depth[start..start + window.width as usize], None, rgba)
        };
        let count = (largest_radius.min(max_radius) / SIDES_PER_RADIUS).max(1.0).log2().floor() as u32;
        let mut levels: Vec<ColorLevel> = Vec::new();
        for _ in 0..count.min(LAST_LEVEL) {
            let next = match levels.last() {
                None => ColorLevel::halved(surface.window, base),
                Some(last) => ColorLevel::halved(last.window, |y| last.row(y)),
            };
            levels.push(next);
        }

        let range = cells.square_ranges.iter().fold(EMPTY, |all, &range| joined(all, range));
        let entry = |i: usize| {
            let radius = i as f32 / STEPS;
            let (kernel, _) = table.with_slope(radius);
            [kernel.a / kernel.weight, kernel.b / kernel.weight, kernel.weight / radius.max(1.0), table.mirror(radius)]
        };
        let table_of = (0..=(MOST_CELLS + 1) as usize * STEPS as usize).map(entry).collect();
        let outline = table.outline().clone();
        let is_opaque = all(&colors[3], |alpha| alpha == 1.0);
        let is_finite = colors.iter().all(|plane| all(plane, |value| finite(value) == value));
        Self {
            cells,
            in_sight,
            surface,
            colors,
            levels,
            outline,
            is_opaque,
            is_finite,
            table: table_of,
            variance,
            max_radius,
            range,
        }
    }

    /// Whether the cell at a pixel is left to the gather.
    pub(crate) fn sees_edge(&self, x: i32, y: i32) -> bool {
        self.in_sight.at(x, y)
    }

    /// How to sum up a tile; none if a gather does it at less cost.
    fn plan(&self, tile: PixelWindow, lens: &TileLens) -> Option<Plan> {
        let reach = |range: Range| lens.reach(range, self.max_radius);
        let (mut least, mut largest) = (f32::INFINITY, 0.0_f32);
        for i in self.cells.squares.around(tile, reach(self.range).min(1e6) as i32) {
            let range = self.cells.square_ranges[i];
            let reach = reach(range);
            if self.cells.squares.squared_gap(i, tile) <= reach * reach {
                least = least.min(lens.least_radius(range));
                largest = largest.max(lens.largest_radius(range));
            }
        }
        let (least, largest) = (least.min(self.max_radius), largest.min(self.max_radius));
        // A kernel is affine in the focus on the way from one pixel to another; next to the plane of focus it is not
        let bend = lens.focus_slope[0].hypot(lens.focus_slope[1]) * lens.center.scale;
        if bend > STEEP_FOCUS && least < LEAST_RADIUS_WHERE_STEEP {
            return None;
        }
        let level = (least / SIDES_PER_RADIUS).max(1.0).log2().floor() as u32;
        let level = level.min(self.levels.len() as u32);
        let cells = (largest / (1 << level) as f32 + 1.0) * lens.stretch;
        ((cells as i32) < MOST_CELLS && lens.center.scale > 0.0).then_some(Plan { level, largest })
    }

    /// Sums up the blocks of a tile without an edge in sight; whether it does. `put` takes eight pixels of a row: how full
    /// the iris is (above 0 where anything is received, and true only if that is wanted: `OPEN`), and the colour.
    #[inline(always)]
    pub(crate) fn blocks<S: Simd, const OPEN: bool>(
        &self,
        simd: S,
        tile: PixelWindow,
        lens: &TileLens,
        scratch: &mut LatticeScratch,
        mut put: impl FnMut(i32, i32, &[[f32; LANES]; CHANNELS]),
    ) -> bool {
        let part = self.part_without_edges(tile);
        if part.is_empty() {
            return false;
        }
        let Some(plan) = self.plan(tile, lens) else { return false };
        let side = 1 << plan.level;
        let part = part.aligned_to(side.max(BLOCK));
        let margin = if plan.level == 0 { 0 } else { MARGIN };
        let [columns, lines] = [part.width, part.height].map(|length| length as i32 / side + 2 * margin);
        let first = (part.x / side - margin, part.y / side - margin);
        self.offsets(lens, plan.largest / side as f32, &mut scratch.offsets);
        let reach = scratch.offsets.reach;

        // Lay out what the cells receive from
        let is_bent = lens.focus_slope != [0.0; 2] || lens.center.skew != [0.0; 2] || self.is_odd();
        let (width, height) = ((columns + 2 * reach) as usize, (lines + 2 * reach + 1) as usize);
        scratch.rows.resize_with(height.max(scratch.rows.len()), Row::default);
        for (j, row) in scratch.rows[..height].iter_mut().enumerate() {
            let start = (first.0 - reach, first.1 - reach + j as i32);
            let largest = plan.largest / side as f32;
            if is_bent {
                self.lay_out::<true>(plan.level, start, width, lens, largest, row);
            } else {
                self.lay_out::<false>(plan.level, start, width, lens, largest, row);
            }
        }

        // Sum up eight cells of two rows at a time
        let width = (columns as usize).next_multiple_of(LANES);
        scratch.sums.iter_mut().for_each(|plane| plane.resize(width * (lines as usize + 1), 0.0));
        for j in (0..lines).step_by(2) {
            let rows = &scratch.rows[j as usize..(j + 2 * reach + 2) as usize];
            scratch.offsets.spans(rows, &mut scratch.spans);
            for i in (0..columns).step_by(LANES) {
                if plan.level == 0 && self.sees_edge(part.x + i, part.y + j) {
                    continue;
                }
                let mut sums = self.sum(simd, (rows, &scratch.spans, &scratch.offsets), i as usize, is_bent);
                for (row, sums) in sums.iter_mut().enumerate() {
                    if OPEN {
                        // The weights were divided by the blur radius
                        let own = &scratch.rows[(j + reach) as usize + row].inverse[(i + reach) as usize..];
                        let full = sums[0].iter_mut().zip(own).filter(|(_, own)| **own != 0.0);
                        full.for_each(|(full, own)| *full = (*full / own.abs()).min(1.0));
                    }
                    if plan.level == 0 {
                        put(part.x + i, part.y + j + row as i32, sums);
                    } else {
                        let to = (j as usize + row) * width + i as usize;
                        for (plane, sums) in scratch.sums.iter_mut().zip(sums) {
                            plane[to..to + LANES].copy_from_slice(sums);
                        }
                    }
                }
            }
        }
        if plan.level > 0 {
            upsample(part, plan.level, &scratch.sums, width, |x, y| !self.sees_edge(x, y), put);
        }
        true
    }

    /// The smallest window that holds all blocks of a tile without an edge in sight.
    fn part_without_edges(&self, tile: PixelWindow) -> PixelWindow {
        let block = |(x, y)| PixelWindow { x, y, width: BLOCK as u32, height: BLOCK as u32 };
        let blocks = blocks_of(tile).filter(|&(x, y)| !self.sees_edge(x, y)).map(block);
        blocks.reduce(|all, block| all.union(&block)).unwrap_or(PixelWindow { width: 0, height: 0, ..tile })
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
        is_bent: bool,
    ) -> [[[f32; LANES]; CHANNELS]; 2] {
        match (is_bent, self.is_odd(), self.is_opaque) {
            (false, false, true) => sum::<S, false, false, true>(simd, rows, spans, offsets, x),
            (false, false, false) => sum::<S, false, false, false>(simd, rows, spans, offsets, x),
            (true, false, true) => sum::<S, true, false, true>(simd, rows, spans, offsets, x),
            (true, false, false) => sum::<S, true, false, false>(simd, rows, spans, offsets, x),
            (_, true, true) => sum::<S, true, true, true>(simd, rows, spans, offsets, x),
            (_, true, false) => sum::<S, true, true, false>(simd, rows, spans, offsets, x),
        }
    }

    /// Lays out `count` cells of a row, starting at `first`.
    #[inline(always)]
    fn lay_out<const BENT: bool>(
        &self,
        level: u32,
        first: (i32, i32),
        count: usize,
        lens: &TileLens,
        largest: f32,
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

        // Kernels; with a = 1/2 + e^2 b and b = 1 / (2 e), a change of a disc's edge e alone changes a twice as much as both
        let is_disc = matches!(self.outline, Outline::Disc);
        let last = (self.table.len() - 2) as f32;
        for (i, (&own, &defocus)) in (from..to).zip(radii.iter().zip(&*inverse)) {
            let place = (own * STEPS).min(last);
            let k = place as usize;
            let t = place - k as f32;
            let Some([low, high]) = self.table[k..].first_chunk() else { continue };
            let step = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
            row.a[i] = low[0] + t * step[0];
            row.b[i] = low[1] + t * step[1];
            row.weight[i] = low[2] + t * step[2];
            if BENT {
                let turn = if defocus.abs() > limit { 0.0 } else { STEPS * step[0] };
                let turn = if is_disc && row.b[i] < 1.0 { 2.0 * turn } else { turn };
                row.turn[i] = turn.copysign(defocus);
                let mirror = low[3];
                row.mirrored[i] = if defocus < 0.0 { 1.0 - mirror } else { mirror };
            }
        }
        for (inverse, own) in inverse.iter_mut().zip(&*radii) {
            *inverse = (1.0 / own.max(1.0)).copysign(*inverse);
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
    }

    /// The metric beyond which a kernel of a radius in cells is 0.
    #[inline(always)]
    fn metric_limit(&self, radius: f32, lens: &PixelLens) -> f32 {
        let skew = lens.skew[0].hypot(lens.skew[1]);
        let entry = self.table[((radius * STEPS).ceil() as usize).min(self.table.len() - 1)];
        (entry[0] / entry[1]) * (1.0 + skew) * (1.0 + skew) + 0.5
    }

    /// The offsets that a blur of at most `largest` cells reaches over.
    fn offsets(&self, lens: &TileLens, largest: f32, offsets: &mut Offsets) {
        let center = &lens.center;
        let skew = center.skew[0].hypot(center.skew[1]);
        let limit = self.metric_limit(largest, center);
        let bend = lens.focus_slope.map(|s| s * center.scale);
        let is_disc = matches!(self.outline, Outline::Disc);
        let metrics = |dx: i32, dy: i32| {
            let (x, y) = (dx as f32, dy as f32);
            let m = &center.to_iris;
            let (u, v) = (m[0] * x + m[1] * y, m[2] * x + m[3] * y);
            let skew = center.skew[0] * u + center.skew[1] * v;
            let bend = bend[0] * x + bend[1] * y;
            let less = if is_disc { bend * bend } else { 0.0 };
            Offset {
                metric: self.outline.metric(u, v) - less,
                mirrored: self.outline.metric(-u, -v) - less,
                bend,
                skew,
            }
        };
        let reach = ((largest + 1.0) * lens.stretch * (1.0 + skew)) as i32 + 1;
        offsets.fill(reach, |dx, dy| {
            let offset = metrics(dx, dy);
            let least = offset.metric.min(offset.mirrored);
            (offset, least <= limit)
        });
    }
}

/// Whether all values of a plane pass a test.
fn all(plane: &Plane, is_good: impl Fn(f32) -> bool + Sync) -> bool {
    plane.values().par_chunks(1 << 14).all(|values| values.iter().fold(true, |all, &value| all & is_good(value)))
}

/// The blocks from which an edge may be seen through a blur of at most `largest` pixels of radius.
fn in_sight(lens: &ViewLens, cells: &Cells, largest: f32) -> InSight {
    let corners = lens.at_corners();
    let widest = corners.iter().map(|lens| lens.widest).fold(0.0, f32::max);
    let stretch = corners.iter().map(PixelLens::stretch).fold(1.0, f32::max);
    let slope = lens.focus_slope().map(|s| s * widest);
    let steepness = slope[0].hypot(slope[1]).min(0.9);
    cells.in_sight(|[far, near], x, y| {
        // The focus changes on the way to who sees it, and over both blocks
        let focus = lens.at(f64::from(x), f64::from(y)).focus;
        let radius = widest * (near - focus).abs().max((far - focus).abs()) + steepness * 2.0 * BLOCK as f32;
        (radius / (1.0 - steepness)).min(largest * stretch) + 2.0
    })
}

//! Rung 3 where no edge is in sight: a plain sum over a lattice of cells.
//!
//! On one continuous surface nothing is hidden, so neither order nor lens points matter, and the gather of
//! [`gather`](crate::gather) becomes the mean of the neighbours' colours by their weights. Of the slope factor `d0 / d` only
//! the neighbour's 1/d is left, since d0 is the receiving pixel's own defocus wherever the neighbour lies.
//!
//! The cells are pixels, or squares of 2, 4, ... pixels. Where all blur around spans [`SIDES_PER_RADIUS`] of them, the sum is
//! only taken at the centres of the cells, and what lies between is interpolated. Where the blur differs more, the surface is
//! cut up by it: each part is summed up in the cells that its own blur allows, and the sums, weights and colours, are added.
//! So no kernel has more cells than a blur of twice [`SIDES_PER_RADIUS`] does, however large the largest is.

use std::sync::atomic::{AtomicU64, Ordering};

use rgbd::{PixelWindow, Plane};

use crate::{
    cells::{BLOCK, Cells, EMPTY, InSight, Range, blocks_of, joined},
    color_pyramid::ColorLevel,
    kernel::KernelTable,
    lattice_sum::STARTS,
    outline::Outline,
    surface::{Surface, Tame},
    upsample::MARGIN,
    view_lens::{TileLens, ViewLens},
};

/// How many sides of a cell the least blur radius spans.
pub(crate) const SIDES_PER_RADIUS: f32 = 8.0;

/// The largest blur radius over [`SIDES_PER_RADIUS`] from which the surface is halved at all: the first level, which serves
/// from 2 on, takes a look at every pixel. At 2.5 it cost a tenth of the filter's time, more than it spared.
const WORTH_HALVING: f32 = 3.0;

/// What the next level does not take has no larger blur radius, in cells: the blur hardly changes over the next level's cell.
const MOST_BEFORE_COARSER: f32 = 2.0 * SIDES_PER_RADIUS + 2.0;

/// Blurs that reach over more cells are left to the gather, which finds a size for each piece.
const MOST_CELLS: i32 = 37;

/// Where the defocus of a thing changes by more than this from pixel to pixel, in pixels of radius, kernels of less than the
/// second are left to the gather.
const STEEP_FOCUS: f32 = 0.02;
const LEAST_RADIUS_WHERE_STEEP: f32 = 2.0;

/// Where it changes by more than this, kernels are no longer affine in the focus, and all is left to the gather: the iris
/// then reaches a good part of the way to the hinge.
const TOO_STEEP_FOCUS: f32 = 0.3;

/// Table entries per cell of radius.
pub(crate) const STEPS: f32 = 32.0;

/// Coarsest level.
pub(crate) const LAST_LEVEL: u32 = 5;

/// The first surface as a lattice.
pub(crate) struct Lattice<'a> {
    /// No other lattice has this number.
    pub(crate) run: u64,
    cells: &'a Cells,
    pub(crate) in_sight: &'a InSight,
    pub(crate) surface: &'a Surface,
    /// The picture that the surface was made of, as it came.
    pub(crate) colors: &'a [Plane; 4],
    pub(crate) levels: Vec<ColorLevel>,
    pub(crate) outline: Outline,
    /// Whether all alpha is 1, and all colour finite.
    pub(crate) is_opaque: bool,
    pub(crate) is_finite: bool,
    /// By radius in cells: edge and weight of the kernel, each with its change up to the next entry.
    pub(crate) table: Vec<[f32; 4]>,
    pub(crate) variance: f32,
    pub(crate) max_radius: f32,
    range: Range,
}

/// How the blocks of a tile without an edge in sight are summed up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    /// The smallest window that holds those blocks, in whole cells of the coarsest level.
    pub(crate) part: PixelWindow,
    /// Cells of 2^level pixels: what the least blur allows, and what the largest does. Where they differ each surface is
    /// summed up in the cells that its own blur allows.
    pub(crate) finest: u32,
    pub(crate) coarsest: u32,
    /// Largest blur radius in pixels.
    pub(crate) largest: f32,
}

impl Plan {
    /// The largest blur radius of what is summed up on a level, in cells.
    pub(crate) fn largest_on(&self, level: u32) -> f32 {
        let largest = self.largest / (1 << level) as f32;
        if level < self.coarsest { largest.min(MOST_BEFORE_COARSER) } else { largest }
    }
}

/// How many cells to each side a blur of at most `largest` cells reaches.
pub(crate) fn reach_in_cells(lens: &TileLens, largest: f32) -> i32 {
    let [along, across] = lens.center.skew;
    ((largest + 1.0) * lens.stretch * (1.0 + along.hypot(across))) as i32 + 1
}

impl<'a> Lattice<'a> {
    /// The lattice of a view's first `surface`; the blur is cut to the first of the limits in pixels, and there is none
    /// larger than the second.
    pub(crate) fn new(
        lens: &ViewLens<'a>,
        surface: &'a Surface,
        cells: &'a Cells,
        in_sight: &'a InSight,
        table: &KernelTable,
        limits: [f32; 2],
    ) -> Self {
        let colors = lens.view.frame().layers()[0].color.planes();
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
        let sides = largest_radius.min(max_radius) / SIDES_PER_RADIUS;
        let count = if sides < WORTH_HALVING { 0 } else { sides.log2().floor() as u32 };
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
            (table.outline().edge(&kernel), kernel.weight / radius.max(1.0))
        };
        let change = |i: usize| {
            let ((edge, weight), (next_edge, next_weight)) = (entry(i), entry(i + 1));
            [edge, next_edge - edge, weight, next_weight - weight]
        };
        let table_of = (0..=(MOST_CELLS + 1) as usize * STEPS as usize).map(change).collect();
        let outline = table.outline().clone();
        let Tame { is_opaque, is_finite } = surface.tame;
        static RUNS: AtomicU64 = AtomicU64::new(0);
        Self {
            run: RUNS.fetch_add(1, Ordering::Relaxed),
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

    /// How to sum up the blocks of a tile without an edge in sight; none if there are none, or if a gather serves better.
    pub(crate) fn plan(&self, tile: PixelWindow, lens: &TileLens) -> Option<Plan> {
        let block = |(x, y)| PixelWindow { x, y, width: BLOCK as u32, height: BLOCK as u32 };
        let blocks = blocks_of(tile).filter(|&(x, y)| !self.in_sight.at(x, y)).map(block);
        let part = blocks.reduce(|all, block| all.union(&block))?;
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
        if bend > TOO_STEEP_FOCUS || bend > STEEP_FOCUS && least < LEAST_RADIUS_WHERE_STEEP {
            return None;
        }
        let level = |radius: f32| (radius / SIDES_PER_RADIUS).max(1.0).log2().floor() as u32;
        let [finest, coarsest] = [least, largest].map(|radius| level(radius).min(self.levels.len() as u32));
        let plan = Plan { part: part.aligned_to((1 << coarsest).max(BLOCK)), finest, coarsest, largest };
        let serves = (finest..=coarsest).all(|level| {
            let reach = reach_in_cells(lens, plan.largest_on(level));
            let columns = (plan.part.width as usize >> level) + 2 * MARGIN as usize;
            reach <= MOST_CELLS && columns + 2 * reach as usize <= STARTS
        });
        (serves && lens.center.scale > 0.0).then_some(plan)
    }

    /// The blur radius in pixels of a cell of a level; 0 where there is none.
    #[inline(always)]
    pub(crate) fn radius_of(&self, level: u32, x: i32, y: i32, lens: &TileLens) -> f32 {
        let level_ref = level.checked_sub(1).map(|i| &self.levels[i as usize]);
        let window = level_ref.map_or(self.surface.window, |level| level.window);
        if !window.contains(x, y) {
            return 0.0;
        }
        let inverse_depth = level_ref.map_or(&self.surface.inverse_depth, |level| &level.inverse_depth);
        let center = |k: i32| (k as f32 + 0.5) * (1 << level) as f32 - 0.5;
        let defocus = lens.center.scale * (inverse_depth[window.index(x, y)] - lens.focus_at(center(x), center(y)));
        defocus.abs().min(self.max_radius)
    }

    /// Whether the blur radius of a cell of a level allows the level.
    #[inline(always)]
    pub(crate) fn allows(&self, level: u32, x: i32, y: i32, lens: &TileLens) -> bool {
        self.radius_of(level, x, y, lens) >= SIDES_PER_RADIUS * (1 << level) as f32
    }
}

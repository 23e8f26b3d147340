//! The blocks of a tile from which no edge is seen, summed up, and those that are left to other methods.

use fearless_simd::prelude::*;
use rgbd::PixelWindow;

use crate::{
    cells::{BLOCK, InSight, blocks_of},
    lattice::Lattice,
    lattice_sum::CHANNELS,
    lattice_work::LatticeScratch,
    row::LANES,
    surface::Surface,
    tiles::{TILE, parts},
    view_lens::{TileLens, ViewLens},
};

/// Blocks in a row of a tile.
const BLOCKS_ACROSS: usize = (TILE / BLOCK as u32) as usize;

/// Where a tile's pixels go: the part of it that is wanted, and its channels, each row by row.
pub(crate) struct Target<'a> {
    pub(crate) part: PixelWindow,
    pub(crate) out: &'a mut [Vec<f32>],
}

/// The blocks of a tile that are left to be gathered.
pub(crate) struct Left {
    pub(crate) tile: PixelWindow,
    blocks: [bool; BLOCKS_ACROSS * BLOCKS_ACROSS],
}

impl Left {
    /// Whether the block at a pixel of the tile is left.
    pub(crate) fn is_left(&self, x: i32, y: i32) -> bool {
        self.blocks[self.index(x, y)]
    }

    fn index(&self, x: i32, y: i32) -> usize {
        let [column, row] = [x - self.tile.x, y - self.tile.y].map(|at| (at / BLOCK) as usize);
        row * BLOCKS_ACROSS + column
    }

    /// The smallest window that holds the blocks of a part of the tile that are left.
    pub(crate) fn within(&self, part: PixelWindow) -> PixelWindow {
        let block = |(x, y)| PixelWindow { x, y, width: BLOCK as u32, height: BLOCK as u32 };
        let left = blocks_of(part).filter(|&(x, y)| self.is_left(x, y)).map(block);
        left.reduce(|all, block| all.union(&block)).unwrap_or(PixelWindow { width: 0, height: 0, ..part })
    }
}

/// What sums up the blocks from which no edge is seen.
pub(crate) struct PlainBlocks<'a> {
    pub(crate) in_sight: &'a InSight,
    /// None where all blocks are left to other methods.
    pub(crate) lattice: Option<Lattice<'a>>,
    pub(crate) first: &'a Surface,
}

impl PlainBlocks<'_> {
    /// Sums up the blocks of a tile that no edge is in sight of; returns those that are left.
    #[inline(always)]
    pub(crate) fn sum_up<S: Simd, const OPEN: bool>(
        &self,
        simd: S,
        lens: &ViewLens,
        scratch: &mut LatticeScratch,
        target: &mut Target,
    ) -> Left {
        // Tiles are anchored at pixel (0, 0), so that bands of a picture have the same ones
        let [x, y] = [target.part.x, target.part.y].map(|at| at.div_euclid(TILE as i32) * TILE as i32);
        let tile = PixelWindow { x, y, width: TILE, height: TILE };
        let mut left = Left { tile, blocks: [true; _] };
        let Some(lattice) = &self.lattice else { return left };
        let over_tile = lens.over(tile);
        if over_tile.is_even {
            self.sum_up_part::<S, OPEN>(simd, lattice, &over_tile, tile, scratch, target, &mut left);
        } else {
            for part in parts(tile) {
                self.sum_up_part::<S, OPEN>(simd, lattice, &lens.over(part), part, scratch, target, &mut left);
            }
        }
        left
    }

    /// Sums up those of a part of the tile, and marks them as no longer left.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn sum_up_part<S: Simd, const OPEN: bool>(
        &self,
        simd: S,
        lattice: &Lattice,
        lens: &TileLens,
        part: PixelWindow,
        scratch: &mut LatticeScratch,
        target: &mut Target,
        left: &mut Left,
    ) {
        if part.intersection(&target.part).is_empty() {
            return;
        }
        let Some(plan) = lattice.plan(part, lens) else { return };
        for (x, y) in blocks_of(part).filter(|&(x, y)| !self.in_sight.at(x, y)) {
            left.blocks[left.index(x, y)] = false;
        }
        lattice.sum_up::<S, OPEN>(
            simd,
            &plan,
            lens,
            scratch,
            #[inline(always)]
            |x, y, sums| self.put_plain(sums, (x, y), target),
        );
    }

    /// Puts eight pixels of a row that were summed up, the first of which is `start`: how full the iris is, and the colour.
    #[inline(always)]
    fn put_plain(&self, [full, rgba @ ..]: &[[f32; LANES]; CHANNELS], (x, y): (i32, i32), target: &mut Target) {
        let Target { part, out } = target;
        let row = PixelWindow { x, y, width: LANES as u32, height: 1 }.intersection(part);
        if row.is_empty() {
            return;
        }
        let (from, to) = ((row.x - x) as usize, (row.x_end() - x) as usize);
        let at = part.index(row.x, y);
        for (out, values) in out.iter_mut().zip(rgba) {
            out[at..at + to - from].copy_from_slice(&values[from..to]);
        }
        if let [_, _, _, _, _, open] = &mut **out {
            open[at..].iter_mut().zip(&full[from..to]).for_each(|(open, full)| *open = 1.0 - full.min(1.0));
        }
        for i in (from..to).filter(|&i| full[i] <= 0.0) {
            let rgba = self.unfiltered(x + i as i32, y);
            (0..4).for_each(|c| out[c][at + i - from] = rgba[c]);
        }
    }

    /// What nothing reaches: the first layer's colour, nothing outside the data.
    pub(crate) fn unfiltered(&self, x: i32, y: i32) -> [f32; 4] {
        let surface = self.first;
        if !surface.window.contains(x, y) {
            return [0.0; 4];
        }
        let i = surface.window.index(x, y);
        surface.rgba[i].map(|c| c / surface.cover[i])
    }
}

//! Rungs 2 and 3: the Potmesil-style gather, in depth order.
//!
//! For each pixel, every neighbour whose footprint covers it contributes with the share of the iris that it fills: one
//! over the footprint's area, times the slope factor below. Neighbours are taken slab by slab, nearest first, until the
//! iris is full: what is nearer hides what is farther (a sharp foreground is not invaded by a blurred background), and
//! where the nearer ones leave the iris open, what lies behind shows through (a blurred foreground is see-through at its
//! rim). What stays open in the end (beyond the border) is shared by what is there: the weights are normalised, so that a
//! furnace stays 1.
//!
//! **Slope factor.** On a plane the inverse depth is affine in the pixel, so the map from pixels to iris points is known
//! exactly: a pixel at defocus d fills `|d0| / |d|^3` of the iris, where d0 is the defocus that the neighbour's plane
//! has at the receiving pixel. Without the factor d0/d the weights of a sloped floor do not sum to 1.
//!
//! **Which part of the iris.** A neighbour is seen through a known lens point: its offset over its defocus. A near thing
//! beside a pixel hides the lens points on one side; if the background lies beyond the plane of focus, these are just the
//! points through which the *visible* background would be seen, and what is seen instead is the background that the near
//! thing hides. So the share and the centroid of the lens points that nearer slabs fill are kept, read as a half plane of
//! the lens, and what is seen through it does not count.
//!
//! **Rung 3** is the same with neighbours merged into squares whose side grows with the blur ([`Forest`]); where no edge is
//! in sight ([`InSight`](crate::cells::InSight)) it is a plain sum ([`Lattice`]); and where all that touches a tile is
//! blurred enough, only the centres of cells receive, and the pixels between them are interpolated
//! ([`upsample`](crate::upsample)). Merged squares alone cost five times what the three together do at 720p and 20 px
//! (`benches/results/2026-11-25.md`).

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, PixelWindow, Plane, Progress};

use crate::{
    FrameView, Sides,
    cells::{BLOCK, Range, blocks_of},
    forest::{Forest, Piece},
    kernel::KernelTable,
    lattice::{self, Lattice, LatticeScratch},
    lens_map::PixelLens,
    prepare::Prepared,
    row::{BlockTap, Footprint, LANES, Round, Row, Shaped, Shared, Slab, gather_row},
    tap::Weight,
    tiles::{TILE, by_tiles},
    upsample::{MARGIN, upsample},
    view_lens::{TileLens, ViewLens},
};

/// Depth of a slab in pixels of blur radius: surfaces nearer to each other do not hide one another.
pub(crate) const SLAB_PX: f32 = 0.5;

/// A merged square stands for its pixels where the blur radius is at least this many of its sides.
const SIDES_PER_RADIUS: f32 = 5.0;

/// Weights are affine in the focus over a tile where the radius changes by at most this share, or this many pixels.
const STEADY_SHARE: f32 = 0.04;
const STEADY_PX: f32 = 0.02;

/// Over a block they are where it changes by at most this share, or by as many pixels as above; else each pixel has its
/// own.
const STEEP_SHARE: f32 = 0.08;

/// Rows of a block by the spread of the defocus over its tile in pixels: weights are affine in the focus over a block.
fn block_rows(spread: f32) -> u32 {
    match spread {
        s if s <= 0.25 => 8,
        s if s <= 1.0 => 4,
        _ => 2,
    }
}

/// What all tiles share.
pub(crate) struct Gather<'a> {
    lens: ViewLens<'a>,
    max_radius: f32,
    /// Blur radius in pixels of a unit of inverse depth.
    px: f32,
    forest: Forest<'a>,
    /// Where no edge is in sight, in rung 3.
    lattice: Option<Lattice<'a>>,
    table: KernelTable,
    merge: bool,
}

/// Picture, and what the predicted error is made of.
pub(crate) struct Gathered {
    pub(crate) picture: Picture,
    /// Mean doubt of what a pixel gathered, and what stayed open of its iris.
    pub(crate) doubt: Option<[Plane; 2]>,
}

/// How a gather is run.
#[derive(Clone, Copy)]
pub(crate) struct GatherRun {
    pub(crate) model: KernelModel,
    /// Largest blur radius in pixels.
    pub(crate) max_radius: f32,
    /// Largest blur radius that there is, in pixels.
    pub(crate) largest_radius: f32,
    /// How many layers are used.
    pub(crate) layers: usize,
    /// What is blurred.
    pub(crate) sides: Sides,
    /// How far behind a silhouette is looked, in pixels.
    pub(crate) fill_reach: f32,
    /// Whether pixels are merged where the blur is large.
    pub(crate) merge: bool,
    /// The instructions to use.
    pub(crate) level: Level,
    /// Whether doubt is wanted too.
    pub(crate) doubt: bool,
}

/// Gathers `window`.
pub(crate) fn gather(
    view: &FrameView,
    camera: &Camera,
    run: &GatherRun,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Gathered, Cancelled> {
    let px = (camera.iris.radius() * camera.film.pixels_per_q().max_element()) as f32;
    let prepared = Prepared::new(view, camera, run.layers, run.fill_reach, run.sides);
    // Squares that nothing is blurred enough for are not needed
    let merged = (run.max_radius.min(run.largest_radius) / SIDES_PER_RADIUS).max(1.0).log2().floor() as u32;
    let forest = Forest::new(&prepared, px, if run.merge { merged.min(4) } else { 0 });
    let table = KernelTable::of(camera);
    let GatherRun { model, max_radius, merge, level, .. } = *run;
    let lens = ViewLens { view, camera, model };
    let limits = [max_radius, run.largest_radius];
    // Kernels of an oval are stretched by an amount of their own at each radius
    let is_plain = merge && table.is_round();
    let lattice = is_plain.then(|| Lattice::new(&lens, &prepared.first, &prepared.cells, &table, limits));
    let job = Gather { lens, max_radius, px, forest, lattice, table, merge };
    let round = model == KernelModel::Disc && camera.iris.shape() == optics::ApertureShape::Disc;

    let channels = if run.doubt { 6 } else { 4 };
    let planes = by_tiles(window, channels, progress, |tile, out| {
        dispatch!(level, simd => match (round, run.doubt) {
            (true, false) => job.tile::<_, _, false>(simd, &Round, tile, out),
            (true, true) => job.tile::<_, _, true>(simd, &Round, tile, out),
            (false, false) => job.tile::<_, _, false>(simd, &Shaped(job.table.outline()), tile, out),
            (false, true) => job.tile::<_, _, true>(simd, &Shaped(job.table.outline()), tile, out),
        });
    })?;
    let mut planes = planes.into_iter();
    let picture = [(); 4].map(|()| planes.next().expect("four planes"));
    let picture = Picture::from_planes(picture).expect("planes of one window");
    let doubt = run.doubt.then(|| [(); 2].map(|()| planes.next().expect("two planes")));
    Ok(Gathered { picture, doubt })
}

/// A piece ready for the blocks of a tile.
#[derive(Clone, Copy)]
struct Tap {
    piece: Piece,
    weight: Weight,
    /// Whether the weight serves the whole tile.
    is_steady: bool,
    bin: i32,
    reach: f32,
}

/// What a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    taps: Vec<Tap>,
    order: Vec<u32>,
    counts: Vec<u32>,
    xs: Vec<f32>,
    ys: Vec<f32>,
    reaches: Vec<f32>,
    block: Vec<BlockTap>,
    slabs: Vec<Slab>,
    lattice: LatticeScratch,
    cells: [Vec<f32>; 6],
}

/// Eight receiving places in each of some rows.
#[derive(Debug, Clone, Copy)]
struct BlockGrid {
    first: [f32; 2],
    /// Pixels from one to the next.
    step: f32,
    rows: u32,
}

thread_local! {
    static SCRATCH: std::cell::RefCell<Scratch> = std::cell::RefCell::default();
}

impl Gather<'_> {
    /// One tile of the picture: `out` holds its channels, each row by row.
    #[inline(always)]
    fn tile<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        tile: PixelWindow,
        out: &mut [Vec<f32>],
    ) {
        // Tiles and blocks are anchored at pixel (0, 0), so that bands of a picture have the same ones
        let anchored = PixelWindow { width: TILE, height: TILE, ..anchor(tile) };
        let lens = self.lens.over(anchored);
        let mut scratch = SCRATCH.take();
        simd.vectorize(
            #[inline(always)]
            || {
                let has_plan = self.plain_blocks::<S, DOUBT>(simd, &lens, anchored, tile, &mut scratch.lattice, out);
                let left = self.left(anchored, has_plan);
                if left.is_empty() {
                    return;
                }
                match self.coarseness(left, &lens) {
                    0 => {
                        self.each_pixel::<S, F, DOUBT>(simd, footprint, &lens, left, has_plan, tile, &mut scratch, out);
                    }
                    level => {
                        let cells = (left, level);
                        self.each_cell::<S, F, DOUBT>(simd, footprint, cells, has_plan, tile, &mut scratch, out);
                    }
                }
            },
        );
        SCRATCH.set(scratch);
    }

    /// Gathers what is left of a tile pixel by pixel.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn each_pixel<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        lens: &TileLens,
        left: PixelWindow,
        has_plan: bool,
        tile: PixelWindow,
        scratch: &mut Scratch,
        out: &mut [Vec<f32>],
    ) {
        self.collect(left, lens, scratch);
        if scratch.taps.iter().all(|tap| tap.piece.rgba == [0.0; 4]) {
            return;
        }
        let rows = block_rows(lens.spread);
        for y in (left.y..left.y_end()).step_by(rows as usize) {
            for x in (left.x..left.x_end()).step_by(LANES) {
                let block = PixelWindow { x, y, width: LANES as u32, height: rows };
                if block.intersection(&tile).is_empty() || !self.is_left(x, y, has_plan) {
                    continue;
                }
                let lattice = BlockGrid { first: [x as f32, y as f32], step: 1.0, rows };
                let is_wanted = |row: u32| (tile.y..tile.y_end()).contains(&(y + row as i32));
                self.block::<S, F, DOUBT>(simd, footprint, lens, lattice, is_wanted, scratch, |row, gathered| {
                    self.put(gathered, (x, y + row as i32), tile, out);
                });
            }
        }
    }

    /// Gathers what is left of a tile at the centres of cells of 2^level pixels, and interpolates between them.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn each_cell<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        (left, level): (PixelWindow, u32),
        has_plan: bool,
        tile: PixelWindow,
        scratch: &mut Scratch,
        out: &mut [Vec<f32>],
    ) {
        // Cells lie on one grid for all tiles
        let side = 1_i32 << level;
        let left = left.aligned_to(side.max(BLOCK));
        let margin = (MARGIN * side) as u32;
        let around = left.grown(margin, margin);
        let lens = self.lens.over(around);
        self.collect(around, &lens, scratch);

        let [columns, lines] = [around.width, around.height].map(|length| length as usize / side as usize);
        let width = columns.next_multiple_of(LANES);
        let rows = block_rows(lens.spread);
        let mut cells = std::mem::take(&mut scratch.cells);
        cells.iter_mut().for_each(|plane| plane.resize(width * lines.next_multiple_of(rows as usize), 0.0));
        let center = |start: i32, k: usize| start as f32 + (k as f32 + 0.5) * side as f32 - 0.5;
        for j in (0..lines).step_by(rows as usize) {
            for i in (0..columns).step_by(LANES) {
                let lattice = BlockGrid { first: [center(around.x, i), center(around.y, j)], step: side as f32, rows };
                let is_wanted = |row: u32| j + (row as usize) < lines;
                self.block::<S, F, DOUBT>(simd, footprint, &lens, lattice, is_wanted, scratch, |row, gathered| {
                    let to = (j + row as usize) * width + i;
                    let share = gathered.full.map(|full| if full > 0.0 { 1.0 / full } else { 0.0 });
                    let scaled =
                        |values: &[f32; LANES]| -> [f32; LANES] { std::array::from_fn(|i| values[i] * share[i]) };
                    let [r, g, b, a] = &gathered.rgba;
                    let open = gathered.full.map(|full| 1.0 - full);
                    let values = [scaled(r), scaled(g), scaled(b), scaled(a), scaled(&gathered.doubt), open];
                    for (plane, values) in cells.iter_mut().zip(values) {
                        plane[to..to + LANES].copy_from_slice(&values);
                    }
                });
            }
        }

        upsample(
            left,
            level,
            &cells,
            width,
            |x, y| self.is_left(x, y, has_plan),
            |x, y, values| {
                for i in (0..LANES).filter(|&i| tile.contains(x + i as i32, y)) {
                    let at = tile.index(x + i as i32, y);
                    out.iter_mut().zip(values).for_each(|(out, values)| out[at] = values[i]);
                }
            },
        );
        scratch.cells = cells;
    }

    /// How often cells may be doubled over which what is left of a tile is interpolated: all that touches it must be
    /// blurred enough.
    fn coarseness(&self, left: PixelWindow, lens: &TileLens) -> u32 {
        if !self.merge {
            return 0;
        }
        // The cells beyond the window see a little more of the focus
        let reach = |range: [f32; 2]| 1.5 * lens.reach(range, self.max_radius) + 3.0 * lens.spread;
        let mut least = self.max_radius;
        self.forest.ranges_around(left, &reach, |range| {
            least = least.min(lens.least_radius(range) - lens.spread);
        });
        (least / lattice::SIDES_PER_RADIUS).max(1.0).log2().floor().min(4.0) as u32
    }

    /// Sums up the blocks of a tile that no edge is in sight of; whether there are any.
    #[inline(always)]
    fn plain_blocks<S: Simd, const DOUBT: bool>(
        &self,
        simd: S,
        lens: &TileLens,
        anchored: PixelWindow,
        tile: PixelWindow,
        scratch: &mut LatticeScratch,
        out: &mut [Vec<f32>],
    ) -> bool {
        let Some(lattice) = &self.lattice else { return false };
        lattice.blocks::<S, DOUBT>(
            simd,
            anchored,
            lens,
            scratch,
            #[inline(always)]
            |x, y, [full, rgba @ ..]| {
                let row = PixelWindow { x, y, width: LANES as u32, height: 1 }.intersection(&tile);
                if row.is_empty() {
                    return;
                }
                let (from, to) = ((row.x - x) as usize, (row.x_end() - x) as usize);
                let at = tile.index(row.x, y);
                for (out, values) in out.iter_mut().zip(rgba) {
                    out[at..at + to - from].copy_from_slice(&values[from..to]);
                }
                if let [_, _, _, _, _, open] = out {
                    open[at..].iter_mut().zip(&full[from..to]).for_each(|(open, full)| *open = 1.0 - full.min(1.0));
                }
                for i in (from..to).filter(|&i| full[i] <= 0.0) {
                    let rgba = self.unfiltered(x + i as i32, y);
                    (0..4).for_each(|c| out[c][at + i - from] = rgba[c]);
                }
            },
        )
    }

    /// Whether the block at a pixel is left to be gathered.
    fn is_left(&self, x: i32, y: i32, has_plan: bool) -> bool {
        !has_plan || self.lattice.as_ref().is_none_or(|lattice| lattice.sees_edge(x, y))
    }

    /// What is left of a tile.
    fn left(&self, tile: PixelWindow, has_plan: bool) -> PixelWindow {
        let cell = |(x, y)| PixelWindow { x, y, width: BLOCK as u32, height: BLOCK as u32 };
        let left = blocks_of(tile).filter(|&(x, y)| self.is_left(x, y, has_plan)).map(cell);
        left.reduce(|all, cell| all.union(&cell)).unwrap_or(PixelWindow { width: 0, height: 0, ..tile })
    }

    /// Collects what may touch a tile, nearest slab first.
    #[inline(always)]
    fn collect(&self, tile: PixelWindow, lens: &TileLens, scratch: &mut Scratch) {
        let Scratch { taps, order, counts, xs, ys, reaches, .. } = scratch;
        taps.clear();
        let reach = |range: [f32; 2]| lens.reach(range, self.max_radius);
        let serves = |piece: &Piece| {
            self.merge && lens.least_radius(piece.range).min(self.max_radius) >= SIDES_PER_RADIUS * piece.size
        };
        // Slabs stand at fixed depths; beyond the limit of the blur they are all one
        let slab = |s: f32| (s * self.px / SLAB_PX).clamp(-1e9, 1e9).floor() as i32;
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
            taps.push(Tap { piece: *piece, weight, is_steady, bin, reach });
        });

        // Sort by slab, nearest first; within a slab the order is that of the visit
        let (low, high) =
            taps.iter().fold((i32::MAX, i32::MIN), |(low, high), tap| (low.min(tap.bin), high.max(tap.bin)));
        order.clear();
        order.resize(taps.len(), 0);
        if taps.is_empty() || i64::from(high) - i64::from(low) > 1 << 16 {
            order.iter_mut().enumerate().for_each(|(i, place)| *place = i as u32);
            order.sort_by_key(|&i| std::cmp::Reverse(taps[i as usize].bin));
        } else {
            counts.clear();
            counts.resize((high - low) as usize + 2, 0);
            taps.iter().for_each(|tap| counts[(high - tap.bin) as usize + 1] += 1);
            (1..counts.len()).for_each(|i| counts[i] += counts[i - 1]);
            for (i, tap) in taps.iter().enumerate() {
                let place = &mut counts[(high - tap.bin) as usize];
                order[*place as usize] = i as u32;
                *place += 1;
            }
        }

        // Lay out what finds the taps of a block
        for (values, value) in [
            (&mut *xs, (|tap| tap.piece.x) as fn(&Tap) -> f32),
            (&mut *ys, |tap| tap.piece.y),
            (&mut *reaches, |tap| tap.reach),
        ] {
            values.clear();
            values.extend(order.iter().map(|&i| value(&taps[i as usize])));
            // Fill the last vector with what touches nothing
            values.resize(order.len().next_multiple_of(LANES), -1e9);
        }
    }

    /// One block of a tile; `put` takes a row's index and what it gathered, if it is wanted.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn block<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        tile_lens: &TileLens,
        block: BlockGrid,
        is_wanted: impl Fn(u32) -> bool,
        scratch: &mut Scratch,
        mut put: impl FnMut(u32, &Row),
    ) {
        let BlockGrid { first: [x, y], step, rows } = block;
        let half = [0.5 * step * (LANES - 1) as f32, 0.5 * step * (rows as f32 - 1.0)];
        let center = [x + half[0], y + half[1]];
        let lens_at = |x: f32, y: f32| self.lens.at(f64::from(x), f64::from(y));
        let lens = lens_at(center[0], center[1]);

        // What the defocus is more at each pixel than at the centre
        let defocus = |x: f32, y: f32| lens.scale * (lens.focus - lens_at(x, y).focus);
        let corner = defocus(x, y);
        let (across, down) = (defocus(x + step, y) - corner, defocus(x, y + step) - corner);
        let spread = 3.5 * across.abs() + 0.5 * (rows as f32 - 1.0) * down.abs();
        self.find(simd, tile_lens, &lens, (center, half, spread), scratch);

        let shared = Shared { lens: &lens, table: &self.table, max_radius: self.max_radius };
        for row in (0..rows).filter(|&row| is_wanted(row)) {
            let mut by = [0.0; LANES];
            for (i, by) in by.iter_mut().enumerate() {
                *by = corner + across * i as f32 + down * row as f32;
            }
            let y = row as f32 * step - half[1];
            let (taps, slabs) = (&scratch.block, &scratch.slabs);
            put(row, &gather_row::<S, F, DOUBT>(simd, footprint, &shared, taps, slabs, (step, y), &by));
        }
    }

    /// Finds the taps that may touch a block, given by its centre, its pixels' largest offsets from there, and how far the
    /// defocus differs from that at the centre.
    #[inline(always)]
    fn find<S: Simd>(
        &self,
        simd: S,
        tile_lens: &TileLens,
        lens: &PixelLens,
        (center, half, spread): ([f32; 2], [f32; 2], f32),
        scratch: &mut Scratch,
    ) {
        let Scratch { taps, order, xs, ys, reaches, block, slabs, .. } = scratch;
        block.clear();
        slabs.clear();
        let by = tile_lens.center.scale * (tile_lens.center.focus - lens.focus);
        let mut last_bin = i32::MAX;
        for chunk in (0..order.len()).step_by(LANES) {
            let part = chunk..chunk + LANES;
            let mut hits = touching(simd, &xs[part.clone()], &ys[part.clone()], &reaches[part], center, half);
            while hits != 0 {
                let i = chunk + hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let tap = &taps[order[i] as usize];
                let weight = if tap.is_steady {
                    tap.weight.moved(by)
                } else {
                    Weight::new(&self.table, &tap.piece, lens, self.max_radius)
                };
                if tap.bin != last_bin {
                    if last_bin != i32::MAX {
                        slabs.push(Slab { bin: last_bin, end: block.len() });
                    }
                    last_bin = tap.bin;
                }
                let piece = &tap.piece;
                let share = 1.0 / piece.cover;
                block.push(BlockTap {
                    x: piece.x - center[0],
                    y: piece.y - center[1],
                    reach: tap.reach,
                    weight,
                    steep: (spread > STEEP_SHARE * weight.defocus.abs().max(STEADY_PX / STEEP_SHARE))
                        .then_some([piece.cover, piece.size]),
                    rgba: piece.rgba.map(|c| c * share),
                    doubt: piece.doubt,
                });
            }
        }
        if last_bin != i32::MAX {
            slabs.push(Slab { bin: last_bin, end: block.len() });
        }
    }

    /// Puts a gathered row, whose first pixel is `start`, into the tile.
    fn put(&self, gathered: &Row, start: (i32, i32), tile: PixelWindow, out: &mut [Vec<f32>]) {
        for i in 0..LANES {
            let (x, y) = (start.0 + i as i32, start.1);
            if !tile.contains(x, y) {
                continue;
            }
            let (at, full) = (tile.index(x, y), gathered.full[i]);
            if full > 0.0 {
                let share = 1.0 / full;
                (0..4).for_each(|c| out[c][at] = gathered.rgba[c][i] * share);
                if let [_, _, _, _, doubt, open] = out {
                    doubt[at] = gathered.doubt[i] * share;
                    open[at] = 1.0 - full;
                }
            } else {
                let rgba = self.unfiltered(x, y);
                (0..4).for_each(|c| out[c][at] = rgba[c]);
            }
        }
    }

    /// What nothing reaches: the first layer's colour, nothing outside the data.
    fn unfiltered(&self, x: i32, y: i32) -> [f32; 4] {
        let surface = self.forest.first_surface();
        if surface.window.contains(x, y) { surface.rgba[surface.window.index(x, y)] } else { [0.0; 4] }
    }
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

/// The corner of the tile, on the grid that starts at (0, 0), in which a window lies.
fn anchor(window: PixelWindow) -> PixelWindow {
    let side = TILE as i32;
    PixelWindow { x: window.x.div_euclid(side) * side, y: window.y.div_euclid(side) * side, ..window }
}

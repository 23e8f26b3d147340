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
//! **Rung 3** is the same with neighbours merged into squares whose side grows with the blur ([`Forest`]).

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, PixelWindow, Plane, Progress};

use crate::{
    FrameView, KernelRule,
    forest::{Forest, Piece},
    kernel::KernelTable,
    lens_map::PixelLens,
    prepare::Prepared,
    row::{BlockTap, Footprint, LANES, Round, Row, Shaped, Slab, gather_row},
    tap::Weight,
    tiles::{TILE, by_tiles},
};

/// Depth of a slab in pixels of blur radius: surfaces nearer to each other do not hide one another.
pub(crate) const SLAB_PX: f32 = 0.5;

/// A merged square stands for its pixels where the blur radius is at least this many of its sides.
const SIDES_PER_RADIUS: f32 = 5.0;

/// Weights are affine in the focus over a tile where the radius changes by at most this share, or this many pixels.
const STEADY_SHARE: f32 = 0.04;
const STEADY_PX: f32 = 0.02;

/// Rows of a block by the spread of the defocus over its tile in pixels: weights are affine in the focus over a block.
fn block_rows(spread: f32) -> u32 {
    match spread {
        s if s <= 0.25 => 8,
        s if s <= 1.0 => 4,
        _ => 2,
    }
}

/// Settings of [`Method::Gather`](crate::Method::Gather) and [`Method::Merged`](crate::Method::Merged).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GatherSettings {
    /// Shape of the footprint.
    pub kernel: KernelRule,
    /// Largest radius of the circle of confusion in pixels; larger ones are cut to it. `None`: a quarter of the display
    /// window's width.
    pub max_radius_px: Option<f32>,
    /// How many of the frame's layers to use; 1 ignores hidden ones.
    pub layers: usize,
}

impl Default for GatherSettings {
    fn default() -> Self {
        Self { kernel: KernelRule::default(), max_radius_px: None, layers: usize::MAX }
    }
}

/// What all tiles share.
pub(crate) struct Gather<'a> {
    view: &'a FrameView<'a>,
    camera: &'a Camera,
    model: KernelModel,
    max_radius: f32,
    /// Blur radius in pixels of a unit of inverse depth.
    px: f32,
    forest: Forest,
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
    let prepared = Prepared::new(view, camera, run.layers, run.fill_reach);
    // Squares that nothing is blurred enough for are not needed
    let merged = (run.max_radius.min(run.largest_radius) / SIDES_PER_RADIUS).max(1.0).log2().floor() as u32;
    let forest = Forest::new(prepared, px, if run.merge { merged.min(4) } else { 0 });
    let table = KernelTable::new(camera.iris.shape());
    let GatherRun { model, max_radius, merge, level, .. } = *run;
    let job = Gather { view, camera, model, max_radius, px, forest, table, merge };
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

/// The lens over a tile.
struct TileLens {
    center: PixelLens,
    /// Smallest and largest focus over the tile.
    focus: [f32; 2],
    /// By how much the defocus differs at most from that at the centre, in pixels.
    spread: f32,
    stretch: f32,
}

impl TileLens {
    /// How far a range of inverse depth may reach, in pixels.
    fn reach(&self, [far, near]: [f32; 2], max_radius: f32) -> f32 {
        let defocus = (near - self.focus[0]).abs().max((far - self.focus[1]).abs());
        (self.center.widest * defocus).min(max_radius * self.stretch) + 1.5
    }

    /// The least blur radius that a range of inverse depth has, in pixels.
    fn least_radius(&self, [far, near]: [f32; 2]) -> f32 {
        self.center.scale * (far - self.focus[1]).max(self.focus[0] - near).max(0.0)
    }
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
}

thread_local! {
    static SCRATCH: std::cell::RefCell<Scratch> = std::cell::RefCell::default();
}

impl Gather<'_> {
    /// The lens that a point sees; whole coordinates are pixel centres.
    fn lens_at(&self, x: f64, y: f64) -> PixelLens {
        let display = self.view.frame().display;
        let at = glam::DVec2::new(x - f64::from(display.x) + 0.5, y - f64::from(display.y) + 0.5);
        PixelLens::new(self.camera, self.model, self.camera.film.q_from_pixel(at))
    }

    fn tile_lens(&self, tile: PixelWindow) -> TileLens {
        let corner = |x: i32, y: i32| self.lens_at(f64::from(x), f64::from(y));
        let (right, bottom) = (tile.x_end() - 1, tile.y_end() - 1);
        let corners = [corner(tile.x, tile.y), corner(right, tile.y), corner(tile.x, bottom), corner(right, bottom)];
        let middle = |start: i32, end: i32| 0.5 * (f64::from(start) + f64::from(end));
        let center = self.lens_at(middle(tile.x, right), middle(tile.y, bottom));
        let low = corners.iter().map(|lens| lens.focus).fold(f32::INFINITY, f32::min);
        let high = corners.iter().map(|lens| lens.focus).fold(f32::NEG_INFINITY, f32::max);
        let spread = center.scale * (high - center.focus).max(center.focus - low);
        let stretch = corners.iter().map(PixelLens::stretch).fold(1.0, f32::max);
        let widest = corners.iter().map(|lens| lens.widest).fold(0.0, f32::max);
        TileLens { center: PixelLens { widest, ..center }, focus: [low, high], spread, stretch }
    }

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
        let lens = self.tile_lens(anchored);
        let mut scratch = SCRATCH.take();
        simd.vectorize(
            #[inline(always)]
            || {
                let scratch = &mut scratch;
                self.collect(anchored, &lens, scratch);
                if scratch.taps.iter().all(|tap| tap.piece.rgba == [0.0; 4]) {
                    return;
                }
                for y in (anchored.y..anchored.y_end()).step_by(block_rows(lens.spread) as usize) {
                    for x in (anchored.x..anchored.x_end()).step_by(LANES) {
                        let block = PixelWindow { x, y, width: LANES as u32, height: block_rows(lens.spread) };
                        if !block.intersection(&tile).is_empty() {
                            self.block::<S, F, DOUBT>(simd, footprint, &lens, block, tile, scratch, out);
                        }
                    }
                }
            },
        );
        SCRATCH.set(scratch);
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
        self.forest.visit(tile, &reach, &serves, &mut |piece| {
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

    /// One block of a tile.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn block<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        tile_lens: &TileLens,
        block: PixelWindow,
        tile: PixelWindow,
        scratch: &mut Scratch,
        out: &mut [Vec<f32>],
    ) {
        let half = 0.5 * (block.height as f32 - 1.0);
        let center = [block.x as f32 + 3.5, block.y as f32 + half];
        let lens = self.lens_at(f64::from(block.x) + 3.5, f64::from(block.y) + f64::from(half));
        self.find(simd, tile_lens, &lens, center, half, scratch);

        // What the defocus is more at each pixel than at the centre
        let defocus = |x: f64, y: f64| lens.scale * (lens.focus - self.lens_at(x, y).focus);
        let (x, y) = (f64::from(block.x), f64::from(block.y));
        let corner = defocus(x, y);
        let (across, down) = (defocus(x + 1.0, y) - corner, defocus(x, y + 1.0) - corner);
        for row in 0..block.height as i32 {
            if block.y + row < tile.y || block.y + row >= tile.y_end() {
                continue;
            }
            let mut by = [0.0; LANES];
            for (i, by) in by.iter_mut().enumerate() {
                *by = corner + across * i as f32 + down * row as f32;
            }
            let y = row as f32 - half;
            let (taps, slabs) = (&scratch.block, &scratch.slabs);
            let gathered = gather_row::<S, F, DOUBT>(simd, footprint, &lens, taps, slabs, y, &by);
            self.put(&gathered, block, row, tile, out);
        }
    }

    /// Finds the taps that may touch a block.
    #[inline(always)]
    fn find<S: Simd>(
        &self,
        simd: S,
        tile_lens: &TileLens,
        lens: &PixelLens,
        center: [f32; 2],
        half: f32,
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
                    rgba: piece.rgba.map(|c| c * share),
                    doubt: piece.doubt,
                });
            }
        }
        if last_bin != i32::MAX {
            slabs.push(Slab { bin: last_bin, end: block.len() });
        }
    }

    /// Puts a gathered row into the tile.
    fn put(&self, gathered: &Row, block: PixelWindow, row: i32, tile: PixelWindow, out: &mut [Vec<f32>]) {
        let y = block.y + row;
        for i in 0..LANES {
            let x = block.x + i as i32;
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
                // Nothing reaches it: the first layer's colour, nothing outside the data
                let surface = self.forest.first_surface();
                if surface.window.contains(x, y) {
                    let rgba = surface.rgba[surface.window.index(x, y)];
                    (0..4).for_each(|c| out[c][at] = rgba[c]);
                }
            }
        }
    }
}

/// Which of eight taps may touch the block around `center`, a bit for each.
#[inline(always)]
fn touching<S: Simd>(simd: S, xs: &[f32], ys: &[f32], reaches: &[f32], center: [f32; 2], half: f32) -> u64 {
    #[inline(always)]
    fn gap<S: Simd>(simd: S, values: &[f32], center: f32, half: f32) -> f32x8<S> {
        ((f32x8::from_slice(simd, values) - center).abs() - half).max(0.0)
    }
    let (dx, dy, reach) =
        (gap(simd, xs, center[0], 3.5), gap(simd, ys, center[1], half), f32x8::from_slice(simd, reaches));
    (dx * dx + dy * dy).simd_le(reach * reach.abs()).to_bitmask()
}

/// The corner of the tile, on the grid that starts at (0, 0), in which a window lies.
fn anchor(window: PixelWindow) -> PixelWindow {
    let side = TILE as i32;
    PixelWindow { x: window.x.div_euclid(side) * side, y: window.y.div_euclid(side) * side, ..window }
}

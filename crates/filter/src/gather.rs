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
//! Where no edge is in sight ([`InSight`](crate::cells::InSight)) nothing hides anything: the first surface is one slab, and
//! there is no other.
//!
//! **Rung 3** is the same with neighbours merged into squares whose side grows with the blur ([`Forest`]); where no edge is
//! in sight it is a plain sum ([`Lattice`]); and where all that touches a tile is blurred enough, only the centres of cells
//! receive, and the pixels between them are interpolated ([`upsample`](crate::upsample)). Merged squares alone cost five times what the three together do at 720p and 20 px
//! (`benches/results/2026-11-25.md`).

use fearless_simd::{Level, dispatch, prelude::*};
use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, PixelWindow, Plane, Progress};

use crate::{
    FrameView, Sides,
    cat_eye::CatEye,
    cells::BLOCK,
    forest::Forest,
    kernel::KernelTable,
    lattice::{self, Lattice},
    lattice_work::LatticeScratch,
    plain_blocks::{Left, PlainBlocks, Target},
    predicted::Doubt,
    prepare::Prepared,
    row::{Footprint, LANES, Round, Row, Shaped},
    taps::{BlockGrid, SIDES_PER_RADIUS, Taps, block_rows},
    tiles::{by_tiles, parts},
    upsample::{MARGIN, upsample},
    view_lens::{TileLens, ViewLens},
};

/// What all tiles share.
pub(crate) struct Gather<'a> {
    pub(crate) lens: ViewLens<'a>,
    pub(crate) max_radius: f32,
    /// Blur radius in pixels of a unit of inverse depth.
    pub(crate) px: f32,
    pub(crate) forest: Forest<'a>,
    plain: PlainBlocks<'a>,
    pub(crate) table: KernelTable,
    pub(crate) merge: bool,
}

/// A picture, and what its predicted error is made of.
pub(crate) struct Gathered {
    pub(crate) picture: Picture,
    pub(crate) doubt: Option<Doubt>,
}

impl Gathered {
    /// From the planes of R, G, B and A, and where wanted of doubt and of what stayed open.
    pub(crate) fn from_planes(planes: Vec<Plane>) -> Self {
        let mut planes = planes.into_iter();
        let picture = [(); 4].map(|()| planes.next().expect("four planes"));
        let picture = Picture::from_planes(picture).expect("planes of one window");
        let doubt = planes.next().zip(planes.next()).map(|(mean, open)| Doubt { mean, open });
        Self { picture, doubt }
    }
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
    let in_sight = lens.in_sight(&prepared.cells, max_radius.min(run.largest_radius));
    // Kernels of an oval are stretched by an amount of their own at each radius, cat's eyes differ from pixel to pixel
    let has_eye = camera.iris.cat_eye() > 0.0;
    let is_plain = merge && table.is_round() && !has_eye;
    let lattice = is_plain.then(|| Lattice::new(&lens, &prepared.first, &prepared.cells, &in_sight, &table, limits));
    let plain = PlainBlocks { in_sight: &in_sight, lattice, first: &prepared.first };
    let job = Gather { lens, max_radius, px, forest, plain, table, merge };
    let round = model == KernelModel::Disc && camera.iris.shape() == optics::ApertureShape::Disc;

    let channels = if run.doubt { 6 } else { 4 };
    let planes = by_tiles(window, channels, progress, |part, out| {
        dispatch!(level, simd => match (round, run.doubt) {
            // Doubt that is not wanted is left out in the end
            _ if has_eye => job.tile::<_, _, true>(simd, &CatEye::new(job.table.outline()), part, out),
            (true, false) => job.tile::<_, _, false>(simd, &Round, part, out),
            (true, true) => job.tile::<_, _, true>(simd, &Round, part, out),
            (false, false) => job.tile::<_, _, false>(simd, &Shaped(job.table.outline()), part, out),
            (false, true) => job.tile::<_, _, true>(simd, &Shaped(job.table.outline()), part, out),
        });
    })?;
    Ok(Gathered::from_planes(planes))
}

/// What a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    taps: Taps,
    lattice: LatticeScratch,
    cells: [Vec<f32>; 6],
}

thread_local! {
    static SCRATCH: std::cell::RefCell<Scratch> = std::cell::RefCell::default();
}

impl Gather<'_> {
    /// One tile of the picture, or the `part` of it that is wanted: `out` holds its channels, each row by row.
    #[inline(always)]
    fn tile<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        part: PixelWindow,
        out: &mut [Vec<f32>],
    ) {
        let mut target = Target { part, out };
        let mut scratch = SCRATCH.take();
        simd.vectorize(
            #[inline(always)]
            || {
                let left = self.plain.sum_up::<S, DOUBT>(simd, &self.lens, &mut scratch.lattice, &mut target);
                for of_tile in parts(left.tile) {
                    let part = left.within(of_tile);
                    if part.intersection(&target.part).is_empty() {
                        continue;
                    }
                    let lens = self.lens.over(of_tile);
                    match self.coarseness(part, &lens) {
                        0 => {
                            self.each_pixel::<S, F, DOUBT>(
                                simd,
                                footprint,
                                &lens,
                                part,
                                &left,
                                &mut scratch,
                                &mut target,
                            );
                        }
                        level => {
                            let cells = (part, level);
                            self.each_cell::<S, F, DOUBT>(simd, footprint, cells, &left, &mut scratch, &mut target);
                        }
                    }
                }
            },
        );
        SCRATCH.set(scratch);
    }

    /// Gathers a part of what is left pixel by pixel.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them change from call to call")]
    fn each_pixel<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        lens: &TileLens,
        part: PixelWindow,
        left: &Left,
        scratch: &mut Scratch,
        target: &mut Target,
    ) {
        let taps = &mut scratch.taps;
        self.collect::<F>(part, lens, taps);
        if taps.are_black() {
            return;
        }
        let wanted = target.part;
        let rows = block_rows(lens.spread);
        for y in (part.y..part.y_end()).step_by(rows as usize) {
            for x in (part.x..part.x_end()).step_by(LANES) {
                let block = PixelWindow { x, y, width: LANES as u32, height: rows };
                if block.intersection(&wanted).is_empty() || !left.is_left(x, y) {
                    continue;
                }
                let is_plain = !self.plain.in_sight.at(x, y);
                let grid = BlockGrid { first: [x as f32, y as f32], step: 1.0, rows, is_plain };
                let is_wanted = |row: u32| (wanted.y..wanted.y_end()).contains(&(y + row as i32));
                self.block::<S, F, DOUBT>(simd, footprint, lens, grid, is_wanted, taps, |row, gathered| {
                    self.put(gathered, (x, y + row as i32), target);
                });
            }
        }
    }

    /// Gathers a part of what is left at the centres of cells of 2^level pixels, and interpolates between them.
    #[inline(always)]
    fn each_cell<S: Simd, F: Footprint, const DOUBT: bool>(
        &self,
        simd: S,
        footprint: &F,
        (part, level): (PixelWindow, u32),
        left: &Left,
        scratch: &mut Scratch,
        target: &mut Target,
    ) {
        // Cells lie on one grid for all tiles
        let side = 1_i32 << level;
        let part = part.aligned_to(side.max(BLOCK));
        let margin = (MARGIN * side) as u32;
        let around = part.grown(margin, margin);
        let lens = self.lens.over(around);
        let Scratch { taps, cells, .. } = scratch;
        self.collect::<F>(around, &lens, taps);

        let [columns, lines] = [around.width, around.height].map(|length| length as usize / side as usize);
        let width = columns.next_multiple_of(LANES);
        let rows = block_rows(lens.spread);
        cells.iter_mut().for_each(|plane| plane.resize(width * lines.next_multiple_of(rows as usize), 0.0));
        let pixel = |start: i32, k: usize| start + k as i32 * side;
        let center = |start: i32, k: usize| pixel(start, k) as f32 + 0.5 * (side - 1) as f32;
        for j in (0..lines).step_by(rows as usize) {
            for i in (0..columns).step_by(LANES) {
                let corners = [(i, j), (i + LANES, j + rows as usize)];
                let [(x, y), (x_end, y_end)] = corners.map(|(i, j)| (pixel(around.x, i), pixel(around.y, j)));
                let used_by = PixelWindow::from_corners(x, y, x_end, y_end).grown(margin, margin);
                if left.within(used_by.intersection(&target.part).aligned_to(BLOCK).intersection(&part)).is_empty() {
                    continue;
                }
                let grid = BlockGrid {
                    first: [center(around.x, i), center(around.y, j)],
                    step: side as f32,
                    rows,
                    is_plain: false,
                };
                let is_wanted = |row: u32| j + (row as usize) < lines;
                self.block::<S, F, DOUBT>(simd, footprint, &lens, grid, is_wanted, taps, |row, gathered| {
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
            part,
            level,
            cells,
            width,
            |x, y| left.is_left(x, y),
            |x, y, values| {
                for i in (0..LANES).filter(|&i| target.part.contains(x + i as i32, y)) {
                    let at = target.part.index(x + i as i32, y);
                    target.out.iter_mut().zip(values).for_each(|(out, values)| out[at] = values[i]);
                }
            },
        );
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

    /// Puts a gathered row, whose first pixel is `start`.
    fn put(&self, gathered: &Row, start: (i32, i32), target: &mut Target) {
        let Target { part, out } = target;
        for i in 0..LANES {
            let (x, y) = (start.0 + i as i32, start.1);
            if !part.contains(x, y) {
                continue;
            }
            let (at, full) = (part.index(x, y), gathered.full[i]);
            if full > 0.0 {
                let share = 1.0 / full;
                (0..4).for_each(|c| out[c][at] = gathered.rgba[c][i] * share);
                if let [_, _, _, _, doubt, open] = &mut **out {
                    doubt[at] = gathered.doubt[i] * share;
                    open[at] = 1.0 - full;
                }
            } else {
                let rgba = self.plain.unfiltered(x, y);
                (0..4).for_each(|c| out[c][at] = rgba[c]);
            }
        }
    }
}

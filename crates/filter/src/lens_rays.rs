//! Rung 5: lens rays marched through the layered depth images (Lee, Eisemann and Seidel 2010, "Real-Time Lens Blur Effects
//! and Focus Control"), after silhouettes are taken apart and the hidden background is filled in.
//!
//! Each pixel sends rays through points of its iris. A ray passes over the pixels of a line, from near to far, and ends on
//! the first surface that it meets: where its inverse depth crosses that of a layer, pixel by pixel a small plane.
//! Neighbouring pixels are one surface where their planes meet at the border; between surfaces there is a gap, through
//! which a ray passes behind what is nearer. So every pixel of a near, blurred thing hides exactly what it hides from each
//! lens point, and nothing is counted twice: occlusion is right where a gather can only weigh.
//!
//! A ray that ends behind everything that the surfaces know takes part in nothing: the pixel is the mean of the rays that
//! found something.
//!
//! Where no edge is in sight all rays end on one surface, and their mean is known without noise: these blocks are summed up as
//! the merged gather does it ([`PlainBlocks`]).

use fearless_simd::{Level, dispatch, prelude::*};
use glam::Vec2;
use optics::{Camera, KernelModel};
use rgbd::{Cancelled, PixelWindow, Progress};

use crate::{
    FrameView, Sides,
    depth_pyramid::{DepthPyramid, Range},
    fetch_radius::FetchRadius,
    gather::Gathered,
    kernel::KernelTable,
    lattice::Lattice,
    lattice_work::LatticeScratch,
    lens_map::{PixelLens, skew, spread},
    lens_points::{LensPoints, open_points},
    lens_ray::{Hit, LensRay, floor, pixel_ranges},
    patch::{Patches, PieceId},
    plain_blocks::{Left, PlainBlocks, Target},
    prepare::Prepared,
    surface::{Surface, pixel_q},
    tiles::{by_tiles, parts},
    view_lens::ViewLens,
};

/// A step in depth that changes the blur by less than this many pixels of radius is no edge.
const SEAMLESS_PX: f32 = 0.25;

/// Settings of [`Method::LensRays`](crate::Method::LensRays).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensRaysSettings {
    /// Rays for each pixel, 1 to 65,536.
    pub samples: u32,
    /// Largest radius (of the wider axis) of the circle of confusion in pixels; larger ones are cut to it. `None`: a quarter of the display
    /// window's width.
    pub max_radius_px: Option<f32>,
    /// How many of the frame's layers to use; 1 ignores hidden ones.
    pub layers: usize,
    /// What is blurred at all.
    pub sides: Sides,
    /// Whether [`Filtered::predicted_error`](crate::Filtered::predicted_error) is wanted too.
    pub predict_error: bool,
}

impl Default for LensRaysSettings {
    /// 64 rays, all layers.
    fn default() -> Self {
        Self { samples: 64, max_radius_px: None, layers: usize::MAX, sides: Sides::Both, predict_error: false }
    }
}

/// Everything that is the same for all tiles.
struct Job<'a> {
    lens: ViewLens<'a>,
    plain: PlainBlocks<'a>,
    max_radius: f32,
    first: &'a Surface,
    patches: Patches,
    pyramid: DepthPyramid,
    /// Rays of a pixel, their points, and so many that they stand for the whole lens.
    samples: usize,
    points: LensPoints,
    many_points: LensPoints,
    fetch: FetchRadius,
}

/// How rays are run.
#[derive(Clone, Copy)]
pub(crate) struct RayRun {
    pub(crate) samples: u32,
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
    /// Whether doubt is wanted too.
    pub(crate) doubt: bool,
}

/// Sends the rays of `window`.
pub(crate) fn lens_rays(
    view: &FrameView,
    camera: &Camera,
    run: &RayRun,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Gathered, Cancelled> {
    let (first, beside, cells) = Prepared::new(view, camera, run.layers, run.fill_reach, run.sides).into_layers();
    let blur = camera.pixels_per_defocus().max_element() as f32;
    let patches = Patches::new(&first, beside, (SEAMLESS_PX / blur).min(1e6));
    let pyramid = DepthPyramid::new(patches.window, pixel_ranges(&patches));
    let shape = camera.iris.shape();
    // Of a cat's eye only the open points serve: have as many more
    let points = LensPoints::new(shape, run.samples * (1.0 / least_open(view, camera)).ceil().min(8.0) as u32);
    let many_points = LensPoints::new(shape, 1024);
    let fetch = FetchRadius::new(&many_points, shape.variance());

    let lens = ViewLens { view, camera, model: KernelModel::Exact };
    let limits = [run.max_radius, run.largest_radius];
    let in_sight = lens.in_sight(&cells, run.max_radius.min(run.largest_radius));
    let table = KernelTable::of(camera);
    // The lattice knows the skew of a leaning iris to second order only, which is less than rays do, and no cat's eye
    let has_eye = camera.iris.cat_eye() > 0.0;
    let is_plain = table.is_round() && !has_eye && camera.iris.e1().z == 0.0 && camera.iris.e2().z == 0.0;
    let lattice = is_plain.then(|| Lattice::new(&lens, &first, &cells, &in_sight, &table, limits));
    let plain = PlainBlocks { in_sight: &in_sight, lattice, first: &first };
    let (samples, max_radius, first) = (run.samples as usize, run.max_radius, &first);
    let job = Job { lens, plain, max_radius, first, patches, pyramid, samples, points, many_points, fetch };
    let level = Level::new();
    let channels = if run.doubt { 6 } else { 4 };
    let planes = by_tiles(window, channels, progress, |part, out| {
        dispatch!(level, simd => match run.doubt {
            true => job.tile::<_, true>(simd, part, out),
            false => job.tile::<_, false>(simd, part, out),
        });
    })?;
    Ok(Gathered::from_planes(planes))
}

/// The least share of the lens that is open anywhere in the frame: in one of its corners.
fn least_open(view: &FrameView, camera: &Camera) -> f64 {
    let data = view.frame().data();
    let corners = [(data.x, data.y), (data.x_end(), data.y), (data.x, data.y_end()), (data.x_end(), data.y_end())];
    let share = |(x, y)| camera.iris.opening(pixel_q(view, camera, x, y)).share();
    corners.into_iter().map(share).fold(1.0, f64::min)
}

/// What a ray, or all rays of a pixel, have found: colour, how far it may be off, and how much of them has ended.
#[derive(Clone, Copy, Default)]
struct Found {
    rgba: [f32; 4],
    doubt: f32,
    ended: f32,
}

impl Found {
    #[inline(always)]
    fn add(&mut self, weight: f32, other: &Self) {
        self.ended += weight * other.ended;
        self.doubt += weight * other.doubt;
        for (sum, c) in self.rgba.iter_mut().zip(other.rgba) {
            *sum += weight * c;
        }
    }
}

thread_local! {
    static SCRATCH: std::cell::RefCell<LatticeScratch> = std::cell::RefCell::default();
}

impl Job<'_> {
    /// One tile of the picture, or the `part` of it that is wanted: `out` holds its channels, each row by row.
    #[inline(always)]
    fn tile<S: Simd, const DOUBT: bool>(&self, simd: S, part: PixelWindow, out: &mut [Vec<f32>]) {
        let mut target = Target { part, out };
        let mut scratch = SCRATCH.take();
        let left = simd.vectorize(
            #[inline(always)]
            || self.plain.sum_up::<S, DOUBT>(simd, &self.lens, &mut scratch, &mut target),
        );
        SCRATCH.set(scratch);
        for of_tile in parts(left.tile) {
            self.left_pixels::<DOUBT>(&left, of_tile.intersection(&part), &mut target);
        }
    }

    /// The pixels of a part of the tile whose blocks are left.
    fn left_pixels<const DOUBT: bool>(&self, left: &Left, part: PixelWindow, target: &mut Target) {
        let pixels: Vec<(i32, i32)> = part.pixels().filter(|&(x, y)| left.is_left(x, y)).collect();
        let lenses: Vec<PixelLens> = pixels.iter().map(|&(x, y)| self.lens.at(f64::from(x), f64::from(y))).collect();
        let range = self.range(part, &lenses);
        for (&(x, y), lens) in pixels.iter().zip(&lenses) {
            let (at, found) = (target.part.index(x, y), self.pixel::<DOUBT>(x, y, lens, range));
            (0..4).for_each(|c| target.out[c][at] = found.rgba[c]);
            if let (true, [_, _, _, _, doubt, open]) = (DOUBT, &mut *target.out) {
                doubt[at] = found.doubt;
                open[at] = 1.0 - found.ended;
            }
        }
    }

    /// The inverse depths that the rays of a tile may meet.
    fn range(&self, tile: PixelWindow, lenses: &[PixelLens]) -> Range {
        let mut range = self.pyramid.over(self.patches.window);
        // What is out of reach for every depth that is left does not count
        for _ in 0..4 {
            if range.is_empty() {
                break;
            }
            let reach = |lens: &PixelLens| {
                let defocus = (range.high - lens.focus).abs().max((range.low - lens.focus).abs());
                (lens.widest * defocus).min(self.max_radius * lens.stretch())
            };
            let reach = lenses.iter().map(reach).fold(0.0, f32::max) as u32 + 2;
            range = self.pyramid.over(tile.grown(reach, reach));
        }
        range
    }

    /// The mean over the rays of one pixel.
    fn pixel<const DOUBT: bool>(&self, x: i32, y: i32, lens: &PixelLens, range: Range) -> Found {
        // Where there is nothing, nothing can be off
        let nothing = |rgba| Found { rgba, doubt: 0.0, ended: 1.0 };
        if range.is_empty() {
            return nothing([0.0; 4]);
        }
        // Span the pixel's footprint per unit of defocus, as equation 5 does
        let ViewLens { view, camera, .. } = self.lens;
        let q = pixel_q(view, camera, x, y);
        let spread = spread(camera, q);
        let (axis1, axis2) = (spread.x_axis.as_vec2(), spread.y_axis.as_vec2());
        let skew = skew(camera, camera.focus.inverse_depth(q)).as_vec2();
        // How far it reaches across and down
        let extent = Vec2::new(axis1.x.hypot(axis2.x), axis1.y.hypot(axis2.y));
        let limit = if lens.scale > 0.0 { self.max_radius / lens.scale } else { f32::INFINITY };

        let window = self.patches.window;
        let display = view.frame().display;
        let mut found = Found::default();
        let points = self.points.of_pixel(x - display.x, y - display.y);
        let open = (camera.iris.cat_eye() > 0.0)
            .then(|| open_points(points, self.samples, &camera.iris.opening(q), self.many_points.of_pixel(0, 0)));
        let points = open.as_deref().unwrap_or(points);
        for u in points {
            let pace = (axis1 * u.x + axis2 * u.y) / (1.0 - skew.dot(*u)).max(0.5);
            let (column, row) = (x - window.x, y - window.y);
            let ray = LensRay { column, row, focus: lens.focus, pace, limit };
            found.add(1.0, &self.trace::<DOUBT>(&ray, extent, range));
        }
        if found.ended <= 0.0 {
            return nothing(self.plain.unfiltered(x, y));
        }
        let count = points.len() as f32;
        Found {
            rgba: found.rgba.map(|c| c / found.ended),
            doubt: found.doubt / found.ended,
            ended: found.ended / count,
        }
    }

    /// What one ray finds; `extent` is its pixel's footprint across and down, in pixels per unit of defocus.
    fn trace<const DOUBT: bool>(&self, ray: &LensRay, extent: Vec2, range: Range) -> Found {
        let mut found = Found::default();
        ray.march(&self.patches, &self.pyramid, range, |hit| {
            let fetched = self.fetch::<DOUBT>(&hit, ray, extent);
            found.add(1.0 - found.ended, &fetched);
            found.ended < OPAQUE
        });
        found
    }

    /// The surface around a hit, interpolated between pixel centres.
    #[inline(always)]
    fn fetch<const DOUBT: bool>(&self, hit: &Hit, ray: &LensRay, extent: Vec2) -> Found {
        // Draw the fetch in, so that interpolation and lens together blur as much as the lens should
        let radius = extent * (hit.s - ray.focus).abs().min(ray.limit);
        let scale = Vec2::new(self.fetch.scale(radius.x), self.fetch.scale(radius.y));
        let at = hit.offset * scale - (hit.offset - hit.within);
        let (left, top) = (floor(at.x), floor(at.y));
        let part = at - Vec2::new(left as f32, top as f32);
        let weights =
            [(1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y];

        // Inside a surface its pixels are mixed as they are
        let width = self.patches.window.width as i32;
        let is_near = |low: i32| (-1..=0).contains(&low);
        let mut found = Found::default();
        if is_near(left) && is_near(top) && self.patches.is_seamless(hit.piece, hit.index) {
            let first = (hit.index as i32 + top * width + left) as usize;
            for (i, weight) in [0, 1, width as usize, width as usize + 1].into_iter().zip(weights) {
                let piece = self.patches.in_layer_of(hit.piece, first + i).unwrap_or(hit.piece);
                found.add(weight, &self.own::<DOUBT>(piece, first + i));
            }
            return found;
        }
        for ((dx, dy), weight) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().zip(weights) {
            if weight > 0.0 {
                found.add(weight, &self.neighbour::<DOUBT>(hit, left + dx, top + dy));
            }
        }
        found
    }

    /// The pixel at (dx, dy) from a hit on the same surface, in this layer or another; where there is none, the pixel that
    /// was hit.
    fn neighbour<const DOUBT: bool>(&self, hit: &Hit, dx: i32, dy: i32) -> Found {
        let window = self.patches.window;
        let (column, row) = (hit.index as i32 % window.width as i32 + dx, hit.index as i32 / window.width as i32 + dy);
        let (x, y) = (window.x + column, window.y + row);
        if (dx, dy) == (0, 0) || !window.contains(x, y) {
            return self.own::<DOUBT>(hit.piece, hit.index);
        }
        let index = window.index(x, y);
        match self.patches.next(hit.piece, hit.index, dx, dy, index) {
            Some(piece) => self.own::<DOUBT>(piece, index),
            None => self.own::<DOUBT>(hit.piece, hit.index),
        }
    }

    /// A piece of a pixel as it is.
    #[inline(always)]
    fn own<const DOUBT: bool>(&self, piece: PieceId, index: usize) -> Found {
        let (rgba, cover, doubt) = match piece {
            PieceId::First => {
                let doubt = if DOUBT { self.first.doubt[index] } else { 0.0 };
                (self.first.rgba[index], self.first.cover[index], doubt)
            }
            PieceId::Beside(k) => {
                let fragment = self.patches.fragment(k);
                (fragment.rgba, fragment.cover, fragment.doubt)
            }
        };
        Found { rgba, doubt: cover * doubt, ended: cover }
    }
}

/// A ray that has ended this far is followed no more.
const OPAQUE: f32 = 0.9999;

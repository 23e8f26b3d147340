//! Rung 2: the Potmesil-style gather, in depth order.
//!
//! For each pixel, every neighbour whose footprint covers it contributes with the share of the iris that it fills: one
//! over the footprint's area, times the slope factor below. Neighbours are taken nearest first until the iris is full:
//! what is nearer hides what is farther (a sharp foreground is not invaded by a blurred background), and where the nearer
//! ones leave the iris open, what lies behind shows through (a blurred foreground is see-through at its rim).
//! What stays open in the end (beyond the border, behind a silhouette) is shared by what is there: the weights are
//! normalised, so that a furnace stays 1.
//!
//! **Slope factor.** On a plane the inverse depth is affine in the pixel, so the map from pixels to iris points is known
//! exactly: a pixel at defocus d fills `|d0| / |d|^3` of the iris, where d0 is the defocus that the neighbour's plane
//! has at the receiving pixel. Without the factor d0/d the weights of a sloped floor do not sum to 1.
//!
//! **Hidden layers** take part only as far as the first layer leaves the iris open, from nothing at 0 % to all at 10 %:
//! the first layer's own weights sum to 1 only within a few percent where surfaces curve.

use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, PixelWindow, Progress};

use crate::{
    FrameView, KernelRule,
    cells::Cells,
    disc_table::DiscTable,
    lens_map::{Footprint, IrisFootprint, PixelLens, RoundFootprint},
    surface::{Surface, pixel_q},
    tiles::by_tiles,
};

/// Share of the iris that the first layer must leave open before hidden layers count in full.
const FULLY_OPEN: f32 = 0.1;

/// Settings of [`Method::Gather`](crate::Method::Gather).
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

/// A pixel of a surface on its way into a tile.
#[derive(Clone, Copy)]
struct Tap {
    inverse_depth: f32,
    x: i32,
    y: i32,
    layer: u32,
    index: u32,
}

/// Everything that is the same for all tiles.
struct Job<'a> {
    view: &'a FrameView<'a>,
    camera: &'a Camera,
    model: KernelModel,
    max_radius: f32,
    surfaces: Vec<Surface>,
    cells: Vec<Cells>,
    table: DiscTable,
}

/// Gathers `window`; `max_radius` in pixels.
pub(crate) fn gather(
    view: &FrameView,
    camera: &Camera,
    model: KernelModel,
    settings: &GatherSettings,
    max_radius: f32,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Picture, Cancelled> {
    let layers = view.frame().layers().len().min(settings.layers.max(1));
    let surfaces: Vec<Surface> = (0..layers).map(|i| Surface::new(view, camera, i)).collect();
    let cells = surfaces.iter().map(Cells::new).collect();
    let table = DiscTable::new(camera.iris.shape());
    let round = model == KernelModel::Disc && camera.iris.shape() == optics::ApertureShape::Disc;
    let job = Job { view, camera, model, max_radius, surfaces, cells, table };

    by_tiles(window, progress, |tile| {
        if round { job.tile(&RoundFootprint, tile) } else { job.tile(&IrisFootprint(job.table.outline()), tile) }
    })
}

/// What a pixel has gathered: colour, and how full its iris is.
#[derive(Clone, Copy, Default)]
struct Gathered {
    rgba: [f32; 4],
    full: f32,
}

impl Gathered {
    fn normalised(&self) -> Option<[f32; 4]> {
        (self.full > 0.0).then(|| self.rgba.map(|c| c / self.full))
    }
}

impl Job<'_> {
    /// The colours of one tile, row by row.
    fn tile(&self, footprint: &impl Footprint, tile: PixelWindow) -> Vec<[f32; 4]> {
        let lenses: Vec<PixelLens> = tile
            .pixels()
            .map(|(x, y)| PixelLens::new(self.camera, self.model, pixel_q(self.view, self.camera, x, y)))
            .collect();
        let taps = self.taps(tile, &lenses);

        // Nothing comes of nothing: most of a picture whose data window is small
        let is_empty = |tap: &Tap| self.surfaces[tap.layer as usize].rgba[tap.index as usize] == [0.0; 4];
        if taps.iter().all(is_empty) {
            return vec![[0.0; 4]; tile.area()];
        }

        // Gather the first layer, then all of them where it leaves the iris open
        let first = self.fill(footprint, tile, &lenses, taps.iter().filter(|tap| tap.layer == 0));
        let is_open = |g: &Gathered| g.full < 1.0;
        let hidden = taps.iter().any(|tap| tap.layer > 0) && first.iter().any(is_open);
        let all = if hidden { self.fill(footprint, tile, &lenses, taps.iter()) } else { first.clone() };

        let blend = |((x, y), (first, all)): ((i32, i32), (&Gathered, &Gathered))| {
            let Some(visible) = first.normalised() else {
                return all.normalised().unwrap_or_else(|| self.unfiltered(x, y));
            };
            let Some(complete) = all.normalised() else { return visible };
            let share = ((1.0 - first.full) / FULLY_OPEN).clamp(0.0, 1.0);
            [0, 1, 2, 3].map(|c| visible[c] + share * (complete[c] - visible[c]))
        };
        tile.pixels().zip(first.iter().zip(&all)).map(blend).collect()
    }

    /// The first layer's colour, nothing outside the data.
    fn unfiltered(&self, x: i32, y: i32) -> [f32; 4] {
        let surface = &self.surfaces[0];
        if surface.window.contains(x, y) { surface.rgba[surface.window.index(x, y)] } else { [0.0; 4] }
    }

    /// All surface pixels that may cover a pixel of the tile, nearest first; ties by layer, row and column.
    fn taps(&self, tile: PixelWindow, lenses: &[PixelLens]) -> Vec<Tap> {
        let reach = self.reach(lenses);
        let mut taps = Vec::new();
        for (layer, (surface, cells)) in self.surfaces.iter().zip(&self.cells).enumerate() {
            for part in cells.reaching(tile, &reach) {
                for (x, y) in part.pixels() {
                    let index = surface.window.index(x, y);
                    if surface.cover[index] > 0.0 {
                        let inverse_depth = surface.inverse_depth[index];
                        taps.push(Tap { inverse_depth, x, y, layer: layer as u32, index: index as u32 });
                    }
                }
            }
        }
        taps.sort_unstable_by(|a, b| {
            let nearer = b.inverse_depth.total_cmp(&a.inverse_depth);
            nearer.then((a.layer, a.y, a.x).cmp(&(b.layer, b.y, b.x)))
        });
        taps
    }

    /// How many pixels a range of inverse depth may reach for these lenses: blur, ramp and rounding.
    fn reach(&self, lenses: &[PixelLens]) -> impl Fn(f32, f32) -> f32 + use<> {
        let stretch = lenses.iter().map(PixelLens::stretch).fold(1.0, f32::max);
        let start = (f32::INFINITY, f32::NEG_INFINITY, 0.0_f32);
        let (low, high, widest) = lenses.iter().fold(start, |(low, high, widest), lens| {
            (low.min(lens.focus), high.max(lens.focus), widest.max(lens.widest))
        });
        let max_radius = self.max_radius;
        move |nearest_sky: f32, nearest: f32| {
            let defocus = (nearest - low).abs().max((nearest_sky - high).abs());
            (widest * defocus).min(max_radius * stretch) + 2.0
        }
    }

    /// Fills each pixel's iris with the taps in their order.
    fn fill<'t>(
        &self,
        footprint: &impl Footprint,
        tile: PixelWindow,
        lenses: &[PixelLens],
        taps: impl Iterator<Item = &'t Tap>,
    ) -> Vec<Gathered> {
        let reach = self.reach(lenses);
        let mut gathered = vec![Gathered::default(); tile.area()];
        for tap in taps {
            let surface = &self.surfaces[tap.layer as usize];
            let index = tap.index as usize;
            let (rgba, cover, slope) = (surface.rgba[index], surface.cover[index], surface.slope[index]);

            // Visit the pixels of the tile that the tap may reach
            let radius = reach(tap.inverse_depth, tap.inverse_depth) as u32;
            let around =
                PixelWindow { x: tap.x, y: tap.y, width: 1, height: 1 }.grown(radius, radius).intersection(&tile);
            if around.is_empty() {
                continue;
            }
            for y in around.y..around.y_end() {
                let row = tile.index(around.x, y);
                for (x, i) in (around.x..around.x_end()).zip(row..) {
                    let open = 1.0 - gathered[i].full;
                    if open <= 0.0 {
                        continue;
                    }
                    let weight = self.weight(footprint, &lenses[i], tap, slope, x, y);
                    if weight > 0.0 {
                        let taken = (weight * cover).min(open);
                        let gathered = &mut gathered[i];
                        gathered.full += taken;
                        // Hidden colour is premultiplied with the cover already
                        let scale = if tap.layer == 0 { taken } else { taken / cover };
                        for (sum, c) in gathered.rgba.iter_mut().zip(rgba) {
                            *sum += scale * c;
                        }
                    }
                }
            }
        }
        gathered
    }

    /// The share of pixel (x, y)'s iris that the tap fills.
    #[inline(always)]
    fn weight(&self, footprint: &impl Footprint, lens: &PixelLens, tap: &Tap, slope: [f32; 2], x: i32, y: i32) -> f32 {
        // Offset from the receiving pixel to the tap, and the tap's blur there
        let (dx, dy) = ((tap.x - x) as f32, (tap.y - y) as f32);
        let defocus = tap.inverse_depth - lens.focus;
        let radius = (lens.scale * defocus.abs()).min(self.max_radius);
        let outer = radius * lens.stretch() + 1.5;
        if dx * dx + dy * dy > outer * outer {
            return 0.0;
        }
        let kernel = self.table.at(radius);
        let inside = footprint.inside(lens, dx, dy, lens.scale * defocus, &kernel);
        if inside <= 0.0 || radius <= SLOPE_FROM {
            return inside * kernel.weight;
        }

        // Count a sloped surface by the part of the iris it fills; not where the footprint is too small to have one
        let factor = (1.0 - (slope[0] * dx + slope[1] * dy) / defocus).clamp(0.5, 2.0);
        let trust = (radius - SLOPE_FROM).min(1.0);
        inside * kernel.weight * (1.0 + trust * (factor - 1.0))
    }
}

/// Radius in pixels from which the slope of a surface counts; it counts in full one pixel later.
const SLOPE_FROM: f32 = 0.5;

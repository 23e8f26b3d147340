//! The lens over a view: at a point, and over a tile.

use glam::DVec2;
use optics::{Camera, KernelModel};
use rgbd::PixelWindow;

use crate::{
    FrameView,
    cat_eye::Eye,
    cells::{BLOCK, Cells, InSight, Range},
    lens_map::PixelLens,
};

/// A camera's lens over the pixels of a view.
#[derive(Clone, Copy)]
pub(crate) struct ViewLens<'a> {
    pub(crate) view: &'a FrameView<'a>,
    pub(crate) camera: &'a Camera,
    pub(crate) model: KernelModel,
}

impl ViewLens<'_> {
    /// The lens that a point sees; whole coordinates are pixel centres.
    pub(crate) fn at(&self, x: f64, y: f64) -> PixelLens {
        PixelLens::new(self.camera, self.model, self.q_at(x, y))
    }

    /// What a point sees open of the lens.
    pub(crate) fn eye_at(&self, x: f64, y: f64) -> Eye {
        Eye::new(self.camera, self.q_at(x, y))
    }

    fn q_at(&self, x: f64, y: f64) -> DVec2 {
        let display = self.view.frame().display;
        let at = DVec2::new(x - f64::from(display.x) + 0.5, y - f64::from(display.y) + 0.5);
        self.camera.film.q_from_pixel(at)
    }

    /// The lens over a tile.
    pub(crate) fn over(&self, tile: PixelWindow) -> TileLens {
        let corner = |x: i32, y: i32| self.at(f64::from(x), f64::from(y));
        let (right, bottom) = (tile.x_end() - 1, tile.y_end() - 1);
        let corners = [corner(tile.x, tile.y), corner(right, tile.y), corner(tile.x, bottom), corner(right, bottom)];
        let middle = |start: i32, end: i32| 0.5 * (f64::from(start) + f64::from(end));
        let at = [middle(tile.x, right), middle(tile.y, bottom)];
        let center = self.at(at[0], at[1]);
        let low = corners.iter().map(|lens| lens.focus).fold(f32::INFINITY, f32::min);
        let high = corners.iter().map(|lens| lens.focus).fold(f32::NEG_INFINITY, f32::max);
        let spread = center.scale * (high - center.focus).max(center.focus - low);
        let stretch = corners.iter().map(PixelLens::stretch).fold(1.0, f32::max);
        let widest = corners.iter().map(|lens| lens.widest).fold(0.0, f32::max);
        // A cat's eye is narrowest in one of the corners
        let narrowest = if self.camera.iris.cat_eye() > 0.0 {
            let eye = |x: i32, y: i32| self.eye_at(f64::from(x), f64::from(y)).narrowest();
            let of_row = |y: i32| eye(tile.x, y).min(eye(right, y));
            of_row(tile.y).min(of_row(bottom))
        } else {
            1.0
        };
        TileLens {
            center: PixelLens { widest, ..center },
            narrowest,
            at: at.map(|at| at as f32),
            focus: [low, high],
            focus_slope: self.focus_slope(),
            spread,
            stretch,
            is_even: corners.iter().all(|lens| *lens == center),
        }
    }

    /// Change of the inverse depth of focus per pixel in x and y.
    pub(crate) fn focus_slope(&self) -> [f32; 2] {
        let [origin, right, below] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
            .map(|(x, y)| self.camera.focus.inverse_depth(self.camera.film.q_from_pixel(DVec2::new(x, y))));
        [(right - origin) as f32, (below - origin) as f32]
    }

    /// The blocks from which an edge may be seen through a blur of at most `largest` pixels of radius.
    pub(crate) fn in_sight(&self, cells: &Cells, largest: f32) -> InSight {
        let corners = self.at_corners();
        let widest = corners.iter().map(|lens| lens.widest).fold(0.0, f32::max);
        let stretch = corners.iter().map(PixelLens::stretch).fold(1.0, f32::max);
        let slope = self.focus_slope().map(|s| s * widest);
        let steepness = slope[0].hypot(slope[1]).min(0.9);
        cells.in_sight(|[far, near], x, y| {
            // The focus changes on the way to who sees it, and over both blocks
            let focus = self.at(f64::from(x), f64::from(y)).focus;
            let radius = widest * (near - focus).abs().max((far - focus).abs()) + steepness * 2.0 * BLOCK as f32;
            (radius / (1.0 - steepness)).min(largest * stretch) + 2.0
        })
    }

    /// The lens at the corners of the frame's data, which is the same for every view of it.
    pub(crate) fn at_corners(&self) -> [PixelLens; 4] {
        let data = self.view.frame().data();
        let at = |start: i32, length: u32, k: i32| f64::from(start) + f64::from(k) * f64::from(length);
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| self.at(at(data.x, data.width, x), at(data.y, data.height, y)))
    }
}

/// The lens over a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileLens {
    pub(crate) center: PixelLens,
    /// The tile's centre in pixels.
    pub(crate) at: [f32; 2],
    /// Smallest and largest inverse depth of focus over the tile, and its change per pixel in x and y.
    pub(crate) focus: [f32; 2],
    pub(crate) focus_slope: [f32; 2],
    /// By how much the defocus differs at most from that at the centre, in pixels.
    pub(crate) spread: f32,
    pub(crate) stretch: f32,
    /// Whether the lens is the same all over the tile.
    pub(crate) is_even: bool,
    /// Half the width of what is open of the lens where that is least, for a radius of 1.
    narrowest: f32,
}

impl TileLens {
    /// The largest defocus of a range of inverse depth.
    fn defocus(&self, [far, near]: Range) -> f32 {
        (near - self.focus[0]).abs().max((far - self.focus[1]).abs())
    }

    /// How far a range of inverse depth may reach, in pixels.
    pub(crate) fn reach(&self, range: Range, max_radius: f32) -> f32 {
        (self.center.widest * self.defocus(range)).min(max_radius * self.stretch) + 1.5
    }

    /// The least blur radius that a range of inverse depth has, in pixels; of a cat's eye half its width.
    pub(crate) fn least_radius(&self, [far, near]: Range) -> f32 {
        self.narrowest * self.center.scale * (far - self.focus[1]).max(self.focus[0] - near).max(0.0)
    }

    /// The largest one.
    pub(crate) fn largest_radius(&self, range: Range) -> f32 {
        self.center.scale * self.defocus(range)
    }

    /// The inverse depth of focus at a point.
    #[inline(always)]
    pub(crate) fn focus_at(&self, x: f32, y: f32) -> f32 {
        self.center.focus + self.focus_slope[0] * (x - self.at[0]) + self.focus_slope[1] * (y - self.at[1])
    }
}

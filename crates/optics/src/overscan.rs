//! How much lies just outside the picture that the lens sees all the same.

use glam::DVec2;

use crate::{Camera, DepthRange, Footprint, Reading, kernel_model::grid};

/// What a lens needs beyond each side of the display window, in pixels, 0 or more; `+inf` where no margin is enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overscan {
    /// Columns left of the picture.
    pub left: f64,
    /// Columns right of the picture.
    pub right: f64,
    /// Rows above the picture.
    pub top: f64,
    /// Rows below the picture.
    pub bottom: f64,
}

impl Overscan {
    /// Whole columns for either side, the wider one, at most `cap`.
    #[must_use]
    pub fn columns(&self, cap: u32) -> u32 {
        whole(self.left.max(self.right), cap)
    }

    /// Whole rows for either side, the wider one, at most `cap`.
    #[must_use]
    pub fn rows(&self, cap: u32) -> u32 {
        whole(self.top.max(self.bottom), cap)
    }
}

/// Pixels, up to the next whole one, and at most `cap`.
fn whole(pixels: f64, cap: u32) -> u32 {
    pixels.ceil().min(f64::from(cap)) as u32
}

impl Camera {
    /// The margin that holds everything the pixels of the display window see, for a scene within `depths`.
    ///
    /// From the bounds of the exact footprint on a grid of 33 x 33 pixels, corners included; exact to about 0.1 %.
    #[must_use]
    pub fn overscan(&self, depths: &DepthRange) -> Overscan {
        let mut need = Overscan { left: 0.0, right: 0.0, top: 0.0, bottom: 0.0 };
        let size = DVec2::new(f64::from(self.film.width()), f64::from(self.film.height()));
        for q in grid(&self.film) {
            let pixel = self.film.pixel_from_q(q);
            for inverse_depth in depths.inverse() {
                let footprint = Footprint::new(self, Reading::Gather, q, inverse_depth).in_pixels(&self.film);
                need.left = need.left.max(footprint.support(DVec2::NEG_X) - pixel.x);
                need.right = need.right.max(footprint.support(DVec2::X) + pixel.x - size.x);
                need.top = need.top.max(footprint.support(DVec2::NEG_Y) - pixel.y);
                need.bottom = need.bottom.max(footprint.support(DVec2::Y) + pixel.y - size.y);
            }
        }
        need
    }

    /// Largest radius of the circle of confusion over the display window in pixels (of the wider axis), for a scene
    /// within `depths`: |D| R s.
    #[must_use]
    pub fn largest_coc_radius_px(&self, depths: &DepthRange) -> f64 {
        // |D| is the greatest at a corner, since D is affine in q and in 1/z
        let corners = self.film.corners().into_iter();
        corners
            .flat_map(|q| depths.inverse().map(|inverse_depth| self.coc_radius_px(q, inverse_depth).abs()))
            .fold(0.0, f64::max)
    }
}

//! The part of a picture that is compared: three channels of one window, every value finite.

use rgbd::{Picture, PixelWindow};

use crate::CompareError;

/// Linear R, G, B of one window, row by row; values that were not finite are 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rgb {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) channels: [Vec<f32>; 3],
    /// How many pixels held a value that was not finite.
    pub(crate) non_finite: usize,
}

impl Rgb {
    /// The colours of `picture` in `window`, which it must cover.
    pub(crate) fn from_picture(picture: &Picture, window: PixelWindow, what: &str) -> Result<Self, CompareError> {
        // Refuse a window with nothing in it, or with more in it than the picture has
        if window.is_empty() {
            return Err(CompareError::NoPixel(window));
        }
        let found = picture.window();
        if !found.contains_window(&window) {
            return Err(CompareError::WindowMismatch { what: what.to_owned(), found, wanted: window });
        }

        // Copy the window, row by row
        let (width, height) = (window.width as usize, window.height as usize);
        let start = (window.x - found.x) as usize;
        let mut channels = [0, 1, 2].map(|c| {
            let mut values: Vec<f32> = Vec::with_capacity(width * height);
            for y in window.y..window.y_end() {
                values.extend_from_slice(&picture.planes()[c].row(y)[start..start + width]);
            }
            values
        });

        // Count the pixels that hold no number, and take them as black
        let mut non_finite = 0;
        for i in 0..width * height {
            if channels.iter().any(|channel| !channel[i].is_finite()) {
                non_finite += 1;
                channels.iter_mut().for_each(|channel| channel[i] = 0.0);
            }
        }
        Ok(Self { width, height, channels, non_finite })
    }

    /// The same window with each value mapped.
    pub(crate) fn map(&self, f: impl Fn(f32) -> f32 + Sync) -> Self {
        let channels = [0, 1, 2].map(|c| self.channels[c].iter().map(|&value| f(value)).collect());
        Self { channels, ..*self }
    }

    /// The three channels of pixel `i`.
    pub(crate) fn at(&self, i: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.channels[c][i])
    }

    /// Number of pixels.
    pub(crate) fn len(&self) -> usize {
        self.width * self.height
    }
}

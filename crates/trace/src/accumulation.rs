//! Sums of samples that do not depend on the order in which they were made.

use std::ops::Range;

use glam::Vec3;
use optics::Camera;
use rgbd::{Picture, PixelWindow, Truth};

use crate::{Pixels, RenderError};

/// One half of a pixel: the sum of its samples in multiples of 2^-28, and their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sum {
    rgb: [i64; 3],
    count: u32,
}

/// Multiples of what a sample is counted in. Every sum is an integer, so that additions are exact and may come in any
/// order: with radiance up to 2^18 (`MAX_RADIANCE`) and 2^16 samples it stays below 2^62. The rounding of a sample is
/// at most 2^-29, far below one step of an f32 picture.
const STEPS: f64 = (1_u64 << 28) as f64;

impl Sum {
    /// Counts a sample.
    #[inline]
    pub(crate) fn add(&mut self, radiance: Vec3) {
        for (sum, value) in self.rgb.iter_mut().zip(radiance.to_array()) {
            *sum += (f64::from(value) * STEPS + 0.5) as i64; // rounds, as no radiance is negative
        }
        self.count += 1;
    }

    fn join(&mut self, other: &Self) {
        for (sum, more) in self.rgb.iter_mut().zip(other.rgb) {
            *sum += more;
        }
        self.count += other.count;
    }

    /// The mean with alpha 1, or nothing if there is no sample.
    fn mean(&self) -> [f32; 4] {
        if self.count == 0 {
            return [0.0; 4];
        }
        let [r, g, b] = self.rgb.map(|sum| (sum as f64 / (STEPS * f64::from(self.count))) as f32);
        [r, g, b, 1.0]
    }
}

/// A render that can go on: for every pixel of a window the sums of both halves.
///
/// Parts of one picture, whatever their pixels and sample ranges, join to the same bits as one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulation {
    window: PixelWindow,
    camera: Camera,
    seed: u64,
    parts: Vec<Part>,
    halves: Vec<[Sum; 2]>,
}

/// What a render call added.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    pixels: Pixels,
    samples: Range<u32>,
}

impl Accumulation {
    pub(crate) fn new(camera: Camera, seed: u64, pixels: Pixels, samples: Range<u32>, halves: Vec<[Sum; 2]>) -> Self {
        let window = pixels.window();
        debug_assert_eq!(halves.len(), window.area());
        Self { window, camera, seed, parts: vec![Part { pixels, samples }], halves }
    }

    /// The pixels it has room for.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }

    /// The camera it was taken with.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Samples of a pixel in each half.
    #[must_use]
    pub fn samples_at(&self, x: i32, y: i32) -> u32 {
        if self.window.contains(x, y) { self.halves[self.window.index(x, y)][0].count } else { 0 }
    }

    /// Adds another part of the same picture; the window grows to hold both. On an error nothing changes.
    pub fn merge(&mut self, other: &Self) -> Result<(), RenderError> {
        if self.seed != other.seed {
            return Err(RenderError::SeedMismatch(self.seed, other.seed));
        }
        if self.camera != other.camera {
            return Err(RenderError::CameraMismatch);
        }
        for mine in &self.parts {
            for theirs in &other.parts {
                let first = mine.samples.start.max(theirs.samples.start);
                let end = mine.samples.end.min(theirs.samples.end);
                if first < end && mine.pixels.meets(&theirs.pixels) {
                    return Err(RenderError::Overlap { first, end });
                }
            }
        }
        self.grow(self.window.union(&other.window));
        for ((x, y), theirs) in other.window.pixels().zip(&other.halves) {
            let mine = &mut self.halves[self.window.index(x, y)];
            mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.join(theirs));
        }
        self.parts.extend(other.parts.iter().cloned());
        Ok(())
    }

    /// Makes room for a larger window.
    fn grow(&mut self, window: PixelWindow) {
        if window == self.window {
            return;
        }
        let mut halves = vec![[Sum::default(); 2]; window.area()];
        for ((x, y), sums) in self.window.pixels().zip(&self.halves) {
            halves[window.index(x, y)] = *sums;
        }
        (self.window, self.halves) = (window, halves);
    }

    /// The picture so far: the mean of all samples with alpha 1, and nothing (alpha 0) where there is none.
    #[must_use]
    pub fn picture(&self) -> Picture {
        Picture::from_fn(self.window, |x, y| {
            let [mut sum, other] = self.halves[self.window.index(x, y)];
            sum.join(&other);
            sum.mean()
        })
    }

    /// The truth so far, whose display window is the camera's film; at least one sample in every pixel is needed.
    ///
    /// Where pixels have different numbers of samples it states the smallest.
    pub fn to_truth(&self) -> Result<Truth, RenderError> {
        let fewest = self.halves.iter().map(|sums| sums[0].count.min(sums[1].count)).min().unwrap_or(0);
        if fewest == 0 {
            return Err(RenderError::NoSamples(self.window));
        }
        let half =
            |half: usize| Picture::from_fn(self.window, |x, y| self.halves[self.window.index(x, y)][half].mean());
        Ok(Truth {
            display: PixelWindow::of_size(self.camera.film.width(), self.camera.film.height()),
            camera: Some(self.camera),
            halves: [half(0), half(1)],
            samples: [fewest; 2],
        })
    }
}

//! Sums of samples that do not depend on the order in which they were made.

use std::ops::Range;

use glam::Vec3;
use optics::Camera;
use rgbd::{Picture, PixelWindow, Truth};

use crate::{MAX_SAMPLES, RenderError};

/// One half of a pixel: the sum of some consecutive samples in multiples of 2^-28.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sum {
    rgb: [i64; 3],
    /// Index of the first sample; 0 where there is none.
    first: u32,
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

    /// One that was written down; `None` if no samples would have made it.
    pub(crate) fn from_parts(rgb: [i64; 3], first: u32, count: u32) -> Option<Self> {
        let most = i64::from(count) << 46; // 2^18 a sample
        let fits = first.checked_add(count)? <= MAX_SAMPLES && rgb.iter().all(|sum| (0..=most).contains(sum));
        fits.then_some(Self { rgb, first, count })
    }

    /// The sums of R, G and B in multiples of 2^-28.
    pub(crate) fn rgb(&self) -> &[i64; 3] {
        &self.rgb
    }

    /// The samples that are summed up.
    pub(crate) fn samples(&self) -> Range<u32> {
        self.first..self.first + self.count
    }

    /// Those of `wanted` that follow the samples it has, and it makes ready to take them; none if they do not follow.
    pub(crate) fn missing(&self, wanted: &Range<u32>) -> Range<u32> {
        let wanted = wanted.start..wanted.end.min(MAX_SAMPLES);
        if self.count == 0 {
            return wanted;
        }
        let end = self.samples().end;
        if wanted.contains(&end) { end..wanted.end } else { end..end }
    }

    /// Says that the next samples start at `first`, if there is none yet.
    pub(crate) fn start(&mut self, first: u32) {
        if self.count == 0 {
            self.first = first;
        }
    }

    fn join(&mut self, other: &Self) {
        for (sum, more) in self.rgb.iter_mut().zip(other.rgb) {
            *sum += more;
        }
        self.first =
            if self.count == 0 || (other.count > 0 && other.first < self.first) { other.first } else { self.first };
        self.count += other.count;
    }

    /// Why two do not join, if so.
    fn fault(&self, other: &Self) -> Option<RenderError> {
        let (a, b) = (self.samples(), other.samples());
        let (first, end) = (a.start.max(b.start), a.end.min(b.end));
        if a.is_empty() || b.is_empty() || first == end {
            None
        } else if first < end {
            Some(RenderError::Overlap { first, end })
        } else {
            Some(RenderError::Gap { first: end, end: first })
        }
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
    halves: Vec<[Sum; 2]>,
}

impl Accumulation {
    /// One without samples.
    #[must_use]
    pub fn new(camera: Camera, window: PixelWindow, seed: u64) -> Self {
        Self { window, camera, seed, halves: vec![[Sum::default(); 2]; window.area()] }
    }

    /// The pixels it has room for.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }

    /// The camera it is taken with.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The seed of its samples.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Samples of a pixel in each half.
    #[must_use]
    pub fn samples_at(&self, x: i32, y: i32) -> [u32; 2] {
        if self.window.contains(x, y) { self.halves[self.window.index(x, y)].map(|sum| sum.count) } else { [0; 2] }
    }

    /// Samples of all pixels and both halves.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.halves.iter().flatten().map(|sum| u64::from(sum.count)).sum()
    }

    /// Joins parts of one picture, which may come in any order.
    ///
    /// In each pixel the samples must follow each other: none twice, none missing between two others.
    pub fn join(parts: impl IntoIterator<Item = Self>) -> Result<Self, RenderError> {
        let mut parts: Vec<Self> = parts.into_iter().collect();
        let first = |part: &Self| part.halves.iter().flatten().filter(|sum| sum.count > 0).map(|sum| sum.first).min();
        parts.sort_by_cached_key(first);
        let mut parts = parts.into_iter();
        let mut whole = parts.next().ok_or(RenderError::NoParts)?;
        parts.try_for_each(|part| whole.merge(&part))?;
        Ok(whole)
    }

    /// Adds another part of the same picture, whose samples follow or precede those that are there; the window grows to
    /// hold both. On an error nothing changes.
    pub fn merge(&mut self, other: &Self) -> Result<(), RenderError> {
        if self.seed != other.seed {
            return Err(RenderError::SeedMismatch(self.seed, other.seed));
        }
        if self.camera != other.camera {
            return Err(RenderError::CameraMismatch);
        }
        for (x, y) in self.window.intersection(&other.window).pixels() {
            let (mine, theirs) = (&self.halves[self.window.index(x, y)], &other.halves[other.window.index(x, y)]);
            if let Some(fault) = mine.iter().zip(theirs).find_map(|(mine, theirs)| mine.fault(theirs)) {
                return Err(fault);
            }
        }
        self.grow(self.window.union(&other.window));
        for ((x, y), theirs) in other.window.pixels().zip(&other.halves) {
            let mine = &mut self.halves[self.window.index(x, y)];
            mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.join(theirs));
        }
        Ok(())
    }

    /// The sums of the pixels, row by row.
    pub(crate) fn halves_mut(&mut self) -> &mut [[Sum; 2]] {
        &mut self.halves
    }

    /// The sums of the pixels, row by row.
    pub(crate) fn halves(&self) -> &[[Sum; 2]] {
        &self.halves
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

    /// Squared difference of the halves of a pixel, over R, G and B; both need a sample.
    pub(crate) fn squared_difference(&self, x: i32, y: i32) -> f64 {
        let [a, b] = &self.halves[self.window.index(x, y)];
        let of = |sum: &Sum, c: usize| sum.rgb[c] as f64 / (STEPS * f64::from(sum.count));
        (0..3).map(|c| (of(a, c) - of(b, c)).powi(2)).sum()
    }

    /// R, G and B of both halves of a pixel; `None` where one of them has no sample.
    #[must_use]
    pub fn halves_at(&self, x: i32, y: i32) -> Option<[[f32; 3]; 2]> {
        if self.samples_at(x, y).contains(&0) {
            return None;
        }
        Some([0, 1].map(|half: usize| {
            let [r, g, b, _] = self.halves[self.window.index(x, y)][half].mean();
            [r, g, b]
        }))
    }

    /// RMS error of the picture so far over R, G and B of all pixels: half the RMS difference of the halves, which have the
    /// same number of samples in each pixel.
    #[must_use]
    pub fn noise(&self) -> f64 {
        let squares: f64 = self.window.pixels().map(|(x, y)| self.squared_difference(x, y)).sum();
        0.5 * (squares / (3.0 * self.window.area().max(1) as f64)).sqrt()
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

//! How many samples each pixel gets.

use std::collections::BTreeMap;

use rgbd::{PixelWindow, Plane};

use crate::Accumulation;

/// Share of the picture's mean squared noise that every pixel is taken to have at least, so that what its neighbours'
/// first samples missed is found, if late.
const FLOOR: f64 = 1.0 / 64.0;

/// Samples grow with this power of the noise. Where the error falls as [`RATE`] says, 2 / (1 + 2 RATE) = 0.84 makes the
/// noise of the picture the least for its samples; a little less forgives that the noise is itself noisy.
///
/// To the squared error that this reaches, the same number of samples for all pixels takes 1.35 times as many on `simple`,
/// tilted, and 1.39 times on `landscape`, miniature, both 240 x 135. Counting a pixel's own difference too makes that 1.45
/// on `simple`, but the noise that the halves state 5 to 10 % too low: it is left out.
const POWER: f64 = 0.8;

/// The error falls with this power of the number of samples, between 1/2, that of chance, and 3/4, that of an edge in
/// strata. It only says how far the next round shall go: what it reached is measured.
const RATE: f64 = 0.69;

/// A round multiplies all samples by at least and at most this.
const STEP: [f64; 2] = [1.04, 4.0];

/// More samples where there is more noise, and how far they went.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spread {
    /// RMS noise about each pixel after the first samples, above 0 unless the whole picture has none.
    noise: Plane,
    /// Samples in each half when that was measured.
    first: u32,
    /// Samples in each half where the noise is 1.
    scale: f64,
    /// How many pixels are about as noisy, by the least noise of each class.
    classes: Vec<(f64, f64)>,
}

impl Spread {
    /// Decides by sums that have `first` samples in each half of every pixel.
    pub(crate) fn new(sums: &Accumulation, first: u32) -> Self {
        let window = sums.window();
        let squares: Vec<f64> = window.pixels().map(|(x, y)| sums.squared_difference(x, y)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        let noise = Plane::from_fn(window, |x, y| (mean_around(&squares, window, x, y) + FLOOR * mean).sqrt() as f32);
        Self::from_parts(noise, first, 0.0)
    }

    /// One that was written down.
    pub(crate) fn from_parts(noise: Plane, first: u32, scale: f64) -> Self {
        // Eight classes for each doubling: floats of the same sign, exponent and three more bits
        let mut classes = BTreeMap::new();
        for value in noise.values() {
            *classes.entry(value.to_bits() >> 20).or_insert(0.0) += 1.0;
        }
        let least = |bits: u32| f64::from(f32::from_bits(bits << 20));
        let classes = classes.into_iter().map(|(bits, pixels)| (least(bits), pixels)).collect();
        Self { noise, first, scale, classes }
    }

    /// RMS noise about each pixel after the first samples.
    pub(crate) fn noise(&self) -> &Plane {
        &self.noise
    }

    /// Samples in each half when the noise was measured.
    pub(crate) fn first(&self) -> u32 {
        self.first
    }

    /// Samples in each half where the noise is 1.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Samples that a pixel shall have in each half by the end of this round.
    pub(crate) fn count(&self, x: i32, y: i32, most: u32) -> u32 {
        self.samples(f64::from(self.noise.at(x, y)), self.scale, most) as u32
    }

    fn samples(&self, noise: f64, scale: f64, most: u32) -> f64 {
        // Sequences are best when they are complete
        let samples = (noise.powf(POWER) * scale).log2().round().exp2();
        samples.clamp(f64::from(self.first), f64::from(most))
    }

    /// Samples of all pixels and both halves by the end of this round.
    pub(crate) fn total(&self, most: u32) -> f64 {
        self.total_at(self.scale, most)
    }

    fn total_at(&self, scale: f64, most: u32) -> f64 {
        self.classes.iter().map(|&(noise, pixels)| 2.0 * pixels * self.samples(noise, scale, most)).sum()
    }

    /// Mean squared noise to expect, but for a factor that all scales share.
    fn expected(&self, scale: f64, most: u32) -> f64 {
        let of = |noise: f64| noise * noise * self.samples(noise, scale, most).powf(-2.0 * RATE);
        self.classes.iter().map(|&(noise, pixels)| pixels * of(noise)).sum()
    }

    /// Goes on to the next round, unless the noise is low enough or no pixel may take more samples. Returns how many samples
    /// of all pixels and both halves it will probably take until it is low enough, 0 if it is.
    pub(crate) fn next_round(&mut self, reached: f64, rmse: f64, most: u32) -> f64 {
        let before = self.total(most);
        let all = self.classes.iter().map(|(_, pixels)| 2.0 * pixels * f64::from(most)).sum::<f64>();
        if reached <= rmse || before >= all {
            return 0.0;
        }
        let goal = self.expected(self.scale, most) * (rmse / reached).powi(2);
        let is_low = |scale: f64| self.expected(scale, most) <= goal;
        let (least, greatest) = ((STEP[0] * before).min(all), (STEP[1] * before).min(all));
        let low_enough = self.least_scale(most, |scale| is_low(scale) || self.total_at(scale, most) >= all);
        self.scale = self.least_scale(most, |scale| {
            let total = self.total_at(scale, most);
            total >= least && (is_low(scale) || total >= greatest)
        });
        self.total_at(low_enough, most).max(self.total(most))
    }

    /// The least scale from which on something holds; where nothing else does, that of the most samples.
    fn least_scale(&self, most: u32, holds: impl Fn(f64) -> bool) -> f64 {
        let least = self.classes.first().map_or(1.0, |(noise, _)| *noise);
        let (mut low, mut high) = (0.0, 2.0 * f64::from(most) / least.max(f64::MIN_POSITIVE).powf(POWER));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if holds(middle) { high = middle } else { low = middle }
        }
        high
    }
}

/// Mean over the up to eight neighbours of a pixel, without the pixel itself; of a lone pixel 0.
fn mean_around(squares: &[f64], window: PixelWindow, x: i32, y: i32) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, j) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
        if window.contains(x + i, y + j) {
            sum += squares[window.index(x + i, y + j)];
            count += 1.0;
        }
    }
    if count == 0.0 { 0.0 } else { sum / count }
}

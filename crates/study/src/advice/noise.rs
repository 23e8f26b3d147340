//! What a trace of a few samples tells of one with more.

use std::time::Instant;

use compare::{Exposures, flip_hdr_at};
use optics::Camera;
use rgbd::{Picture, PixelWindow, Plane, Progress};
use trace::Scene;

use crate::{StudyError, advice::forecast::Doubt};

/// Samples in each half of the pilot's trace of a picture of less than so many pixels.
const HALVES: [(u64, u32); 3] = [(400_000, 8), (1_600_000, 4), (u64::MAX, 2)];

/// Noise of n samples falls as n^-POWER, and what HDR-FLIP makes of it as n^-FLIP_POWER; `simple/tilt` has it so. Where tiles with
/// more samples tell another power, it counts within the limits.
const POWER: f64 = 0.66;
const FLIP_POWER: f64 = 0.6;
const POWERS: [f64; 2] = [0.45, 0.8];

/// HDR-FLIP of a trace over that forecast from halves, which hide errors that both have: the median of `simple`'s shots (2026-11-26).
const WHOLE_FLIP: f64 = 1.12;

/// Standard deviation of the true over the forecast noise, about (`benches/results/2026-11-26-advice.md`).
const DOUBT: f64 = 0.1;

/// What the tracer's pilot found.
pub(crate) struct Noise {
    /// The two halves.
    halves: [Picture; 2],
    /// Mean square noise of both together, per pixel.
    pub(crate) square: Plane,
    /// Samples of both together.
    samples: f64,
    /// Seconds for one sample of every pixel.
    pub(crate) seconds_per_sample: f64,
    /// HDR-FLIP of both together per pixel, if it was asked for.
    flip: Option<Plane>,
    power: f64,
    flip_power: f64,
}

impl Noise {
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        display: PixelWindow,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Self, StudyError> {
        let area = display.area() as u64;
        let (_, half) = HALVES.into_iter().find(|&(most, _)| area < most).expect("a number for every size");
        let started = Instant::now();
        let sums = trace::render(scene, camera, &display.into(), 0..half, seed, progress)?;
        let samples = f64::from(2 * half);
        let seconds_per_sample = started.elapsed().as_secs_f64() / samples;
        let halves = sums.to_truth()?.halves;
        let [a, b] = &halves;
        let square = Plane::from_fn(display, |x, y| {
            let (a, b) = (a.at(x, y), b.at(x, y));
            (0..3).map(|c| 0.25 * (a[c] - b[c]).powi(2)).sum::<f32>() / 3.0
        });
        Ok(Self { halves, square, samples, seconds_per_sample, flip: None, power: POWER, flip_power: FLIP_POWER })
    }

    /// Looks at HDR-FLIP too.
    pub(crate) fn with_flip(mut self, exposures: Exposures) -> Result<Self, StudyError> {
        let [a, b] = &self.halves;
        let mut map = flip_hdr_at(a, b, self.square.window(), exposures)?;
        // The halves differ by twice as much as both together are off
        let share = 0.5_f64.powf(FLIP_POWER / POWER) as f32;
        map.values_mut().iter_mut().for_each(|flip| *flip *= share);
        self.flip = Some(map);
        Ok(self)
    }

    /// Learns from what `samples` leave of a noise, root mean square or HDR-FLIP, where the pilot has `own`.
    pub(crate) fn learn(&mut self, samples: f64, [rms, own_rms]: [f64; 2], flips: Option<[f64; 2]>) {
        let times = (samples / self.samples).ln();
        let power = |left: f64, own: f64, otherwise: f64| {
            let power = (own / left).ln() / times;
            if power.is_finite() { power.clamp(POWERS[0], POWERS[1]) } else { otherwise }
        };
        self.power = power(rms, own_rms, POWER);
        if let Some([flip, own_flip]) = flips {
            self.flip_power = power(flip, own_flip, FLIP_POWER);
        }
    }

    /// Mean square noise over the picture where a pixel has `samples`, of which `weight` counts.
    pub(crate) fn left(&self, of_pixel: impl Fn(i32, i32) -> (f64, f64)) -> f64 {
        mean(self.square.window(), |x, y| {
            let (samples, weight) = of_pixel(x, y);
            if samples == 0.0 {
                return 0.0;
            }
            let share = weight * (self.samples / samples).powf(self.power);
            f64::from(self.square.at(x, y)) * share * share
        })
    }

    /// Mean HDR-FLIP of that noise.
    pub(crate) fn flip_left(&self, of_pixel: impl Fn(i32, i32) -> (f64, f64)) -> Option<f64> {
        let flip = self.flip.as_ref()?;
        let flip_left = mean(flip.window(), |x, y| {
            let (samples, weight) = of_pixel(x, y);
            if samples == 0.0 {
                return 0.0;
            }
            f64::from(flip.at(x, y)) * weight * (self.samples / samples).powf(self.flip_power)
        });
        Some(WHOLE_FLIP * flip_left)
    }

    /// HDR-FLIP of the pilot's noise per pixel.
    pub(crate) fn flip(&self) -> Option<&Plane> {
        self.flip.as_ref()
    }

    /// HDR-FLIP of a picture, from that of its halves, which differ by twice as much as the picture is off.
    pub(crate) fn of_both(&self, of_halves: f64) -> f64 {
        of_halves * 0.5_f64.powf(self.flip_power / self.power)
    }

    /// How far its forecasts are off, relative.
    pub(crate) fn doubt() -> Doubt {
        Doubt { rmse: DOUBT, hdr_flip: DOUBT }
    }
}

/// Mean over the pixels of a window.
fn mean(window: PixelWindow, value: impl Fn(i32, i32) -> f64) -> f64 {
    window.pixels().map(|(x, y)| value(x, y)).sum::<f64>() / window.area().max(1) as f64
}

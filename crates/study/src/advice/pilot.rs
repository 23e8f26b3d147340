//! A few cheap runs, from which all rungs are forecast.
//!
//! - The merged gather with all layers makes the picture and predicts its own error e of each pixel: that is the filter's
//!   forecast, and the root of the mean of e^2 its RMS error.
//! - A cheaper rung of the filter is held against that picture; the filter's own error joins as independent.
//! - The tracer takes 16 samples (fewer in a large picture), in two halves: their difference tells the noise, which falls with a power of the number of
//!   samples, and their seconds its speed.
//! - The hybrid is put together pixel by pixel from e and from the noise, as `hybrid.rs` would.
//!
//! For HDR-FLIP, which no map of errors tells, pictures are made that differ as much as is forecast: the filter's picture
//! and itself with an error of e of random sign (from texture one for each pixel; what is guessed is wrong over a wider area,
//! which is seen more: there one for 2x2 pixels); the two halves of the trace, whose difference has twice the noise.

use std::time::Instant;

use compare::mean_flip_hdr;
use filter::{Filtered, FrameView, GatherSettings, Method, PredictedError};
use optics::Camera;
use rgbd::{Frame, Picture, PixelWindow, Plane, Progress};
use trace::Scene;

use crate::hybrid::{hybrid, samples_of, trace_weight, widened};
use crate::{ExpectedError, Forecast, HybridSettings, Rung, StudyError, step::Step};

/// Samples in each half of the pilot's trace of a picture of less than so many pixels.
const HALVES: [(u64, u32); 3] = [(400_000, 8), (1_600_000, 4), (u64::MAX, 2)];

/// Noise of n samples falls as n^-POWER, and what HDR-FLIP makes of it as n^-FLIP_POWER, as was seen on `simple/tilt`.
const POWER: f64 = 0.66;
const FLIP_POWER: f64 = 0.6;

/// Samples per pixel of the tracer's rungs.
const TRACES: [u32; 8] = [4, 8, 16, 32, 64, 128, 256, 512];

/// Tolerances of the hybrid's rungs.
const HYBRIDS: [f32; 5] = [0.04, 0.02, 0.01, 0.005, 0.0025];

/// Time of the merged gather without a prediction over that with one: about the median of both scenes of
/// `benches/results/2026-11-26-advice.md`, where it scatters by half.
const UNPREDICTED: f64 = 0.5;

/// What the advice is about.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// The scene; without one there is no tracer and no hybrid.
    pub scene: Option<&'a Scene>,
    /// The camera, whose film is the frame's display window.
    pub camera: &'a Camera,
    /// Colour and depth.
    pub frame: &'a Frame,
    /// Seed of the pilot's samples, and of those that it advises.
    pub seed: u64,
}

/// A run of the filter.
struct Run {
    filtered: Filtered,
    seconds: f64,
}

/// What the tracer's pilot found.
struct Noise {
    /// The two halves.
    halves: [Picture; 2],
    /// Mean square noise of both together, per pixel.
    square: Plane,
    /// Samples of both together.
    samples: f64,
    /// Seconds for one sample of every pixel.
    seconds_per_sample: f64,
}

/// Forecasts of every rung that the evidence allows, from cheap runs on this machine.
///
/// HDR-FLIP is forecast where it is asked for.
pub fn forecasts(evidence: &Evidence, with_flip: bool, progress: &dyn Progress) -> Result<Vec<Forecast>, StudyError> {
    let display = evidence.frame.display;
    let layers = evidence.frame.layers().len();
    let step = |index: usize| Step { whole: progress, index, count: 4 };
    let flip = |a: &Picture, b: &Picture| -> Result<Option<f64>, StudyError> {
        Ok(if with_flip { Some(mean_flip_hdr(a, b, display)?) } else { None })
    };
    let mut all = Vec::new();

    // The filter's best, and the rest of the filter held against it
    let gather = |layers| GatherSettings { layers, predict_error: true, ..GatherSettings::default() };
    let plain = |layers| GatherSettings { layers, ..GatherSettings::default() };
    let merged = evidence.run(Method::Merged(gather(layers)), &step(0))?;
    let best = merged.own_error(with_flip)?;
    for method in [Method::Pinhole, Method::OwnCoc(plain(1))] {
        let run = evidence.run(method, &step(1))?;
        let rmse = difference(&run.filtered.picture, &merged.filtered.picture, display).hypot(best.rmse);
        let hdr_flip = flip(&merged.filtered.picture, &run.filtered.picture)?;
        let hdr_flip = hdr_flip.zip(best.hdr_flip).map(|(flip, best)| flip.hypot(best));
        all.push(run.forecast(method, ExpectedError { rmse, hdr_flip }));
    }
    if layers > 1 {
        let run = evidence.run(Method::Merged(gather(1)), &step(2))?;
        all.push(run.forecast(Method::Merged(plain(1)), run.own_error(with_flip)?));
    }
    all.push(merged.forecast(Method::Merged(plain(layers)), best));

    // The tracer, and the hybrid
    if let Some(scene) = evidence.scene {
        let noise = Noise::new(scene, evidence, &step(3))?;
        let halves_flip = flip(&noise.halves[0], &noise.halves[1])?;
        for samples in TRACES {
            all.push(noise.trace(samples, halves_flip));
        }
        for tolerance in HYBRIDS {
            let settings = HybridSettings { tolerance, layers, seed: evidence.seed, ..HybridSettings::default() };
            all.push(noise.hybrid(&settings, &merged, best.hdr_flip, halves_flip));
        }
    }
    Ok(all)
}

/// The error that a filtered picture predicts of itself; `None` if it was not asked to. HDR-FLIP where it is wanted.
pub fn error_of_filtered(filtered: &Filtered, with_flip: bool) -> Result<Option<ExpectedError>, StudyError> {
    let Some(predicted) = &filtered.predicted_error else { return Ok(None) };
    let off = || off_by(&filtered.picture, predicted);
    let window = predicted.total.window();
    let hdr_flip = with_flip.then(|| mean_flip_hdr(&filtered.picture, &off(), window)).transpose()?;
    Ok(Some(ExpectedError { rmse: rms(&predicted.total), hdr_flip }))
}

impl Evidence<'_> {
    /// The picture of a rung over the display window; the tracer's need a scene.
    pub fn picture(&self, rung: &Rung, progress: &dyn Progress) -> Result<Picture, StudyError> {
        match (rung, self.scene) {
            (Rung::Filter(method), _) => Ok(self.run(*method, progress)?.filtered.picture),
            (Rung::Hybrid(settings), Some(scene)) => {
                Ok(hybrid(scene, self.camera, self.frame, settings, progress)?.picture)
            }
            (Rung::Trace { samples }, Some(scene)) => {
                let pixels = self.frame.display.into();
                let sums = trace::render(scene, self.camera, &pixels, 0..samples.div_ceil(2), self.seed, progress)?;
                Ok(sums.picture())
            }
            (_, None) => Err(StudyError::NoScene),
        }
    }

    fn run(&self, method: Method, progress: &dyn Progress) -> Result<Run, StudyError> {
        let started = Instant::now();
        let display = self.frame.display;
        let filtered = filter::apply(&FrameView::whole(self.frame), self.camera, &method, display, progress)?;
        Ok(Run { filtered, seconds: started.elapsed().as_secs_f64() })
    }
}

impl Run {
    /// What it predicts of itself; it was asked to.
    fn own_error(&self, with_flip: bool) -> Result<ExpectedError, StudyError> {
        Ok(error_of_filtered(&self.filtered, with_flip)?.expect("the prediction that was asked for"))
    }

    fn forecast(&self, method: Method, error: ExpectedError) -> Forecast {
        // The prediction itself took its part of the time
        let share = if self.filtered.predicted_error.is_some() { UNPREDICTED } else { 1.0 };
        let seconds = (share * self.seconds).max(1e-9);
        Forecast { rung: Rung::Filter(method), seconds, error, kernel: Some(self.filtered.kernel) }
    }
}

impl Noise {
    fn new(scene: &Scene, evidence: &Evidence, progress: &dyn Progress) -> Result<Self, StudyError> {
        let display = evidence.frame.display;
        let area = display.area() as u64;
        let (_, half) = HALVES.into_iter().find(|&(most, _)| area < most).expect("a number for every size");
        let started = Instant::now();
        let sums = trace::render(scene, evidence.camera, &display.into(), 0..half, evidence.seed, progress)?;
        let samples = f64::from(2 * half);
        let seconds_per_sample = started.elapsed().as_secs_f64() / samples;
        let halves = sums.to_truth()?.halves;
        let [a, b] = &halves;
        let square = Plane::from_fn(display, |x, y| {
            let (a, b) = (a.at(x, y), b.at(x, y));
            (0..3).map(|c| 0.25 * (a[c] - b[c]).powi(2)).sum::<f32>() / 3.0
        });
        Ok(Self { halves, square, samples, seconds_per_sample })
    }

    /// The share of the pilot's noise that `samples` leave.
    fn share(&self, samples: f64) -> f64 {
        (self.samples / samples).powf(POWER)
    }

    /// HDR-FLIP of the pilot's own noise, from that of its halves, which differ by twice as much.
    fn flip(&self, of_halves: f64) -> f64 {
        of_halves * 0.5_f64.powf(FLIP_POWER / POWER)
    }

    fn rms(&self) -> f64 {
        mean(self.square.values().iter().map(|&square| f64::from(square))).sqrt()
    }

    fn trace(&self, samples: u32, halves_flip: Option<f64>) -> Forecast {
        let share = self.share(f64::from(samples));
        let hdr_flip = halves_flip.map(|flip| self.flip(flip) * share.powf(FLIP_POWER / POWER));
        let error = ExpectedError { rmse: self.rms() * share, hdr_flip };
        let seconds = self.seconds_per_sample * f64::from(samples);
        Forecast { rung: Rung::Trace { samples }, seconds, error, kernel: None }
    }

    fn hybrid(
        &self,
        settings: &HybridSettings,
        merged: &Run,
        filter_flip: Option<f64>,
        halves_flip: Option<f64>,
    ) -> Forecast {
        let predicted = &merged.filtered.predicted_error.as_ref().expect("the prediction that was asked for").total;
        let display = predicted.window();
        let wide = widened(predicted);
        let (mut filtered, mut noise, mut samples) = (0.0, 0.0, 0_u64);
        for (x, y) in display.pixels() {
            let weight = trace_weight(wide.at(x, y), settings.tolerance);
            let left = f64::from((1.0 - weight) * predicted.at(x, y));
            filtered += left * left;
            let half = samples_of(weight, settings.samples.div_ceil(2));
            if half > 0 {
                let share = f64::from(weight) * self.share(2.0 * f64::from(half));
                noise += f64::from(self.square.at(x, y)) * share * share;
                samples += 2 * u64::from(half);
            }
        }
        let count = display.area().max(1) as f64;
        let [filtered, noise] = [filtered, noise].map(|sum| (sum / count).sqrt());

        // Of both kinds of FLIP as much is left as of the error
        let hdr_flip = filter_flip.zip(halves_flip).map(|(filter, halves)| {
            let traced = (noise / self.rms().max(f64::MIN_POSITIVE)).powf(FLIP_POWER / POWER);
            filter * filtered / rms(predicted).max(f64::MIN_POSITIVE) + self.flip(halves) * traced
        });
        let error = ExpectedError { rmse: filtered.hypot(noise), hdr_flip };
        let seconds = merged.seconds + self.seconds_per_sample * samples as f64 / count;
        Forecast { rung: Rung::Hybrid(*settings), seconds, error, kernel: Some(merged.filtered.kernel) }
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

/// Root mean square of a plane.
fn rms(plane: &Plane) -> f64 {
    mean(plane.values().iter().map(|&value| f64::from(value) * f64::from(value))).sqrt()
}

/// Root mean square difference of two pictures over R, G and B.
fn difference(a: &Picture, b: &Picture, display: PixelWindow) -> f64 {
    let square = |(x, y)| {
        let (a, b) = (a.at(x, y), b.at(x, y));
        (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>() / 3.0
    };
    let sum: f64 = display.pixels().map(square).sum();
    (sum / display.area().max(1) as f64).sqrt()
}

/// A picture that is off by as much as is predicted of each pixel, up or down by chance.
fn off_by(picture: &Picture, error: &PredictedError) -> Picture {
    let [texture, others @ ..] = &error.causes;
    Picture::from_fn(error.total.window(), |x, y| {
        let wide = others.iter().map(|plane| plane.at(x, y)).fold(0.0, f32::hypot);
        let off = sign(x, y) * texture.at(x, y) + sign(x.div_euclid(2), y.div_euclid(2)) * wide;
        let [r, g, b, a] = picture.at(x, y);
        [(r + off).max(0.0), (g + off).max(0.0), (b + off).max(0.0), a]
    })
}

/// 1 or -1, by chance.
fn sign(x: i32, y: i32) -> f32 {
    let mut hash = (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2C1B_3C6D);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297A_2D39);
    if (hash ^ (hash >> 15)) & 1 == 1 { 1.0 } else { -1.0 }
}

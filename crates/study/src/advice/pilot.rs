//! A few cheap runs, from which all rungs are forecast.
//!
//! - The merged gather makes the picture, with all layers and with one, and predicts its own error e of each pixel: that is the
//!   filter's forecast, and the root of the mean of e^2 its RMS error.
//! - Of a scene, the tracer takes 16 samples (fewer in a large picture), in two halves: their difference tells the noise, which
//!   falls with a power of the number of samples, and their seconds its speed.
//! - Then it takes 256 samples in a few tiles (`spots.rs`), which tell how wrong the filter really is, and that power.
//! - A cheaper rung of the filter is held against the filter's best; the error of that joins as independent.
//! - The hybrid is put together pixel by pixel from e, from what the tiles show, and from the noise, as `hybrid.rs` would.
//!
//! HDR-FLIP, which no map of errors tells, comes from the tiles. Without a scene a picture is made that differs as much as is
//! forecast: the filter's own with an error of e of random sign (from texture one for each pixel; what is guessed is wrong over a
//! wider area, which is seen more: there one for 2x2 pixels).

use std::time::Instant;

use compare::mean_flip_hdr;
use filter::{Filtered, FrameView, GatherSettings, Method, PredictedError};
use optics::Camera;
use rgbd::{Frame, Picture, PixelWindow, Plane, Progress};
use trace::Scene;

use crate::advice::forecast::Doubt;
use crate::advice::traced::Traced;
use crate::{ExpectedError, Forecast, HybridSettings, Rung, StudyError, hybrid::hybrid, step::Step};

/// Samples per pixel of the tracer's rungs.
const TRACES: [u32; 8] = [4, 8, 16, 32, 64, 128, 256, 512];

/// Tolerances of the hybrid's rungs, and their samples.
const HYBRIDS: [f32; 6] = [0.08, 0.04, 0.02, 0.01, 0.005, 0.0025];
const HYBRID_SAMPLES: [u32; 3] = [16, 64, 256];

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

/// An error, and how far it may be off if that is known.
type Known = (ExpectedError, Option<Doubt>);

/// Forecasts of every rung that the evidence allows, from cheap runs on this machine.
///
/// HDR-FLIP is forecast where it is asked for.
pub fn forecasts(evidence: &Evidence, with_flip: bool, progress: &dyn Progress) -> Result<Vec<Forecast>, StudyError> {
    let display = evidence.frame.display;
    let layers = evidence.frame.layers().len();
    let step = |index: usize| Step { whole: progress, index, count: 6 };
    let plain = |layers| GatherSettings { layers, ..GatherSettings::default() };

    // The filter with the prediction of its error, which takes time, and without
    let predicting = |layers| Method::Merged(GatherSettings { predict_error: true, ..plain(layers) });
    let merged = evidence.run(predicting(layers), &step(0))?;
    let one = if layers > 1 { Some(evidence.run(predicting(1), &step(1))?) } else { None };
    let seconds = evidence.run(Method::Merged(plain(layers)), &step(2))?.seconds;
    let one_seconds = if layers > 1 { evidence.run(Method::Merged(plain(1)), &step(3))?.seconds } else { seconds };

    // The tracer, where the filter may be wrong
    let predicted = merged.predicted();
    let expected = match &one {
        Some(one) => Plane::from_fn(display, |x, y| predicted.total.at(x, y).max(one.predicted().total.at(x, y))),
        None => predicted.total.clone(),
    };
    let traced = |scene| Traced::new(scene, evidence, &merged.filtered.picture, &expected, with_flip, &step(4));
    let traced = evidence.scene.map(traced).transpose()?;
    let known = |run: &Run| -> Result<Known, StudyError> {
        Ok(match &traced {
            Some(traced) => {
                let (error, doubt) = traced.filtered(&run.filtered, &run.predicted().total)?;
                (error, Some(doubt))
            }
            None => (run.own_error(with_flip)?, None),
        })
    };

    // The rest of the filter is held against its best
    let best = known(&merged)?;
    let mut all = Vec::new();
    for method in [Method::Pinhole, Method::OwnCoc(plain(1))] {
        let run = evidence.run(method, &step(5))?;
        all.push(run.forecast(method, run.seconds, run.beside(&merged, best, with_flip)?));
    }
    if let Some(one) = &one {
        all.push(one.forecast(Method::Merged(plain(1)), one_seconds, known(one)?));
    }
    all.push(merged.forecast(Method::Merged(plain(layers)), seconds, best));

    // The tracer, and the hybrid
    if let Some(traced) = &traced {
        all.extend(TRACES.map(|samples| traced.trace(samples)));
        for tolerance in HYBRIDS {
            for samples in HYBRID_SAMPLES {
                let settings = HybridSettings { tolerance, samples, layers, seed: evidence.seed };
                all.push(traced.hybrid(&settings, &merged.filtered, &predicted.total, merged.seconds)?);
            }
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
        Ok(Run { filtered, seconds: started.elapsed().as_secs_f64().max(1e-9) })
    }
}

impl Run {
    /// The error that it predicts of itself; it was asked to.
    fn predicted(&self) -> &PredictedError {
        self.filtered.predicted_error.as_ref().expect("the prediction that was asked for")
    }

    fn own_error(&self, with_flip: bool) -> Result<ExpectedError, StudyError> {
        Ok(error_of_filtered(&self.filtered, with_flip)?.expect("the prediction that was asked for"))
    }

    /// The error of a cheaper picture, by how far it is from the best and how wrong that is.
    fn beside(&self, merged: &Self, (best, doubt): Known, with_flip: bool) -> Result<Known, StudyError> {
        let [own, other] = [&self.filtered.picture, &merged.filtered.picture];
        let window = other.window();
        let rmse = difference(own, other, window).hypot(best.rmse);
        let apart = with_flip.then(|| mean_flip_hdr(other, own, window)).transpose()?;
        let hdr_flip = apart.zip(best.hdr_flip).map(|(apart, best)| apart.hypot(best));
        // What is known of the best is a part of it
        let part = |best: f64, all: f64| if all > 0.0 { (best / all).powi(2) } else { 1.0 };
        let doubt = doubt.map(|doubt| Doubt {
            rmse: doubt.rmse * part(best.rmse, rmse),
            hdr_flip: doubt.hdr_flip * part(best.hdr_flip.unwrap_or(0.0), hdr_flip.unwrap_or(0.0)),
        });
        Ok((ExpectedError { rmse, hdr_flip }, doubt))
    }

    fn forecast(&self, method: Method, seconds: f64, (error, doubt): Known) -> Forecast {
        let kernel = Some(self.filtered.kernel);
        Forecast { rung: Rung::Filter(method), seconds, error, doubt, kernel }
    }
}

/// Root mean square of a plane.
pub(crate) fn rms(plane: &Plane) -> f64 {
    let sum: f64 = plane.values().iter().map(|&value| f64::from(value) * f64::from(value)).sum();
    (sum / plane.values().len().max(1) as f64).sqrt()
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

//! Rung 6: the filter everywhere, real rays only where it predicts that it is wrong.
//!
//! The merged gather makes the whole picture and predicts its own error e of each pixel. Where e exceeds the tolerance T,
//! the tracer takes the pixel too, and both are mixed: the trace counts by
//!
//! ```text
//! w = 0 for e <= T,    e / T - 1 between,    1 for e >= 2 T.
//! ```
//!
//! What the filter leaves of its predicted error is e (1 - w) = e (2 - e / T) on the ramp, which is T at its start and less
//! beyond: nowhere more than was asked for. As w rises from 0, there is no place where a picture begins: a pixel that is
//! just worth tracing differs from its neighbour that is not by what both differ by anyway. So that the ramp is one of the
//! picture too and not of single pixels, e is first taken as the largest of 3x3 pixels and then as their mean.
//!
//! A pixel that counts by w needs fewer samples: n w^(3/2), rounded up to n / 2^k, instead of n. Whether noise falls with
//! the root of their number, as random numbers have it, or with the power 2/3, as measured here, what it adds to the pixel
//! stays below that of a pixel that is traced with all n.

use filter::{FrameView, GatherSettings, Method};
use optics::Camera;
use rgbd::{Frame, Picture, Plane, Progress};
use trace::{Accumulation, MAX_SAMPLES, RenderError, Scene};

use crate::{StudyError, step::Step};

/// How much of a [`hybrid`] is traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HybridSettings {
    /// Predicted error (root mean square over R, G and B, linear values) that the filter may leave in a pixel: 0 traces
    /// everything, +inf nothing.
    pub tolerance: f32,
    /// Samples of a pixel that is traced alone, 2 to 131,072, rounded up to an even number; mixed ones get fewer.
    pub samples: u32,
    /// How many of the frame's layers the filter uses.
    pub layers: usize,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for HybridSettings {
    /// A tolerance of 0.02, 256 samples, all layers, seed 1.
    fn default() -> Self {
        Self { tolerance: 0.02, samples: 256, layers: usize::MAX, seed: 1 }
    }
}

/// A picture that is filtered, and traced where that would be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Hybrid {
    /// The picture of the display window.
    pub picture: Picture,
    /// Error of the filter that was predicted for each pixel, widened as described.
    pub predicted_error: Plane,
    /// How much of each pixel is traced, 0 to 1.
    pub weight: Plane,
    /// Camera rays for each pixel, mean over the picture.
    pub mean_samples: f64,
}

impl Hybrid {
    /// The share of the pixels that were traced at all, 0 to 1.
    #[must_use]
    pub fn traced_share(&self) -> f64 {
        let traced = self.weight.values().iter().filter(|&&weight| weight > 0.0).count();
        traced as f64 / self.weight.values().len().max(1) as f64
    }
}

/// Filters the frame's display window and traces what the filter predicts to be off by more than the tolerance.
///
/// The frame must be of the scene as `camera` sees it, and the camera's film its display window. At a tolerance of 0 the
/// result is the picture of [`trace::render`] to the bit, at +inf that of [`filter::apply`].
pub fn hybrid(
    scene: &Scene,
    camera: &Camera,
    frame: &Frame,
    settings: &HybridSettings,
    progress: &dyn Progress,
) -> Result<Hybrid, StudyError> {
    let HybridSettings { tolerance, samples, layers, seed } = *settings;
    if tolerance.is_nan() || tolerance < 0.0 {
        let what = "tolerance of the hybrid";
        return Err(StudyError::BadSetting { what, value: f64::from(tolerance), wanted: "0 or positive" });
    }
    if !(2..=2 * MAX_SAMPLES).contains(&samples) {
        let what = "number of samples of the hybrid";
        return Err(StudyError::BadSetting { what, value: f64::from(samples), wanted: "2 to 131072" });
    }

    let step = |index: usize| Step { whole: progress, index, count: 2 };

    // Filter everything
    let method = Method::Merged(GatherSettings { layers, predict_error: true, ..GatherSettings::default() });
    let filtered = filter::apply(&FrameView::whole(frame), camera, &method, frame.display, &step(0))?;
    let predicted = filtered.predicted_error.expect("the prediction that was asked for").total;
    let predicted_error = widened(&predicted);

    // Trace where that is not enough
    let display = frame.display;
    let weight = Plane::from_fn(display, |x, y| trace_weight(predicted_error.at(x, y), tolerance));
    let counts = |x: i32, y: i32| {
        let count = samples_of(weight.at(x, y), samples.div_ceil(2));
        [0..count, 0..count]
    };
    let mut sums = Accumulation::new(*camera, display, seed);
    sums.extend(scene, &counts, &step(1)).map_err(RenderError::from)?;
    let mut picture = filtered.picture;
    mix(&mut picture, &sums.picture(), &weight);
    let mean_samples = sums.samples() as f64 / display.area().max(1) as f64;
    Ok(Hybrid { picture, predicted_error, weight, mean_samples })
}

/// Samples in each half of a pixel of which `weight` is traced, where one that is traced alone gets `all`; at least 1.
pub(crate) fn samples_of(weight: f32, all: u32) -> u32 {
    if weight > 0.0 { all.checked_shr(times_halved(weight)).unwrap_or(0).max(1) } else { 0 }
}

/// How often the number of samples is halved for a pixel of which `weight` (above 0) is traced.
fn times_halved(weight: f32) -> u32 {
    (-1.5 * weight.log2()).floor().max(0.0) as u32
}

/// How much the trace counts where the filter is predicted to be off by `error`.
pub(crate) fn trace_weight(error: f32, tolerance: f32) -> f32 {
    if error >= 2.0 * tolerance {
        1.0
    } else if error <= tolerance {
        0.0
    } else {
        error / tolerance - 1.0
    }
}

/// The largest of 3x3 pixels, then their mean.
pub(crate) fn widened(error: &Plane) -> Plane {
    let around = |x: i32, y: i32| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
    let largest =
        Plane::from_fn(error.window(), |x, y| around(x, y).filter_map(|(x, y)| error.get(x, y)).fold(0.0, f32::max));
    Plane::from_fn(error.window(), |x, y| {
        let known = || around(x, y).filter_map(|(x, y)| largest.get(x, y));
        known().sum::<f32>() / known().count() as f32
    })
}

/// Puts the traced pixels over the filtered ones by weight.
fn mix(picture: &mut Picture, traced: &Picture, weight: &Plane) {
    for (x, y) in weight.window().pixels().filter(|&(x, y)| weight.at(x, y) > 0.0) {
        let (w, f, t) = (weight.at(x, y), picture.at(x, y), traced.at(x, y));
        // All of the trace is the trace, to the bit
        let mixed = if w < 1.0 { [0, 1, 2, 3].map(|c| f[c] + w * (t[c] - f[c])) } else { t };
        picture.set(x, y, mixed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nowhere_is_more_left_of_the_predicted_error_than_the_tolerance() {
        const TOLERANCE: f32 = 0.01;
        const ROUNDING: f32 = 1e-6;
        let mut last = 0.0;
        for error in (0..=500).map(|i| i as f32 * 1e-4) {
            let weight = trace_weight(error, TOLERANCE);
            assert!((0.0..=1.0).contains(&weight) && weight >= last, "{weight} at {error}");
            assert!(weight - last < 0.011, "the weight jumps at {error}");
            assert!(error * (1.0 - weight) <= TOLERANCE + ROUNDING, "{error}");
            last = weight;
        }
        assert_eq!(last, 1.0);
    }

    #[test]
    fn a_mixed_pixel_is_as_noisy_as_a_traced_one_at_most() {
        const ROUNDING: f32 = 1e-5;
        assert_eq!([1.0, 0.64, 0.62, 0.4, 0.39].map(times_halved), [0, 0, 1, 1, 2]);
        for weight in (1..=1000).map(|i| i as f32 * 1e-3) {
            let share = 0.5_f32.powi(times_halved(weight) as i32);
            for power in [0.5, 2.0 / 3.0] {
                assert!(weight * share.powf(-power) <= 1.0 + ROUNDING, "{weight} with noise ~ n^-{power}");
            }
        }
    }

    #[test]
    fn no_tolerance_traces_what_is_predicted_perfect_and_an_infinite_one_nothing() {
        assert_eq!([0.0, 1e-9, 1.0].map(|error| trace_weight(error, 0.0)), [1.0; 3]);
        assert_eq!([0.0, 1e-9, 1e9].map(|error| trace_weight(error, f32::INFINITY)), [0.0; 3]);
    }
}

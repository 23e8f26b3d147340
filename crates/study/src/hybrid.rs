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

use filter::{FrameView, GatherSettings, Method};
use optics::Camera;
use rgbd::{Frame, Mask, Picture, Plane, Progress};
use trace::{Pixels, Scene};

use crate::{StudyError, step::Step};

/// How much of a [`hybrid`] is traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HybridSettings {
    /// Predicted error (root mean square over R, G and B, linear values) that the filter may leave in a pixel: 0 traces
    /// everything, +inf nothing.
    pub tolerance: f32,
    /// Samples of a traced pixel, 2 to 131,072, rounded up to an even number.
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

    // Filter everything
    let method = Method::Merged(GatherSettings { layers, predict_error: true, ..GatherSettings::default() });
    let step = Step { whole: progress, index: 0, count: 2 };
    let filtered = filter::apply(&FrameView::whole(frame), camera, &method, frame.display, &step)?;
    let predicted = filtered.predicted_error.expect("the prediction that was asked for").total;
    let predicted_error = widened(&predicted);

    // Trace where that is not enough
    let display = frame.display;
    let weight = Plane::from_fn(display, |x, y| trace_weight(predicted_error.at(x, y), tolerance));
    let mask = Mask::from_fn(display, |x, y| weight.at(x, y) > 0.0);
    let mut picture = filtered.picture;
    if mask.count() > 0 {
        let step = Step { whole: progress, index: 1, count: 2 };
        let sums = trace::render(scene, camera, &Pixels::from(mask), 0..samples.div_ceil(2), seed, &step)?;
        mix(&mut picture, &sums.picture(), &weight);
    }
    Ok(Hybrid { picture, predicted_error, weight })
}

/// How much the trace counts where the filter is predicted to be off by `error`.
fn trace_weight(error: f32, tolerance: f32) -> f32 {
    if error >= 2.0 * tolerance {
        1.0
    } else if error <= tolerance {
        0.0
    } else {
        error / tolerance - 1.0
    }
}

/// The largest of 3x3 pixels, then their mean.
fn widened(error: &Plane) -> Plane {
    let around = |x: i32, y: i32| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
    let largest =
        Plane::from_fn(error.window(), |x, y| around(x, y).filter_map(|(x, y)| error.get(x, y)).fold(0.0, f32::max));
    Plane::from_fn(error.window(), |x, y| {
        let known = || around(x, y).filter_map(|(x, y)| largest.get(x, y));
        known().sum::<f32>() / known().count() as f32
    })
}

/// Puts the traced picture over the filtered one by weight.
fn mix(picture: &mut Picture, traced: &Picture, weight: &Plane) {
    for (x, y) in weight.window().pixels() {
        let w = weight.at(x, y);
        if w > 0.0 {
            let (f, t) = (picture.at(x, y), traced.at(x, y));
            // All of the trace is the trace, to the bit
            let mixed = if w < 1.0 { [0, 1, 2, 3].map(|c| f[c] + w * (t[c] - f[c])) } else { t };
            picture.set(x, y, mixed);
        }
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
    fn no_tolerance_traces_what_is_predicted_perfect_and_an_infinite_one_nothing() {
        assert_eq!([0.0, 1e-9, 1.0].map(|error| trace_weight(error, 0.0)), [1.0; 3]);
        assert_eq!([0.0, 1e-9, 1e9].map(|error| trace_weight(error, f32::INFINITY)), [0.0; 3]);
    }
}

//! What traces tell of every rung: one of few samples everywhere, one of many in some tiles.

use compare::Exposures;
use filter::Filtered;
use rgbd::{Picture, Plane, Progress};
use trace::Scene;

use crate::advice::forecast::Doubt;
use crate::advice::noise::Noise;
use crate::advice::pilot::{Evidence, rms};
use crate::advice::spots::{Found, HALF, Spots};
use crate::hybrid::{samples_of, trace_weight, widened};
use crate::{ExpectedError, Forecast, HybridSettings, Rung, StudyError, step::Step};

/// Standard deviation of the logarithm of the true over the predicted error of the filter, about
/// (`benches/results/2026-11-26-advice.md`).
const PREDICTION_DOUBT: f64 = 0.3;

/// The least doubt about what was found in tiles: a few tiles that are alike by chance prove nothing.
const LEAST_DOUBT: f64 = 0.05;

/// Share of an HDR-FLIP that is left at least when noise is taken off.
const LEAST_FLIP: f64 = 0.25;

/// HDR-FLIP of a picture over that of its tiles, each alone in right surroundings: what is seen of an error beyond the tile counts
/// more than what is not seen of errors outside, as FLIP grows slower than the error. Medians of `simple`'s shots (2026-11-26).
const WHOLE_FLIP: f64 = 0.88;

/// The traces.
pub(crate) struct Traced {
    noise: Noise,
    spots: Spots,
    /// At which HDR-FLIP looks, where it is asked for.
    exposures: Option<Exposures>,
}

/// An error, and how far it may be off.
type Known = (ExpectedError, Doubt);

impl Traced {
    /// Traces a scene; tiles where the filter is `expected` to be wrong, about the picture `filtered`.
    pub(crate) fn new(
        scene: &Scene,
        evidence: &Evidence,
        filtered: &Picture,
        expected: &Plane,
        with_flip: bool,
        progress: &dyn Progress,
    ) -> Result<Self, StudyError> {
        let step = |index: usize| Step { whole: progress, index, count: 2 };
        let (camera, display, seed) = (evidence.camera, evidence.frame.display, evidence.seed);
        let exposures = with_flip.then(|| Exposures::of_picture(filtered, display)).transpose()?;
        let mut noise = Noise::new(scene, camera, display, seed, &step(0))?;
        if let Some(exposures) = exposures {
            noise = noise.with_flip(exposures)?;
        }
        // Other samples than the pilot's, and than those that frames are made of, whose error would be shared
        let spots = Spots::new(scene, camera, expected, seed.wrapping_add(2), &step(1))?;
        let flips = match (exposures, noise.flip()) {
            (Some(exposures), Some(pilot)) => {
                let own = spots.flip_of_halves(filtered, |_, _| 1.0, exposures)?;
                Some([noise.of_both(own.mean), spots.mean(pilot).mean])
            }
            _ => None,
        };
        noise.learn(f64::from(2 * HALF), spots.noises(&noise.square).map(f64::sqrt), flips);
        Ok(Self { noise, spots, exposures })
    }

    /// The error of a filtered picture that predicts its own.
    pub(crate) fn filtered(&self, filtered: &Filtered, predicted: &Plane) -> Result<Known, StudyError> {
        self.left(&filtered.picture, predicted, |_, _| 1.0)
    }

    /// A trace of `samples`.
    pub(crate) fn trace(&self, samples: u32) -> Forecast {
        let all = |_, _| (f64::from(samples), 1.0);
        let error = ExpectedError { rmse: self.noise.left(all).sqrt(), hdr_flip: self.noise.flip_left(all) };
        let seconds = self.noise.seconds_per_sample * f64::from(samples);
        Forecast { rung: Rung::Trace { samples }, seconds, error, doubt: Some(Noise::doubt()), kernel: None }
    }

    /// A hybrid over a filtered picture that took `seconds` and predicts its own error.
    pub(crate) fn hybrid(
        &self,
        settings: &HybridSettings,
        filtered: &Filtered,
        predicted: &Plane,
        seconds: f64,
    ) -> Result<Forecast, StudyError> {
        // What the filter leaves
        let wide = widened(predicted);
        let weight = |x: i32, y: i32| trace_weight(wide.at(x, y), settings.tolerance);
        let (left, left_doubt) = self.left(&filtered.picture, predicted, |x, y| 1.0 - weight(x, y))?;

        // What the tracer adds
        let half = |x: i32, y: i32| samples_of(weight(x, y), settings.samples.div_ceil(2));
        let traced = |x: i32, y: i32| (f64::from(2 * half(x, y)), f64::from(weight(x, y)));
        let noise = self.noise.left(traced).sqrt();
        let doubt = Noise::doubt();
        let rmse = left.rmse.hypot(noise);
        let rmse_doubt = (left.rmse.powi(2) * left_doubt.rmse).hypot(noise.powi(2) * doubt.rmse) / (rmse * rmse);
        let flips = left.hdr_flip.zip(self.noise.flip_left(traced));
        let (hdr_flip, flip_doubt) = match flips {
            Some((left, noise)) => {
                let both = left + noise;
                (Some(both), (left * left_doubt.hdr_flip).hypot(noise * doubt.hdr_flip) / both)
            }
            None => (None, 0.0),
        };
        let known = |doubt: f64| if doubt.is_finite() { doubt } else { 0.0 };
        let doubt = Doubt { rmse: known(rmse_doubt), hdr_flip: known(flip_doubt) };

        let display = predicted.window();
        let samples: u64 = display.pixels().map(|(x, y)| 2 * u64::from(half(x, y))).sum();
        let mean_samples = samples as f64 / display.area().max(1) as f64;
        Ok(Forecast {
            rung: Rung::Hybrid(*settings),
            seconds: seconds + self.noise.seconds_per_sample * mean_samples,
            error: ExpectedError { rmse, hdr_flip },
            doubt: Some(doubt),
            kernel: Some(filtered.kernel),
        })
    }

    /// The error of a filtered picture of which a share of each pixel is left.
    fn left(
        &self,
        picture: &Picture,
        predicted: &Plane,
        share: impl Fn(i32, i32) -> f32 + Copy,
    ) -> Result<Known, StudyError> {
        let expected = Plane::from_fn(predicted.window(), |x, y| share(x, y) * predicted.at(x, y));
        let (rmse, rmse_doubt) = joined(rms(&expected), self.spots.square_error(picture, share));
        let (hdr_flip, flip_doubt) = match self.exposures {
            Some(exposures) => {
                let found = self.spots.flip(picture, share, exposures)?;
                let noise = self.noise.of_both(self.spots.flip_of_halves(picture, share, exposures)?.mean);
                let (flip, doubt) = without_noise(found, noise);
                (Some(WHOLE_FLIP * flip), doubt)
            }
            None => (None, 0.0),
        };
        Ok((ExpectedError { rmse, hdr_flip }, Doubt { rmse: rmse_doubt, hdr_flip: flip_doubt }))
    }
}

/// A predicted root mean square error and the mean square that was found, each by its own doubt, and the doubt of both.
fn joined(predicted: f64, found: Found) -> (f64, f64) {
    if found.mean.is_nan() || found.mean <= 0.0 {
        return (predicted, PREDICTION_DOUBT);
    }
    let doubt = (0.5 * found.scatter / found.mean).max(LEAST_DOUBT);
    let found = found.mean.sqrt();
    if predicted <= 0.0 {
        return (found, doubt);
    }
    let [own, other] = [PREDICTION_DOUBT, doubt].map(|doubt| doubt.powi(-2));
    let both = own + other;
    (((own * predicted.ln() + other * found.ln()) / both).exp(), both.sqrt().recip())
}

/// HDR-FLIP without that of the trace's own noise, and its doubt.
fn without_noise(found: Found, noise: f64) -> (f64, f64) {
    if found.mean <= 0.0 {
        return (0.0, 0.0);
    }
    let square = found.mean.powi(2) - noise.powi(2);
    let flip = square.max((LEAST_FLIP * found.mean).powi(2)).sqrt();
    (flip, (found.scatter * found.mean / (flip * flip)).max(LEAST_DOUBT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_better_counts_more() {
        let found = |mean: f64, scatter: f64| Found { mean, scatter };
        let (sure, doubt) = joined(0.01, found(0.0004, 0.00004));
        assert!((0.0195..0.02).contains(&sure) && doubt < 0.06, "{sure}, {doubt}");
        let (vague, doubt) = joined(0.01, found(0.0004, 0.0008));
        assert!((0.01..0.011).contains(&vague) && (0.28..0.3).contains(&doubt), "{vague}, {doubt}");
        assert_eq!(joined(0.01, found(-0.001, 0.01)), (0.01, PREDICTION_DOUBT), "noise alone");
        assert!((joined(0.0, found(0.0001, 0.0)).0 - 0.01).abs() < 1e-12, "nothing was predicted");
        assert_eq!(joined(0.0, found(0.0, 0.0)).0, 0.0);
    }

    #[test]
    fn noise_is_taken_off_but_never_all() {
        let found = Found { mean: 0.05, scatter: 0.005 };
        assert!((without_noise(found, 0.03).0 - 0.04).abs() < 1e-12);
        assert!((without_noise(found, 0.06).0 - 0.05 * LEAST_FLIP).abs() < 1e-12);
        assert!(without_noise(found, 0.04).1 > without_noise(found, 0.01).1, "the more noise, the less is known");
    }
}

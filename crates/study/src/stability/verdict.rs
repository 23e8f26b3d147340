//! Whether a method holds the criteria over a sweep.

use serde::Serialize;

use super::figures::{Change, Estimate};
use super::{Mode, Steadiness, TruthChange};

/// The step at which a criterion is met worst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Worst {
    /// What was found over what is allowed: held up to 1.
    pub ratio: f64,
    /// Where on the sweep.
    pub at: f64,
}

impl Worst {
    /// The largest of some ratios, each with its place.
    fn of(ratios: impl Iterator<Item = (f64, f64)>) -> Self {
        // What is no number holds nothing
        let ratio = |ratio: f64| if ratio.is_nan() { f64::INFINITY } else { ratio };
        ratios.fold(Self { ratio: 0.0, at: 0.0 }, |worst, (found, at)| {
            if ratio(found) > worst.ratio { Self { ratio: ratio(found), at } } else { worst }
        })
    }

    /// Whether the criterion is held.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.ratio <= 1.0
    }
}

/// How a method fares against every criterion on one sweep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SweepVerdict {
    /// Pixels that were not finite, of all steps.
    pub non_finite: usize,
    /// Change per step, root mean square over the pixels.
    pub change_rms: Worst,
    /// Change per step, 99.9th percentile of the pixels.
    pub change_peak: Worst,
    /// Error against that of no filter.
    pub error: Worst,
}

impl SweepVerdict {
    /// Whether all criteria are held.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.non_finite == 0 && [self.change_rms, self.change_peak, self.error].iter().all(Worst::holds)
    }

    /// The criterion that is broken worst, in a few words; `None` where all are held.
    #[must_use]
    pub fn broken(&self) -> Option<String> {
        if self.non_finite > 0 {
            return Some(format!("{} pixels not finite", self.non_finite));
        }
        let criteria = [("change", self.change_rms), ("peak change", self.change_peak), ("error", self.error)];
        let (what, worst) = criteria.into_iter().max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio))?;
        (!worst.holds()).then(|| format!("{what} {:.2}x at {:.3}", worst.ratio, worst.at))
    }
}

/// What a sweep gives all methods to be judged by; changes lead from one place to the next that has a picture.
pub(crate) struct Judge<'a> {
    pub(crate) mode: Mode,
    pub(crate) at: &'a [f64],
    pub(crate) change_at: &'a [f64],
    pub(crate) truth_change: &'a [TruthChange],
    pub(crate) unfiltered: &'a [Estimate],
}

impl Judge<'_> {
    pub(crate) fn verdict(&self, non_finite: usize, errors: &[Estimate], changes: &[Change]) -> SweepVerdict {
        let mean = |part: fn(&Change) -> f64| {
            let squares: f64 = changes.iter().map(|change| part(change).powi(2)).sum();
            (squares / changes.len().max(1) as f64).sqrt()
        };
        let allowed = |own: f64, truth: f64, noise: f64| match self.mode.steadiness() {
            Steadiness::Truth { k } => k * truth + noise + Mode::UNSEEN,
            Steadiness::OwnMean { k } => k * own + Mode::UNSEEN,
        };
        let places = || changes.iter().zip(self.truth_change).zip(self.change_at);
        let (own_rms, own_peak) = (mean(|change| change.rms), mean(|change| change.peak));
        let change_rms =
            Worst::of(places().map(|((own, truth), &at)| (own.rms / allowed(own_rms, truth.rms, truth.noise_rms), at)));
        let change_peak = Worst::of(
            places().map(|((own, truth), &at)| (own.peak / allowed(own_peak, truth.peak, truth.noise_peak), at)),
        );
        let error = Worst::of(errors.iter().zip(self.unfiltered).zip(self.at).map(|((own, unfiltered), &at)| {
            (own.low() / (Mode::WORSE_THAN_UNFILTERED * unfiltered.high() + Mode::UNSEEN), at)
        }));
        SweepVerdict { non_finite, change_rms, change_peak, error }
    }
}

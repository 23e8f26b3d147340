//! How far forecasts are trusted.

use crate::{Doubt, ExpectedError, Family, Rung, Tolerance};

/// What a forecast of an error may be off by even where nothing casts doubt on it, relative.
const LEAST_DOUBT: f64 = 0.05;

/// The chance (0 to 1) that a rung's error is truly within a tolerance.
///
/// Errors that were held against a trace are as likely too large as too small, by their doubt, in their logarithm. Where the
/// filter's own prediction is all there is, it is 1 or 0: its margin is kept or not.
pub(crate) fn chance(rung: &Rung, error: &ExpectedError, doubt: Option<Doubt>, tolerance: &Tolerance) -> f64 {
    let used = tolerance.used_by(error);
    match doubt {
        Some(doubt) => {
            let doubt = if tolerance.needs_flip() { doubt.hdr_flip } else { doubt.rmse };
            // The logistic curve of the same spread is within 0.01 of the normal one
            1.0 / (1.0 + (1.702 * used.ln() / doubt.hypot(LEAST_DOUBT)).exp())
        }
        None if used * margin(rung, tolerance) <= 1.0 => 1.0,
        None => 0.0,
    }
}

/// What an error that the filter predicts of itself is multiplied by before it is held against a tolerance, so that a tolerance is
/// missed seldom.
///
/// Those of the RMS error were searched for on the nine blurred shots of `simple` alone, at 320x180 and 640x360 (2026-11-26):
/// right in at least 97 % of the cases, at the least extra time. Those of HDR-FLIP are one of three sets that were tried by hand
/// from the largest ratios on `simple`, when the outcome on `landscape` was in sight; `benches/results/2026-11-26-advice.md`.
fn margin(rung: &Rung, tolerance: &Tolerance) -> f64 {
    match (rung.family(), tolerance.needs_flip()) {
        (Family::Pinhole, false) => 1.1,
        (Family::Pinhole, true) => 1.01,
        (Family::OwnCoc, false) => 1.05,
        (Family::OwnCoc, true) => 1.2,
        (_, false) => 1.2,
        (_, true) if rung.layers() == Some(1) => 1.6,
        (_, true) => 1.9,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_trace(rmse: f64, doubt: f64) -> f64 {
        let doubt = Some(Doubt { rmse: doubt, hdr_flip: 0.0 });
        let error = ExpectedError { rmse, hdr_flip: None };
        chance(&Rung::Trace { samples: 16 }, &error, doubt, &Tolerance::Rmse(0.01))
    }

    #[test]
    fn a_chance_is_even_at_the_tolerance_and_follows_the_doubt() {
        assert!((of_trace(0.01, 0.1) - 0.5).abs() < 1e-12);
        // A normal deviate is below -1 in 16 % and below -2 in 2.3 % of all cases
        let doubt = 0.1_f64.hypot(LEAST_DOUBT);
        assert!((of_trace(0.01 * doubt.exp(), 0.1) - 0.16).abs() < 0.011);
        assert!((of_trace(0.01 * (2.0 * doubt).exp(), 0.1) - 0.023).abs() < 0.011);
        assert!(of_trace(0.012, 0.3) > of_trace(0.012, 0.05), "the vaguer a miss, the less it is one");
        assert_eq!(of_trace(0.0, 0.1), 1.0, "no error");
        assert_eq!(of_trace(f64::INFINITY, 0.1), 0.0);
    }
}

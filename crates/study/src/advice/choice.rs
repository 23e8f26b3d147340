//! The cheapest rung that will do.

use crate::{ExpectedError, Forecast, Rung, Tolerance, advice::calibration::margin};

/// What to run, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice<'a> {
    /// The rung to run.
    pub forecast: &'a Forecast,
    /// Whether it is expected to be within the tolerance.
    pub is_within: bool,
    /// The next cheaper rung, and why not that.
    pub cheaper: Option<&'a Forecast>,
    /// Whether a cheaper or truer one was left out for its time.
    pub is_limited_by_budget: bool,
}

/// The cheapest rung whose error is expected to be within the tolerance, with the calibrated margin for each family, and
/// whose time within the budget in seconds. Where none is, the one of the budget that comes nearest (the cheapest of all
/// where even that takes too long); `None` without forecasts.
#[must_use]
pub fn choose<'a>(forecasts: &'a [Forecast], tolerance: &Tolerance, budget: Option<f64>) -> Option<Choice<'a>> {
    let used = |forecast: &Forecast| used(&forecast.rung, &forecast.error, tolerance);
    let cheapest = |a: &&Forecast, b: &&Forecast| a.seconds.total_cmp(&b.seconds);
    let affordable = |forecast: &&Forecast| budget.is_none_or(|budget| forecast.seconds <= budget);
    let within = |forecast: &&Forecast| used(forecast) <= 1.0;

    let chosen = forecasts.iter().filter(affordable).filter(within).min_by(cheapest);
    let nearest = || forecasts.iter().filter(affordable).min_by(|a, b| used(a).total_cmp(&used(b)));
    let forecast = chosen.or_else(nearest).or_else(|| forecasts.iter().min_by(cheapest))?;
    let cheaper = forecasts.iter().filter(|other| other.seconds < forecast.seconds).max_by(cheapest);
    let is_limited_by_budget = chosen.is_none() && forecasts.iter().any(|other| within(&other));
    Some(Choice { forecast, is_within: chosen.is_some(), cheaper, is_limited_by_budget })
}

/// Whether a rung's error, as forecast or as it predicted it itself, is trusted to be within a tolerance.
#[must_use]
pub fn is_trusted_within(rung: &Rung, error: &ExpectedError, tolerance: &Tolerance) -> bool {
    used(rung, error, tolerance) <= 1.0
}

/// How far an error exhausts a tolerance, with the margin of its rung.
fn used(rung: &Rung, error: &ExpectedError, tolerance: &Tolerance) -> f64 {
    tolerance.used_by(error) * margin(rung, tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use filter::Method;

    fn forecast(samples: u32, seconds: f64, rmse: f64) -> Forecast {
        let error = ExpectedError { rmse, hdr_flip: None };
        Forecast { rung: Rung::Trace { samples }, seconds, error, kernel: None }
    }

    #[test]
    fn the_cheapest_that_will_do_is_chosen() {
        let all =
            [forecast(4, 1.0, 0.04), forecast(64, 4.0, 0.008), forecast(16, 2.0, 0.02), forecast(256, 8.0, 0.003)];
        let chosen = |tolerance, budget| {
            let choice = choose(&all, &Tolerance::Rmse(tolerance), budget).unwrap();
            (choice.forecast.seconds, choice.is_within, choice.is_limited_by_budget)
        };
        assert_eq!(chosen(0.1, None), (1.0, true, false));
        assert_eq!(chosen(0.01, None), (4.0, true, false));
        assert_eq!(chosen(0.001, None), (8.0, false, false), "nothing will do: the nearest");
        assert_eq!(
            chosen(0.01, Some(2.5)),
            (2.0, false, true),
            "what would do takes too long: the nearest of the rest"
        );
        assert_eq!(chosen(0.01, Some(0.5)), (1.0, false, true), "nothing is fast enough: the fastest");
        let choice = choose(&all, &Tolerance::Rmse(0.01), None).unwrap();
        assert_eq!(choice.cheaper.map(|forecast| forecast.seconds), Some(2.0));
        assert!(choose(&[], &Tolerance::Rmse(0.01), None).is_none());
    }

    #[test]
    fn what_is_not_trusted_needs_room() {
        let error = ExpectedError { rmse: 0.0099, hdr_flip: Some(0.0099) };
        let filter = Rung::Filter(Method::default());
        assert!(is_trusted_within(&Rung::Trace { samples: 64 }, &error, &Tolerance::Rmse(0.01)));
        assert!(!is_trusted_within(&filter, &error, &Tolerance::Rmse(0.01)));
        assert!(is_trusted_within(&filter, &error, &Tolerance::Rmse(0.0125)));
        assert!(!is_trusted_within(&filter, &ExpectedError { hdr_flip: None, ..error }, &Tolerance::HdrFlip(1.0)));
    }
}

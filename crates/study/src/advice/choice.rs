//! The cheapest rung that will do.

use crate::{ExpectedError, Forecast, Rung, Tolerance, advice::calibration::chance};

/// A chance (0 to 1) at which a rung is as good as sure.
const SURE: f64 = 0.98;

/// How much the time of something sure counts that is run after a rung that failed. Of 0.5, 1 and 1.5 the one that is right in at
/// least 95 % of the cases on `simple` at the least extra time (`benches/results/2026-11-26-advice.md`).
const RISK: f64 = 0.5;

/// What to run, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice<'a> {
    /// The rung to run.
    pub forecast: &'a Forecast,
    /// The chance that it is truly within the tolerance, 0 to 1.
    pub chance: f64,
    /// Whether it is expected to be within the tolerance.
    pub is_within: bool,
    /// The next cheaper rung, and why not that.
    pub cheaper: Option<&'a Forecast>,
    /// Whether a cheaper or truer one was left out for its time.
    pub is_limited_by_budget: bool,
}

/// The rung that leads to a picture within the tolerance in the least time, as far as the forecasts tell, and whose own time is
/// within the budget in seconds.
///
/// That time is the rung's own, and where it fails, half of that of the cheapest which is as good as sure. Of what is more likely to fail
/// than not, nothing is advised: where all is, the one of the budget that comes nearest (the cheapest of all where even that
/// takes too long). `None` without forecasts.
#[must_use]
pub fn choose<'a>(forecasts: &'a [Forecast], tolerance: &Tolerance, budget: Option<f64>) -> Option<Choice<'a>> {
    let chance = |forecast: &Forecast| chance(&forecast.rung, &forecast.error, forecast.doubt, tolerance);
    let cheapest = |a: &&Forecast, b: &&Forecast| a.seconds.total_cmp(&b.seconds);
    let affordable = |forecast: &&Forecast| budget.is_none_or(|budget| forecast.seconds <= budget);
    let is_likely = |forecast: &&Forecast| chance(forecast) >= 0.5;

    let seconds = |forecast: &Forecast| forecast.seconds;
    let sure = forecasts.iter().filter(|forecast| chance(forecast) >= SURE).map(seconds).reduce(f64::min);
    let sure = sure.or_else(|| forecasts.iter().map(seconds).reduce(f64::max))?;
    let in_the_end = |forecast: &Forecast| forecast.seconds + RISK * (1.0 - chance(forecast)) * sure;
    let chosen =
        forecasts.iter().filter(affordable).filter(is_likely).min_by(|a, b| in_the_end(a).total_cmp(&in_the_end(b)));
    let used = |forecast: &Forecast| tolerance.used_by(&forecast.error);
    let nearest = || forecasts.iter().filter(affordable).min_by(|a, b| used(a).total_cmp(&used(b)));
    let forecast = chosen.or_else(nearest).or_else(|| forecasts.iter().min_by(cheapest))?;
    let cheaper = forecasts.iter().filter(|other| other.seconds < forecast.seconds).max_by(cheapest);
    let is_limited_by_budget = chosen.is_none() && forecasts.iter().any(|other| is_likely(&other));
    Some(Choice { forecast, chance: chance(forecast), is_within: chosen.is_some(), cheaper, is_limited_by_budget })
}

/// Whether a rung's error, as it predicted it itself, is trusted to be within a tolerance.
#[must_use]
pub fn is_trusted_within(rung: &Rung, error: &ExpectedError, tolerance: &Tolerance) -> bool {
    chance(rung, error, None, tolerance) >= 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Doubt;
    use filter::Method;

    fn forecast(samples: u32, seconds: f64, rmse: f64) -> Forecast {
        let error = ExpectedError { rmse, hdr_flip: None };
        Forecast { rung: Rung::Trace { samples }, seconds, error, doubt: None, kernel: None }
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
    fn a_risk_is_taken_where_being_sure_costs_more() {
        let doubtful =
            |seconds, rmse| Forecast { doubt: Some(Doubt { rmse: 0.1, hdr_flip: 0.1 }), ..forecast(4, seconds, rmse) };
        let chosen = |dear: f64| {
            let all = [doubtful(1.0, 0.0095), doubtful(dear, 0.001)];
            choose(&all, &Tolerance::Rmse(0.01), None).unwrap().forecast.seconds
        };
        assert_eq!(chosen(1.1), 1.1, "what is sure costs hardly more than what is likely");
        assert_eq!(chosen(100.0), 1.0);
        let all = [doubtful(1.0, 0.0105), doubtful(100.0, 0.001)];
        assert_eq!(choose(&all, &Tolerance::Rmse(0.01), None).unwrap().forecast.seconds, 100.0, "no bad bets");
    }

    #[test]
    fn what_is_not_trusted_needs_room() {
        let error = ExpectedError { rmse: 0.0099, hdr_flip: Some(0.0099) };
        let filter = Rung::Filter(Method::default());
        assert!(!is_trusted_within(&filter, &error, &Tolerance::Rmse(0.01)));
        assert!(is_trusted_within(&filter, &error, &Tolerance::Rmse(0.0125)));
        assert!(!is_trusted_within(&filter, &ExpectedError { hdr_flip: None, ..error }, &Tolerance::HdrFlip(1.0)));
    }
}

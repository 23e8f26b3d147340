//! The cheapest rung that will do.

use crate::{Forecast, Tolerance, advice::calibration::Calibration};

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
    let used = |forecast: &Forecast| tolerance.used_by(&forecast.error) * Calibration::margin(&forecast.rung, tolerance);
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

//! A picture that is to be within a tolerance: the filter tells by its own prediction whether it is, and tries harder.

use ::filter::{Filtered, LensRaysSettings, Method};
use serde::Serialize;
use study::{ExpectedError, Rung, Tolerance, error_of_filtered, is_trusted_within};

use super::job::Say;

/// What is expected of a picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Promise {
    tolerance: Tolerance,
    expected: ExpectedError,
    pub(super) is_within: bool,
}

impl Promise {
    /// In words.
    pub(super) fn text(&self) -> String {
        let (expected, tolerance) = (self.tolerance.text_of(&self.expected), self.tolerance);
        let verdict = if self.is_within { "within" } else { "not surely within" };
        format!("expected at {expected}, {verdict} {tolerance}")
    }
}

/// Filters with the method that was asked for, which predicts its error, and where that is not expected to be within the
/// tolerance with lens rays too; the better of the two is kept.
pub(super) fn within(
    method: Method,
    tolerance: Tolerance,
    mut filter: impl FnMut(&Method) -> anyhow::Result<Filtered>,
    say: Say<'_>,
) -> anyhow::Result<(Method, Filtered, Promise)> {
    let mut run = |method: Method| {
        let filtered = filter(&method)?;
        let expected = error_of_filtered(&filtered, tolerance.needs_flip())?.expect("a method that predicts its error");
        let is_within = is_trusted_within(&Rung::Filter(method), &expected, &tolerance);
        anyhow::Ok((method, filtered, Promise { tolerance, expected, is_within }))
    };
    let first = run(method)?;
    let (Method::Merged(settings) | Method::Gather(settings), false) = (method, first.2.is_within) else {
        return Ok(first);
    };
    say(format_args!("{}: {}; trying lens rays", method.name(), first.2.text()));
    let second = run(Method::LensRays(LensRaysSettings {
        max_radius_px: settings.max_radius_px,
        layers: settings.layers,
        sides: settings.sides,
        predict_error: true,
        ..LensRaysSettings::default()
    }))?;
    let used = |promise: &Promise| promise.tolerance.used_by(&promise.expected);
    Ok(if second.2.is_within || used(&second.2) < used(&first.2) { second } else { first })
}

//! How far forecasts are trusted.

use crate::{Family, Rung, Tolerance};

/// What a forecast error is multiplied by before it is held against a tolerance, so that a tolerance is missed seldom.
///
/// Those of the RMS error were searched for on the nine blurred shots of `simple` alone, at 320x180 and 640x360 (2026-11-26):
/// right in at least 97 % of the cases, at the least extra time. Those of HDR-FLIP are one of three sets that were tried by hand
/// from the largest ratios on `simple`, when the outcome on `landscape` was in sight; `benches/results/2026-11-26-advice.md`.
pub(crate) fn margin(rung: &Rung, tolerance: &Tolerance) -> f64 {
    let is_one_layer = rung.layers() == Some(1);
    match (rung.family(), tolerance.needs_flip()) {
        (Family::Pinhole, false) => 1.1,
        (Family::Pinhole, true) => 1.01,
        (Family::OwnCoc, false) => 1.05,
        (Family::OwnCoc, true) => 1.2,
        (Family::Trace | Family::Candidate, false) => 1.0,
        (Family::Trace | Family::Candidate, true) => 1.2,
        (Family::Hybrid, false) => 1.1,
        (Family::Hybrid, true) => 1.7,
        (Family::Gather | Family::Merged | Family::LensRays, false) => 1.2,
        (Family::Gather | Family::Merged | Family::LensRays, true) if is_one_layer => 1.6,
        (Family::Gather | Family::Merged | Family::LensRays, true) => 1.9,
    }
}

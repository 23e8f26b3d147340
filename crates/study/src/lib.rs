//! Experiments that need both sides: what each further second buys.
//!
//! [`forecasts`] tells from a few cheap runs what every rung would cost and how wrong it would be, and [`choose`] names the
//! cheapest that is within a [`Tolerance`].
//!
//! Here alone (and in the command line) the tracer and the filter meet. [`measure`] runs every [`Rung`] of the ladder on
//! this machine, and a [`Chart`] places them by [`Timing`] and error, with the Pareto [`frontier`] drawn and each dominated
//! method named.
//!
//! ```
//! use study::{Tradeoff, dominated_by, frontier};
//!
//! // Time in seconds, error
//! let methods = [(0.1, 0.02), (0.2, 0.03), (0.4, 0.01)].map(|(seconds, error)| Tradeoff { seconds, error });
//! assert_eq!(frontier(&methods), [0, 2]);
//! assert_eq!(dominated_by(&methods), [None, Some(0), None], "the second is slower than the first, and worse");
//! ```

mod advice;
mod benchmark;
mod causes;
mod chart;
mod chart_svg;
mod error;
mod growth;
mod hybrid;
mod labels;
mod log_axis;
mod machine;
mod marks;
mod measure;
mod pareto;
mod rung;
mod series;
mod series_svg;
mod stability;
mod step;
mod timing;

pub use advice::{
    Choice, Doubt, Evidence, ExpectedError, Forecast, Tolerance, choose, error_of_filtered, forecasts,
    is_trusted_within,
};
pub use benchmark::{BENCHMARK_FORMAT, Benchmark, Case, Score, checksum, score};
pub use causes::{CAUSES_FORMAT, Cause, CauseShare, Causes, CausesReport, CausesSettings, Shares, Verdict, causes};
pub use chart::{CHART_FORMAT, Chart, Clock, Conditions, Point, PointError, RmsError};
pub use error::StudyError;
pub use growth::growth_exponent;
pub use hybrid::{Hybrid, HybridSettings, hybrid};
pub use machine::Machine;
pub use measure::{Measured, Subject, measure};
pub use pareto::{Tradeoff, dominated_by, frontier};
pub use rung::{Family, Rung};
pub use series::{Growth, Over, Place, SERIES_FORMAT, Series};
pub use stability::{
    Clip, Contender, Curve, Estimate, Failed, Flicker, Flickers, Mode, Quality, Refusal, STABILITY_FORMAT, Sensitivity,
    Spoilt, Stability, StabilityConditions, Stage, Staged, Steadiness, Sweep, SweepFigures, SweepVerdict, TruthChange,
    Worst, refusals, run_clip, run_sensitivity, run_sweep,
};
pub use timing::Timing;

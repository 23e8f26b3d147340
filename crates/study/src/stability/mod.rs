//! Where methods fail, and must fail softly: each bad point swept through in small steps, every rung held against the tracer.
//!
//! A [`Sweep`] leads through one failure [`Mode`]; [`run_sweep`] takes the truth at each step, with the same seed at all,
//! and every [`Contender`]'s picture. Four criteria hold at each step ([`SweepVerdict`]):
//!
//! - no pixel is not finite;
//! - from step to step the picture changes by no more than k times what the truth changes by, plus the truth's noise and
//!   [`Mode::UNSEEN`], as the root mean square and as the 99.9th percentile over the pixels (k is [`Mode::steadiness`]'s);
//! - its error is at most 10 % above that of no filter;
//! - where a request has no meaning, there is the documented error and no picture ([`refusals`], [`SweepFigures::refused`]).
//!
//! [`run_clip`] measures flicker over a pan of the plane of focus and a rack focus, [`run_sensitivity`] what doubtful depth
//! costs. All figures together are a [`Stability`].

mod clip;
mod contender;
mod figures;
mod lens_sweeps;
mod mode;
mod own_sweeps;
mod panels;
mod refusals;
mod report;
mod run;
mod sensitivity;
mod spoil;
mod stage;
mod sweep;
mod verdict;

pub use clip::{Clip, Flicker, Flickers, run_clip};
pub use contender::{Contender, Staged};
pub use figures::{Estimate, TruthChange};
pub use mode::{Mode, Steadiness};
pub use refusals::{Refusal, refusals};
pub use report::{Failed, STABILITY_FORMAT, Stability, StabilityConditions};
pub use run::{Curve, Quality, SweepFigures, run_sweep};
pub use sensitivity::{Sensitivity, Spoilt, run_sensitivity};
pub use stage::Stage;
pub use sweep::Sweep;
pub use verdict::{SweepVerdict, Worst};

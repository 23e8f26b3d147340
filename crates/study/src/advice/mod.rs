//! Model no more than a scene needs: the cheapest rung that is expected to be within a tolerance.

mod calibration;
mod choice;
mod forecast;
mod pilot;
mod tolerance;

pub use choice::{Choice, choose};
pub use forecast::{ExpectedError, Forecast};
pub use pilot::{Evidence, forecasts};
pub use tolerance::Tolerance;

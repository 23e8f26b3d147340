//! Model no more than a scene needs: the cheapest rung that is expected to be within a tolerance.

mod calibration;
mod choice;
mod forecast;
mod pilot;
mod tolerance;

pub use choice::{Choice, choose, is_trusted_within};
pub use forecast::{ExpectedError, Forecast};
pub use pilot::{Evidence, error_of_filtered, forecasts};
pub use tolerance::Tolerance;

//! Model no more than a scene needs: the cheapest rung that is expected to be within a tolerance.

mod calibration;
mod choice;
mod forecast;
mod noise;
mod pilot;
mod spots;
mod tolerance;
mod traced;

pub use choice::{Choice, choose, is_trusted_within};
pub use forecast::{Doubt, ExpectedError, Forecast};
pub use pilot::{Evidence, error_of_filtered, forecasts};
pub use tolerance::Tolerance;

//! What cannot be asked of a lens, each request with its reason.

use thiserror::Error;

/// A request that no lens or camera can fulfil.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A number is outside its range.
    #[error("{what} is {value}; it must be {wanted}")]
    OutOfRange {
        /// What the number stands for, with its unit.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// The range that would do.
        wanted: &'static str,
    },
    /// The three axes of a pose are not an orthonormal frame.
    #[error("camera axes are not perpendicular unit vectors: {0}")]
    NotAFrame(&'static str),
}

/// `value` if it is finite and `accept`s it, else an error that says what it should be.
pub(crate) fn in_range(
    what: &'static str,
    value: f64,
    wanted: &'static str,
    accept: impl Fn(f64) -> bool,
) -> Result<f64, OpticsError> {
    if value.is_finite() && accept(value) {
        return Ok(value);
    }
    Err(OpticsError::OutOfRange { what, value, wanted })
}

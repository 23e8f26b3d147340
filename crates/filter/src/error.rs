//! Why a frame cannot be filtered.

use rgbd::{Cancelled, PixelWindow};
use thiserror::Error;

/// Why a frame cannot be filtered.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FilterError {
    /// The window to produce has no pixel in common with the data.
    #[error("the window to produce, {wanted}, lies outside the data window, {data}")]
    NoData {
        /// What was asked for.
        wanted: PixelWindow,
        /// What there is.
        data: PixelWindow,
    },
    /// The camera's film is not the frame's display window.
    #[error("the camera's film has {film_width}x{film_height} pixels, the frame's display window is {display}")]
    FilmMismatch {
        /// Width of the film in pixels.
        film_width: u32,
        /// Height of the film in pixels.
        film_height: u32,
        /// The display window.
        display: PixelWindow,
    },
    /// A setting is outside its range.
    #[error("{what} is {value}; it must be {wanted}")]
    BadSetting {
        /// Which one, with its unit.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// The range that would do.
        wanted: &'static str,
    },
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

//! Why two pictures cannot be compared.

use rgbd::PixelWindow;
use thiserror::Error;

/// A comparison or report that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// A picture does not cover the window that is compared.
    #[error("{what} covers {found}; the comparison needs {wanted}")]
    WindowMismatch {
        /// Which picture or mask.
        what: String,
        /// Its window.
        found: PixelWindow,
        /// The display window.
        wanted: PixelWindow,
    },
    /// There is no pixel to compare.
    #[error("the display window {0} holds no pixel")]
    NoPixel(PixelWindow),
    /// The camera's film has another size than the frame's display window.
    #[error("the camera's film is {film_width}x{film_height} pixels, the display window is {display}")]
    FilmMismatch {
        /// Columns of the film.
        film_width: u32,
        /// Rows of the film.
        film_height: u32,
        /// The display window.
        display: PixelWindow,
    },
    /// The reach of the edge mask is no distance.
    #[error("the edge mask reaches {0} px; it must be 0 or a positive number of pixels")]
    BadReach(f64),
    /// A given noise is no mean square.
    #[error("the noise MSE of {mask} is {value}; it must be 0 or positive")]
    BadNoise {
        /// Which part of the picture.
        mask: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A picture of the report could not be encoded.
    #[error("a picture of the report could not be encoded as PNG: {0}")]
    Png(String),
}

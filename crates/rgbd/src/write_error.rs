//! Why a picture was not written.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::PixelWindow;

/// Why a picture was not written. What stood in its place before still does.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The disk, the folder or the rights did not allow it.
    #[error("cannot write \"{}\": {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// OpenEXR knows no empty windows, and no coordinates beyond 2^30.
    #[error("cannot write \"{}\": the {what} window is {window}; it must hold a pixel and stay within 2^30", path.display())]
    BadWindow {
        /// The file.
        path: PathBuf,
        /// `display` or `data`.
        what: &'static str,
        /// The window.
        window: PixelWindow,
    },
    /// A name that a channel or an attribute cannot have.
    #[error("cannot write \"{}\": {what} \"{name}\" {why}", path.display())]
    BadName {
        /// The file.
        path: PathBuf,
        /// What bears the name.
        what: &'static str,
        /// The name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A number that a file cannot hold.
    #[error("cannot write \"{}\": {what} is {value}; it must be {wanted}", path.display())]
    BadNumber {
        /// The file.
        path: PathBuf,
        /// What it stands for.
        what: &'static str,
        /// The value.
        value: f64,
        /// What would do.
        wanted: &'static str,
    },
    /// The encoder refused the picture.
    #[error("cannot write \"{}\": {reason}", path.display())]
    Encoding {
        /// The file.
        path: PathBuf,
        /// What it says.
        reason: String,
    },
}

//! Why a file was not read.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::{FrameError, PhotoFormat};

/// Why a file was not read, and what would do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("cannot read \"{}\": {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Not an OpenEXR file, or not a whole one.
    #[error("\"{}\" is damaged or no OpenEXR file: {reason}; write or copy it anew", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Not a whole picture of its format.
    #[error("\"{}\" starts like a {format} picture but is none that can be read: {reason}; write or copy it anew", path.display())]
    Undecodable {
        /// The file.
        path: PathBuf,
        /// What it starts like.
        format: PhotoFormat,
        /// What is wrong with it.
        reason: String,
    },
    /// A valid file of a kind that is not read.
    #[error("\"{}\" holds {what}, which is not read; {remedy}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it holds.
        what: String,
        /// What would do.
        remedy: &'static str,
    },
    /// The header claims more pixels than allowed.
    #[error("\"{}\" claims {pixels} pixels in its {what}; at most {limit} are read (raise it with --max-pixels)", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Which window.
        what: String,
        /// How many pixels it has.
        pixels: u64,
        /// How many are allowed.
        limit: u64,
    },
    /// An attribute of ours does not hold what it should.
    #[error("attribute {name} of \"{}\" makes no sense: {reason}", path.display())]
    BadAttribute {
        /// The file.
        path: PathBuf,
        /// The attribute.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Nothing in the file is wanted by that name.
    #[error("no {what} \"{name}\" in \"{}\" ({available})", path.display())]
    NotFound {
        /// The file.
        path: PathBuf,
        /// What was looked for: view, colour layer, depth channel.
        what: &'static str,
        /// Its name.
        name: String,
        /// What there is instead.
        available: String,
    },
    /// There is no colour to be found.
    #[error("no colour in \"{}\" (channels: {available}); name a layer with --color", path.display())]
    NoColor {
        /// The file.
        path: PathBuf,
        /// What there is instead.
        available: String,
    },
    /// There is no depth to be found.
    #[error("no depth channel in \"{}\" (channels: {available}); name one with --depth", path.display())]
    NoDepth {
        /// The file.
        path: PathBuf,
        /// What there is instead.
        available: String,
    },
    /// Several readings are equally plausible.
    #[error("\"{}\" can be read in several ways: {what} may be {candidates}; name one with {option}", path.display())]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// Colour or depth.
        what: &'static str,
        /// The equals.
        candidates: String,
        /// The option that decides.
        option: &'static str,
    },
    /// Distances along the ray become depths only with the directions of the pixels.
    #[error(
        "depth of \"{}\" as distance along the ray needs the camera's field of view; name --focal-length and --sensor-width, or --fov",
        path.display()
    )]
    NeedsCamera {
        /// The file.
        path: PathBuf,
    },
    /// The file holds something else than asked for.
    #[error("\"{}\" holds {found}, not {wanted}", path.display())]
    WrongKind {
        /// The file.
        path: PathBuf,
        /// What it holds.
        found: &'static str,
        /// What was asked for.
        wanted: &'static str,
    },
    /// Its parts do not make a frame.
    #[error("\"{}\": {source}", path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// Why.
        source: FrameError,
    },
}

//! What can be wrong with a scene file, with the place where it is.

use std::path::PathBuf;

use optics::OpticsError;
use thiserror::Error;

use crate::SceneError;

/// Why a scene file cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file cannot be read.
    #[error("cannot read {path:?}: {source}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is not TOML, or a key or value is not what the format knows.
    #[error("{path:?}: {source}")]
    Syntax {
        /// Which file.
        path: PathBuf,
        /// Line, caret and what was expected.
        source: Box<toml::de::Error>,
    },
    /// A line says something that cannot be.
    #[error("{path:?}, line {line}: {message}")]
    Line {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would do.
        message: String,
    },
    /// The format is of another version.
    #[error("{path:?} is of format {found}; this program reads format 1")]
    Version {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// A named part is wrong.
    #[error("{path:?}, {part}: {message}")]
    Part {
        /// Which file.
        path: PathBuf,
        /// Which part, as its table is called.
        part: String,
        /// What is wrong and what would do.
        message: String,
    },
    /// A mesh file cannot be used.
    #[error("mesh {path:?}: {message}")]
    Mesh {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// There is no such shot.
    #[error("{path:?} has no shot {name:?} (shots: {known})")]
    NoSuchShot {
        /// Which file.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
}

/// What is wrong with a part of a file, before it is known which part and which file.
#[derive(Debug, Error)]
pub(crate) enum Fault {
    #[error("{0}")]
    Says(String),
    #[error(transparent)]
    Optics(#[from] OpticsError),
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl Fault {
    pub(crate) fn says<T>(message: impl Into<String>) -> Result<T, Self> {
        Err(Self::Says(message.into()))
    }
}

//! Why an experiment cannot be made.

use rgbd::Cancelled;
use thiserror::Error;

/// Why an experiment cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The filter refuses the frame.
    #[error(transparent)]
    Filter(#[from] filter::FilterError),
    /// The tracer refuses the scene or the number of samples.
    #[error(transparent)]
    Render(#[from] trace::RenderError),
    /// A lens or a camera has no meaning.
    #[error(transparent)]
    Optics(#[from] optics::OpticsError),
    /// Things do not make a scene.
    #[error(transparent)]
    Scene(#[from] trace::SceneError),
    /// A picture cannot be compared.
    #[error(transparent)]
    Compare(#[from] compare::CompareError),
    /// A picture that was just written cannot be read.
    #[error(transparent)]
    Read(#[from] rgbd::ReadError),
    /// A picture cannot be written.
    #[error(transparent)]
    Write(#[from] rgbd::WriteError),
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
    /// The layers that were put together are no frame.
    #[error(transparent)]
    Frame(#[from] rgbd::FrameError),
    /// A map cannot be encoded.
    #[error("a map could not be encoded as PNG: {0}")]
    Png(String),
    /// Finer pixels than a film can have.
    #[error("pixels {fine} times as fine are more than a film can have; take a smaller picture")]
    TooFine {
        /// How much finer.
        fine: u32,
    },
    /// A benchmark's file is not one.
    #[error("{why}")]
    Benchmark {
        /// What is wrong, and where.
        why: String,
    },
    /// Nothing tells what camera took a frame.
    #[error("the frame does not say what camera took it")]
    NoCamera,
    /// The tracer has nothing to trace.
    #[error("without a scene nothing can be traced")]
    NoScene,
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

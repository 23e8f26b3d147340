//! What cannot be built or rendered, each request with its reason.

use rgbd::Cancelled;
use thiserror::Error;

/// Why things do not make a scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A placement squeezes a shape flat or is not finite.
    #[error("a placement is not finite, or scales by 0: a shape would have no volume")]
    FlatPlacement,
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
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but the mesh has {count} vertices")]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// Something without an end shall move.
    #[error("an endless plane cannot move; give it a size")]
    EndlessMover,
    /// More things than fit.
    #[error("{0} primitives are more than the {max} that fit", max = crate::geometry::Geometry::MOST)]
    TooMany(usize),
}

/// Why a picture cannot be rendered.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// It was stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The range of samples does not exist.
    #[error("samples {first} to {end} per half: the sequence has {max}", max = crate::MAX_SAMPLES)]
    SampleRange {
        /// First index asked for.
        first: u32,
        /// One past the last.
        end: u32,
    },
    /// Two accumulations hold the same samples.
    #[error("samples {first} to {end} of some pixels are in both: joined they would count twice")]
    Overlap {
        /// First common index.
        first: u32,
        /// One past the last.
        end: u32,
    },
    /// Samples between those of two accumulations are missing.
    #[error("samples {first} to {end} of some pixels are missing between the parts")]
    Gap {
        /// First missing index.
        first: u32,
        /// One past the last.
        end: u32,
    },
    /// A render was begun towards a number of samples and shall go on towards a noise, or the other way round.
    #[error("the render was begun towards another goal: a number of samples and a noise spread them differently")]
    AnotherGoal,
    /// There is nothing to join.
    #[error("there is no part to join")]
    NoParts,
    /// Two accumulations come from different seeds.
    #[error("seeds {0} and {1} do not belong to one picture")]
    SeedMismatch(u64, u64),
    /// Two accumulations were made through different cameras.
    #[error("the parts were rendered through different cameras")]
    CameraMismatch,
    /// There are no pixels, or some pixel has no sample.
    #[error("no pixels were asked for, or some pixel of {0} has no sample")]
    NoSamples(rgbd::PixelWindow),
    /// The layers do not make a frame.
    #[error(transparent)]
    Frame(#[from] rgbd::FrameError),
}

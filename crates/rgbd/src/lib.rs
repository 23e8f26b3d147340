//! The frame: RGB-D pictures with layers, windows and a camera, and the files they live in.
//!
//! One picture type crosses crate borders, the [`Frame`]: colour and depth in layers, nearest first. A result without
//! depth is a [`Picture`]; a traced ground truth with its own noise is a [`Truth`].

mod frame;
mod picture;
mod pixel_window;
mod plane;
mod primaries;
mod progress;
mod truth;

pub use frame::{Frame, FrameError, Layer};
pub use picture::Picture;
pub use pixel_window::PixelWindow;
pub use plane::{Mask, Plane};
pub use primaries::Primaries;
pub use progress::{Cancelled, Progress, Silent};
pub use truth::Truth;

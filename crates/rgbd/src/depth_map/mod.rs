//! Depth or disparity maps that lie beside a picture, in a file of their own.

mod fill;
mod meaning;
mod read;
mod upsample;

pub use fill::fill_holes;
pub use meaning::MapMeaning;
pub use read::{DepthMap, read_depth_map};
pub use upsample::fit_to_picture;

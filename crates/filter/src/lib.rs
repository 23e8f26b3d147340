//! Depth of field as a post-process: an RGB-D [`Frame`](rgbd::Frame) and a camera become the picture that the camera's
//! tilted, swung, shifted lens would have taken.
//!
//! The methods form a ladder from cheap to true, all behind [`Method`] and called through [`apply`]:
//!
//! | rung | method | what it does |
//! | --- | --- | --- |
//! | 0 | [`Method::Pinhole`] | nothing: the unfiltered picture, which every figure stands beside |
//! | 1 | [`Method::OwnCoc`] | every pixel averages its own circle of confusion; no occlusion |
//! | 2 | [`Method::Gather`] | every neighbour whose footprint covers the pixel contributes, nearest first |
//! | 3 | [`Method::Merged`] | the same with neighbours merged into squares where the blur is large: the default |
//! | 5 | [`Method::LensRays`] | rays through points of the iris are marched through the surfaces |
//!
//! The blur of a neighbour is read as a *gather*: with the focus w(q) of the receiving pixel, where an upright iris gives
//! an exact uniform disc of radius `R s |1/z - w(q)|` pixels, however much the plane of focus tilts.
//!
//! What mirrors and glass show is blurred by how far away it seems to be, where the frame knows that
//! ([`optical_depth`](rgbd::Frame::optical_depth)).
//!
//! Light must be linear and may be brighter than white. Where it was clipped at white, [`Highlights`] can guess it back
//! first, so that lamps out of focus become bright discs.

mod apply;
mod bands;
mod beside;
mod cat_eye;
mod cells;
mod color_pyramid;
mod depth_pyramid;
mod error;
mod even_taps;
mod fetch_radius;
mod fill;
mod forest;
mod fragment;
mod gather;
mod highlights;
mod images;
mod kernel;
mod lattice;
mod lattice_rows;
mod lattice_sum;
mod lattice_work;
mod lens_map;
mod lens_points;
mod lens_ray;
mod lens_rays;
mod outline;
mod oval;
mod own_coc;
mod patch;
#[cfg(test)]
mod plain;
mod plain_blocks;
mod predicted;
mod prepare;
mod row;
mod settings;
mod surface;
mod tap;
mod taps;
mod tiles;
mod unmix;
mod upsample;
mod view;
mod view_lens;

pub use apply::{Filtered, Method, apply, coc_radius_px, reach_px};
pub use bands::apply_in_bands;
pub use error::FilterError;
pub use highlights::Highlights;
pub use lens_map::KernelRule;
pub use lens_rays::LensRaysSettings;
pub use predicted::{ErrorCause, PredictedError};
pub use settings::{GatherSettings, Sides};
pub use view::FrameView;

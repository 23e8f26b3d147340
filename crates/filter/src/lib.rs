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

mod apply;
mod depth_pyramid;
mod error;
mod fetch_radius;
mod fill;
mod forest;
mod fragment;
mod gather;
mod kernel;
mod lens_map;
mod lens_points;
mod lens_ray;
mod lens_rays;
mod own_coc;
mod patch;
#[cfg(test)]
mod plain;
mod predicted;
mod prepare;
mod row;
mod surface;
mod tap;
mod tiles;
mod unmix;
mod view;

pub use apply::{Filtered, Method, apply, coc_radius_px, reach_px};
pub use error::FilterError;
pub use gather::{GatherSettings, Sides};
pub use lens_map::KernelRule;
pub use lens_rays::LensRaysSettings;
pub use view::FrameView;

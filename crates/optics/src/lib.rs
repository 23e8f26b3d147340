//! The camera of a tilt-shift lens: where it looks, what it holds sharp, and how large everything else blurs.
//!
//! # Conventions
//!
//! Camera space is left-handed: **x right, y up, z = depth into the scene** along the sensor's normal (OpenEXR's
//! `worldToCamera` space). The lens centre is the origin. A pixel is its chief-ray direction `q = (qx, qy)`, the ray
//! `(qx, qy, 1)`; row 0 of the picture is the *largest* `qy`. The sensor is the plane `z = -v`.
//!
//! ```text
//!            y up                        Positive tilt turns the lens axis n downwards,
//!            |   plane of focus          then positive swing turns it to the right:
//!            |  /   w . P = 1              n = (sin s cos t, -sin t, cos s cos t)
//!   sensor   | /                         Positive tilt puts the hinge below the lens:
//!   z = -v   |/                          the plane of focus lies along the floor.
//!     |      +--------> z depth          Positive shift is rise / right.
//!     |      lens
//! ```
//!
//! # One vector does it all
//!
//! A thin lens measured along its own axis n gives `1/(n.P) + 1/(k n.P) = 1/F` for a point P and its image -kP, so a
//! pixel is sharp at a depth whose *inverse is affine in the pixel*:
//!
//! ```text
//! 1 / z_f(q) = w(q) = w . (qx, qy, 1)    with    w = n / F - z^ / v
//! ```
//!
//! The plane of sharp focus is `w . P = 1`. Everything in this crate follows from that one vector; see [`Focus`].
//!
//! # Where to find what
//!
//! A [`Camera`] holds what rays need and nothing derived. To say what it should be, begin with a [`ThinLens`] (focal
//! length, f-number, tilt, swing, shift), or with the wanted plane ([`Focus`]: three picked pixels, a plane of the world,
//! [`Nakane`]'s angle and distance) and ask for the lens that does it ([`ThinLens::at_image_distance`],
//! [`ThinLens::of_focal_length`]). To read what a camera is, ask it for its [`ThinLens`], its hinge and vanishing line,
//! its [`Wedge`] of depth of field. Where a point lands in the picture, exactly or nearly, is a [`Footprint`]; the
//! cheapest model of it that will do is a [`KernelChoice`], the margin that it needs an [`Overscan`].
//!
//! All lengths in a [`Camera`] are in one unit, the scene's; [`ThinLens`] is in metres or any other one unit.

mod camera;
mod depth_range;
mod error;
mod film;
mod focus;
mod focusing;
mod footprint;
mod ground;
mod iris;
mod kernel_model;
mod line;
mod moments;
mod nakane;
mod opening;
mod overscan;
mod pose;
mod thin_lens;
mod wedge;

pub use camera::{Camera, LensRay};
pub use depth_range::DepthRange;
pub use error::OpticsError;
pub use film::Film;
pub use focus::Focus;
pub use footprint::{Footprint, Reading};
pub use ground::Ground;
pub use iris::{ApertureShape, Iris};
pub use kernel_model::{KernelChoice, KernelModel};
pub use line::{PixelLine, SpaceLine};
pub use moments::Moments;
pub use nakane::Nakane;
pub use opening::Opening;
pub use overscan::Overscan;
pub use pose::Pose;
pub use thin_lens::ThinLens;
pub use wedge::Wedge;

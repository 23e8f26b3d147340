//! A distributed ray tracer whose lens tilts, swings and shifts.
//!
//! Cook, Porter, Carpenter, "Distributed Ray Tracing" (SIGGRAPH 1984): a pixel is the mean over its area and over the
//! iris. The camera of crate `optics` makes the rays; nothing here knows how large a blur should be.
//!
//! ```
//! use glam::{DAffine3, DVec2, DVec3, Vec3};
//! use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
//! use rgbd::{PixelWindow, Silent};
//! use trace::{Material, SceneBuilder, Shape};
//!
//! let mut builder = SceneBuilder::new();
//! let glow = builder.material(Material::glowing(Vec3::ONE));
//! builder.shape(Shape::Sphere, DAffine3::from_translation(DVec3::new(0.0, 0.0, -5.0)), glow)?;
//! let scene = builder.build()?;
//! let camera = Camera {
//!     pose: Pose::IDENTITY,
//!     film: Film::from_fov(1.0, 32, 32)?,
//!     focus: Focus::at_depth(5.0)?,
//!     iris: Iris::upright(0.1, ApertureShape::Disc)?,
//! };
//! let truth = trace::truth(&scene, &camera, PixelWindow::of_size(32, 32), 16, 1, &Silent)?;
//! assert_eq!(truth.picture().at(16, 16), [1.0; 4]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod absorption;
mod accumulation;
mod body;
mod bounds;
mod bvh;
mod curve;
mod error;
mod exposure;
mod file;
mod finish;
mod geometry;
mod job;
mod layers;
mod lens;
#[cfg(test)]
mod levels;
mod light;
mod material;
mod mesh_detail;
mod motion;
mod packet;
mod part_file;
mod pixels;
mod ray;
mod render;
mod sampler;
mod scene;
mod scene_builder;
mod shade;
mod shape;
mod spread;
mod stage;
mod texture;
mod transport;
mod triangle;

pub use absorption::Absorption;
pub use accumulation::Accumulation;
pub use body::Body;
pub use error::{RenderError, SceneError};
pub use exposure::Exposure;
pub use file::{FileError, SceneFile, Shot, Wishes};
pub use finish::{Alpha, Finish, Matter};
pub use geometry::Hit;
pub use job::{Goal, Job};
pub use layers::{LayerSettings, LayeredFrame, Margin, layers, optical_depth};
pub use light::{Cone, Light};
pub use material::{Material, Pigment};
pub use mesh_detail::MeshDetail;
pub use motion::{Motion, MoveKey, Moves};
pub use part_file::{Part, PartError};
pub use pixels::Pixels;
pub use ray::Ray;
pub use render::{Wanted, render, truth, truth_to_noise};
pub use sampler::MAX_SAMPLES;
pub use scene::{MAX_RADIANCE, Scene};
pub use scene_builder::{BodyId, MaterialId, SceneBuilder};
pub use shape::Shape;
pub use texture::{Encoding, Texture, TextureError, TextureMap, Wrap};
pub use transport::Environment;

//! Scene files: TOML in, scene and cameras out. `data/scenes/FORMAT.md` documents the format.

mod animation;
mod error;
mod gltf_access;
mod gltf_material;
mod gltf_mesh;
mod looks;
mod mesh;
mod model;
mod model_view;
mod obj_mesh;
mod objects;
mod resources;
mod scatter;
mod scene_file;
mod shot;
mod shutter;
mod spec;
mod take;
mod triple;

pub use error::FileError;
pub use scene_file::{SceneFile, Wishes};
pub use shot::Shot;

//! Scene files: TOML in, scene and cameras out. `data/scenes/FORMAT.md` documents the format.

mod animation;
mod error;
mod gltf_mesh;
mod mesh;
mod obj_mesh;
mod scene_file;
mod shot;
mod spec;
mod triple;

pub use error::FileError;
pub use scene_file::SceneFile;
pub use shot::Shot;

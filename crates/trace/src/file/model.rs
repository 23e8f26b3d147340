//! What a glTF or OBJ file holds beyond triangles: cameras, lights, and what was wrong but could be lived with.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::error::FileError;
use super::mesh::Mesh;
use super::scene_file::refuse_special;
use super::{gltf_mesh, obj_mesh};
use crate::Light;

/// A model file, all transforms inside it applied.
#[derive(Debug, Clone, Default)]
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    pub(crate) cameras: Vec<ModelCamera>,
    pub(crate) lights: Vec<Light>,
}

/// A camera of a model file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ModelCamera {
    pub(crate) name: String,
    /// Where it stands, if a node has it: it looks along its -z.
    pub(crate) world_from_camera: Option<DAffine3>,
    /// Vertical field of view in radians, and width over height, of a perspective one.
    pub(crate) view: Option<(f64, Option<f64>)>,
}

impl Model {
    /// Whether a file is one by its extension.
    pub(crate) fn is_one(path: &Path) -> bool {
        matches!(extension(path).as_str(), "obj" | "gltf" | "glb")
    }

    /// Reads an OBJ or glTF file, told by its extension.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let fault = |message: String| FileError::Mesh { path: path.to_owned(), message };
        let read = match extension(path).as_str() {
            "obj" => obj_mesh::read,
            "gltf" | "glb" => gltf_mesh::read,
            _ => return Err(fault("the extension is none of .obj, .gltf, .glb".to_owned())),
        };
        refuse_special(path).map_err(|source| FileError::Read { path: path.to_owned(), source })?;
        let mut model = read(path).map_err(fault)?;
        model.mesh.forget_the_plain();
        Ok(model)
    }

    /// The corners of the box around all vertices that triangles have, near and far.
    pub(crate) fn bounds(&self) -> Option<[DVec3; 2]> {
        let corners = self.mesh.triangles.iter().flatten().filter_map(|&i| self.mesh.vertices.get(i as usize));
        corners.filter(|corner| corner.is_finite()).fold(None, |bounds, &corner| {
            let [low, high] = bounds.unwrap_or([corner; 2]);
            Some([low.min(corner), high.max(corner)])
        })
    }
}

fn extension(path: &Path) -> String {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_ascii_lowercase()
}

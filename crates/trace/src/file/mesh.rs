//! Triangles with the colours that their file gives them.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::scene_file::refuse_special;
use super::{error::FileError, gltf_mesh, obj_mesh};
use crate::Material;

/// What a mesh file holds, all transforms inside it applied.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Per triangle, an index into `materials`.
    pub(crate) material_of: Vec<u32>,
    pub(crate) materials: Vec<Material>,
}

impl Mesh {
    /// Reads an OBJ or glTF file, told by its extension.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let fault = |message: String| FileError::Mesh { path: path.to_owned(), message };
        let read = match extension.as_str() {
            "obj" => obj_mesh::read,
            "gltf" | "glb" => gltf_mesh::read,
            _ => return Err(fault("the extension is none of .obj, .gltf, .glb".to_owned())),
        };
        refuse_special(path).map_err(|source| FileError::Read { path: path.to_owned(), source })?;
        read(path).map_err(fault)
    }

    /// Adds all that makes it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        self.vertices.iter().flat_map(DVec3::to_array).for_each(|x| fingerprint.update(&x.to_le_bytes()));
        let indices = self.triangles.iter().flatten().chain(&self.material_of);
        indices.for_each(|i| fingerprint.update(&i.to_le_bytes()));
        self.materials.iter().for_each(|material| fingerprint.update(format!("{material:?}").as_bytes()));
    }

    /// The index of a material for surfaces that have none: white, reflecting 80 %.
    pub(crate) fn add_default_material(&mut self) -> u32 {
        self.add_material(Material::matte(Vec3::splat(0.8)))
    }

    pub(crate) fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        (self.materials.len() - 1) as u32
    }
}

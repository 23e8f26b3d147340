//! Triangles with the colours that their file gives them.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::error::FileError;
use super::model::Model;
use crate::{Finish, Material, MeshDetail};

/// What a mesh file holds, all transforms inside it applied.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Per triangle, an index into `materials`.
    pub(crate) material_of: Vec<u32>,
    pub(crate) materials: Vec<Material>,
    /// One for each material.
    pub(crate) finishes: Vec<Finish>,
    /// Per triangle, if anything.
    pub(crate) detail: Arc<MeshDetail>,
    /// What was wrong but can be lived with, a sentence each.
    pub(crate) warnings: Vec<String>,
}

/// What is known of some vertices beyond their places; each list is empty or complete.
#[derive(Debug, Default)]
pub(super) struct Attributes {
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: [Vec<Vec2>; 2],
    pub(super) colors: Vec<Vec4>,
}

impl Mesh {
    /// Reads an OBJ or glTF file, told by its extension.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        Model::read(path).map(|model| model.mesh)
    }

    /// Adds all that makes it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        self.vertices.iter().flat_map(DVec3::to_array).for_each(|x| fingerprint.update(&x.to_le_bytes()));
        let indices = self.triangles.iter().flatten().chain(&self.material_of);
        indices.for_each(|i| fingerprint.update(&i.to_le_bytes()));
        self.materials.iter().for_each(|material| fingerprint.update(format!("{material:?}").as_bytes()));
        self.finishes.iter().filter(|finish| !finish.is_plain()).for_each(|finish| finish.add_to(fingerprint));
        self.detail.add_to(fingerprint);
    }

    /// The index of a material for surfaces that have none: white, reflecting 80 %.
    pub(crate) fn add_default_material(&mut self) -> u32 {
        self.add_finished(Material::matte(Vec3::splat(0.8)), Finish::default())
    }

    pub(crate) fn add_finished(&mut self, material: Material, finish: Finish) -> u32 {
        self.materials.push(material);
        self.finishes.push(finish);
        (self.materials.len() - 1) as u32
    }

    /// Adds triangles of one material between vertices that start at `first`, with what is known of them.
    pub(super) fn add_triangles(
        &mut self,
        triangles: impl Iterator<Item = [u32; 3]>,
        first: u32,
        material: u32,
        attributes: &Attributes,
    ) {
        let before = self.triangles.len();
        let mut detail = std::mem::take(&mut self.detail);
        let own = Arc::make_mut(&mut detail);
        // Fill in what earlier triangles did not have, each list on its first use
        fn fill<T: Clone>(list: &mut Vec<T>, is_used: bool, count: usize, plain: T) -> bool {
            let is_used = is_used || !list.is_empty();
            if is_used {
                list.resize(count, plain);
            }
            is_used
        }
        let Attributes { normals, uvs, colors } = attributes;
        let has_normals = fill(&mut own.normals, !normals.is_empty(), before, [Vec3::ZERO; 3]);
        let has_colors = fill(&mut own.colors, !colors.is_empty(), before, [Vec4::ONE; 3]);
        let has_uvs = [0, 1].map(|set| fill(&mut own.uvs[set], !uvs[set].is_empty(), before, [Vec2::ZERO; 3]));
        for corners in triangles {
            self.triangles.push(corners.map(|i| first.saturating_add(i)));
            self.material_of.push(material);
            if has_normals {
                own.normals.push(corners.map(|i| normals.get(i as usize).copied().unwrap_or(Vec3::ZERO)));
            }
            if has_colors {
                own.colors.push(corners.map(|i| colors.get(i as usize).copied().unwrap_or(Vec4::ONE)));
            }
            for set in 0..2 {
                if has_uvs[set] {
                    own.uvs[set].push(corners.map(|i| uvs[set].get(i as usize).copied().unwrap_or(Vec2::ZERO)));
                }
            }
        }
        self.detail = detail;
    }

    /// Leaves every triangle flat.
    pub(super) fn forget_normals(&mut self) {
        Arc::make_mut(&mut self.detail).normals = Vec::new();
    }

    /// Leaves out what says nothing: normals that are those of the flat triangles, colours that are white.
    pub(super) fn forget_the_plain(&mut self) {
        /// Squared sine of the angle up to which a normal is that of its triangle: 0.06 degrees.
        const SAME: f64 = 1e-6;
        let corner = |i: u32| self.vertices.get(i as usize).copied().unwrap_or(DVec3::NAN);
        let is_flat = |(triangle, normals): (&[u32; 3], &[Vec3; 3])| {
            let [a, b, c] = triangle.map(corner);
            let flat = (b - a).cross(c - a).normalize_or_zero();
            let same = |n: &Vec3| n.as_dvec3().normalize_or_zero().cross(flat).length_squared() <= SAME;
            normals.iter().all(same) || !flat.is_finite()
        };
        let is_all_flat = self.triangles.iter().zip(&self.detail.normals).all(is_flat);
        let is_all_white = self.detail.colors.iter().flatten().all(|color| *color == Vec4::ONE);
        let has_maps = self.finishes.iter().any(|finish| finish.maps().next().is_some());
        let detail = Arc::make_mut(&mut self.detail);
        if is_all_flat {
            detail.normals = Vec::new();
        }
        if is_all_white {
            detail.colors = Vec::new();
        }
        if !has_maps {
            detail.uvs = [Vec::new(), Vec::new()];
        }
    }
}

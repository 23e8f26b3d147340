//! What a mesh says at the corners of its triangles beyond their places.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat3, Mat3, Vec2, Vec3, Vec4};

/// Normals, texture coordinates and colours of each triangle's corners; a list is empty where the mesh has none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshDetail {
    /// Normals of the surface that the triangles stand for, of any length; zero or not finite: that of the triangle.
    pub normals: Vec<[Vec3; 3]>,
    /// Two sets of texture coordinates, v down from the top.
    pub uvs: [Vec<[Vec2; 3]>; 2],
    /// Linear RGBA that multiplies the surface's own.
    pub colors: Vec<[Vec4; 3]>,
}

impl MeshDetail {
    /// Whether it says anything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty() && self.uvs.iter().all(Vec::is_empty) && self.colors.is_empty()
    }

    /// Adds it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        let mut add = |x: f32| fingerprint.update(&x.to_le_bytes());
        self.normals.iter().flatten().flat_map(Vec3::to_array).for_each(&mut add);
        self.uvs.iter().flatten().flatten().flat_map(Vec2::to_array).for_each(&mut add);
        self.colors.iter().flatten().flat_map(Vec4::to_array).for_each(&mut add);
    }
}

/// The triangles of one placed mesh, of all that a scene has.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    /// Which they are.
    pub(crate) range: Range<u32>,
    detail: Arc<MeshDetail>,
    /// Which triangle of the mesh each is, unless they are all there.
    kept: Option<Vec<u32>>,
    world_from_normal: Mat3,
}

/// Corners of one triangle in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corners {
    pub(crate) normals: Option<[Vec3; 3]>,
    pub(crate) uvs: [Option<[Vec2; 3]>; 2],
    pub(crate) colors: Option<[Vec4; 3]>,
}

impl Corners {
    /// The same in a space that a map leads to.
    pub(crate) fn mapped(self, linear: &DMat3) -> Self {
        let turn = linear.inverse().transpose().as_mat3();
        Self { normals: self.normals.map(|normals| normals.map(|n| turn * n)), ..self }
    }
}

/// The placed meshes of a geometry, by its triangles' names.
#[derive(Debug, Clone)]
pub(crate) struct Patches {
    /// In the order of their triangles.
    list: Vec<Patch>,
    /// The triangle behind each name; `u32::MAX` for names without one.
    triangle_of: Vec<u32>,
}

impl Patches {
    pub(crate) fn new(list: Vec<Patch>, triangle_of: Vec<u32>) -> Self {
        Self { list, triangle_of }
    }

    /// What a mesh says of the triangle with this name, if it says anything.
    pub(crate) fn corners(&self, primitive: u32) -> Option<Corners> {
        let triangle = self.triangle_of[primitive as usize];
        let after = self.list.partition_point(|patch| patch.range.start <= triangle);
        let patch = &self.list[after.checked_sub(1)?];
        patch.range.contains(&triangle).then(|| patch.corners(triangle))
    }

    /// The names of all triangles.
    pub(crate) fn names(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.triangle_of).filter(|(_, triangle)| **triangle != u32::MAX).map(|(name, _)| name)
    }
}

impl Patch {
    pub(crate) fn new(range: Range<u32>, detail: Arc<MeshDetail>, kept: Option<Vec<u32>>, map: &DAffine3) -> Self {
        let linear: DMat3 = map.matrix3;
        Self { range, detail, kept, world_from_normal: linear.inverse().transpose().as_mat3() }
    }

    /// What the mesh says of a triangle of the scene.
    pub(crate) fn corners(&self, triangle: u32) -> Corners {
        let own = (triangle - self.range.start) as usize;
        let index = self.kept.as_ref().map_or(own, |kept| kept[own] as usize);
        let normals = self.detail.normals.get(index).map(|normals| normals.map(|n| self.world_from_normal * n));
        Corners {
            normals,
            uvs: [0, 1].map(|set| self.detail.uvs[set].get(index).copied()),
            colors: self.detail.colors.get(index).copied(),
        }
    }

    /// Whether triangles are shaded round.
    pub(crate) fn is_smooth(&self) -> bool {
        !self.detail.normals.is_empty()
    }

    /// Whether corners have colours.
    pub(crate) fn is_colored(&self) -> bool {
        !self.detail.colors.is_empty()
    }
}

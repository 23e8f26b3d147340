//! Surfaces that belong together, as they are collected.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use crate::geometry::Triangle;
use crate::mesh_detail::Patch;
use crate::shape::PlacedShape;
use crate::{MaterialId, MeshDetail, SceneError, Shape};

/// Shapes and triangles in a space of their own: what moves as a whole, or all that stands still.
#[derive(Debug, Clone, Default)]
pub struct Body {
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) shapes: Vec<PlacedShape>,
    pub(crate) patches: Vec<Patch>,
}

impl Body {
    /// One without surfaces.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether it has no surface.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.shapes.is_empty()
    }

    /// Adds a canonical shape under an affine map, which must be finite and invertible.
    pub fn shape(&mut self, shape: Shape, body_from_local: DAffine3, material: MaterialId) -> Result<(), SceneError> {
        self.shapes.push(PlacedShape::new(shape, body_from_local, material.0)?);
        Ok(())
    }

    /// Adds triangles: `corners` are indices into `vertices`, counter-clockwise seen from outside, each triangle with
    /// its own material. Triangles without area, or with a corner that is not finite, can never be seen: they are left
    /// out, and their number is returned.
    pub fn mesh(
        &mut self,
        vertices: &[DVec3],
        corners: &[[u32; 3]],
        materials: impl Fn(usize) -> MaterialId,
        body_from_local: DAffine3,
    ) -> Result<usize, SceneError> {
        self.detailed_mesh(vertices, corners, materials, body_from_local, &Arc::default())
    }

    /// Adds triangles of which more is known than their corners' places: `detail` has an entry for each, or none.
    pub fn detailed_mesh(
        &mut self,
        vertices: &[DVec3],
        corners: &[[u32; 3]],
        materials: impl Fn(usize) -> MaterialId,
        body_from_local: DAffine3,
        detail: &Arc<MeshDetail>,
    ) -> Result<usize, SceneError> {
        let first = self.triangles.len();
        let mut kept = Vec::new();
        // Rounding once per vertex keeps neighbours together
        let placed: Vec<Vec3> = vertices.iter().map(|&v| body_from_local.transform_point3(v).as_vec3()).collect();
        let mut dropped = 0;
        for (triangle, indices) in corners.iter().enumerate() {
            if let Some(&vertex) = indices.iter().find(|&&i| i as usize >= placed.len()) {
                return Err(SceneError::NoSuchVertex { triangle, vertex, count: placed.len() });
            }
            let corners = indices.map(|i| placed[i as usize]);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let area = (b - a).cross(c - a).length();
            if area > 0.0 && area.is_finite() {
                self.triangles.push(Triangle { corners, material: materials(triangle).0 });
                kept.push(triangle as u32);
            } else {
                dropped += 1;
            }
        }
        if !detail.is_empty() && first < self.triangles.len() {
            let kept = (dropped > 0).then_some(kept);
            let range = first as u32..self.triangles.len() as u32;
            self.patches.push(Patch::new(range, Arc::clone(detail), kept, &body_from_local));
        }
        Ok(dropped)
    }

    /// The materials that it uses, again and again.
    pub(crate) fn materials(&self) -> impl Iterator<Item = u32> {
        let of_triangles = self.triangles.iter().map(|triangle| triangle.material);
        of_triangles.chain(self.shapes.iter().map(|shape| shape.material))
    }

    /// The box around it, `None` if some of it is endless.
    pub(crate) fn extent(&self) -> Option<[DVec3; 2]> {
        let mut extent = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |point: DVec3| extent = [extent[0].min(point), extent[1].max(point)];
        self.triangles.iter().flat_map(|triangle| triangle.corners).for_each(|corner| include(corner.as_dvec3()));
        for shape in &self.shapes {
            shape.corners()?.into_iter().for_each(&mut include);
        }
        Some(extent)
    }
}

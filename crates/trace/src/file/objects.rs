//! Objects of a scene file: shapes, meshes and groups of both, each copied to its places.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use toml::Spanned;

use super::error::{Fault, FileError};
use super::mesh::Mesh;
use super::scatter;
use super::scene_file::Reader;
use super::spec::{ObjectSpec, PlacementSpec, ShapeSpec};
use crate::{MaterialId, SceneBuilder, Shape};

/// Adds objects to a scene.
pub(super) struct Objects<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) builder: &'a mut SceneBuilder,
    pub(super) materials: BTreeMap<String, MaterialId>,
    pub(super) meshes: BTreeMap<String, Mesh>,
}

/// What is copied.
enum Part {
    Shape {
        shape: Shape,
        material: MaterialId,
        object_from_local: DAffine3,
    },
    /// A mesh by its name, and what stands for each of its materials.
    Mesh {
        name: String,
        materials: Vec<MaterialId>,
        object_from_local: DAffine3,
    },
}

/// What an object or a part of a group is called by.
#[derive(Clone, Copy)]
struct Names<'a> {
    shape: Option<&'a Spanned<String>>,
    mesh: Option<&'a Spanned<String>>,
    material: Option<&'a Spanned<String>>,
}

impl Objects<'_> {
    /// Adds all copies of an object.
    pub(super) fn add(&mut self, object: &ObjectSpec) -> Result<(), FileError> {
        let parts = self.parts(object)?;
        let unplaced = [Spanned::new(0..0, PlacementSpec::default())];
        let placements = match (&object.placements, &object.scatter) {
            (Some(placements), _) => placements,
            (None, None) => unplaced.as_slice(),
            (None, Some(_)) => &[],
        };
        for placement in placements {
            let added = self.add_copy(&parts, world_from_placed(placement.get_ref()));
            added.map_err(|fault| self.reader.line(placement, fault.to_string()))?;
        }
        if let Some(scatter) = &object.scatter {
            let maps = scatter::placements(scatter.get_ref());
            let added = maps.and_then(|maps| maps.into_iter().try_for_each(|map| self.add_copy(&parts, map)));
            added.map_err(|fault| self.reader.line(scatter, fault.to_string()))?;
        }
        Ok(())
    }

    fn add_copy(&mut self, parts: &[Part], world_from_object: DAffine3) -> Result<(), Fault> {
        for part in parts {
            match part {
                Part::Shape { shape, material, object_from_local } => {
                    self.builder.shape(*shape, world_from_object * *object_from_local, *material)?;
                }
                Part::Mesh { name, materials, object_from_local } => {
                    let mesh = &self.meshes[name];
                    let material_of = |i: usize| materials[mesh.material_of[i] as usize];
                    let map = world_from_object * *object_from_local;
                    self.builder.detailed_mesh(&mesh.vertices, &mesh.triangles, material_of, map, &mesh.detail)?;
                }
            }
        }
        Ok(())
    }

    /// What an object consists of.
    fn parts(&mut self, object: &ObjectSpec) -> Result<Vec<Part>, FileError> {
        let ObjectSpec { shape, mesh, group, material, .. } = object;
        let Some(group) = group else {
            let names = Names { shape: shape.as_ref(), mesh: mesh.as_ref(), material: material.as_ref() };
            return Ok(vec![self.part(names, DAffine3::IDENTITY)?]);
        };
        if shape.is_some() || mesh.is_some() || material.is_some() {
            return Err(self.reader.line(group, "a group brings its own shapes, meshes and materials"));
        }
        let reader = self.reader;
        let parts = reader.find("group", group, &reader.spec.groups)?;
        let made = parts.iter().map(|part| {
            let names =
                Names { shape: part.shape.as_ref(), mesh: part.mesh.as_ref(), material: part.material.as_ref() };
            self.part(names, world_from_placed(&part.place))
        });
        made.collect()
    }

    fn part(&mut self, names: Names<'_>, object_from_placed: DAffine3) -> Result<Part, FileError> {
        let reader = self.reader;
        let own = names.material.map(|name| reader.find("material", name, &self.materials)).transpose()?.copied();
        match (names.shape, names.mesh) {
            (Some(name), None) => {
                let (shape, placed_from_local) = shape(reader.find("shape", name, &reader.spec.shapes)?);
                let material = own.ok_or_else(|| reader.line(name, "a shape needs a material"))?;
                Ok(Part::Shape { shape, material, object_from_local: object_from_placed * placed_from_local })
            }
            (None, Some(name)) => {
                let mesh = reader.find("mesh", name, &self.meshes)?;
                let theirs = mesh.materials.iter().zip(&mesh.finishes);
                let materials = theirs
                    .map(|(&material, finish)| own.unwrap_or_else(|| self.builder.finished(material, finish.clone())));
                let materials = materials.collect();
                Ok(Part::Mesh { name: name.get_ref().clone(), materials, object_from_local: object_from_placed })
            }
            _ => {
                let fault = Fault::Says("each object names either a shape or a mesh".to_owned());
                Err(reader.part("[[objects]]", &fault))
            }
        }
    }
}

/// Fails unless all lengths of a shape are positive and finite.
pub(super) fn check_size(spec: &ShapeSpec) -> Result<(), Fault> {
    let (_, placed_from_local) = shape(spec);
    let scale = placed_from_local.matrix3;
    let lengths = [scale.x_axis.x, scale.y_axis.y, scale.z_axis.z];
    if lengths.iter().all(|&length| length > 0.0 && length.is_finite()) {
        return Ok(());
    }
    Fault::says("sizes, radii and heights must be positive and finite")
}

/// The canonical shape, and its map to the size asked for.
fn shape(spec: &ShapeSpec) -> (Shape, DAffine3) {
    let (shape, scale) = match *spec {
        ShapeSpec::Plane { size: None } => (Shape::Plane, DVec3::ONE),
        ShapeSpec::Plane { size: Some([x, z]) } => (Shape::Rectangle, DVec3::new(0.5 * x, 1.0, 0.5 * z)),
        ShapeSpec::Box { size } => (Shape::Cuboid, 0.5 * size.0),
        ShapeSpec::Sphere { radius } => (Shape::Sphere, DVec3::splat(radius)),
        ShapeSpec::Cylinder { radius, height } => (Shape::Cylinder, DVec3::new(radius, height, radius)),
        ShapeSpec::Cone { radius, height } => (Shape::Cone, DVec3::new(radius, height, radius)),
    };
    (shape, DAffine3::from_scale(scale))
}

/// Scales, then turns about z, x and y in this order, then moves.
fn world_from_placed(spec: &PlacementSpec) -> DAffine3 {
    let [x, y, z] = spec.rotate_deg.unwrap_or_default().map(f64::to_radians);
    DAffine3::from_scale_rotation_translation(
        spec.scale.map_or(DVec3::ONE, |scale| scale.0),
        DQuat::from_euler(EulerRot::YXZ, y, x, z),
        DVec3::from_array(spec.translate.unwrap_or_default()),
    )
}

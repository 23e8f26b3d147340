//! Objects of a scene file: shapes, meshes and groups of both, each copied to its places.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use toml::Spanned;

use super::error::{Fault, FileError};
use super::mesh::Mesh;
use super::scatter;
use super::scene_file::Reader;
use super::spec::{EaseSpec, MoveSpec, ObjectSpec, PlacementSpec, ShapeSpec};
use crate::motion::{self, Motion, MoveKey, Moves};
use crate::{Body, BodyId, MaterialId, SceneBuilder, Shape};

/// Adds objects to a scene.
pub(super) struct Objects<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) builder: &'a mut SceneBuilder,
    pub(super) materials: BTreeMap<String, MaterialId>,
    pub(super) meshes: BTreeMap<String, Mesh>,
}

/// What is copied.
struct Part {
    what: What,
    /// Placed from its own space, and object from placed; it goes its own way in between.
    inner: DAffine3,
    outer: DAffine3,
    moves: Option<Arc<Moves>>,
}

enum What {
    Shape {
        shape: Shape,
        material: MaterialId,
    },
    /// A mesh by its name, and what stands for each of its materials.
    Mesh {
        name: String,
        materials: Vec<MaterialId>,
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
        let moves = self.moves(object.moves.as_ref(), object.ease)?;
        let unplaced = [Spanned::new(0..0, PlacementSpec::default())];
        let placements = match (&object.placements, &object.scatter) {
            (Some(placements), _) => placements,
            (None, None) => unplaced.as_slice(),
            (None, Some(_)) => &[],
        };
        let mut bodies = BTreeMap::new();
        for placement in placements {
            let PlacementSpec { moves: own, ease, .. } = placement.get_ref();
            let own = self.moves(own.as_ref(), *ease)?;
            let moves: Vec<_> = own.iter().chain(&moves).collect();
            let added = self.add_copy(&parts, world_from_placed(placement.get_ref()), &moves, &mut bodies);
            added.map_err(|fault| self.reader.line(placement, fault.to_string()))?;
        }
        if let Some(scatter) = &object.scatter {
            let maps = scatter::placements(scatter.get_ref());
            let moves: Vec<_> = moves.iter().collect();
            let mut copy = |map| self.add_copy(&parts, map, &moves, &mut bodies);
            let added = maps.and_then(|maps| maps.into_iter().try_for_each(&mut copy));
            added.map_err(|fault| self.reader.line(scatter, fault.to_string()))?;
        }
        Ok(())
    }

    /// The way that is written somewhere, if one is.
    fn moves(
        &self,
        keys: Option<&Spanned<Vec<MoveSpec>>>,
        ease: Option<EaseSpec>,
    ) -> Result<Option<Arc<Moves>>, FileError> {
        let Some(keys) = keys else { return Ok(None) };
        let key = |spec: &MoveSpec| MoveKey {
            frame: spec.frame,
            translate: spec.translate.map(DVec3::from_array),
            rotate: spec.rotate_deg.map(|angles| DVec3::from_array(angles.map(f64::to_radians))),
            scale: spec.scale.map(|scale| scale.0),
        };
        let list: Vec<_> = keys.get_ref().iter().map(key).collect();
        let moves = Moves::new(&list, matches!(ease, Some(EaseSpec::Smooth)));
        moves.map(|moves| Some(Arc::new(moves))).map_err(|error| self.reader.line(keys, error.to_string()))
    }

    /// Adds a copy that goes through `moves` in the place where it is put; `bodies` has those that copies before it are made of.
    fn add_copy(
        &mut self,
        parts: &[Part],
        world_from_object: DAffine3,
        moves: &[&Arc<Moves>],
        bodies: &mut BTreeMap<usize, BodyId>,
    ) -> Result<(), Fault> {
        let whole = moves.iter().fold(Motion::new().placed(world_from_object), |motion, moves| motion.moved(moves));
        // What goes as the whole does makes one body, each part with a way of its own another
        let goes_along = |part: &Part| part.moves.is_none();
        for (i, part) in parts.iter().enumerate().filter(|(_, part)| !goes_along(part)) {
            let body = self.body(bodies, i, std::iter::once((part, part.inner)))?;
            let motion = whole.clone().placed(part.outer);
            self.builder.moving(body, part.moves.iter().fold(motion, Motion::moved))?;
        }
        let along = parts.iter().filter(|part| goes_along(part));
        if whole.moves() {
            let body = self.body(bodies, usize::MAX, along.map(|part| (part, part.outer * part.inner)))?;
            return Ok(self.builder.moving(body, whole)?);
        }
        for part in along {
            put(self.builder.still(), &self.meshes, part, world_from_object * (part.outer * part.inner))?;
        }
        Ok(())
    }

    /// The body of some parts, made once.
    fn body<'p>(
        &mut self,
        bodies: &mut BTreeMap<usize, BodyId>,
        key: usize,
        parts: impl Iterator<Item = (&'p Part, DAffine3)>,
    ) -> Result<BodyId, Fault> {
        if let Some(&body) = bodies.get(&key) {
            return Ok(body);
        }
        let mut body = Body::new();
        for (part, map) in parts {
            put(&mut body, &self.meshes, part, map)?;
        }
        let body = self.builder.body(body);
        bodies.insert(key, body);
        Ok(body)
    }

    /// What an object consists of.
    fn parts(&mut self, object: &ObjectSpec) -> Result<Vec<Part>, FileError> {
        let ObjectSpec { shape, mesh, group, material, .. } = object;
        let Some(group) = group else {
            let names = Names { shape: shape.as_ref(), mesh: mesh.as_ref(), material: material.as_ref() };
            return Ok(vec![self.part(names, DAffine3::IDENTITY, None)?]);
        };
        if shape.is_some() || mesh.is_some() || material.is_some() {
            return Err(self.reader.line(group, "a group brings its own shapes, meshes and materials"));
        }
        let reader = self.reader;
        let parts = reader.find("group", group, &reader.spec.groups)?;
        let made = parts.iter().map(|part| {
            let names =
                Names { shape: part.shape.as_ref(), mesh: part.mesh.as_ref(), material: part.material.as_ref() };
            let moves = self.moves(part.place.moves.as_ref(), part.place.ease)?;
            self.part(names, world_from_placed(&part.place), moves)
        });
        made.collect()
    }

    fn part(&mut self, names: Names<'_>, outer: DAffine3, moves: Option<Arc<Moves>>) -> Result<Part, FileError> {
        let reader = self.reader;
        let own = names.material.map(|name| reader.find("material", name, &self.materials)).transpose()?.copied();
        let (what, inner) = match (names.shape, names.mesh) {
            (Some(name), None) => {
                let (shape, placed_from_local) = shape(reader.find("shape", name, &reader.spec.shapes)?);
                let material = own.ok_or_else(|| reader.line(name, "a shape needs a material"))?;
                (What::Shape { shape, material }, placed_from_local)
            }
            (None, Some(name)) => {
                let mesh = reader.find("mesh", name, &self.meshes)?;
                let theirs = mesh.materials.iter().zip(&mesh.finishes);
                let materials = theirs
                    .map(|(&material, finish)| own.unwrap_or_else(|| self.builder.finished(material, finish.clone())));
                (What::Mesh { name: name.get_ref().clone(), materials: materials.collect() }, DAffine3::IDENTITY)
            }
            _ => {
                let fault = Fault::Says("each object names either a shape or a mesh".to_owned());
                return Err(reader.part("[[objects]]", &fault));
            }
        };
        Ok(Part { what, inner, outer, moves })
    }
}

/// Adds a part to a body.
fn put(body: &mut Body, meshes: &BTreeMap<String, Mesh>, part: &Part, map: DAffine3) -> Result<(), Fault> {
    match &part.what {
        What::Shape { shape, material } => body.shape(*shape, map, *material)?,
        What::Mesh { name, materials } => {
            let mesh = &meshes[name];
            let material_of = |i: usize| materials[mesh.material_of[i] as usize];
            body.detailed_mesh(&mesh.vertices, &mesh.triangles, material_of, map, &mesh.detail)?;
        }
    }
    Ok(())
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
    let angles = DVec3::from_array(spec.rotate_deg.unwrap_or_default().map(f64::to_radians));
    let translate = DVec3::from_array(spec.translate.unwrap_or_default());
    motion::map(spec.scale.map_or(DVec3::ONE, |scale| scale.0), angles, translate)
}

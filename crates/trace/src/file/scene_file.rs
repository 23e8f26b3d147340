//! A scene file, read and checked.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use toml::Spanned;

use super::animation::Animation;
use super::error::{Fault, FileError};
use super::mesh::Mesh;
use super::shot::{Shot, ShotTables};
use super::spec::{
    AxesSpec, FileSpec, LightSpec, MaterialSpec, MeshSpec, ObjectSpec, PlacementSpec, ShapeSpec, ShotSpec,
};
use crate::{Light, Material, MaterialId, Pigment, Scene, SceneBuilder, Shape};

/// A scene and its shots, from a TOML file.
#[derive(Debug, Clone)]
pub struct SceneFile {
    path: PathBuf,
    description: String,
    scene: Scene,
    fingerprint: u32,
    base: Option<Shot>,
    shots: BTreeMap<String, Shot>,
    animated: BTreeMap<String, Animated>,
}

/// A shot that moves.
#[derive(Debug, Clone)]
struct Animated {
    description: String,
    tables: ShotTables,
    animation: Animation,
}

impl SceneFile {
    /// Reads a file and the meshes it names; every shot is checked.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        refuse_special(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        let text = std::fs::read_to_string(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        Self::parse(&text, path)
    }

    /// Reads a scene from text; `path` is what errors call it, and meshes are looked for beside it.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        let spec: FileSpec =
            toml::from_str(text).map_err(|source| FileError::Syntax { path: path.into(), source: Box::new(source) })?;
        if spec.format != 1 {
            return Err(FileError::Version { path: path.into(), found: spec.format });
        }
        let reader = Reader { path, text, spec: &spec };
        let tables = ShotTables { camera: spec.camera.clone(), lens: spec.lens.clone(), film: spec.film.clone() };
        let base = if tables.is_given() {
            let shot = tables.resolve(&spec.description, spec.metres_per_unit);
            Some(shot.map_err(|fault| reader.part("[camera], [lens], [film]", &fault))?)
        } else {
            None
        };
        let (mut shots, mut animated) = (BTreeMap::new(), BTreeMap::new());
        for (name, shot) in &spec.shots {
            let part = format!("[shots.{name}]");
            let (tables, animation) = reader.shot_tables(shot, &tables)?;
            let animation = animation.map_err(|fault| reader.part(&part, &fault))?;
            let resolved = match animation {
                None => tables.resolve(&shot.description, spec.metres_per_unit),
                Some(animation) => {
                    let moving = Animated { description: shot.description.clone(), tables, animation };
                    // Every frame must be one: find out now, not in the middle of the night
                    for frame in moving.animation.frames() {
                        let resolved = moving.at(frame, spec.metres_per_unit);
                        resolved.map_err(|fault| reader.part(&format!("{part}, frame {frame}"), &fault))?;
                    }
                    let first = moving.at(*moving.animation.frames().start(), spec.metres_per_unit);
                    animated.insert(name.clone(), moving);
                    first
                }
            };
            shots.insert(name.clone(), resolved.map_err(|fault| reader.part(&part, &fault))?);
        }
        let (scene, fingerprint) = reader.scene()?;
        let description = spec.description.clone();
        Ok(Self { path: path.into(), description, scene, fingerprint, base, shots, animated })
    }

    /// What the file says about itself.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// A checksum of the scene, shots, cameras and comments aside: scenes that differ have different ones, but for one in
    /// 4 billion.
    #[must_use]
    pub fn fingerprint(&self) -> u32 {
        self.fingerprint
    }

    /// The frames of a shot that moves, from its first key to its last.
    #[must_use]
    pub fn frames(&self, shot: &str) -> Option<RangeInclusive<i64>> {
        Some(self.animated.get(shot)?.animation.frames())
    }

    /// A shot in one of its frames; before its first key and after its last it stands still, and one without keys always
    /// does.
    pub fn shot_at(&self, name: &str, frame: i64) -> Result<Shot, FileError> {
        let Some(moving) = self.animated.get(name) else { return self.shot(Some(name)).cloned() };
        let part = format!("[shots.{name}], frame {frame}");
        let fault = |fault: Fault| FileError::Part { path: self.path.clone(), part, message: fault.to_string() };
        moving.at(frame, self.scene.metres_per_unit()).map_err(fault)
    }

    /// The shots by name; of one that moves the first frame.
    #[must_use]
    pub fn shots(&self) -> &BTreeMap<String, Shot> {
        &self.shots
    }

    /// The named shot; without a name the file's own camera, lens and film.
    pub fn shot(&self, name: Option<&str>) -> Result<&Shot, FileError> {
        let shot = match name {
            Some(name) => self.shots.get(name),
            None => self.base.as_ref(),
        };
        shot.ok_or_else(|| FileError::NoSuchShot {
            path: self.path.clone(),
            name: name.unwrap_or("(the file's own camera)").to_owned(),
            known: names(&self.shots),
        })
    }
}

impl Animated {
    fn at(&self, frame: i64, metres_per_unit: Option<f64>) -> Result<Shot, Fault> {
        self.animation.over(&self.tables, frame)?.resolve(&self.description, metres_per_unit)
    }
}

/// A file's text and what was read from it.
struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
    spec: &'a FileSpec,
}

impl Reader<'_> {
    fn part(&self, part: &str, fault: &Fault) -> FileError {
        FileError::Part { path: self.path.into(), part: part.to_owned(), message: fault.to_string() }
    }

    fn line<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> FileError {
        let before = self.text.get(..at.span().start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        FileError::Line { path: self.path.into(), line, message: message.into() }
    }

    /// What a reference names, or an error that lists what there is.
    fn find<'m, T>(
        &self,
        kind: &str,
        name: &Spanned<String>,
        known: &'m BTreeMap<String, T>,
    ) -> Result<&'m T, FileError> {
        known.get(name.get_ref()).ok_or_else(|| {
            self.line(name, format!("there is no {kind} {:?} (there are: {})", name.get_ref(), names(known)))
        })
    }

    /// A shot's tables over those of the shots it builds on, over the file's, and the keys of the nearest that has some.
    fn shot_tables(
        &self,
        shot: &ShotSpec,
        base: &ShotTables,
    ) -> Result<(ShotTables, Result<Option<Animation>, Fault>), FileError> {
        // Follow the chain to its end
        let mut chain = vec![shot];
        while let Some(from) = chain.last().and_then(|shot| shot.from.as_ref()) {
            if chain.len() > self.spec.shots.len() {
                return Err(self.line(from, "these shots build on each other in a circle"));
            }
            chain.push(self.find("shot", from, &self.spec.shots)?);
        }
        let tables = chain.iter().rev().fold(base.clone(), |base, shot| ShotTables {
            camera: shot.camera.over(&base.camera),
            lens: shot.lens.over(&base.lens),
            film: shot.film.over(&base.film),
        });
        let ease = chain.iter().find_map(|shot| shot.ease).unwrap_or_default();
        let moving = chain.iter().find(|shot| !shot.keys.is_empty());
        Ok((tables, moving.map(|shot| Animation::new(&shot.keys, ease)).transpose()))
    }

    /// The scene and its fingerprint.
    fn scene(&self) -> Result<(Scene, u32), FileError> {
        let mut fingerprint = crc32fast::Hasher::new();
        fingerprint.update(self.what_is_seen().as_bytes());
        let mut builder = SceneBuilder::new();
        if let Some(metres) = self.spec.metres_per_unit {
            builder.metres_per_unit(metres).map_err(|error| self.part("metres_per_unit", &error.into()))?;
        }
        if let Some(sky) = self.spec.sky {
            builder.sky(sky.0.as_vec3());
        }
        builder.shadow_bias(self.spec.shadow_bias).map_err(|error| self.part("shadow_bias", &error.into()))?;
        for (name, light) in &self.spec.lights {
            let light = self::light(light).map_err(|fault| self.part(&format!("[lights.{name}]"), &fault))?;
            builder.light(light);
        }
        let mut materials = BTreeMap::new();
        for (name, spec) in &self.spec.materials {
            let material = material(spec).map_err(|fault| self.part(&format!("[materials.{name}]"), &fault))?;
            materials.insert(name.clone(), builder.material(material));
        }
        for (name, spec) in &self.spec.shapes {
            check_size(spec).map_err(|fault| self.part(&format!("[shapes.{name}]"), &fault))?;
        }
        let mut meshes = BTreeMap::new();
        for (name, spec) in &self.spec.meshes {
            let mesh = self.mesh(name, spec)?;
            mesh.add_to(&mut fingerprint);
            meshes.insert(name.clone(), mesh);
        }
        for object in &self.spec.objects {
            self.add_object(&mut builder, object, &materials, &meshes)?;
        }
        let scene = builder.build().map_err(|error| self.part("the scene", &error.into()))?;
        Ok((scene, fingerprint.finalize()))
    }

    /// The file's text without what only says how it is seen; its tables sorted by name.
    fn what_is_seen(&self) -> String {
        let mut table: toml::Table = self.text.parse().unwrap_or_default();
        for key in ["description", "camera", "lens", "film", "shots"] {
            table.remove(key);
        }
        table.to_string()
    }

    fn mesh(&self, name: &str, spec: &MeshSpec) -> Result<Mesh, FileError> {
        match (&spec.file, &spec.vertices, &spec.triangles) {
            (Some(file), None, None) => Mesh::read(&self.path.parent().unwrap_or(Path::new("")).join(file)),
            (None, Some(vertices), Some(triangles)) => {
                let mut mesh = Mesh { triangles: triangles.clone(), ..Mesh::default() };
                mesh.vertices = vertices.iter().map(|&v| DVec3::from_array(v)).collect();
                let plain = mesh.add_default_material();
                mesh.material_of = vec![plain; triangles.len()];
                Ok(mesh)
            }
            _ => {
                let fault = Fault::Says("a mesh needs a file, or vertices and triangles".to_owned());
                Err(self.part(&format!("[meshes.{name}]"), &fault))
            }
        }
    }

    fn add_object(
        &self,
        builder: &mut SceneBuilder,
        object: &ObjectSpec,
        materials: &BTreeMap<String, MaterialId>,
        meshes: &BTreeMap<String, Mesh>,
    ) -> Result<(), FileError> {
        let own_material = object.material.as_ref().map(|name| self.find("material", name, materials)).transpose()?;
        let unplaced = [Spanned::new(0..0, PlacementSpec::default())];
        let placements = object.placements.as_deref().unwrap_or(&unplaced);
        match (&object.shape, &object.mesh) {
            (Some(name), None) => {
                let (shape, placed_from_local) = shape(self.find("shape", name, &self.spec.shapes)?);
                let material = *own_material.ok_or_else(|| self.line(name, "a shape needs a material"))?;
                for placement in placements {
                    let world_from_local = world_from_placed(placement.get_ref()) * placed_from_local;
                    let added = builder.shape(shape, world_from_local, material);
                    added.map_err(|error| self.line(placement, error.to_string()))?;
                }
            }
            (None, Some(name)) => {
                let mesh = self.find("mesh", name, meshes)?;
                let theirs: Vec<MaterialId> = match own_material {
                    Some(_) => Vec::new(),
                    None => mesh.materials.iter().map(|&material| builder.material(material)).collect(),
                };
                let material_of =
                    |i: usize| own_material.copied().unwrap_or_else(|| theirs[mesh.material_of[i] as usize]);
                for placement in placements {
                    let map = world_from_placed(placement.get_ref());
                    let added = builder.mesh(&mesh.vertices, &mesh.triangles, material_of, map);
                    added.map_err(|error| self.line(placement, error.to_string()))?;
                }
            }
            _ => {
                let fault = Fault::Says("each object names either a shape or a mesh".to_owned());
                return Err(self.part("[[objects]]", &fault));
            }
        }
        Ok(())
    }
}

/// The names of a table, for an error.
fn names<T>(table: &BTreeMap<String, T>) -> String {
    if table.is_empty() { "none".to_owned() } else { table.keys().cloned().collect::<Vec<_>>().join(", ") }
}

fn light(spec: &LightSpec) -> Result<Light, Fault> {
    Ok(match *spec {
        LightSpec::Ambient { strength } => Light::Ambient { strength: strength.0.as_vec3() },
        LightSpec::Sun { toward, strength } => Light::sun(DVec3::from_array(toward), strength.0.as_vec3())?,
    })
}

fn material(spec: &MaterialSpec) -> Result<Material, Fault> {
    let pigment = match (&spec.color, &spec.checker) {
        (Some(_), Some(_)) => return Fault::says("give a color or a checker, not both"),
        (None, None) if spec.emission.is_none() => return Fault::says("give a color, a checker or an emission"),
        (None, None) => Pigment::Constant(Vec3::ZERO),
        (Some(color), None) => Pigment::Constant(color.0.as_vec3()),
        (None, Some(checker)) => Pigment::Checker {
            colors: checker.colors.map(|color| color.0.as_vec3()),
            side: checker.side,
            axes: match checker.axes {
                AxesSpec::Xz => [0, 2],
                AxesSpec::Xy => [0, 1],
                AxesSpec::Yz => [1, 2],
            },
        },
    };
    Ok(Material { pigment, emission: spec.emission.map_or(Vec3::ZERO, |emission| emission.0.as_vec3()) })
}

/// Fails unless all lengths of a shape are positive and finite.
fn check_size(spec: &ShapeSpec) -> Result<(), Fault> {
    let (_, placed_from_local) = shape(spec);
    let scale = placed_from_local.matrix3;
    let lengths = [scale.x_axis.x, scale.y_axis.y, scale.z_axis.z];
    if lengths.iter().all(|&length| length > 0.0 && length.is_finite()) {
        return Ok(());
    }
    Fault::says("sizes, radii and heights must be positive and finite")
}

/// Fails for what is no file but a folder, a pipe or a device, of which there may be no end.
pub(super) fn refuse_special(path: &Path) -> std::io::Result<()> {
    if std::fs::metadata(path)?.is_file() {
        return Ok(());
    }
    Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a regular file"))
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

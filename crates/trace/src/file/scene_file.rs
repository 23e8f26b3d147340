//! A scene file, read and checked.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use glam::DVec3;
use toml::Spanned;

use super::animation::Animation;
use super::error::{Fault, FileError};
use super::looks;
use super::mesh::Mesh;
use super::model::Model;
use super::model_view;
use super::objects::{self, Objects};
use super::shot::{Shot, ShotTables};
use super::spec::{FileSpec, MeshSpec, ShotSpec};
use super::take::{FEW_STEPS, Take};
use crate::{Scene, SceneBuilder};

/// What a user wants otherwise than a scene file or model says.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wishes {
    /// How often light goes from surface to surface; what the scene needs without.
    pub bounces: Option<u32>,
    /// Metres in one unit of a model file; 1 without.
    pub metres_per_unit: Option<f64>,
    /// How many frames the shutter is open, about each frame; what a shot says without.
    pub shutter: Option<f64>,
}

/// A scene and its shots, from a TOML file.
#[derive(Debug, Clone)]
pub struct SceneFile {
    path: PathBuf,
    description: String,
    scene: Scene,
    fingerprint: u32,
    base: Option<Shot>,
    shots: BTreeMap<String, Shot>,
    takes: BTreeMap<String, Take>,
    warnings: Vec<String>,
}

impl SceneFile {
    /// Reads a file and the meshes it names; every shot is checked.
    ///
    /// A glTF or OBJ file is a scene too, under its own lights or a sun and a sky, with a shot `cameraN` for each of its
    /// perspective cameras; without a name the first of those is taken, or a view of all of it.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::open_with(path, &Wishes::default())
    }

    /// The same with what a user wants otherwise.
    pub fn open_with(path: impl AsRef<Path>, wishes: &Wishes) -> Result<Self, FileError> {
        let path = path.as_ref();
        if Model::is_one(path) {
            return model_view::open(path, wishes);
        }
        refuse_special(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        let text = std::fs::read_to_string(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        Self::parse_with(&text, path, wishes)
    }

    /// Reads a scene from text; `path` is what errors call it, and meshes are looked for beside it.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::parse_with(text, path.as_ref(), &Wishes::default())
    }

    fn parse_with(text: &str, path: &Path, wishes: &Wishes) -> Result<Self, FileError> {
        let spec: FileSpec =
            toml::from_str(text).map_err(|source| FileError::Syntax { path: path.into(), source: Box::new(source) })?;
        if spec.format != 1 {
            return Err(FileError::Version { path: path.into(), found: spec.format });
        }
        let reader = Reader { path, text, spec: &spec };
        let take = |description: &str, tables: ShotTables, animation: Option<Animation>| {
            let (description, metres_per_unit) = (description.to_owned(), spec.metres_per_unit);
            Take { description, tables, animation, metres_per_unit, shutter: wishes.shutter }
        };
        let tables = ShotTables { camera: spec.camera.clone(), lens: spec.lens.clone(), film: spec.film.clone() };
        let base = if tables.is_given() {
            let shot = take(&spec.description, tables.clone(), None).still();
            Some(shot.map_err(|fault| reader.part("[camera], [lens], [film]", &fault))?)
        } else {
            None
        };
        let (mut shots, mut takes) = (BTreeMap::new(), BTreeMap::new());
        for (name, shot) in &spec.shots {
            let part = format!("[shots.{name}]");
            let (tables, animation) = reader.shot_tables(shot, &tables)?;
            let animation = animation.map_err(|fault| reader.part(&part, &fault))?;
            let taken = take(&shot.description, tables, animation);
            // Every frame must be one: find out now, not in the middle of the night
            for frame in taken.frames().into_iter().flatten() {
                let resolved = taken.in_steps(frame as f64, FEW_STEPS);
                resolved.map_err(|fault| reader.part(&format!("{part}, frame {frame}"), &fault))?;
            }
            shots.insert(name.clone(), taken.still().map_err(|fault| reader.part(&part, &fault))?);
            takes.insert(name.clone(), taken);
        }
        let (scene, fingerprint, warnings) = reader.scene(wishes)?;
        let description = spec.description.clone();
        Ok(Self { path: path.into(), description, scene, fingerprint, base, shots, takes, warnings })
    }

    /// A scene that is no TOML.
    pub(super) fn of_model(
        path: &Path,
        (description, warnings): (String, Vec<String>),
        (scene, fingerprint): (Scene, u32),
        base: Option<Shot>,
        shots: BTreeMap<String, Shot>,
    ) -> Self {
        Self { path: path.into(), description, scene, fingerprint, base, shots, takes: BTreeMap::new(), warnings }
    }

    /// What was wrong with the files but could be lived with, a sentence each.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What the file says about itself.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The scene; what moves in it stands as in frame 0.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as it is while a shot is taken.
    #[must_use]
    pub fn scene_of(&self, shot: &Shot) -> Scene {
        self.scene.exposed(&shot.exposure)
    }

    /// A checksum of the scene, shots, cameras and comments aside: scenes that differ have different ones, but for one in
    /// 4 billion.
    #[must_use]
    pub fn fingerprint(&self) -> u32 {
        self.fingerprint
    }

    /// The same of the scene while a shot is taken: where something moves its exposure counts too.
    #[must_use]
    pub fn fingerprint_of(&self, shot: &Shot) -> u32 {
        if self.scene.frames().is_none() && !shot.exposure.moves_camera() {
            return self.fingerprint;
        }
        let mut fingerprint = crc32fast::Hasher::new();
        fingerprint.update(format!("{} {:?}", self.fingerprint, shot.exposure).as_bytes());
        fingerprint.finalize()
    }

    /// The frames of a shot that moves, from its first key to its last; of one whose camera stands still those of the things
    /// that move.
    #[must_use]
    pub fn frames(&self, shot: &str) -> Option<RangeInclusive<i64>> {
        let of_things = || self.scene.frames().map(|[first, last]| first.floor() as i64..=last.ceil() as i64);
        self.takes.get(shot)?.frames().or_else(of_things)
    }

    /// A shot in one of its frames; before its first key and after its last its camera stands still, and that of one without
    /// keys always does.
    pub fn shot_at(&self, name: &str, frame: i64) -> Result<Shot, FileError> {
        let Some(take) = self.takes.get(name) else { return self.shot(Some(name)).cloned() };
        let part = format!("[shots.{name}], frame {frame}");
        let fault = |fault: Fault| FileError::Part { path: self.path.clone(), part, message: fault.to_string() };
        take.at(frame as f64).map_err(fault)
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

/// A file's text and what was read from it.
pub(super) struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
    pub(super) spec: &'a FileSpec,
}

impl Reader<'_> {
    pub(super) fn part(&self, part: &str, fault: &Fault) -> FileError {
        FileError::Part { path: self.path.into(), part: part.to_owned(), message: fault.to_string() }
    }

    pub(super) fn line<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> FileError {
        let before = self.text.get(..at.span().start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        FileError::Line { path: self.path.into(), line, message: message.into() }
    }

    /// What a reference names, or an error that lists what there is.
    pub(super) fn find<'m, T>(
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

    /// The scene, its fingerprint, and what was wrong with its meshes.
    fn scene(&self, wishes: &Wishes) -> Result<(Scene, u32, Vec<String>), FileError> {
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
            let light = looks::light(light).map_err(|fault| self.part(&format!("[lights.{name}]"), &fault))?;
            builder.light(light);
        }
        let mut materials = BTreeMap::new();
        for (name, spec) in &self.spec.materials {
            let looks = looks::material(name, spec);
            let (material, finish) = looks.map_err(|fault| self.part(&format!("[materials.{name}]"), &fault))?;
            materials.insert(name.clone(), builder.finished(material, finish));
        }
        for (name, spec) in &self.spec.shapes {
            objects::check_size(spec).map_err(|fault| self.part(&format!("[shapes.{name}]"), &fault))?;
        }
        let mut meshes = BTreeMap::new();
        let mut warnings = Vec::new();
        for (name, spec) in &self.spec.meshes {
            let mesh = self.mesh(name, spec)?;
            mesh.add_to(&mut fingerprint);
            warnings.extend(mesh.warnings.iter().map(|warning| format!("mesh {name:?}: {warning}")));
            meshes.insert(name.clone(), mesh);
        }
        if let Some(spec) = &self.spec.environment {
            let environment = looks::environment(spec, &self.beside(&spec.file));
            let environment = environment.map_err(|fault| self.part("[environment]", &fault))?;
            environment.add_to(&mut fingerprint);
            builder.environment(environment);
        }
        if let Some(bounces) = wishes.bounces.or(self.spec.render.bounces) {
            builder.bounces(bounces).map_err(|error| self.part("[render]", &error.into()))?;
        }
        if let Some(bounces) = wishes.bounces {
            fingerprint.update(&bounces.to_le_bytes());
        }
        let mut objects = Objects { reader: self, builder: &mut builder, materials, meshes };
        for object in &self.spec.objects {
            objects.add(object)?;
        }
        let scene = builder.build().map_err(|error| self.part("the scene", &error.into()))?;
        Ok((scene, fingerprint.finalize(), warnings))
    }

    /// Where a file lies that this one names.
    fn beside(&self, file: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
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
            (Some(file), None, None) => {
                let mut mesh = Mesh::read(&self.beside(file))?;
                if spec.smooth == Some(false) {
                    mesh.forget_normals();
                }
                Ok(mesh)
            }
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
}

/// The names of a table, for an error.
fn names<T>(table: &BTreeMap<String, T>) -> String {
    if table.is_empty() { "none".to_owned() } else { table.keys().cloned().collect::<Vec<_>>().join(", ") }
}

/// Fails for what is no file but a folder, a pipe or a device, of which there may be no end.
pub(super) fn refuse_special(path: &Path) -> std::io::Result<()> {
    if std::fs::metadata(path)?.is_file() {
        return Ok(());
    }
    Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a regular file"))
}

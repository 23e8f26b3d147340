//! A model file as a scene: light and a view where it has none.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DVec2, DVec3, Vec3};
use optics::{Camera, Film, Focus, Iris, Pose};

use super::error::{Fault, FileError};
use super::model::{Model, ModelCamera};
use super::scene_file::{SceneFile, Wishes};
use super::shot::Shot;
use crate::{Exposure, Light, Scene, SceneBuilder};

/// Pixels of a picture, where nobody says how many.
const SIZE: [u32; 2] = [1280, 720];
/// Horizontal field of view of a view of all of it, in degrees: a short telephoto lens.
const VIEW_DEG: f64 = 40.0;
/// From where all of it is seen: the right, above, in front.
const FROM: DVec3 = DVec3::new(0.75, 0.5, 1.0);

/// Daylight for a model without lights: the sun comes over the viewer's left shoulder.
const TOWARD_SUN: DVec3 = DVec3::new(-0.25, 1.0, 0.8);
const SUN: Vec3 = Vec3::new(0.8, 0.77, 0.7);
const SKY: Vec3 = Vec3::new(0.42, 0.52, 0.68);
/// What lights shadows where light does not bounce.
const FILL: Vec3 = Vec3::new(0.22, 0.25, 0.3);
/// Sky around a model that brings its own lights.
const DUSK: Vec3 = Vec3::new(0.02, 0.024, 0.03);

/// Opens a model file as a scene.
pub(super) fn open(path: &Path, wishes: &Wishes) -> Result<SceneFile, FileError> {
    let mut model = Model::read(path)?;
    let fault = |fault: Fault| FileError::Mesh { path: path.to_owned(), message: fault.to_string() };
    let Some(bounds) = model.bounds() else {
        return Err(fault(Fault::Says("it has no triangles to be seen".to_owned())));
    };
    let (scene, fingerprint) = scene(&model, wishes).map_err(fault)?;

    // A shot for each camera, and one without a name
    let mut shots = BTreeMap::new();
    for (number, camera) in model.cameras.iter().enumerate() {
        match shot_of(camera, &bounds) {
            Ok(shot) => _ = shots.insert(format!("camera{number}"), shot),
            Err(reason) => model.mesh.warnings.push(format!("camera {number} is left out: {reason}")),
        }
    }
    let base = match shots.values().next() {
        Some(first) => first.clone(),
        None => view_of(&bounds).map_err(fault)?,
    };
    let description = format!(
        "{} ({} triangles)",
        path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        model.mesh.triangles.len()
    );
    let words = (description, std::mem::take(&mut model.mesh.warnings));
    Ok(SceneFile::of_model(path, words, (scene, fingerprint), Some(base), shots))
}

fn scene(model: &Model, wishes: &Wishes) -> Result<(Scene, u32), Fault> {
    let mesh = &model.mesh;
    let mut fingerprint = crc32fast::Hasher::new();
    mesh.add_to(&mut fingerprint);
    let Wishes { bounces, metres_per_unit, .. } = wishes;
    fingerprint.update(format!("{:?} {bounces:?} {metres_per_unit:?}", model.lights).as_bytes());

    let mut builder = SceneBuilder::new();
    builder.metres_per_unit(wishes.metres_per_unit.unwrap_or(1.0))?;
    let materials = mesh.materials.iter().zip(&mesh.finishes);
    let materials: Vec<_> = materials.map(|(&material, finish)| builder.finished(material, finish.clone())).collect();
    let material_of = |i: usize| materials[mesh.material_of[i] as usize];
    builder.detailed_mesh(&mesh.vertices, &mesh.triangles, material_of, DAffine3::IDENTITY, &mesh.detail)?;
    if let Some(bounces) = wishes.bounces {
        builder.bounces(bounces)?;
    }

    // Light it as it says, or by day
    let glows = mesh.material_of.iter().any(|&i| mesh.finishes[i as usize].is_light);
    if !model.lights.is_empty() || glows {
        builder.sky(DUSK);
        model.lights.iter().for_each(|&light| builder.light(light));
    } else {
        builder.sky(SKY);
        builder.light(Light::sun(TOWARD_SUN, SUN)?);
        if builder.needs().0 == 0 {
            builder.light(Light::Ambient { strength: FILL });
        }
    }
    Ok((builder.build()?, fingerprint.finalize()))
}

/// What a camera of the file sees.
fn shot_of(source: &ModelCamera, [low, high]: &[DVec3; 2]) -> Result<Shot, String> {
    let (fov, aspect) = source.view.ok_or("it is orthographic; only perspective ones can be taken")?;
    let map = source.world_from_camera.ok_or("no node of the scene has it")?;
    if !(fov > 0.0 && fov < std::f64::consts::PI) || aspect.is_some_and(|aspect| !(0.01..=100.0).contains(&aspect)) {
        return Err("its field of view or aspect ratio cannot be".to_owned());
    }
    let [width, height] = SIZE;
    let aspect = aspect.unwrap_or(f64::from(width) / f64::from(height));
    let height = (f64::from(width) / aspect).round().clamp(1.0, 16_384.0) as u32;
    let half = (0.5 * fov).tan();
    let position = map.translation;
    let shot = || -> Result<Shot, Fault> {
        let pose = Pose::look_at(position, position - map.matrix3.z_axis, map.matrix3.y_axis)?;
        let film = Film::new(-DVec2::new(half * aspect, half), DVec2::new(half * aspect, half), width, height)?;
        let distance = pose.point_to_camera(0.5 * (*low + *high)).z;
        let focus = Focus::at_depth(if distance > 0.0 { distance } else { f64::INFINITY })?;
        let camera = Camera { pose, film, focus, iris: Iris::pinhole() };
        let name = if source.name.is_empty() { "a camera of the file" } else { &source.name };
        Ok(Shot { description: name.to_owned(), camera, lens: None, exposure: Exposure::default() })
    };
    shot().map_err(|fault| fault.to_string())
}

/// All of it, seen from the right, above and in front, from as near as its box allows.
fn view_of([low, high]: &[DVec3; 2]) -> Result<Shot, Fault> {
    /// Room around it.
    const ROOM: f64 = 1.08;
    let [width, height] = SIZE;
    let film = Film::from_fov(VIEW_DEG.to_radians(), width, height)?;
    let centre = 0.5 * (*low + *high);
    let pose = Pose::look_at(centre + FROM, centre, DVec3::Y)?;
    let half = film.max();
    let needed = (0..8).map(|corner: usize| {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let p = pose.direction_to_camera(DVec3::new(pick(0), pick(1), pick(2)) - centre);
        ROOM * (p.x.abs() / half.x).max(p.y.abs() / half.y) - p.z
    });
    let distance = needed.fold(f64::MIN_POSITIVE, f64::max);
    let pose = Pose::look_at(centre + distance * FROM.normalize(), centre, DVec3::Y)?;
    let camera = Camera { pose, film, focus: Focus::at_depth(distance)?, iris: Iris::pinhole() };
    Ok(Shot {
        description: "All of it, from the right, above and in front".to_owned(),
        camera,
        lens: None,
        exposure: Exposure::default(),
    })
}

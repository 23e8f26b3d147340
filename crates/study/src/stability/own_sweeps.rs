//! Sweeps through small scenes of their own: things that are near, thin or bright before a checkered wall.

use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use trace::{Light, Material, Pigment, Scene, SceneBuilder, Shape};

use super::sweep::{Input, geometric, linear};
use super::{Mode, Stage, Sweep};
use crate::StudyError;

/// Depth of the wall in metres.
const WALL: f64 = 4.0;

/// Horizontal field of view in radians.
const FIELD_OF_VIEW: f64 = 0.9;

/// Colours of the wall's tiles.
const TILES: [f32; 2] = [0.75, 0.15];

/// A focal length in metres, and an f-number.
const LENS: (f64, f64) = (0.05, 2.8);

/// The empty room: the film of the stage's size before the wall.
struct Room {
    film: Film,
    /// Pixels per unit of q.
    scale: f64,
}

impl Room {
    fn new(stage: &Stage) -> Result<Self, StudyError> {
        let film = Film::from_fov(FIELD_OF_VIEW, stage.camera().film.width(), stage.camera().film.height())?;
        Ok(Self { film, scale: film.pixels_per_q().x })
    }

    /// An untilted camera focused at an inverse depth, which may be 0 or negative.
    fn camera(&self, inverse_depth: f64, radius: f64) -> Result<Camera, StudyError> {
        Ok(Camera {
            pose: Pose::IDENTITY,
            film: self.film,
            focus: Focus::new(DVec3::new(0.0, 0.0, inverse_depth))?,
            iris: Iris::upright(radius, ApertureShape::Disc)?,
        })
    }

    /// The wall, evenly lit, and one thing before it: a unit shape under a map from its place to camera space (z = depth).
    fn scene(&self, shape: Shape, place: Place, material: Material) -> Result<Scene, StudyError> {
        let mut builder = SceneBuilder::new();
        let tiles = Pigment::Checker { colors: TILES.map(Vec3::splat), side: 0.25, axes: [0, 1] };
        let wall = builder.material(Material { pigment: tiles, emission: Vec3::ZERO });
        let upright = DAffine3::from_rotation_translation(DQuat::from_rotation_x(FRAC_PI_2), -WALL * DVec3::Z);
        builder.shape(Shape::Plane, upright, wall)?;
        let material = builder.material(material);
        builder.shape(shape, place.world(), material)?;
        builder.light(Light::Ambient { strength: Vec3::ONE });
        Ok(builder.build()?)
    }
}

/// Where a thing stands: centre in camera space, half sizes, turn about the view's axis in radians.
struct Place {
    center: DVec3,
    half: DVec3,
    turn: f64,
}

impl Place {
    fn world(&self) -> DAffine3 {
        let DVec3 { x, y, z } = self.center;
        let turn = DQuat::from_rotation_z(self.turn);
        DAffine3::from_scale_rotation_translation(self.half, turn, DVec3::new(x, y, -z))
    }
}

/// A scene that stands still, seen by a lens that is focused.
fn still<'s>(
    mode: Mode,
    scene: Scene,
    places: Vec<f64>,
    widest: f64,
    camera_at: impl Fn(f64) -> Result<Camera, StudyError> + Sync + 'static,
) -> Sweep<'s> {
    Sweep {
        mode,
        places,
        scene_at: Box::new(move |_| Ok(Cow::Owned(scene.clone()))),
        camera_at: Box::new(camera_at),
        input: Input::Fixed { widest },
        samples_factor: 1,
    }
}

/// Focus moves through the wall, whose blur crosses 1.5 px on both sides, behind a card that is blurred by 6 px.
pub(super) fn small_blur<'s>(stage: &Stage, steps: usize) -> Result<Sweep<'s>, StudyError> {
    let room = Room::new(stage)?;
    let card = Place { center: DVec3::new(-0.45, -0.2, 0.5 * WALL), half: DVec3::new(0.35, 0.3, 0.01), turn: 0.1 };
    let scene = room.scene(Shape::Cuboid, card, Material::matte(Vec3::new(0.8, 0.2, 0.1)))?;
    // R s (2 / WALL - 1 / WALL) = 6 px
    let radius = 6.0 * WALL / room.scale;
    let camera_at = move |at: f64| room.camera(1.0 / WALL - at / (radius * room.scale), radius);
    Ok(still(Mode::SmallBlur, scene, linear(-1.5, 1.5, steps), 0.0, camera_at))
}

/// A ball that looks equally large at any distance comes from 20 focal lengths to 0.4.
pub(super) fn near_object<'s>(stage: &Stage, steps: usize) -> Result<Sweep<'s>, StudyError> {
    let room = Room::new(stage)?;
    let (focal_length, f_number) = LENS;
    let camera = room.camera(1.0 / WALL, 0.5 * focal_length / f_number)?;
    let scene_at = move |at: f64| {
        let depth = at * focal_length;
        let ball = Place { center: depth * DVec3::new(0.2, 0.05, 1.0), half: DVec3::splat(0.1 * depth), turn: 0.0 };
        Ok(Cow::Owned(room.scene(Shape::Sphere, ball, Material::matte(Vec3::new(0.1, 0.3, 0.8)))?))
    };
    Ok(Sweep {
        mode: Mode::NearObject,
        places: geometric(20.0, 0.4, steps),
        scene_at: Box::new(scene_at),
        camera_at: Box::new(move |_| Ok(camera)),
        input: Input::Moving,
        samples_factor: 1,
    })
}

/// A leaning pole of one pixel, blurred by 2.5 px, moves over three pixels of a sharp wall.
pub(super) fn thin_occluder<'s>(stage: &Stage, steps: usize) -> Result<Sweep<'s>, StudyError> {
    const DEPTH: f64 = 1.0;
    let room = Room::new(stage)?;
    let camera = room.camera(1.0 / WALL, 2.5 / (room.scale * (1.0 / DEPTH - 1.0 / WALL)))?;
    let scene_at = move |at: f64| {
        let center = DVec3::new((0.1 * f64::from(room.film.width()) + at) / room.scale, 0.0, DEPTH);
        let pole = Place { center, half: DVec3::new(0.5 / room.scale, 2.0, 1e-4), turn: 0.03 };
        Ok(Cow::Owned(room.scene(Shape::Cuboid, pole, Material::matte(Vec3::new(0.9, 0.4, 0.1)))?))
    };
    Ok(Sweep {
        mode: Mode::ThinOccluder,
        places: linear(0.0, 3.0, steps),
        scene_at: Box::new(scene_at),
        camera_at: Box::new(move |_| Ok(camera)),
        input: Input::Moving,
        samples_factor: 1,
    })
}

/// Focus moves through a ball of one pixel that shines 10,000 times as bright as the wall, from 4 px of blur to 4.
pub(super) fn bright_light<'s>(stage: &Stage, steps: usize) -> Result<Sweep<'s>, StudyError> {
    const DEPTH: f64 = 2.0;
    let room = Room::new(stage)?;
    let mean = 0.5 * (TILES[0] + TILES[1]);
    // In the middle of a pixel
    let center = DVec3::new(10.5 / room.scale, 5.5 / room.scale, 1.0) * DEPTH;
    let ball = Place { center, half: DVec3::splat(0.5 * DEPTH / room.scale), turn: 0.0 };
    let scene = room.scene(Shape::Sphere, ball, Material::glowing(Vec3::splat(1e4 * mean)))?;
    let radius = 16.0 / room.scale;
    let camera_at = move |at: f64| room.camera(1.0 / DEPTH - at / (radius * room.scale), radius);
    let sweep = still(Mode::BrightLight, scene, linear(-4.0, 4.0, steps), 0.0, camera_at);
    // Few rays of a pixel meet the light, and those count
    Ok(Sweep { samples_factor: 8, ..sweep })
}

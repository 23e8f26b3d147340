//! Where images in mirrors and glass stand: known answers of geometrical optics.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use optics::{Camera, Film, Focus, Iris, Pose};
use rgbd::PixelWindow;
use trace::{Finish, Material, Matter, Scene, SceneBuilder, Shape, optical_depth};

/// Finite differences of f32 rays.
const CLOSE: f64 = 0.01;

fn mirror(builder: &mut SceneBuilder) -> trace::MaterialId {
    let matter = Matter::Glossy { metallic: 1.0, roughness: 0.0, ior: 1.5 };
    builder.finished(Material::matte(Vec3::ONE), Finish { matter, ..Finish::default() })
}

/// Looks along -z from the origin.
fn camera() -> Camera {
    Camera {
        pose: Pose::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y).unwrap(),
        film: Film::from_fov(0.2, 9, 9).unwrap(),
        focus: Focus::at_depth(3.0).unwrap(),
        iris: Iris::pinhole(),
    }
}

fn at_centre(scene: &Scene) -> f64 {
    f64::from(optical_depth(scene, &camera(), PixelWindow::of_size(9, 9)).at(4, 4))
}

fn wall(builder: &mut SceneBuilder, z: f64) {
    let grey = builder.material(Material::matte(Vec3::splat(0.5)));
    let map = DAffine3::from_translation(z * DVec3::Z)
        * DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    builder.shape(Shape::Plane, map, grey).unwrap();
}

#[test]
fn what_is_no_mirror_has_the_depth_of_its_surface() {
    let mut builder = SceneBuilder::new();
    wall(&mut builder, -4.0);
    mirror(&mut builder);
    let scene = builder.build().unwrap();
    assert!((at_centre(&scene) - 4.0).abs() < 1e-5);
    assert_eq!(at_centre(&SceneBuilder::new().build().unwrap()), f64::INFINITY);
}

#[test]
fn an_image_in_a_flat_mirror_is_as_far_behind_it_as_the_thing_before() {
    let mut builder = SceneBuilder::new();
    let silver = mirror(&mut builder);
    wall(&mut builder, 3.0);
    let map = DAffine3::from_translation(2.0 * DVec3::NEG_Z)
        * DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    builder.shape(Shape::Rectangle, map, silver).unwrap();
    // 2 to the mirror, 5 back to the wall behind the viewer
    assert!((at_centre(&builder.build().unwrap()) / 7.0 - 1.0).abs() < CLOSE);
}

#[test]
fn an_image_in_a_ball_stands_behind_its_surface() {
    let (radius, distance, object) = (1.0, 4.0, 7.0);
    let mut builder = SceneBuilder::new();
    let silver = mirror(&mut builder);
    wall(&mut builder, object - distance);
    let map =
        DAffine3::from_translation((distance + radius) * DVec3::NEG_Z) * DAffine3::from_scale(DVec3::splat(radius));
    builder.shape(Shape::Sphere, map, silver).unwrap();
    // 1 / s' = 2 / R + 1 / s
    let expected = distance + 1.0 / (2.0 / radius + 1.0 / object);
    let found = at_centre(&builder.build().unwrap());
    assert!((found / expected - 1.0).abs() < CLOSE, "{found} instead of {expected}");
}

#[test]
fn the_sky_in_a_ball_stands_at_its_focus() {
    let mut builder = SceneBuilder::new();
    let silver = mirror(&mut builder);
    let map = DAffine3::from_translation(5.0 * DVec3::NEG_Z);
    builder.shape(Shape::Sphere, map, silver).unwrap();
    let found = at_centre(&builder.build().unwrap());
    assert!((found / 4.5 - 1.0).abs() < CLOSE, "{found}");
}

#[test]
fn a_pane_brings_what_is_behind_it_nearer() {
    let mut builder = SceneBuilder::new();
    let glass = Finish { matter: Matter::glass(1.5, false), ..Finish::default() };
    let glass = builder.finished(Material::matte(Vec3::ONE), glass);
    let map = DAffine3::from_translation(3.0 * DVec3::NEG_Z) * DAffine3::from_scale(DVec3::new(9.0, 9.0, 0.75));
    builder.shape(Shape::Cuboid, map, glass).unwrap();
    wall(&mut builder, -6.0);
    // By t (1 - 1 / n)
    let expected = 6.0 - 1.5 * (1.0 - 1.0 / 1.5);
    let found = at_centre(&builder.build().unwrap());
    assert!((found / expected - 1.0).abs() < CLOSE, "{found} instead of {expected}");
}

//! A small scene with all that noise comes from: a sharp and a blurred part, edges, and lights far brighter than the rest.

use glam::{DAffine3, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::PixelWindow;
use trace::{Light, Material, Pigment, Scene, SceneBuilder, Shape};

/// The whole picture.
pub(crate) const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 32, height: 24 };

pub(crate) fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let colors = [Vec3::new(0.7, 0.6, 0.5), Vec3::splat(0.1)];
    let floor = Material { pigment: Pigment::Checker { colors, side: 0.7, axes: [0, 2] }, emission: Vec3::ZERO };
    let floor = builder.material(floor);
    let red = builder.material(Material::matte(Vec3::new(0.8, 0.1, 0.1)));
    let glow = builder.material(Material::glowing(Vec3::new(30.0, 25.0, 10.0)));
    builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
    builder.shape(Shape::Sphere, DAffine3::from_translation(DVec3::Y), red).unwrap();
    for (x, z) in [(-1.5, -3.0), (1.2, -4.0), (0.4, 2.5)] {
        let place = DAffine3::from_translation(DVec3::new(x, 0.8, z)) * DAffine3::from_scale(DVec3::splat(0.04));
        builder.shape(Shape::Sphere, place, glow).unwrap();
    }
    builder.light(Light::Ambient { strength: Vec3::splat(0.3) });
    builder.light(Light::sun(DVec3::new(1.0, 2.0, 0.5), Vec3::splat(0.7)).unwrap());
    builder.sky(Vec3::new(0.5, 0.6, 0.9));
    builder.build().unwrap()
}

pub(crate) fn camera() -> Camera {
    Camera {
        pose: Pose::look_at(DVec3::new(0.0, 3.0, 6.0), DVec3::Y, DVec3::Y).unwrap(),
        film: Film::from_fov(0.7, WINDOW.width, WINDOW.height).unwrap(),
        focus: Focus::new(DVec3::new(0.05, -0.1, 0.16)).unwrap(),
        iris: Iris::new(DVec3::new(0.05, -0.1, 1.0), 0.3, ApertureShape::Disc).unwrap(),
    }
}

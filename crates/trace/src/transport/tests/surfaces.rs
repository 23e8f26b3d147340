//! Textures, holes and lights at points.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};

use super::*;
use crate::{Light, Material, MeshDetail, SceneBuilder, Shape, Texture, TextureMap};

/// One wall of two triangles with coordinates from 0 to 1, and what `finish` says.
fn wall(finish: Finish, color: Vec3) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let paint = builder.finished(Material::matte(color), finish);
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let vertices = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
    let uv = corners.map(|(x, y)| Vec2::new(x as f32, 1.0 - y as f32));
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let uvs = triangles.map(|corners| corners.map(|i| uv[i as usize]));
    let detail = Arc::new(MeshDetail { uvs: [uvs.to_vec(), Vec::new()], ..MeshDetail::default() });
    builder.detailed_mesh(&vertices, &triangles, |_| paint, DAffine3::IDENTITY, &detail).unwrap();
    builder.light(Light::Ambient { strength: Vec3::ONE });
    builder.sky(Vec3::new(0.0, 0.0, 1.0));
    builder
}

fn striped(alpha: [f32; 2]) -> TextureMap {
    let texels = [[1.0, 0.0, 0.0, alpha[0]], [0.0, 1.0, 0.0, alpha[1]]];
    TextureMap::new(Arc::new(Texture::from_linear(2, 1, &texels).unwrap()))
}

fn toward(x: f64) -> Ray {
    Ray::new(DVec3::new(x, 0.5, 2.0), DVec3::NEG_Z)
}

#[test]
fn textures_colour_and_masks_are_holes_for_light_depth_and_shadow() {
    let finish = Finish { color_map: Some(striped([1.0; 2])), ..Finish::default() };
    let scene = wall(finish, Vec3::splat(0.5)).build().unwrap();
    assert_eq!((scene.radiance(&toward(0.25)), scene.radiance(&toward(0.75))), (0.5 * Vec3::X, 0.5 * Vec3::Y));
    assert_eq!(scene.needs(), ["textured material"]);

    let finish = Finish { color_map: Some(striped([1.0, 0.0])), alpha: Alpha::Mask(0.5), ..Finish::default() };
    let scene = wall(finish, Vec3::ONE).build().unwrap();
    assert_eq!((scene.radiance(&toward(0.25)), scene.radiance(&toward(0.75))), (Vec3::X, Vec3::Z));
    assert!(scene.hit(&toward(0.25)).is_some() && scene.hit(&toward(0.75)).is_none());
    assert!(scene.is_blocked(&toward(0.25), 9.0) && !scene.is_blocked(&toward(0.75), 9.0));
    assert!(!scene.is_blocked(&toward(0.25), 1.5));

    // And a sun through the hole lights the floor behind
    let finish = Finish { color_map: Some(striped([1.0, 0.0])), alpha: Alpha::Mask(0.5), ..Finish::default() };
    let mut builder = wall(finish, Vec3::ONE);
    let white = builder.material(Material::matte(Vec3::ONE));
    let back = DAffine3::from_translation(DVec3::new(0.0, 0.0, -1.0))
        * DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    builder.shape(Shape::Plane, back, white).unwrap();
    builder.light(Light::sun(DVec3::Z, Vec3::ONE).unwrap());
    let scene = builder.build().unwrap();
    let behind = |x: f64| scene.radiance(&Ray::new(DVec3::new(x, 0.5, -0.5), DVec3::NEG_Z)).x;
    assert_eq!((behind(0.25), behind(0.75)), (1.0, 2.0));
}

#[test]
fn what_covers_half_lets_half_through() {
    let finish = Finish { alpha: Alpha::Blend, opacity: 0.25, ..Finish::default() };
    let mut builder = wall(finish, Vec3::X);
    let white = builder.material(Material::matte(Vec3::ONE));
    let back = DAffine3::from_translation(DVec3::new(0.0, 0.0, -1.0))
        * DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    builder.shape(Shape::Plane, back, white).unwrap();
    builder.light(Light::sun(DVec3::Z, Vec3::ONE).unwrap());
    let scene = builder.build().unwrap();
    // A quarter of what is lit by 2; behind it ambient light and three quarters of the sun
    let (mean, error) = mean(&scene, &toward(0.5), 4000);
    let expected = Vec3::new(0.25 * 2.0 + 0.75 * 1.75, 0.75 * 1.75, 0.75 * 1.75);
    assert!((mean - expected).abs().max_element() < SIGMAS * error, "{mean} +- {error} instead of {expected}");
    // It does not count in depth
    assert!((scene.hit(&toward(0.5)).unwrap().t - 3.0).abs() < 1e-5);
}

#[test]
fn a_point_light_falls_off_and_keeps_to_its_cone() {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    builder.shape(Shape::Plane, DAffine3::IDENTITY, white).unwrap();
    let cone = Cone::new(DVec3::NEG_Y, 0.2, 0.4).unwrap();
    builder.light(Light::Point { at: 2.0 * DVec3::Y, strength: Vec3::splat(4.0), cone: Some(cone) });
    let scene = builder.build().unwrap();
    let at = |x: f64| scene.radiance(&Ray::new(DVec3::new(x, 1.0, 0.0), DVec3::NEG_Y)).x;
    assert!((at(0.0) - 1.0).abs() < 1e-5, "{}", at(0.0));
    // cos^3 / h^2 within the inner cone, nothing beyond the outer one
    let x = 2.0 * 0.15_f64.tan();
    assert!((f64::from(at(x)) - 0.15_f64.cos().powi(3)).abs() < 1e-5);
    let between = at(2.0 * 0.3_f64.tan());
    assert!(between > 0.0 && between < 0.9 * 0.3_f32.cos().powi(3));
    assert_eq!(at(2.0 * 0.41_f64.tan()), 0.0);
}

#[test]
fn textured_scenes_without_bounces_look_as_the_base_shading() {
    // The same scene twice: one of them traced ray by ray, for a white texture
    let build = |finish: Finish| {
        let mut builder = wall(finish, Vec3::new(0.8, 0.5, 0.3));
        let floor = builder.material(Material::matte(Vec3::splat(0.6)));
        builder.shape(Shape::Plane, DAffine3::from_translation(-0.1 * DVec3::Y), floor).unwrap();
        builder.light(Light::sun(DVec3::new(0.3, 1.0, -0.5), Vec3::new(0.9, 0.8, 0.7)).unwrap());
        builder.build().unwrap()
    };
    let white = TextureMap::new(Arc::new(Texture::from_linear(1, 1, &[[1.0; 4]]).unwrap()));
    let [plain, textured] = [Finish::default(), Finish { color_map: Some(white), ..Finish::default() }].map(build);
    assert!(plain.needs().is_empty() && !textured.needs().is_empty());
    for i in 0..400 {
        let place = DVec3::new(f64::from(i % 20) / 8.0 - 0.7, f64::from(i / 20) / 12.0 - 0.6, 0.0);
        let eye = DVec3::new(0.5, 1.0, 3.0);
        let ray = Ray::new(eye, place - eye);
        let (a, b) = (plain.radiance(&ray), textured.radiance(&ray));
        // f32 rounding
        assert!((a - b).abs().max_element() < 1e-5, "{place}: {a} {b}");
    }
}

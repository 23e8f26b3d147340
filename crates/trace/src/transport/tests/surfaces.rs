//! Textures, holes and lights at points.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};

use super::*;
use crate::sampler::Sampler;
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

#[test]
fn a_texture_is_as_soft_as_the_footprint_is_wide() {
    // Squares of one texel: from two texels on there is nothing but their mean
    let texels: Vec<_> = (0..64 * 64).map(|i| [((i % 64 + i / 64) % 2) as f32, 0.0, 0.0, 1.0]).collect();
    let map = TextureMap::new(Arc::new(Texture::from_linear(64, 64, &texels).unwrap()));
    let scene = wall(Finish { color_map: Some(map), ..Finish::default() }, Vec3::ONE).build().unwrap();
    let transport = scene.transport.as_ref().unwrap();
    let sampler = Sampler::new(1, 2, 3, 0);
    let seen = |texels: f64| {
        // The wall is 2 away and 64 texels wide; half a pixel counts
        let footprint = Footprint::of_pixel(2.0 * texels / 64.0 / 2.0);
        let at = |i: u32| {
            let ray = Ray::new(DVec3::new((f64::from(i) + 0.5) / 64.0, 32.5 / 64.0, 2.0), DVec3::NEG_Z);
            transport.radiance(&scene, &ray, footprint, &mut Stream::new(&sampler, 0, false)).x
        };
        (0..64).map(|i| (at(i) - 0.5).abs()).sum::<f32>() / 64.0
    };
    let contrasts = [0.1, 1.0, 1.5, 2.0, 30.0].map(seen);
    assert!(contrasts.windows(2).all(|pair| pair[1] <= pair[0] + 1e-6), "{contrasts:?}");
    assert!(contrasts[3] < 1e-4 && contrasts[0] > 0.2, "{contrasts:?}");
}

#[test]
fn normals_of_maps_and_meshes_turn_the_light() {
    let (sine, cosine) = 0.5_f32.sin_cos();
    let lit = |finish: Finish, normals: Option<Vec3>, toward_sun: Vec3| {
        let mut builder = SceneBuilder::new();
        let paint = builder.finished(Material::matte(Vec3::ONE), finish);
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y];
        // u to the right, v down
        let uv = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.0)];
        let normals = normals.map_or_else(Vec::new, |normal| vec![[normal; 3]]);
        let detail = Arc::new(MeshDetail { normals, uvs: [vec![uv], Vec::new()], ..MeshDetail::default() });
        builder.detailed_mesh(&vertices, &[[0, 1, 2]], |_| paint, DAffine3::IDENTITY, &detail).unwrap();
        builder.light(Light::sun(toward_sun.as_dvec3(), Vec3::ONE).unwrap());
        builder.build().unwrap().radiance(&Ray::new(DVec3::new(0.3, 0.3, 2.0), DVec3::NEG_Z)).x
    };
    let bent = |normal: Vec3| {
        let [r, g, b] = (0.5 * normal + 0.5).to_array();
        let map = TextureMap::new(Arc::new(Texture::from_linear(1, 1, &[[r, g, b, 1.0]]).unwrap()));
        Finish { normal_map: Some((map, 1.0)), ..Finish::default() }
    };
    // Red bends to the right, green up; 16 bits of a texel
    let (right, up) = (Vec3::new(sine, 0.0, cosine), Vec3::new(0.0, sine, cosine));
    for (normal, sun, expected) in [
        (Vec3::Z, Vec3::Z, 1.0),
        (right, right, 1.0),
        (up, up, 1.0),
        (right, Vec3::Z, cosine),
        (up, right, cosine * cosine),
    ] {
        let found = lit(bent(normal), None, sun);
        assert!((found - expected).abs() < 1e-4, "{normal} under {sun}: {found} instead of {expected}");
        let found = lit(Finish::default(), Some(3.0 * normal), sun);
        assert!((found - expected).abs() < 1e-5, "mesh, {normal} under {sun}: {found} instead of {expected}");
    }
    // Normals that are none, or point to the other side, leave the triangle flat
    for normal in [Vec3::ZERO, Vec3::NAN, Vec3::NEG_Z, Vec3::INFINITY] {
        assert!((lit(Finish::default(), Some(normal), right) - cosine).abs() < 1e-5, "{normal}");
    }
}

#[test]
fn colours_at_vertices_are_mixed() {
    let mut builder = SceneBuilder::new();
    let paint = builder.material(Material::matte(Vec3::splat(0.5)));
    let colors = vec![[Vec3::X, Vec3::Y, Vec3::Z].map(|color| color.extend(1.0))];
    let detail = Arc::new(MeshDetail { colors, ..MeshDetail::default() });
    builder
        .detailed_mesh(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]], |_| paint, DAffine3::IDENTITY, &detail)
        .unwrap();
    builder.light(Light::Ambient { strength: Vec3::ONE });
    let scene = builder.build().unwrap();
    let found = scene.radiance(&Ray::new(DVec3::new(0.25, 0.5, 2.0), DVec3::NEG_Z));
    assert!((found - 0.5 * Vec3::new(0.25, 0.25, 0.5)).abs().max_element() < 1e-5, "{found}");
}

//! Light that is asked, light that is met, and both together are the same light.

use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::*;
use crate::{Material, SceneBuilder, Shape};

/// A square at a place, its normal turned from +y by angles about x and z.
fn square(at: DVec3, half: f64, [x, z]: [f64; 2]) -> DAffine3 {
    let turn = DQuat::from_rotation_z(z.to_radians()) * DQuat::from_rotation_x(x.to_radians());
    DAffine3::from_scale_rotation_translation(DVec3::splat(half), turn, at)
}

fn lamp(builder: &mut SceneBuilder, map: DAffine3, radiance: f32) {
    let lamp = Material::glowing(Vec3::splat(radiance));
    let lamp = builder.finished(lamp, Finish { is_light: true, ..Finish::default() });
    builder.shape(Shape::Rectangle, map, lamp).unwrap();
}

/// A box with a red and a green wall, a lamp in its ceiling and two blocks, one of them glossy.
fn cornell(size: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let [white, red, green] = [[0.73, 0.73, 0.73], [0.65, 0.05, 0.05], [0.12, 0.45, 0.15]]
        .map(|color| builder.material(Material::matte(Vec3::from_array(color))));
    let gloss = finish(Matter::Glossy { metallic: 1.0, roughness: 0.3, ior: 1.5 });
    let gloss = builder.finished(Material::matte(Vec3::new(0.9, 0.8, 0.6)), gloss);
    for (at, turn, paint) in [
        (DVec3::NEG_Y, [0.0, 0.0], white),
        (DVec3::Y, [180.0, 0.0], white),
        (DVec3::NEG_Z, [90.0, 0.0], white),
        (DVec3::NEG_X, [0.0, -90.0], red),
        (DVec3::X, [0.0, 90.0], green),
    ] {
        builder.shape(Shape::Rectangle, square(at, 1.0, turn), paint).unwrap();
    }
    let block = |at: [f64; 3], half: f64, turn: f64| {
        let turn = DQuat::from_rotation_y(turn.to_radians());
        DAffine3::from_scale_rotation_translation(DVec3::splat(half), turn, DVec3::from_array(at))
    };
    builder.shape(Shape::Cuboid, block([-0.35, -0.7, -0.3], 0.3, 18.0), gloss).unwrap();
    builder.shape(Shape::Cuboid, block([0.4, -0.75, 0.3], 0.25, -15.0), white).unwrap();
    lamp(&mut builder, square(DVec3::new(0.0, 0.99, 0.0), size, [180.0, 0.0]), (0.5 / (size * size)) as f32);
    builder.bounces(3).unwrap();
    builder
}

/// A plate, metal or varnished or of rough glass over a floor, under a lamp.
fn plate(matter: Matter, size: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let paint = builder.finished(Material::matte(Vec3::new(0.8, 0.6, 0.4)), finish(matter));
    builder.shape(Shape::Rectangle, DAffine3::from_scale(DVec3::splat(4.0)), paint).unwrap();
    let white = builder.material(Material::matte(Vec3::splat(0.8)));
    builder.shape(Shape::Plane, DAffine3::from_translation(-0.7 * DVec3::Y), white).unwrap();
    lamp(&mut builder, square(DVec3::new(0.3, 2.0, -1.5), size, [120.0, 0.0]), (1.0 / (size * size)) as f32);
    builder.bounces(2).unwrap();
    builder
}

#[test]
fn all_strategies_find_the_same_light_and_a_wrong_weight_another() {
    const COUNT: u32 = 40_000;
    /// Five standard errors: light that is met rarely has an error that is known less well.
    const SIGMAS: f32 = 5.0;
    let gloss = |metallic, roughness| Matter::Glossy { metallic, roughness, ior: 1.5 };
    let pane = Matter::Glass { ior: 1.5, thin: true, roughness: 0.4, absorption: None };
    let mut cases = Vec::new();
    for size in [0.1, 0.6] {
        let into = Ray::new(DVec3::new(0.0, 0.0, 3.5), DVec3::new(-0.1, -0.22, -1.0));
        cases.push((format!("box, lamp {size}"), cornell(size), into));
        for matter in [gloss(1.0, 0.25), gloss(0.0, 0.3), pane] {
            let onto = Ray::new(DVec3::new(0.1, 1.5, 2.5), DVec3::new(0.05, -1.5, -2.2));
            cases.push((format!("{matter:?}, lamp {size}"), plate(matter, size), onto));
        }
    }
    for (name, builder, ray) in cases {
        let mut scene = builder.build().unwrap();
        let mut found = |weighing| {
            let transport = scene.transport.as_mut().expect("lamps need it");
            Arc::make_mut(transport).weighing = weighing;
            mean(&scene, &ray, COUNT)
        };
        let (both, both_error) = found(Weighing::Balanced);
        assert!(both.max_element() > 1e-3 && both_error < 0.05 * both.max_element(), "{name}: {both} +- {both_error}");
        for weighing in [Weighing::LightsAlone, Weighing::SurfacesAlone] {
            let (alone, error) = found(weighing);
            let allowed = SIGMAS * (error.powi(2) + both_error.powi(2)).sqrt();
            assert!(
                (alone - both).abs().max_element() < allowed,
                "{name}, {weighing:?}: {alone} +- {error}, not {both} +- {both_error}"
            );
        }
        // Counted twice it is too bright by far more than chance allows
        let (doubled, error) = found(Weighing::Doubled);
        let allowed = SIGMAS * (error.powi(2) + both_error.powi(2)).sqrt();
        assert!((doubled - both).max_element() > allowed, "{name}: {doubled} +- {error}: the test would say little");
    }
}

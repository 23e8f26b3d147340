//! Suns through glass, and suns that have a size.

use glam::{DAffine3, DVec3, Vec3};

use super::*;
use crate::{Light, Material, SceneBuilder, Shape};

const TOWARD: DVec3 = DVec3::new(0.3, 1.0, 0.2);

/// A white floor under a sun.
fn floor(light: Light) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::splat(0.5)));
    builder.shape(Shape::Rectangle, DAffine3::from_scale(DVec3::splat(30.0)), white).unwrap();
    builder.light(light);
    builder.bounces(8).unwrap();
    builder
}

fn down() -> Ray {
    Ray::new(DVec3::new(0.4, 1.0, 3.0), DVec3::new(-0.4, -1.0, -3.0))
}

#[test]
fn a_pane_lets_suns_and_points_through_as_fresnel_and_its_colour_say() {
    let point = DVec3::new(1.0, 3.0, 0.5);
    let lights = [
        (Light::sun(TOWARD, Vec3::ONE).unwrap(), TOWARD),
        (Light::Point { at: point, strength: Vec3::splat(9.0), cone: None }, point),
    ];
    for (light, way) in lights {
        let bare = floor(light).build().unwrap();
        let tint = Vec3::new(0.9, 0.5, 0.2);
        let mut builder = floor(light);
        let pane = builder.finished(Material::matte(tint), finish(Matter::glass(1.5, true)));
        // Two panes over all of the floor, above the eye
        for height in [1.5, 2.0] {
            let map = DAffine3::from_translation(height * DVec3::Y) * DAffine3::from_scale(DVec3::splat(90.0));
            builder.shape(Shape::Rectangle, map, pane).unwrap();
        }
        let scene = builder.build().unwrap();
        // Paths that the panes reflect back to the floor add a little: they are not counted with one bounce
        let direct = |scene: &Scene| {
            let mut scene = scene.clone();
            Arc::make_mut(scene.transport.as_mut().unwrap()).bounces = 0;
            scene
        };
        let (open, through) = (direct(&bare).radiance(&down()), direct(&scene).radiance(&down()));
        let share = 1.0 - fresnel::sheet(way.normalize().y as f32, 1.5);
        // With no bounces glass is matte: the law is that of the share alone
        assert_eq!(through, Vec3::ZERO);
        let (lit, error) = mean(&scene, &down(), 20_000);
        let expected = open * (tint * share).powf(2.0);
        assert!((lit - expected).min_element() > -SIGMAS * error - 1e-4, "{lit} +- {error}, at least {expected}");
        // Half of what the floor sends up comes back by a quarter at most from both panes, and again
        assert!((lit - expected * 1.25).max_element() < SIGMAS * error + 1e-3, "{lit} +- {error}, about {expected}");
    }
}

/// A sun of a size lights as one without, by asking for it and by meeting it, and its penumbra is as wide as it is.
#[test]
fn a_sun_of_a_size_is_as_strong_as_one_without() {
    let degrees = |size: f64| Light::sun_of_size(TOWARD, Vec3::new(1.0, 0.8, 0.6), size.to_radians()).unwrap();
    let (open, _) = mean(&floor(degrees(0.0)).build().unwrap(), &down(), 4);
    for size in [0.53, 12.0] {
        let mut scene = floor(degrees(size)).build().unwrap();
        assert!(scene.needs().contains(&"sun of a size".to_owned()));
        let (found, error) = mean(&scene, &down(), 20_000);
        assert!((found - open).abs().max_element() < SIGMAS * error + 1e-4, "{size}: {found} +- {error}, not {open}");
        if size > 5.0 {
            Arc::make_mut(scene.transport.as_mut().unwrap()).weighing = Weighing::SurfacesAlone;
            let (met, error) = mean(&scene, &down(), 200_000);
            // The last of the bounces asks only; there is nothing here to bounce to
            assert!((met - open).abs().max_element() < SIGMAS * error, "{size}: {met} +- {error}, not {open}");
        }
    }
    assert!(matches!(degrees(0.0), Light::Sun { .. }));
    assert!(
        Light::sun_of_size(TOWARD, Vec3::ONE, f64::NAN).is_err() && Light::sun_of_size(TOWARD, Vec3::ONE, 2.0).is_err()
    );
}

#[test]
fn a_sun_of_a_size_shines_through_solid_glass_and_is_seen_in_mirrors() {
    // A thick pane: nothing but the share that two boundaries and what they reflect let through
    let light = Light::sun_of_size(DVec3::Y, Vec3::ONE, 0.2).unwrap();
    let open = mean(&floor(light).build().unwrap(), &down(), 4).0;
    let mut builder = floor(light);
    let glass = builder.finished(Material::matte(Vec3::ONE), finish(Matter::glass(1.5, false)));
    let map = DAffine3::from_translation(2.0 * DVec3::Y) * DAffine3::from_scale(DVec3::new(20.0, 0.3, 20.0));
    builder.shape(Shape::Cuboid, map, glass).unwrap();
    let (found, error) = mean(&builder.build().unwrap(), &down(), 200_000);
    let expected = 1.0 - fresnel::sheet(1.0, 1.5);
    assert!(
        error < 0.05 * found.x && (found.x / open.x - expected).abs() < SIGMAS * error / open.x + 0.02,
        "{found} +- {error}, open {open}"
    );

    // And in a mirror it is as bright as itself
    let mut builder = SceneBuilder::new();
    let mirror = finish(Matter::Glossy { metallic: 1.0, roughness: 0.0, ior: 1.5 });
    let mirror = builder.finished(Material::matte(Vec3::ONE), mirror);
    builder.shape(Shape::Rectangle, DAffine3::IDENTITY, mirror).unwrap();
    builder.light(light);
    let scene = builder.build().unwrap();
    let image = scene.radiance(&Ray::new(DVec3::Y, DVec3::NEG_Y));
    let itself = scene.radiance(&Ray::new(DVec3::Y, DVec3::Y));
    assert!((image - itself).abs().max_element() < 1e-3 * itself.x && itself.x > 10.0, "{image} {itself}");
}

//! Known answers of light transport.

use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::*;
use crate::sampler::Sampler;
use crate::{Absorption, Light, Material, Matter, Pigment, SceneBuilder, Shape};

mod strategies;
mod suns;
mod surfaces;

/// Mean radiance along a ray over `count` paths, with its standard error (the largest of the channels').
fn mean(scene: &Scene, ray: &Ray, count: u32) -> (Vec3, f32) {
    let transport = scene.transport.as_ref().expect("the scene needs no light transport");
    let (mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO);
    for i in 0..count {
        // A sequence of its own for each path: independent, so that the error is that of chance
        let sampler = Sampler::new(9, i as i32, 0, 0);
        let radiance = transport.radiance(scene, ray, Footprint::SHARP, &mut Stream::new(&sampler, 0, false));
        sum += radiance;
        squares += radiance * radiance;
    }
    let n = count as f32;
    let mean = sum / n;
    let error = ((squares / n - mean * mean).max(Vec3::ZERO) / n).max_element().sqrt();
    (mean, error)
}

/// Four standard errors: wrongly alarming once in 16,000 comparisons.
const SIGMAS: f32 = 4.0;

fn finish(matter: Matter) -> Finish {
    Finish { matter, ..Finish::default() }
}

/// A ball of radius 1 at the origin under a white sky of radiance 1.
fn furnace(matter: Matter, bounces: u32) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.finished(Material::matte(Vec3::ONE), finish(matter));
    builder.shape(Shape::Sphere, DAffine3::IDENTITY, white).unwrap();
    builder.sky(Vec3::ONE);
    builder.bounces(bounces).unwrap();
    builder.build().unwrap()
}

#[test]
fn a_white_furnace_stays_white() {
    /// What the tables of albedos are wrong by.
    const TABLES: f32 = 0.004;
    let gloss = |metallic, roughness| Matter::Glossy { metallic, roughness, ior: 1.5 };
    let mut cases = vec![
        (Matter::Matte, 0.0),
        (gloss(1.0, 0.0), 0.0),
        (Matter::glass(1.5, false), 0.0),
        (Matter::glass(1.5, true), 0.0),
    ];
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            cases.push((gloss(metallic, roughness), TABLES));
        }
    }
    // Light meets some boundaries of a ball of glass before it leaves, each with a table
    for roughness in [0.05, 0.3, 0.6, 1.0] {
        for thin in [false, true] {
            cases.push((Matter::Glass { ior: 1.5, thin, roughness, absorption: None }, 3.0 * TABLES));
        }
    }
    for (matter, tables) in cases {
        // Glass lets go of what is caught in it after a few reflections; where it is a little rough some turn into its rim, and stay
        // for hundreds
        let is_rough = matches!(matter, Matter::Glass { roughness: 0.01.., .. });
        let scene = furnace(matter, if is_rough { 1000 } else { 60 });
        for x in [0.0, 0.5, 0.9, 0.99] {
            let ray = Ray::new(DVec3::new(x, 0.1, 5.0), DVec3::NEG_Z);
            let (mean, error) = mean(&scene, &ray, 4000);
            let off = (mean - 1.0).abs().max_element();
            assert!(off <= SIGMAS * error + tables + 1e-5, "{matter:?} at {x}: {mean} +- {error}");
        }
    }
}

/// A slab of glass in front of a white sky, and what is behind it.
fn slab(thickness: f64, ior: f32, absorption: Absorption) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let glass = Matter::Glass { ior, thin: false, roughness: 0.0, absorption: Some(absorption) };
    let glass = builder.finished(Material::matte(Vec3::ONE), finish(glass));
    let map = DAffine3::from_scale(DVec3::new(50.0, 50.0, 0.5 * thickness));
    builder.shape(Shape::Cuboid, map, glass).unwrap();
    builder.sky(Vec3::ONE);
    builder.bounces(64).unwrap();
    builder
}

/// Beer and Lambert: white becomes the colour after the distance, and its power by the length of the way.
#[test]
fn light_fades_in_glass_by_the_length_of_its_way() {
    let (color, distance) = (Vec3::new(0.9, 0.5, 0.0), 0.4);
    let absorption = Absorption::new(color, distance).unwrap();
    for degrees in [0.0_f64, 40.0, 70.0] {
        let direction = DVec3::new(degrees.to_radians().sin(), 0.0, -degrees.to_radians().cos());
        let ray = Ray::new(-4.0 * direction, direction);
        for thickness in [0.1_f64, 0.4, 1.3] {
            // Of index 1 nothing is reflected nor bent
            let scene = slab(thickness, 1.0, absorption).build().unwrap();
            let expected = color.powf((thickness / degrees.to_radians().cos()) as f32 / distance);
            let off = (scene.radiance(&ray) - expected).abs().max_element();
            assert!(off < 1e-5, "{degrees}, {thickness}: {} instead of {expected}", scene.radiance(&ray));

            // Of another what is reflected inside fades on each way: R + (1 - R)^2 T / (1 - R T)
            let ior = 1.6_f64;
            let scene = slab(thickness, ior as f32, absorption).build().unwrap();
            let inside = (degrees.to_radians().sin() / ior).asin().cos();
            let fade = color.powf((thickness / inside) as f32 / distance);
            let once = fresnel::dielectric(degrees.to_radians().cos() as f32, ior as f32);
            let expected = Vec3::splat(once) + fade * (1.0 - once).powi(2) / (Vec3::ONE - fade * once);
            let (found, error) = mean(&scene, &ray, 4000);
            let off = (found - expected).abs().max_element();
            assert!(off < SIGMAS * error + 1e-4, "{degrees}, {thickness}: {found} +- {error} instead of {expected}");
        }
    }
}

/// A floor and a lamp in one block of tinted glass: as dim by the lamp's own samples as by paths that find it.
#[test]
fn light_fades_alike_where_a_lamp_is_asked_and_where_it_is_met() {
    let absorption = Absorption::new(Vec3::new(0.8, 0.4, 0.2), 1.0).unwrap();
    let scene = |is_sampled: bool| {
        let mut builder = slab(40.0, 1.0, absorption);
        builder.sky(Vec3::ZERO);
        builder.bounces(2).unwrap();
        let floor = builder.material(Material::matte(Vec3::ONE));
        let lamp = Material::glowing(Vec3::splat(4.0));
        let lamp = builder.finished(lamp, Finish { is_light: true, ..Finish::default() });
        builder.shape(Shape::Rectangle, DAffine3::from_scale(DVec3::splat(9.0)), floor).unwrap();
        let height = if is_sampled { 1.0 } else { 1e-6 };
        let map = DAffine3::from_translation(1.5 * DVec3::Y) * DAffine3::from_scale(DVec3::new(1.5, height, 1.5));
        builder.shape(if is_sampled { Shape::Rectangle } else { Shape::Cuboid }, map, lamp).unwrap();
        builder.build().unwrap()
    };
    // From a point inside, so that the camera's own way counts once it meets the floor only by what came before
    let ray = Ray::new(DVec3::new(0.0, 1.0, 3.0), DVec3::new(0.1, -1.0, -2.0));
    let (asked, asked_error) = mean(&scene(true), &ray, 6000);
    let (met, met_error) = mean(&scene(false), &ray, 60_000);
    let error = SIGMAS * (asked_error.powi(2) + met_error.powi(2)).sqrt();
    assert!((asked - met).abs().max_element() < error, "{asked} {met} +- {error}");
}

#[test]
fn a_coloured_coat_never_gives_more_than_it_gets() {
    for roughness in [0.0, 0.2, 0.5, 1.0] {
        for metallic in [0.0, 1.0] {
            let mut builder = SceneBuilder::new();
            let color = Vec3::new(1.0, 0.5, 0.0);
            let matter = Matter::Glossy { metallic, roughness, ior: 1.8 };
            let paint = builder.finished(Material::matte(color), finish(matter));
            builder.shape(Shape::Sphere, DAffine3::IDENTITY, paint).unwrap();
            builder.sky(Vec3::ONE);
            let scene = builder.build().unwrap();
            let (mean, error) = mean(&scene, &Ray::new(DVec3::new(0.3, 0.4, 5.0), DVec3::NEG_Z), 4000);
            assert!(mean.max_element() <= 1.0 + SIGMAS * error + 0.004, "{matter:?}: {mean}");
            assert!(mean.z < mean.y && mean.y < mean.x, "{mean}");
        }
    }
}

/// Inside a closed ball that emits E and reflects the share a, N bounces make E (1 + a + ... + a^N).
#[test]
fn a_closed_ball_shines_as_its_series_says() {
    let (emission, albedo) = (Vec3::new(0.5, 1.0, 2.0), 0.6_f32);
    let matters = [Matter::Matte, Matter::Glossy { metallic: 1.0, roughness: 0.0, ior: 1.5 }];
    for (matter, bounces) in [0, 1, 2, 5, 60].into_iter().flat_map(|n| matters.map(|matter| (matter, n))) {
        let mut builder = SceneBuilder::new();
        let material = Material { pigment: Pigment::Constant(Vec3::splat(albedo)), emission };
        let wall = builder.finished(material, Finish { is_light: true, ..finish(matter) });
        builder.shape(Shape::Sphere, DAffine3::from_scale(DVec3::splat(3.0)), wall).unwrap();
        builder.bounces(bounces).unwrap();
        builder.light(Light::Point { at: DVec3::ZERO, strength: Vec3::ZERO, cone: None });
        let scene = builder.build().unwrap();
        let series: f32 = (0..=bounces).map(|n| albedo.powi(n as i32)).sum();
        let (mean, error) = mean(&scene, &Ray::new(DVec3::new(0.4, 0.1, 0.0), DVec3::new(1.0, 0.3, 0.7)), 2000);
        if matter == Matter::Matte || bounces == 0 {
            let off = (mean / emission - series).abs().max_element();
            assert!(off <= SIGMAS * error / 0.5 + 1e-4, "{bounces} bounces: {mean} instead of {}", emission * series);
        } else {
            // A mirror of 60 % straight on reflects more aslant (Schlick), never less
            assert!((mean / emission).min_element() >= series - 1e-4, "{mean}");
        }
    }
}

/// A floor under a square lamp and a pillar: as bright by the lamp's own samples as by paths that find it.
#[test]
fn lights_that_are_asked_and_lights_that_are_met_give_the_same() {
    for matter in [Matter::Matte, Matter::Glossy { metallic: 0.5, roughness: 0.4, ior: 1.5 }] {
        let scene = |is_sampled: bool| {
            let mut builder = SceneBuilder::new();
            let floor = builder.finished(Material::matte(Vec3::new(0.8, 0.6, 0.4)), finish(matter));
            let lamp = Material::glowing(Vec3::splat(4.0));
            let lamp = builder.finished(lamp, Finish { is_light: true, ..Finish::default() });
            builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
            // A flat box is none of the shapes that are asked, but as good as the square
            let height = if is_sampled { 1.0 } else { 1e-6 };
            let map = DAffine3::from_translation(3.0 * DVec3::Y) * DAffine3::from_scale(DVec3::new(1.5, height, 1.5));
            builder.shape(if is_sampled { Shape::Rectangle } else { Shape::Cuboid }, map, lamp).unwrap();
            builder.bounces(1).unwrap();
            builder.build().unwrap()
        };
        let ray = Ray::new(DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.2, -2.0, -5.0));
        let (asked, asked_error) = mean(&scene(true), &ray, 6000);
        let (met, met_error) = mean(&scene(false), &ray, 60_000);
        let error = SIGMAS * (asked_error.powi(2) + met_error.powi(2)).sqrt();
        assert!((asked - met).abs().max_element() < error, "{matter:?}: {asked} {met} +- {error}");
        assert!(asked_error < 0.02 * asked.max_element(), "{asked} +- {asked_error}: the lamp is not asked");
    }
}

#[test]
fn a_square_lamp_lights_a_floor_as_its_form_factor_says() {
    let mut builder = SceneBuilder::new();
    let floor = builder.material(Material::matte(Vec3::ONE));
    let lamp = builder.finished(Material::glowing(Vec3::ONE), Finish { is_light: true, ..Finish::default() });
    builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
    builder.shape(Shape::Rectangle, DAffine3::from_translation(DVec3::Y), lamp).unwrap();
    builder.bounces(1).unwrap();
    let scene = builder.build().unwrap();
    // From a point under the corner of a rectangle a x b at height c (Howell, configuration B-3); here four of 1 x 1 x 1
    let (a, b) = (1.0_f64, 1.0_f64);
    let (da, db) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    let one = (a / da * (b / da).atan() + b / db * (a / db).atan()) / std::f64::consts::TAU;
    let (mean, error) = mean(&scene, &Ray::new(DVec3::new(1e-3, 0.5, 0.0), DVec3::new(-1e-3, -0.5, 0.0)), 20_000);
    assert!((mean.x - 4.0 * one as f32).abs() < SIGMAS * error, "{mean} +- {error} instead of {}", 4.0 * one);
    assert!(error < 0.01);
}

/// The edge of a half plane at height h casts, from a lamp of width s at height H, a penumbra s h / (H - h) wide.
#[test]
fn the_penumbra_is_as_wide_as_the_lamp_says() {
    let (size, lamp_height, edge_height) = (0.8, 4.0, 1.0);
    let mut builder = SceneBuilder::new();
    let floor = builder.material(Material::matte(Vec3::ONE));
    let black = builder.material(Material::matte(Vec3::ZERO));
    let lamp = builder.finished(Material::glowing(Vec3::splat(50.0)), Finish { is_light: true, ..Finish::default() });
    builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
    let square = |size: f64, at: DVec3| DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.5 * size));
    builder.shape(Shape::Rectangle, square(size, DVec3::new(0.0, lamp_height, 0.0)), lamp).unwrap();
    builder.shape(Shape::Rectangle, square(40.0, DVec3::new(20.0, edge_height, 0.0)), black).unwrap();
    builder.bounces(1).unwrap();
    let scene = builder.build().unwrap();
    // The floor from beside, below the half plane
    let at = |x: f64| {
        let target = DVec3::new(x, 0.0, 0.0);
        let eye = target + DVec3::new(0.0, 0.8, 3.0);
        mean(&scene, &Ray::new(eye, target - eye), 400).0.x
    };
    let half = 0.5 * size * edge_height / (lamp_height - edge_height);
    let lit = at(-half - 0.02);
    assert!(at(half + 0.01) == 0.0, "light where the whole lamp is hidden");
    assert!(at(half - 0.02) > 0.0, "no light where some of the lamp is seen");
    assert!(at(-half + 0.03) < 0.97 * lit, "full light where some of the lamp is hidden");
    // Half of it is hidden under the edge; 400 samples of yes and no scatter by 2.5 %
    assert!((at(0.0) / lit - 0.5).abs() < 0.1, "{}", at(0.0) / lit);
}

/// Light that goes through a thick pane aslant comes out parallel, moved by t sin(i - r) / cos r (Snell), and weakened by
/// Fresnel's two boundaries and all the reflections between them.
#[test]
fn a_pane_moves_and_weakens_light_as_snell_and_fresnel_say() {
    let (thickness, ior) = (0.5, 1.5_f64);
    let mut builder = SceneBuilder::new();
    let glass = finish(Matter::glass(ior as f32, false));
    let glass = builder.finished(Material::matte(Vec3::ONE), glass);
    let pane = DAffine3::from_scale(DVec3::new(50.0, 50.0, 0.5 * thickness));
    builder.shape(Shape::Cuboid, pane, glass).unwrap();
    // Behind it a wall that is lit on one side of a line only
    let light = builder.material(Material::glowing(Vec3::ONE));
    let half = DAffine3::from_translation(DVec3::new(-50.0, 0.0, -3.0))
        * DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2))
        * DAffine3::from_scale(DVec3::new(50.0, 1.0, 50.0));
    builder.shape(Shape::Rectangle, half, light).unwrap();
    builder.bounces(24).unwrap();
    let scene = builder.build().unwrap();

    let angle = 50_f64.to_radians();
    let inside = (angle.sin() / ior).asin();
    let moved = thickness * (angle - inside).sin() / inside.cos() / angle.cos();
    // A ray that would reach x at the wall; the pane moves it back by `moved`
    let at = |x: f64| {
        let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
        let wall = DVec3::new(x, 0.0, -3.0);
        let origin = wall - direction * (6.0 / angle.cos());
        mean(&scene, &Ray::new(origin, direction), 3000)
    };
    // Reflections inside leave the pane 2 t tan r further on each time: sum up those that still meet the lit side
    let once = f64::from(fresnel::dielectric(angle.cos() as f32, ior as f32));
    let step = 2.0 * thickness * inside.tan();
    let passing = |x: f64| {
        let terms = (0..12).filter(|n| x - moved + f64::from(*n) * step < 0.0);
        terms.map(|n| (1.0 - once).powi(2) * once.powi(2 * n)).sum::<f64>()
    };
    for x in [moved - 1.0, moved - 0.01, moved + 0.01] {
        let (found, error) = at(x);
        let expected = passing(x) as f32;
        assert!((found.x - expected).abs() <= SIGMAS * error + 1e-4, "{x}: {found} +- {error} instead of {expected}");
    }
}

#[test]
fn an_environment_lights_as_a_sky_of_its_radiance() {
    let texels = vec![Vec3::new(0.2, 0.5, 0.9); 32 * 16];
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::splat(0.5)));
    builder.shape(Shape::Sphere, DAffine3::IDENTITY, white).unwrap();
    builder.environment(Environment::new(32, 16, texels, 0.0).unwrap());
    let scene = builder.build().unwrap();
    assert_eq!(scene.needs(), ["environment map"]);
    let (mean, error) = mean(&scene, &Ray::new(DVec3::new(0.2, 0.3, 4.0), DVec3::NEG_Z), 3000);
    let expected = 0.5 * Vec3::new(0.2, 0.5, 0.9);
    assert!((mean - expected).abs().max_element() < SIGMAS * error + 1e-4, "{mean} +- {error}");
    // A miss sees it
    assert!((scene.radiance(&Ray::new(3.0 * DVec3::Z, DVec3::Z)) - 2.0 * expected).abs().max_element() < 1e-6);
}

#[test]
fn a_small_bright_spot_of_an_environment_is_found() {
    // The spot holds nearly all light: asked for, the error is small; met by chance it would be seen once in 2,000 paths
    let (width, height) = (64, 32);
    let mut texels = vec![Vec3::splat(0.01); width * height];
    texels[6 * width + 20] = Vec3::splat(4000.0);
    let environment = Environment::new(width, height, texels, 0.0).unwrap();
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    builder.shape(Shape::Plane, DAffine3::IDENTITY, white).unwrap();
    builder.environment(environment);
    builder.bounces(1).unwrap();
    let scene = builder.build().unwrap();
    let (mean, error) = mean(&scene, &Ray::new(DVec3::new(0.0, 1.0, 1.0), DVec3::new(0.0, -1.0, -1.0)), 20_000);
    assert!(error < 0.02 * mean.x, "{mean} +- {error}");
}

//! Scenes whose picture can be written down.

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{PixelWindow, Silent};
use trace::{Light, Material, Pigment, Ray, SceneBuilder, SceneError, Shape};

/// f32 rays of length about 10: 2^-24 x 10 twice over.
const RAY_ROUNDING: f64 = 2e-6;

fn single(shape: Shape, map: DAffine3) -> trace::Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    builder.shape(shape, map, white).unwrap();
    builder.build().unwrap()
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))
}

/// The distance and normal of the first hit of a ray whose direction has length 1.
#[track_caller]
fn expect(scene: &trace::Scene, ray: Ray, t: f64, normal: [f64; 3]) {
    let hit = scene.hit(&ray).expect("the ray should hit");
    assert!((hit.t - t).abs() < RAY_ROUNDING, "{} is not {t}", hit.t);
    let off = (hit.normal - DVec3::from_array(normal)).length();
    assert!(off < RAY_ROUNDING, "{} is not {normal:?}", hit.normal);
}

#[test]
fn a_sphere_is_hit_where_its_equation_says() {
    let scene = single(
        Shape::Sphere,
        DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), DQuat::IDENTITY, DVec3::new(0.0, 0.0, -10.0)),
    );
    expect(&scene, ray([0.0; 3], [0.0, 0.0, -1.0]), 8.0, [0.0, 0.0, 1.0]);
    // A chord at height 1.2 has half length 1.6
    expect(&scene, ray([0.0, 1.2, 0.0], [0.0, 0.0, -1.0]), 8.4, [0.0, 0.6, 0.8]);
    // From inside the far side is hit, its normal still outwards
    expect(&scene, ray([0.0, 1.2, -10.0], [0.0, 0.0, -1.0]), 1.6, [0.0, 0.6, -0.8]);
    assert!(scene.hit(&ray([0.0, 2.001, 0.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn a_turned_box_is_hit_where_its_corner_points() {
    // A cube of side 2 turned by 45 degrees shows an edge at sqrt(2) from its centre
    let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_4);
    let scene = single(Shape::Cuboid, DAffine3::from_rotation_translation(turn, DVec3::new(0.0, 0.0, -10.0)));
    let h = std::f64::consts::FRAC_1_SQRT_2;
    expect(&scene, ray([0.25, 0.0, 0.0], [0.0, 0.0, -1.0]), 10.0 - 2.0 * h + 0.25, [h, 0.0, h]);
    expect(&scene, ray([-0.25, 0.0, 0.0], [0.0, 0.0, -1.0]), 10.0 - 2.0 * h + 0.25, [-h, 0.0, h]);
    expect(&scene, ray([0.0, 5.0, -10.0], [0.0, -1.0, 0.0]), 4.0, [0.0, 1.0, 0.0]);
    assert!(scene.hit(&ray([2.0 * h + 0.001, 0.0, 0.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn a_cylinder_is_closed_and_round() {
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.5, 3.0, 0.5),
        DQuat::IDENTITY,
        DVec3::new(0.0, -1.0, -10.0),
    );
    let scene = single(Shape::Cylinder, map);
    expect(&scene, ray([0.3, 0.0, 0.0], [0.0, 0.0, -1.0]), 9.6, [0.6, 0.0, 0.8]);
    expect(&scene, ray([0.3, 5.0, -10.0], [0.0, -1.0, 0.0]), 3.0, [0.0, 1.0, 0.0]);
    expect(&scene, ray([0.3, -5.0, -10.0], [0.0, 1.0, 0.0]), 4.0, [0.0, -1.0, 0.0]);
    assert!(scene.hit(&ray([0.0, 2.001, 0.0], [0.0, 0.0, -1.0])).is_none());
    assert!(scene.hit(&ray([0.501, 0.0, 0.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn a_cone_is_closed_and_has_one_nappe() {
    // Base radius 2, height 4: its side rises 2 for each 1 inwards
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 4.0, 2.0),
        DQuat::IDENTITY,
        DVec3::new(0.0, 0.0, -10.0),
    );
    let scene = single(Shape::Cone, map);
    let (up, out) = (0.2_f64.sqrt(), 0.8_f64.sqrt());
    expect(&scene, ray([0.0, 2.0, 0.0], [0.0, 0.0, -1.0]), 9.0, [0.0, up, out]);
    expect(&scene, ray([0.5, -3.0, -10.0], [0.0, 1.0, 0.0]), 3.0, [0.0, -1.0, 0.0]);
    expect(&scene, ray([1.0, 9.0, -10.0], [0.0, -1.0, 0.0]), 7.0, [out, up, 0.0]);
    assert!(scene.hit(&ray([0.0, 4.5, 0.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn planes_and_rectangles_are_seen_from_both_sides() {
    let lift = DAffine3::from_translation(DVec3::new(0.0, 2.0, 0.0));
    let plane = single(Shape::Plane, lift);
    expect(&plane, ray([50.0, 5.0, 3.0], [0.0, -1.0, 0.0]), 3.0, [0.0, 1.0, 0.0]);
    expect(&plane, ray([0.0, 0.0, 0.0], [0.6, 0.8, 0.0]), 2.5, [0.0, 1.0, 0.0]);
    assert!(plane.hit(&ray([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])).is_none());
    let rectangle = single(Shape::Rectangle, lift);
    expect(&rectangle, ray([0.99, 5.0, -0.99], [0.0, -1.0, 0.0]), 3.0, [0.0, 1.0, 0.0]);
    assert!(rectangle.hit(&ray([1.01, 5.0, 0.0], [0.0, -1.0, 0.0])).is_none());
}

#[test]
fn a_mesh_lies_where_its_vertices_are() {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    let vertices = [[-1.0, -1.0, -4.0], [1.0, -1.0, -4.0], [0.0, 1.0, -4.0]].map(DVec3::from_array);
    let dropped = builder.mesh(&vertices, &[[0, 1, 2], [0, 0, 1]], |_| white, DAffine3::from_scale(DVec3::splat(2.0)));
    assert_eq!(dropped.unwrap(), 1, "a triangle without area is left out");
    let missing = builder.mesh(&vertices, &[[0, 1, 3]], |_| white, DAffine3::IDENTITY);
    assert!(matches!(missing, Err(SceneError::NoSuchVertex { triangle: 0, vertex: 3, count: 3 })));
    let scene = builder.build().unwrap();
    expect(&scene, ray([0.0; 3], [0.0, 0.0, -1.0]), 8.0, [0.0, 0.0, 1.0]);
    expect(&scene, ray([0.0, 0.0, -20.0], [0.0, 0.0, 1.0]), 12.0, [0.0, 0.0, 1.0]);
    assert!(scene.hit(&ray([0.0, 2.01, 0.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn base_shading_is_ambient_plus_sun_with_hard_shadows() {
    let mut builder = SceneBuilder::new();
    let floor = builder.material(Material {
        pigment: Pigment::Checker { colors: [Vec3::splat(0.8), Vec3::splat(0.1)], side: 1.0, axes: [0, 2] },
        emission: Vec3::ZERO,
    });
    let lid = builder.material(Material::matte(Vec3::ONE));
    builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
    let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, DVec3::new(0.0, 2.0, 0.0));
    builder.shape(Shape::Sphere, map, lid).unwrap();
    builder.light(Light::Ambient { strength: Vec3::splat(0.25) });
    builder.light(Light::sun(DVec3::new(0.0, 4.0, 3.0), Vec3::splat(0.75)).unwrap());
    let scene = builder.build().unwrap();
    let down = |x: f64, z: f64| scene.radiance(&ray([x, 1.0, z], [0.0, -1.0, 0.0])).x;
    // The sun is 3 : 4 from the zenith: n . l = 0.8
    let close = |a: f32, b: f32| (a - b).abs() < 1e-6; // a few f32 roundings
    assert!(close(down(3.5, 3.5), 0.8 * (0.25 + 0.75 * 0.8)));
    assert!(close(down(3.5, 4.5), 0.1 * (0.25 + 0.75 * 0.8)));
    assert!(close(down(-0.5, 0.5), 0.1 * (0.25 + 0.75 * 0.8)));
    // The ball's shadow falls at z = -1.5
    assert!(close(down(0.25, -1.5), 0.8 * 0.25));
    // Seen from below the floor's normal turns, and the floor shades itself
    assert!(close(scene.radiance(&ray([3.5, -1.0, 3.5], [0.0, 1.0, 0.0])).x, 0.8 * 0.25));
}

#[test]
fn nothing_shades_itself() {
    // Tessellated and analytic bodies under a sun: the lit side must be lit everywhere (no acne), far from the origin too
    for distance in [1.0, 100.0, 10_000.0] {
        let mut builder = SceneBuilder::new();
        let white = builder.material(Material::matte(Vec3::ONE));
        let centre = DVec3::new(distance, 0.3 * distance, -distance);
        builder.shape(Shape::Sphere, DAffine3::from_translation(centre), white).unwrap();
        builder.light(Light::sun(DVec3::new(0.3, 1.0, 0.5), Vec3::ONE).unwrap());
        let scene = builder.build().unwrap();
        let sun = DVec3::new(0.3, 1.0, 0.5).normalize();
        for i in 0..10_000 {
            let (a, b) = (f64::from(i) * 0.618_034 % 1.0, f64::from(i) / 10_000.0);
            let outside = centre + 3.0 * DVec3::new((a * 6.3).cos(), 2.0 * b - 1.0, (a * 6.3).sin());
            let ray = Ray::new(outside, centre - outside);
            let hit = scene.hit(&ray).expect("a ray to the centre hits");
            let cosine = hit.normal.dot(sun);
            // f32 rays far away see another point of the ball; within 1e-3 of the terminator either answer is fair
            if cosine > 1e-3 {
                let light = f64::from(scene.radiance(&ray).x);
                assert!((light - cosine).abs() < 1e-5, "{light} instead of {cosine} at {distance}");
            }
        }
    }
}

/// Tilted, swung, wide open, focused behind the camera in part of the picture.
fn hard_cameras() -> Vec<Camera> {
    let pose = Pose::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y).unwrap();
    let film = Film::from_fov(1.2, 24, 16).unwrap();
    let polygon = ApertureShape::polygon(5, 0.3).unwrap();
    let build = |w: [f64; 3], normal: [f64; 3], radius, shape| Camera {
        pose,
        film,
        focus: Focus::new(DVec3::from_array(w)).unwrap(),
        iris: Iris::new(DVec3::from_array(normal), radius, shape).unwrap(),
    };
    vec![
        build([0.0, 0.0, 0.3], [0.0, 0.0, 1.0], 0.0, ApertureShape::Disc),
        build([0.0, 0.0, 0.3], [0.0, 0.0, 1.0], 0.5, ApertureShape::Disc),
        build([0.0, -0.9, 0.1], [0.1, -0.3, 1.0], 0.7, ApertureShape::Disc),
        build([0.6, 0.4, -0.2], [-0.2, 0.1, 1.0], 0.4, polygon),
    ]
}

#[test]
fn a_furnace_stays_one_through_every_lens() {
    // Sky of 1, a glowing ball of 1 and a white floor under ambient light of 1: nothing can be seen
    let mut builder = SceneBuilder::new();
    let glow = builder.material(Material::glowing(Vec3::ONE));
    let white = builder.material(Material::matte(Vec3::ONE));
    builder.shape(Shape::Sphere, DAffine3::IDENTITY, glow).unwrap();
    builder.shape(Shape::Plane, DAffine3::from_translation(DVec3::NEG_Y), white).unwrap();
    builder.light(Light::Ambient { strength: Vec3::ONE });
    builder.sky(Vec3::ONE);
    let scene = builder.build().unwrap();
    for camera in hard_cameras() {
        // The border beyond the display window too
        let window = PixelWindow::of_size(24, 16).grown(5, 5);
        let truth = trace::truth(&scene, &camera, window, 10, 3, &Silent).unwrap();
        assert!(truth.picture().planes().iter().all(|plane| plane.values().iter().all(|&x| x == 1.0)));
        assert_eq!(truth.noise_rmse(window), 0.0);
    }
}

#[test]
fn a_pinhole_sees_a_ball_as_large_as_geometry_says() {
    // A glowing ball of radius r at distance d covers a disc of tan(asin(r / d)) in q
    let mut builder = SceneBuilder::new();
    let glow = builder.material(Material::glowing(Vec3::ONE));
    builder.shape(Shape::Sphere, DAffine3::from_translation(DVec3::new(0.0, 0.0, -5.0)), glow).unwrap();
    let scene = builder.build().unwrap();
    let camera = Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::splat(-0.5), DVec2::splat(0.5), 60, 60).unwrap(),
        focus: Focus::at_depth(5.0).unwrap(),
        iris: Iris::pinhole(),
    };
    let window = PixelWindow::of_size(60, 60);
    let picture = trace::truth(&scene, &camera, window, 256, 1, &Silent).unwrap().picture();
    let covered: f64 = picture.planes()[0].values().iter().map(|&x| f64::from(x)).sum();
    let radius = (0.2_f64).asin().tan() * 60.0;
    let area = std::f64::consts::PI * radius * radius;
    // About 80 rim pixels with a standard error of 0.01 each: 0.1 px in all
    assert!((covered - area).abs() < 0.4, "{covered} px instead of {area}");
}

#[test]
fn bad_requests_are_errors() {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    let flat = builder.shape(Shape::Sphere, DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)), white);
    assert!(matches!(flat, Err(SceneError::FlatPlacement)));
    assert!(builder.metres_per_unit(-1.0).is_err());
    assert!(Light::sun(DVec3::ZERO, Vec3::ONE).is_err());
    let bright = |emission| {
        let mut builder = SceneBuilder::new();
        builder.material(Material::glowing(emission));
        builder.build()
    };
    assert!(bright(Vec3::splat(1e5)).is_ok());
    for emission in [Vec3::splat(1e6), Vec3::new(0.0, -1.0, 0.0), Vec3::NAN] {
        assert!(matches!(bright(emission), Err(SceneError::OutOfRange { .. })), "{emission}");
    }
}

//! Scenes with light transport are rendered as all others: in parts, to the same bits, with honest noise, in layers.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Mask, PixelWindow, Silent};
use trace::{
    Accumulation, Alpha, Finish, Goal, Job, LayerSettings, Light, Margin, Material, MeshDetail, Scene, SceneBuilder,
    SceneFile, Texture, TextureMap, Wrap, layers, render, truth,
};

const TABLE: &str = r#"
format = 1
sky = [0.3, 0.4, 0.5]
[materials]
floor = { checker = { colors = [0.7, 0.2], side = 0.5 }, roughness = 0.3 }
chrome = { color = 0.9, metallic = 1.0, roughness = 0.05 }
clear = { glass = { ior = 1.5 } }
lamp = { emission = 30, area_light = true }
[shapes]
ground = { plane = {} }
ball = { sphere = { radius = 0.5 } }
bulb = { sphere = { radius = 0.1 } }
[[objects]]
shape = "ground"
material = "floor"
[[objects]]
shape = "ball"
material = "chrome"
placements = [{ translate = [-0.6, 0.5, 0] }]
[[objects]]
shape = "ball"
material = "clear"
placements = [{ translate = [0.6, 0.5, 0.4] }]
[[objects]]
shape = "bulb"
material = "lamp"
placements = [{ translate = [0.2, 2, 1] }]
[render]
bounces = 4
"#;

fn table() -> SceneFile {
    SceneFile::parse(TABLE, "table.toml").unwrap()
}

fn camera(cat_eye: f64) -> Camera {
    let camera = Camera {
        pose: Pose::look_at(DVec3::new(0.0, 1.5, 4.0), DVec3::new(0.0, 0.4, 0.0), DVec3::Y).unwrap(),
        film: Film::from_fov(0.7, 24, 16).unwrap(),
        focus: Focus::new(DVec3::new(0.02, -0.05, 0.25)).unwrap(),
        iris: Iris::new(DVec3::new(0.05, -0.1, 1.0), 0.08, ApertureShape::Disc).unwrap(),
    };
    camera.with_cat_eye(cat_eye).unwrap()
}

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 24, height: 16 };

#[test]
fn parts_of_samples_and_pixels_join_to_the_bits_of_the_whole() {
    let file = table();
    assert_eq!(file.scene().bounces(), 4);
    for cat_eye in [0.0, 0.6] {
        let camera = camera(cat_eye);
        let part =
            |window: PixelWindow, samples| render(file.scene(), &camera, &window.into(), samples, 5, &Silent).unwrap();
        let whole = part(WINDOW, 0..12);
        let left = PixelWindow { width: 10, ..WINDOW };
        let right = PixelWindow { x: 10, width: 14, ..WINDOW };
        let parts = [part(right, 5..12), part(left, 0..12), part(right, 0..5)];
        assert!(Accumulation::join(parts).unwrap() == whole);
        // Any set of pixels
        let mask = Mask::from_fn(WINDOW, |x, y| (x + y) % 3 == 0);
        let some = render(file.scene(), &camera, &mask.into(), 0..12, 5, &Silent).unwrap().picture();
        let all = whole.picture();
        assert!((0..16).all(|y| (0..24).filter(|x| (x + y) % 3 == 0).all(|x| some.at(x, y) == all.at(x, y))));
        // Any number of threads
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert!(one.install(|| part(WINDOW, 0..12)) == whole);
    }
}

#[test]
fn samples_that_go_where_they_count_leave_the_mean_alone() {
    let file = table();
    let camera = camera(0.0);
    let fixed = truth(file.scene(), &camera, WINDOW, 512, 1, &Silent).unwrap();
    // Means over the whole picture of eight adaptive renders, against one with a fixed number
    let mean = |picture: &rgbd::Picture| {
        let values = WINDOW.pixels().map(|(x, y)| f64::from(picture.at(x, y)[1]));
        values.sum::<f64>() / WINDOW.area() as f64
    };
    let means: Vec<f64> = (2..10)
        .map(|seed| {
            let mut job = Job::new(camera, WINDOW, seed);
            job.run(file.scene(), &Goal::Noise { rmse: 0.02, most: 256 }, &Silent).unwrap();
            mean(&job.sums().picture())
        })
        .collect();
    let average = means.iter().sum::<f64>() / 8.0;
    let scatter = (means.iter().map(|m| (m - average).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt();
    let noise = fixed.noise_rmse(WINDOW) / (WINDOW.area() as f64).sqrt();
    // Student's t with 7 degrees of freedom exceeds 5.4 once in a thousand
    let limit = 5.4 * (scatter * scatter + noise * noise).sqrt();
    let expected = mean(&fixed.picture());
    assert!((average - expected).abs() < limit, "{average} {expected} +- {limit}");
}

#[test]
fn the_noise_that_is_stated_is_that_which_is_there() {
    let file = table();
    let camera = camera(0.0);
    let truths: Vec<_> = (0..8).map(|seed| truth(file.scene(), &camera, WINDOW, 32, seed, &Silent).unwrap()).collect();
    let stated = (truths.iter().map(|truth| truth.noise_rmse(WINDOW).powi(2)).sum::<f64>() / 8.0).sqrt();
    let mut squares = 0.0;
    for (x, y) in WINDOW.pixels() {
        for c in 0..3 {
            let values: Vec<f64> = truths.iter().map(|truth| f64::from(truth.picture().at(x, y)[c])).collect();
            let mean = values.iter().sum::<f64>() / 8.0;
            squares += values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 7.0;
        }
    }
    let found = (squares / (3.0 * WINDOW.area() as f64)).sqrt();
    // A few bright paths make most of it: 8 pictures tell it to some 20 %
    assert!((0.7..1.4).contains(&(stated / found)), "stated {stated}, found {found}");
}

/// A wall with a masked hole in its right half, before a floor.
fn holed() -> Scene {
    let texels = [[1.0, 0.2, 0.1, 1.0], [1.0, 1.0, 1.0, 0.0]];
    let texture = Arc::new(Texture::from_linear(2, 1, &texels).unwrap());
    let map = TextureMap { wrap: [Wrap::Clamp; 2], ..TextureMap::new(texture) };
    let finish = Finish { color_map: Some(map), alpha: Alpha::Mask(0.5), ..Finish::default() };
    let mut builder = SceneBuilder::new();
    let wall = builder.finished(Material::matte(Vec3::ONE), finish);
    let back = builder.material(Material::matte(Vec3::new(0.1, 0.3, 0.9)));
    let square = |size: f64, z: f64| {
        [(-size, -size), (size, -size), (size, size), (-size, size)].map(|(x, y)| DVec3::new(x, y, z))
    };
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let uv = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v));
    let uvs = triangles.map(|corners| corners.map(|i| uv[i as usize])).to_vec();
    let detail = Arc::new(MeshDetail { uvs: [uvs, Vec::new()], ..MeshDetail::default() });
    builder.detailed_mesh(&square(1.0, 0.0), &triangles, |_| wall, DAffine3::IDENTITY, &detail).unwrap();
    builder.mesh(&square(9.0, -3.0), &triangles, |_| back, DAffine3::IDENTITY).unwrap();
    builder.light(Light::Ambient { strength: Vec3::ONE });
    builder.build().unwrap()
}

#[test]
fn holes_of_a_mask_are_holes_in_depth_and_layers() {
    let scene = holed();
    let camera = Camera {
        pose: Pose::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y).unwrap(),
        film: Film::from_fov(0.5, 40, 20).unwrap(),
        focus: Focus::at_depth(4.0).unwrap(),
        iris: Iris::upright(0.2, ApertureShape::Disc).unwrap(),
    };
    let settings = LayerSettings { margin: Margin::Pixels(0), color_samples: 16, ..LayerSettings::default() };
    let frame = layers(&scene, &camera, &settings, &Silent).unwrap().frame;
    let [first, hidden] = frame.layers() else { panic!("two layers") };
    let depth = |x: i32| first.depth.at(x, 10);
    assert!((depth(8) - 4.0).abs() < 1e-4 && (depth(32) - 7.0).abs() < 1e-4, "{} {}", depth(8), depth(32));
    let color = |x: i32| Vec3::from_slice(&first.color.at(x, 10)[..3]);
    assert!((color(8) - Vec3::new(1.0, 0.2, 0.1)).abs().max_element() < 1e-3, "{}", color(8));
    assert!((color(32) - Vec3::new(0.1, 0.3, 0.9)).abs().max_element() < 1e-3);
    // Beside the hole's rim the lens sees the back behind the wall
    assert!(hidden.known.at(19, 10) && (hidden.depth.at(19, 10) - 7.0).abs() < 1e-4);
    assert!(!hidden.known.at(32, 10));
}

/// A sheet whose back is seen, behind the edge of a near card.
#[test]
fn the_back_of_a_leaf_is_a_hidden_surface_if_it_has_two_sides() {
    let hidden = |is_double_sided: bool| {
        let mut builder = SceneBuilder::new();
        let grey = builder.material(Material::matte(Vec3::splat(0.5)));
        let leaf = builder.finished(Material::matte(Vec3::Y), Finish { is_double_sided, ..Finish::default() });
        let square =
            |z: f64, left: f64| [(left, -9.0), (9.0, -9.0), (9.0, 9.0), (left, 9.0)].map(|(x, y)| DVec3::new(x, y, z));
        builder.mesh(&square(0.0, 0.0), &[[0, 1, 2], [0, 2, 3]], |_| grey, DAffine3::IDENTITY).unwrap();
        builder.mesh(&square(-2.0, -9.0), &[[0, 2, 1], [0, 3, 2]], |_| leaf, DAffine3::IDENTITY).unwrap();
        builder.light(Light::Ambient { strength: Vec3::ONE });
        let scene = builder.build().unwrap();
        let camera = Camera {
            pose: Pose::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y).unwrap(),
            film: Film::from_fov(0.5, 40, 20).unwrap(),
            focus: Focus::at_depth(6.0).unwrap(),
            iris: Iris::upright(0.2, ApertureShape::Disc).unwrap(),
        };
        let settings = LayerSettings { margin: Margin::Pixels(0), color_samples: 8, ..LayerSettings::default() };
        let frame = layers(&scene, &camera, &settings, &Silent).unwrap().frame;
        let layer = &frame.layers()[1];
        (layer.known.at(20, 10), layer.depth.at(20, 10), layer.color.at(20, 10)[1])
    };
    assert_eq!(hidden(true), (true, 6.0, 1.0));
    assert!(!hidden(false).0);
}

#[test]
fn layers_of_a_path_traced_scene_have_the_colour_of_its_picture() {
    let file = table();
    let settings = LayerSettings { margin: Margin::Pixels(2), color_samples: 32, ..LayerSettings::default() };
    let frame = layers(file.scene(), &camera(0.0), &settings, &Silent).unwrap().frame;
    let pinhole = camera(0.0).pinhole();
    let plain = render(file.scene(), &pinhole, &frame.data().into(), 0..16, settings.seed, &Silent).unwrap().picture();
    let color = &frame.layers()[0].color;
    assert!(frame.data().pixels().all(|(x, y)| color.at(x, y) == plain.at(x, y)));
    let values =
        frame.layers().iter().flat_map(|layer| layer.color.window().pixels().map(|(x, y)| layer.color.at(x, y)));
    assert!(values.flatten().all(f32::is_finite));
    // The first hit is what depth tells, mirror and glass too
    let at = |x: i32, y: i32| frame.layers()[0].depth.at(x, y);
    assert!(at(5, 8) < 4.6 && at(17, 8) < 4.3, "{} {}", at(5, 8), at(17, 8));
}

#[test]
fn the_log_can_say_why() {
    let file = table();
    let needs = file.scene().needs().join(", ");
    for reason in ["glossy material 'chrome'", "glass material 'clear'", "area light 'lamp'"] {
        assert!(needs.contains(reason), "{needs}");
    }
    // Neither what nothing is made of, nor bounces that are not wanted
    let unused = TABLE.replace("shape = \"ball\"\nmaterial = \"clear\"", "shape = \"ball\"\nmaterial = \"chrome\"");
    assert!(!SceneFile::parse(&unused, "t").unwrap().scene().needs().join(", ").contains("glass"));
    let flat = SceneFile::parse(&TABLE.replace("bounces = 4", "bounces = 0"), "t").unwrap();
    assert_eq!((flat.scene().bounces(), flat.scene().needs().len()), (0, 0));
    assert!(SceneFile::parse(&TABLE.replace("bounces = 4", "bounces = 5000"), "t").is_err());
}

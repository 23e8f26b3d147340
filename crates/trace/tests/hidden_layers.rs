//! What the RGB-D frame holds behind the first surface, and around the picture.
#![allow(clippy::print_stdout)] // tests say what they measured

mod reference_case;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use optics::{ApertureShape, Camera, DepthRange, Film, Focus, Iris, Pose};
use rgbd::{PixelWindow, Silent};
use trace::{LayerSettings, LayeredFrame, Light, Margin, Material, Scene, SceneBuilder, Shape};

const RED: Vec3 = Vec3::new(0.8, 0.1, 0.1);
const GREEN: Vec3 = Vec3::new(0.1, 0.7, 0.1);

/// A card in the left half of the view at depth 5, and a wall at depth 10 if there is one.
fn card(wall: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let (red, green) = (builder.material(Material::glowing(RED)), builder.material(Material::glowing(GREEN)));
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let sheet = |half: f64, x: f64, depth: f64| {
        DAffine3::from_scale_rotation_translation(DVec3::splat(half), upright, DVec3::new(x, 0.0, -depth))
    };
    builder.shape(Shape::Rectangle, sheet(20.0, -20.0, 5.0), red).unwrap();
    if wall {
        builder.shape(Shape::Plane, sheet(1.0, 0.0, 10.0), green).unwrap();
    }
    builder.sky(Vec3::new(0.2, 0.3, 0.9));
    builder.build().unwrap()
}

fn camera(focus: [f64; 3], radius: f64) -> Camera {
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::new(-0.5, -0.25), DVec2::new(0.5, 0.25), 100, 50).unwrap(),
        focus: Focus::new(DVec3::from_array(focus)).unwrap(),
        iris: Iris::upright(radius, ApertureShape::Disc).unwrap(),
    }
}

fn make(scene: &Scene, camera: &Camera, count: usize, margin: Margin) -> LayeredFrame {
    trace::layers(scene, camera, &LayerSettings { count, margin, ..LayerSettings::default() }, &Silent).unwrap()
}

/// Columns of a row in which the second layer holds something.
fn hidden_columns(made: &LayeredFrame, row: i32) -> Vec<i32> {
    let layer = &made.frame.layers()[1];
    let window = layer.window();
    (window.x..window.x_end()).filter(|&x| layer.known.at(x, row)).collect()
}

#[test]
fn a_hidden_layer_is_as_wide_as_the_lens_sees_behind() {
    // Through the rim of a lens of radius R the card's edge moves by R (1/5 - 1/10) before the wall: 10 px for R = 1
    let scene = card(true);
    for radius in [0.5, 1.0, 2.0] {
        let made = make(&scene, &camera([0.0, 0.0, 0.2], radius), 2, Margin::Pixels(0));
        let columns = hidden_columns(&made, 25);
        let width = radius * 0.1 * 100.0;
        // Half a pixel of rounding, and rim points up to 7.5 degrees beside the widest one
        let off = (columns.len() as f64 - width).abs();
        assert!(off <= 0.5 + 0.01 * width, "{} columns instead of {width}", columns.len());
        assert_eq!(columns.last(), Some(&49), "the band ends at the card's edge");
        let layer = &made.frame.layers()[1];
        for &x in &columns {
            assert!((layer.depth.at(x, 25) - 10.0).abs() < 1e-5);
            // At the rim of what is seen it is seen in a part of the pixel
            let cover = layer.color.at(x, 25)[3];
            assert!(cover == 1.0 || (Some(&x) == columns.first() && cover > 0.0), "column {x} is covered by {cover}");
            let expected = [GREEN.x, GREEN.y, GREEN.z].map(|c| c * cover);
            assert!((0..3).all(|c| (layer.color.at(x, 25)[c] - expected[c]).abs() < 1e-6));
        }
        assert_eq!(layer.color.at(5, 25), [0.0; 4]);
        assert_eq!(made.frame.camera.unwrap().iris.radius(), radius);
    }
}

#[test]
fn the_sky_can_be_hidden_too() {
    let made = make(&card(false), &camera([0.0, 0.0, 0.2], 0.5), 3, Margin::Pixels(0));
    // The sky's parallax is the whole R / 5: 10 px
    let columns = hidden_columns(&made, 25);
    assert!((columns.len() as f64 - 10.0).abs() <= 1.0, "{columns:?}");
    let [first, second, third] = made.frame.layers() else { panic!("three layers") };
    assert_eq!(second.depth.at(45, 25), f32::INFINITY);
    assert!(second.known.at(45, 25));
    assert_eq!(second.color.at(45, 25), [0.2, 0.3, 0.9, 1.0]);
    assert_eq!(first.depth.at(60, 25), f32::INFINITY);
    assert_eq!(third.known.count(), 0);
}

#[test]
fn nothing_inside_solids_and_nothing_that_no_lens_point_sees() {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    builder.shape(Shape::Plane, DAffine3::from_translation(DVec3::new(0.0, -1.0, 0.0)), white).unwrap();
    builder.shape(Shape::Cuboid, DAffine3::from_translation(DVec3::new(0.0, 0.0, -8.0)), white).unwrap();
    builder
        .shape(
            Shape::Sphere,
            DAffine3::from_scale_rotation_translation(DVec3::splat(0.3), DQuat::IDENTITY, DVec3::new(0.0, 0.0, -8.0)),
            white,
        )
        .unwrap();
    builder.light(Light::Ambient { strength: Vec3::ONE });
    let scene = builder.build().unwrap();
    let camera = Camera {
        pose: Pose::look_at(DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.0, 0.0, -8.0), DVec3::Y).unwrap(),
        ..camera([0.0, 0.0, 0.125], 0.3)
    };
    let made = make(&scene, &camera, 4, Margin::Pixels(0));
    let [_, second, third, _] = made.frame.layers() else { panic!("four layers") };
    assert!(second.known.count() > 20, "the floor beside the box is seen");
    for (x, y) in second.window().pixels().filter(|&(x, y)| second.known.at(x, y) && second.depth.at(x, y).is_finite())
    {
        // Everything hidden lies on the floor, outside the box
        let q = camera.film.q_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let p = camera.pose.point_to_world(q.extend(1.0) * f64::from(second.depth.at(x, y)));
        assert!((p.y + 1.0).abs() < 1e-4, "{p}");
        assert!(p.x.abs() > 0.999 || (p.z + 8.0).abs() > 0.999, "{p} lies under the box");
    }
    assert_eq!(third.known.bits().iter().filter(|&&known| known).count(), 0);
}

#[test]
fn a_pinhole_sees_nothing_behind() {
    let made = make(&card(true), &camera([0.0, 0.0, 0.2], 0.0), 2, Margin::Needed { cap: 0.25 });
    assert_eq!(made.frame.layers()[1].known.count(), 0);
    assert_eq!(made.needed_margin, [0, 0]);
}

#[test]
fn the_margin_is_what_the_lens_needs() {
    // A wall at depth 10 alone: the same as the closed form's bounds, plus at most 2 px
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::matte(Vec3::ONE));
    let map = DAffine3::from_rotation_translation(
        DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        DVec3::new(0.0, 0.0, -10.0),
    );
    builder.shape(Shape::Plane, map, white).unwrap();
    let scene = builder.build().unwrap();
    for focus in [[0.0, 0.0, 0.2], [0.1, -0.1, 0.1]] {
        let camera = camera(focus, 0.6);
        let needed = camera.overscan(&DepthRange::new(10.0, 10.0).unwrap());
        let wanted = [needed.columns(1000), needed.rows(1000)];
        let made = make(&scene, &camera, 1, Margin::Needed { cap: 1.0 });
        for axis in 0..2 {
            let (got, wanted) = (made.needed_margin[axis], wanted[axis]);
            assert!((wanted..=wanted + 2).contains(&got), "{got} px, {wanted} needed");
        }
        assert!(!made.is_capped());
        let window = PixelWindow::of_size(100, 50).grown(made.margin[0], made.margin[1]);
        assert_eq!(made.frame.data(), window);
        let capped = make(&scene, &camera, 1, Margin::Needed { cap: 0.02 });
        assert_eq!(capped.margin[0], 2);
        assert!(capped.is_capped());
    }
}

#[test]
fn threads_do_not_change_layers() {
    let scene = card(true);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make(&scene, &camera([0.1, -0.1, 0.15], 1.0), 2, Margin::Needed { cap: 0.25 }))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}

#[test]
fn depth_and_hidden_layer_agree_with_the_reference() {
    let Some(folder) = reference_case::folder() else { return };
    for (name, radius) in [("simple", 0.6), ("landscape", 5.0)] {
        let scene = reference_case::scene(&folder, name);
        let case = reference_case::Case::read(&folder, &format!("{name}_pinhole"));
        let iris = Iris::upright(radius, ApertureShape::Disc).unwrap();
        let camera = Camera { iris, ..case.camera };
        let made = make(&scene, &camera, 2, Margin::Pixels(56));
        let path = folder.join(format!("{name}_rgbd.exr"));
        let window = made.frame.data();
        let [z, hidden_z, hidden_r] =
            ["Z", "L2.Z", "L2.R"].map(|channel| reference_case::plane(&path, channel, window));
        // The first hit, up to pixels whose centre grazes an edge
        let close = |share: f32, a: f32, b: f32| a == b || ((a - b) / b).abs() < share;
        let first = &made.frame.layers()[0];
        let area = window.area() as f64;
        let off = window.pixels().filter(|&(x, y)| !close(1e-5, first.depth.at(x, y), z.at(x, y))).count();
        assert!((off as f64) < 2e-4 * area, "{name}: {off} first depths differ");
        // The hidden layer: the same 48 points up to their angles, so its rim may differ. Their rays go on beside the
        // pixel's line, by the same bias as their shadow rays: 9 mm at 100 m
        let second = &made.frame.layers()[1];
        let (mut both, mut either, mut depths_off, mut color_off) = (0, 0, 0, 0.0);
        for (x, y) in window.pixels() {
            // They ask at the centre of a pixel alone what is seen, so that it is all or nothing
            let (ours, theirs) = (second.color.at(x, y)[3] > 0.5, !hidden_z.at(x, y).is_nan());
            either += usize::from(ours || theirs);
            if ours && theirs {
                both += 1;
                depths_off += usize::from(!close(5e-4, second.depth.at(x, y), hidden_z.at(x, y)));
                color_off += f64::from(held(&made, 1, x, y).1.x - hidden_r.at(x, y));
            }
        }
        let share = both as f64 / either as f64;
        println!("{name}: {either} hidden pixels, {share:.4} in common, {depths_off} depths differ");
        // Measured: 0.987 and 0.970; points of a pixel and its centre disagree at the rim of what is seen
        assert!(share > 0.96, "{name}: only {share} of the hidden pixels are common");
        assert!((depths_off as f64) < 0.005 * both as f64, "{name}: {depths_off} of {both} hidden depths differ");
        // Their colour is one sample, ours an average
        assert!((color_off / both as f64).abs() < 0.01, "{name}: hidden colours are off by {color_off}");
    }
}

/// The camera with its film moved by a share of a pixel, so that what lay on the border of pixel 50 lies at 50 + `by`.
fn moved(camera: &Camera, by: f64) -> Camera {
    let half = DVec2::new(0.5, 0.25);
    let by = DVec2::new(by / 100.0, 0.0);
    Camera { film: Film::new(-half - by, half - by, 100, 50).unwrap(), ..*camera }
}

#[test]
fn the_rest_of_a_pixel_is_what_the_other_surface_fills() {
    let lens = camera([0.0, 0.0, 0.2], 0.5);
    // The card ends at 50.3, so that the centre of pixel 50 sees the wall; at 50.7 it sees the card
    for (edge, share, depth, color) in [(0.3, 0.3, 5.0, RED), (0.7, 0.3, 10.0, GREEN)] {
        let frame = make(&card(true), &moved(&lens, edge), 2, Margin::Pixels(2)).frame;
        let rest = frame.rest().expect("a frame of two layers knows it");
        for y in frame.data().y..frame.data().y_end() {
            let found = rest.at(50, y).expect("two surfaces");
            // The end cuts one of a half's 32 strata, and the mean colour counts as these do
            assert!((found.rgba[3] - share).abs() <= 2.0 / 64.0, "{} of {share}", found.rgba[3]);
            assert!((found.depth - depth).abs() < 1e-5);
            let expected = [color.x, color.y, color.z].map(|c| c * found.rgba[3]);
            assert!((0..3).all(|c| (found.rgba[c] - expected[c]).abs() < 1e-6), "{:?}", found.rgba);
            // Colour less the rest is the other surface's alone
            let own = if color == RED { GREEN } else { RED };
            let left = frame.layers()[0].color.at(50, y)[0] - found.rgba[0];
            assert!((left - own.x * (1.0 - found.rgba[3])).abs() < 1e-6);
            assert_eq!((rest.at(49, y), rest.at(51, y)), (None, None), "pixels of one surface have none");
        }
    }
    assert!(
        make(&card(true), &lens, 1, Margin::Pixels(0)).frame.rest().is_none(),
        "one layer is what any renderer writes"
    );
}

#[test]
fn a_wire_between_the_centres_of_pixels_is_found() {
    let mut builder = SceneBuilder::new();
    let (red, green) = (builder.material(Material::glowing(RED)), builder.material(Material::glowing(GREEN)));
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let wall = DAffine3::from_scale_rotation_translation(DVec3::ONE, upright, DVec3::new(0.0, 0.0, -10.0));
    builder.shape(Shape::Plane, wall, green).unwrap();
    // 0.4 pixels wide at depth 5, from 50.05 to 50.45
    let size = DVec3::new(0.01, 20.0, 20.0);
    let wire = DAffine3::from_scale_rotation_translation(size, upright, DVec3::new(0.0125, 0.0, -5.0));
    builder.shape(Shape::Rectangle, wire, red).unwrap();
    let scene = builder.build().unwrap();
    let frame = make(&scene, &camera([0.0, 0.0, 0.1], 0.5), 2, Margin::Pixels(0)).frame;
    assert!(frame.layers()[0].depth.values().iter().all(|&z| (z - 10.0).abs() < 1e-5), "no centre meets it");
    for (x, y) in frame.data().pixels() {
        match frame.rest().unwrap().at(x, y) {
            Some(found) => {
                assert_eq!(x, 50);
                // Each end cuts one of a half's 32 strata
                assert!((found.rgba[3] - 0.4).abs() <= 4.0 / 64.0, "{}", found.rgba[3]);
                assert!((found.depth - 5.0).abs() < 1e-5);
            }
            None => assert_ne!(x, 50, "row {y}"),
        }
    }
}

const BLUE: Vec3 = Vec3::new(0.1, 0.2, 0.9);

/// A card in the left half of the view at depth 5, behind it a blue one from column `from` to column `to` at depth 8, and a
/// wall at depth 10.
fn two_cards(from: f64, to: f64) -> Scene {
    let mut builder = SceneBuilder::new();
    let [red, green, blue] = [RED, GREEN, BLUE].map(|color| builder.material(Material::glowing(color)));
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let sheet = |half: f64, x: f64, depth: f64| {
        DAffine3::from_scale_rotation_translation(DVec3::new(half, 20.0, 20.0), upright, DVec3::new(x, 0.0, -depth))
    };
    builder.shape(Shape::Rectangle, sheet(20.0, -20.0, 5.0), red).unwrap();
    let [from, to] = [from, to].map(|column| 8.0 * (column - 50.0) / 100.0);
    builder.shape(Shape::Rectangle, sheet(0.5 * (to - from), 0.5 * (from + to), 8.0), blue).unwrap();
    builder.shape(Shape::Plane, sheet(1.0, 0.0, 10.0), green).unwrap();
    builder.build().unwrap()
}

/// Alpha, colour as if it filled the pixel, and depth of a layer.
fn held(made: &LayeredFrame, layer: usize, x: i32, y: i32) -> (f32, Vec3, f32) {
    let layer = &made.frame.layers()[layer];
    assert_eq!(layer.known.at(x, y), layer.color.at(x, y)[3] > 0.0);
    let [r, g, b, a] = layer.color.at(x, y);
    (a, Vec3::new(r, g, b) / a, layer.depth.at(x, y))
}

#[test]
fn a_hidden_edge_covers_its_share_of_a_pixel() {
    let lens = camera([0.0, 0.0, 0.2], 1.0);
    // Lens points look up to 7.5 columns behind the red card onto the blue one, and past its end onto the wall
    for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
        let scene = two_cards(-50.0, 45.0 + f64::from(share));
        let made = make(&scene, &lens, 3, Margin::Pixels(0));
        for y in 0..50 {
            let (alpha, color, depth) = held(&made, 1, 45, y);
            // The end cuts one of a half's 32 strata
            assert!((alpha - share).abs() <= 2.0 / 64.0, "{alpha} of {share}");
            assert!((color - BLUE).abs().max_element() < 1e-5 && (depth - 8.0).abs() < 1e-4, "{color} at {depth}");
            let (alpha, color, depth) = held(&made, 2, 45, y);
            assert_eq!(alpha, 1.0, "the wall goes on behind the edge");
            assert!((color - GREEN).abs().max_element() < 1e-5 && (depth - 10.0).abs() < 1e-4, "{color} at {depth}");
            // Beside the edge each fills its pixels
            assert_eq!((held(&made, 1, 44, y).0, held(&made, 1, 46, y).0), (1.0, 1.0));
            assert!((held(&made, 1, 44, y).2 - 8.0).abs() < 1e-4 && (held(&made, 1, 46, y).2 - 10.0).abs() < 1e-4);
        }

        // One layer is left for both: the one that covers more has it
        let made = make(&scene, &lens, 2, Margin::Pixels(0));
        let (alpha, _, depth) = held(&made, 1, 45, 25);
        let expected = if share > 0.52 { Some((share, 8.0)) } else { (share < 0.48).then_some((1.0, 10.0)) };
        if let Some((share, expected)) = expected {
            assert!((alpha - share).abs() <= 2.0 / 64.0 && (depth - expected).abs() < 1e-4, "{alpha} at {depth}");
        }
    }
}

#[test]
fn a_hidden_wire_between_the_centres_of_pixels_is_found() {
    let made = make(&two_cards(45.05, 45.45), &camera([0.0, 0.0, 0.2], 1.0), 3, Margin::Pixels(0));
    for y in 0..50 {
        let (alpha, color, depth) = held(&made, 1, 45, y);
        // Each end cuts one of a half's 32 strata
        assert!((alpha - 0.4).abs() <= 4.0 / 64.0, "{alpha}");
        assert!((color - BLUE).abs().max_element() < 1e-5 && (depth - 8.0).abs() < 1e-4, "{color} at {depth}");
        assert_eq!(held(&made, 2, 45, y).0, 1.0, "the wall goes on behind it");
        assert_eq!(held(&made, 2, 44, y).0 + held(&made, 2, 46, y).0, 0.0, "only where it is");
    }
}

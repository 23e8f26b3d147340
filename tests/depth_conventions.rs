//! Depth in every convention that can be stated: one frame of our own tracer, written each way, gives one picture. And what the
//! flat surfaces of each say where nothing is stated.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::process::Command;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, LayerAttributes, WritableImage, f16};
use image::{ImageBuffer, Luma};
use optics::{Camera, Film};
use rgbd::{DepthConvention, DepthVerdict, Frame, Picture, PixelWindow, ReadOptions, Silent, read_frame, read_picture};
use trace::{LayerSettings, SceneFile};

const SIZE: PixelWindow = PixelWindow { x: 0, y: 0, width: 192, height: 108 };

/// A floor 80 m long, a wall, boxes and balls below an empty sky, in metres.
const SCENE: &str = r#"
format = 1
metres_per_unit = 1.0
sky = [0.5, 0.7, 0.9]
[materials.floor]
checker = { colors = [0.8, 0.15], side = 0.7 }
[materials.wall]
color = [0.7, 0.55, 0.4]
[materials.red]
color = [0.8, 0.1, 0.08]
[shapes]
floor = { plane = { size = [60, 80] } }
wall = { box = { size = [5, 2.2, 0.1] } }
block = { box = { size = 0.8 } }
ball = { sphere = { radius = 0.5 } }
[lights]
fill = { ambient = { strength = 0.3 } }
sun = { sun = { toward = [-0.4, 1.0, 0.3], strength = 0.7 } }
[[objects]]
shape = "floor"
material = "floor"
[[objects]]
shape = "wall"
material = "wall"
placements = [{ translate = [2.5, 1.1, -5.0], rotate_deg = [0, 35, 0] }]
[[objects]]
shape = "block"
material = "red"
placements = [{ translate = [-1.2, 0.4, 0.5], rotate_deg = [0, 20, 0] }]
[[objects]]
shape = "ball"
material = "red"
placements = [{ translate = [0.6, 0.5, 1.2] }]
[camera]
position = [0.0, 1.5, 5.0]
look_at = [0.0, 0.9, 0.0]
[lens]
focus = { distance = 4.5 }
image_distance = 1.0
aperture = "pinhole"
[film]
size = [192, 108]
window = { q = [-0.5, -0.28125, 0.5, 0.28125] }
"#;

/// 2 atan(0.5), and what the lens is.
const LENS: [&str; 10] =
    ["--fov", "53.13010235415598", "--sensor-width", "36", "-N", "0.1", "--tilt", "0.3", "--focus-distance", "4.5"];

fn traced() -> (Frame, Camera) {
    let scene = SceneFile::parse(SCENE, "scene.toml").unwrap();
    let camera = scene.shot(None).unwrap().camera;
    let settings = LayerSettings { count: 1, color_samples: 64, ..LayerSettings::default() };
    let frame = trace::layers(scene.scene(), &camera, &settings, &Silent).unwrap().frame;
    (frame, camera)
}

/// How numbers are stored.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Float,
    Half,
}

/// One way to write depth, and what to say of it.
struct Way {
    name: &'static str,
    kind: Kind,
    /// Of planar depth (infinite for the sky) and the length of (q, 1).
    stored: Box<dyn Fn(f32, f32) -> f32>,
    options: &'static [&'static str],
}

fn way(
    name: &'static str,
    kind: Kind,
    options: &'static [&'static str],
    stored: impl Fn(f32, f32) -> f32 + 'static,
) -> Way {
    Way { name, kind, stored: Box::new(stored), options }
}

/// Depth with a number for the sky.
fn or(z: f32, sky: f32) -> f32 {
    if z.is_finite() { z } else { sky }
}

/// Near and far of the normalised ways: nothing of the scene is nearer, and little farther.
const NEAR: f32 = 1.0;
const FAR: f32 = 100.0;

fn ways() -> Vec<Way> {
    use Kind::{Float, Half};
    let unit = |z: f32| (z - NEAR) / (FAR - NEAR);
    vec![
        way("planar, background inf", Float, &["--depth-as", "planar"], |z, _| z),
        way("planar, background 1e10", Float, &["--depth-as", "planar"], |z, _| or(z, 1e10)),
        way("planar, background 1e30", Float, &["--depth-as", "planar"], |z, _| or(z, 1e30)),
        way("planar, background 65504", Float, &["--depth-as", "planar", "--background", "65504"], |z, _| {
            or(z, 65504.0)
        }),
        way("planar, background 0", Float, &["--depth-as", "planar", "--background", "0"], |z, _| or(z, 0.0)),
        way("planar, background -1", Float, &["--depth-as", "planar", "--background", "-1"], |z, _| or(z, -1.0)),
        way("planar, background NaN", Float, &["--depth-as", "planar", "--background", "nan"], |z, _| or(z, f32::NAN)),
        way("negative planar, background -inf", Float, &["--depth-as", "planar"], |z, _| -z),
        way("negative planar, background 0", Float, &["--depth-as", "planar", "--background", "0"], |z, _| or(-z, 0.0)),
        way("planar in cm", Float, &["--depth-as", "planar", "--metres-per-unit", "0.01"], |z, _| 100.0 * z),
        way("planar in mm", Float, &["--depth-as", "planar", "--metres-per-unit", "0.001"], |z, _| 1000.0 * z),
        way("planar in units of 0.3048 m", Float, &["--depth-as", "planar", "--metres-per-unit", "0.3048"], |z, _| {
            z / 0.3048
        }),
        way("ray, background inf", Float, &["--depth-as", "ray"], |z, r| z * r),
        way("ray, background 1e10", Float, &["--depth-as", "ray"], |z, r| or(z * r, 1e10)),
        way(
            "ray in cm, background NaN",
            Float,
            &["--depth-as", "ray", "--metres-per-unit", "0.01", "--background", "nan"],
            |z, r| or(100.0 * z * r, f32::NAN),
        ),
        way("1/z, background 0", Float, &["--depth-as", "inverse"], |z, _| 1.0 / z),
        way("1/z in 1/mm", Float, &["--depth-as", "inverse", "--metres-per-unit", "0.001"], |z, _| 0.001 / z),
        way("1/z, background NaN", Float, &["--depth-as", "inverse", "--background", "nan"], |z, _| {
            or(1.0 / or(z, f32::NAN), f32::NAN)
        }),
        way(
            "normalised, white far, background inf",
            Float,
            &["--depth-as", "planar", "--depth-range", "1,100"],
            move |z, _| unit(z),
        ),
        way(
            "normalised, white far, background 9",
            Float,
            &["--depth-as", "planar", "--depth-range", "1,100", "--background", "9"],
            move |z, _| or(unit(z), 9.0),
        ),
        way(
            "inverted, white near, background -1",
            Float,
            &["--depth-as", "planar", "--depth-range", "100,1", "--background", "-1"],
            move |z, _| or(1.0 - unit(z), -1.0),
        ),
        way("normalised ray", Float, &["--depth-as", "ray", "--depth-range", "1,100"], move |z, r| unit(z * r)),
        way("normalised 1/z, white near", Float, &["--depth-as", "inverse", "--depth-range", "inf,1"], |z, _| 1.0 / z),
        way("normalised 1/z, white far", Float, &["--depth-as", "inverse", "--depth-range", "1,inf"], |z, _| {
            1.0 - 1.0 / z
        }),
        way("planar, half, background 65504", Half, &["--depth-as", "planar"], |z, _| or(z, 65504.0)),
        way("planar, half, background inf", Half, &["--depth-as", "planar"], |z, _| z),
        way("planar in cm, half", Half, &["--depth-as", "planar", "--metres-per-unit", "0.01"], |z, _| 100.0 * z),
        way("ray, half", Half, &["--depth-as", "ray"], |z, r| z * r),
        way("1/z, half", Half, &["--depth-as", "inverse"], |z, _| 1.0 / z),
    ]
}

/// Length of (q, 1) at a pixel.
fn stretch(film: &Film, x: i32, y: i32) -> f32 {
    let q = film.q_from_pixel(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    q.extend(1.0).length() as f32
}

/// The traced frame as another program's file.
fn write(path: &Path, frame: &Frame, film: &Film, way: &Way) {
    let layer = &frame.layers()[0];
    let plane = |c: usize| SIZE.pixels().map(|(x, y)| layer.color.at(x, y)[c]).collect::<Vec<f32>>();
    let depth: Vec<f32> = SIZE.pixels().map(|(x, y)| (way.stored)(layer.depth.at(x, y), stretch(film, x, y))).collect();
    let depth = match way.kind {
        Kind::Float => FlatSamples::F32(depth),
        Kind::Half => FlatSamples::F16(depth.into_iter().map(f16::from_f32).collect()),
    };
    let colors =
        ["R", "G", "B"].into_iter().zip(0..).map(|(name, c)| AnyChannel::new(name, FlatSamples::F32(plane(c))));
    let channels = AnyChannels::sort(colors.chain([AnyChannel::new("Z", depth)]).collect());
    let size = (SIZE.width as usize, SIZE.height as usize);
    let layer = exr::prelude::Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

/// What the command makes of a file with these options.
fn filtered(folder: &Path, name: &str, options: &[&str]) -> Picture {
    let output = Command::new(env!("CARGO_BIN_EXE_tiltshift"))
        .args([&["filter", name, "-o", "out.exr"], &LENS[..], options].concat())
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{options:?}: {said}");
    assert!(!said.contains("warning"), "{options:?}: {said}");
    read_picture(&folder.join("out.exr"), &ReadOptions::default()).unwrap().value
}

/// The largest difference of a colour, and the root of the mean square.
fn difference(a: &Picture, b: &Picture) -> [f32; 2] {
    let each = |c: usize| a.planes()[c].values().iter().zip(b.planes()[c].values()).map(|(a, b)| (a - b).abs());
    let all: Vec<f32> = (0..3).flat_map(each).collect();
    let squares: f64 = all.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
    [all.iter().copied().fold(0.0, f32::max), (squares / all.len() as f64).sqrt() as f32]
}

#[test]
fn every_convention_once_stated_gives_the_picture_of_planar_depth() {
    /// The claim: what a float keeps moves no colour by more.
    const SAME: f32 = 1e-4;
    /// A half keeps 11 bits: a depth that is wrong by 2.4e-4 of itself makes a circle of confusion of 4 px in diameter wrong by
    /// 1e-3 px, and colours that change by up to 0.3 a pixel by some 1e-4 in the mean; a sum that falls on the other side of a
    /// decision (whose edge a pixel is) now and then by more.
    const SAME_MEAN_OF_HALVES: f32 = 1e-3;

    let folder = tempfile::tempdir().unwrap();
    let (frame, camera) = traced();
    let mut planar: Option<Picture> = None;
    println!("| depth written as | stated as | largest difference | RMS | flat surfaces say, nothing stated |");
    println!("| --- | --- | --- | --- | --- |");
    for way in ways() {
        let path = folder.path().join("frame.exr");
        write(&path, &frame, &camera.film, &way);
        let picture = filtered(folder.path(), "frame.exr", way.options);
        let reference = planar.get_or_insert_with(|| picture.clone());
        let [largest, mean] = difference(reference, &picture);

        // What would be told without a word
        let read = read_frame(&path, &ReadOptions::default()).unwrap().value;
        let depth = rgbd::Plane::from_fn(SIZE, |x, y| {
            let z = read.layers()[0].depth.at(x, y);
            if Some(z) == background(&way) { f32::NAN } else { z }
        });
        let verdict = DepthVerdict::of(&depth, SIZE, Some(&camera.film));
        println!("| {} | `{}` | {largest:.1e} | {mean:.1e} | {verdict} |", way.name, way.options.join(" "));
        match way.kind {
            Kind::Float => assert!(largest <= SAME, "{}: {largest}", way.name),
            Kind::Half => assert!(mean <= SAME_MEAN_OF_HALVES, "{}: {mean}", way.name),
        }
    }
}

/// A background that is typed as a positive number.
fn background(way: &Way) -> Option<f32> {
    let at = way.options.iter().position(|option| *option == "--background")?;
    way.options[at + 1].parse().ok()
}

#[test]
fn sixteen_bit_maps_give_the_picture_of_planar_depth_as_far_as_their_steps_go() {
    let folder = tempfile::tempdir().unwrap();
    let (frame, camera) = traced();
    let planar = way("planar", Kind::Float, &["--depth-as", "planar"], |z, _| z);
    write(&folder.path().join("frame.exr"), &frame, &camera.film, &planar);
    let reference = filtered(folder.path(), "frame.exr", planar.options);
    let depth = &frame.layers()[0].depth;
    println!("| map | stated as | largest difference | RMS |\n| --- | --- | --- | --- |");
    // Millimetres are exact to 0.5 mm: at 4 m to half a half's step. Disparity has 65536 even steps, the best there is. Even steps
    // of depth over 20 m are 0.3 mm
    type Stored = Box<dyn Fn(f32, f32) -> f32>;
    let maps: [(&str, &[&str], Stored, f32); 5] = [
        (
            "millimetres, 0 sky",
            &["--depth-as", "planar", "--metres-per-unit", "0.001", "--background", "0"],
            Box::new(|z, _| or(1000.0 * z, 0.0)),
            5e-4,
        ),
        (
            "millimetres along the ray",
            &["--depth-as", "ray", "--metres-per-unit", "0.001", "--background", "0"],
            Box::new(|z, r| or(1000.0 * z * r, 0.0)),
            5e-4,
        ),
        (
            "disparity, white near",
            &["--depth-as", "inverse", "--depth-range", "inf,1"],
            Box::new(|z, _| 65535.0 / z),
            5e-4,
        ),
        (
            "disparity, white far",
            &["--depth-as", "inverse", "--depth-range", "1,inf"],
            Box::new(|z, _| 65535.0 * (1.0 - 1.0 / z)),
            5e-4,
        ),
        (
            "normalised 1 to 60 m, white sky",
            &["--depth-as", "planar", "--depth-range", "1,60", "--background", "65535"],
            Box::new(|z, _| 65535.0 * (z - 1.0) / 59.0),
            2e-3,
        ),
    ];
    for (name, options, stored, most) in maps {
        let pixel = |x: u32, y: u32| {
            let (x, y) = (x as i32, y as i32);
            let number = stored(depth.at(x, y), stretch(&camera.film, x, y));
            Luma([number.round().clamp(0.0, 65535.0) as u16])
        };
        ImageBuffer::from_fn(SIZE.width, SIZE.height, pixel).save(folder.path().join("map.png")).unwrap();
        let picture = filtered(folder.path(), "frame.exr", &[&["--depth", "map.png"], options].concat());
        let [largest, mean] = difference(&reference, &picture);
        println!("| {name} | `{}` | {largest:.1e} | {mean:.1e} |", options.join(" "));
        assert!(mean <= most, "{name}: {mean}");
    }
}

#[test]
fn flat_surfaces_tell_planar_depth_from_distances_and_from_disparity() {
    let (frame, camera) = traced();
    let depth = &frame.layers()[0].depth;
    let of = |stored: &dyn Fn(f32, f32) -> f32, film: Option<&Film>| {
        let numbers = rgbd::Plane::from_fn(SIZE, |x, y| stored(depth.at(x, y), stretch(&camera.film, x, y)));
        DepthVerdict::of(&numbers, SIZE, film)
    };
    let film = Some(&camera.film);
    let noisy = |z: f32, x: f32| z * (1.0 + 2e-3 * (1e4 * x.fract()).fract());
    for (name, verdict, wanted) in [
        ("planar", of(&|z, _| z, film), DepthConvention::Planar),
        ("planar without a film", of(&|z, _| z, None), DepthConvention::Planar),
        ("ray", of(&|z, r| z * r, film), DepthConvention::Ray),
        ("1/z", of(&|z, _| 1.0 / z, film), DepthConvention::Inverse),
        ("1/z without a film", of(&|z, _| 1.0 / z, None), DepthConvention::Inverse),
        ("planar in halves", of(&|z, _| f16::from_f32(z).to_f32(), film), DepthConvention::Planar),
        ("ray in halves", of(&|z, r| f16::from_f32(z * r).to_f32(), film), DepthConvention::Ray),
        ("noisy planar", of(&|z, r| noisy(z, 1e3 * r), film), DepthConvention::Planar),
        ("noisy ray", of(&|z, r| noisy(z * r, 1e3 * r), film), DepthConvention::Ray),
    ] {
        println!("{name}: {verdict}");
        assert_eq!(verdict.convention, Some(wanted), "{name}: {verdict}");
        assert!(verdict.is_sure(), "{name}: {verdict}");
    }

    // A ball has no flat side, whatever it looks like; nor has what is the same all over
    let ball = rgbd::Plane::from_fn(SIZE, |x, y| {
        let q = camera.film.q_from_pixel(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let (a, b) = (q.length_squared() + 1.0, 10.0);
        ((b - (b * b - a * (b * b - 9.0)).max(0.0).sqrt()) / a) as f32
    });
    for (name, verdict) in [
        ("ball", DepthVerdict::of(&ball, SIZE, None)),
        ("ball, film known", DepthVerdict::of(&ball, SIZE, film)),
        ("one number", of(&|_, _| 4.0, film)),
    ] {
        assert!(!verdict.is_sure(), "{name}: {verdict}");
    }
}

#[test]
fn what_is_surely_no_planar_depth_is_taken_as_what_it_is_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let (frame, camera) = traced();
    let path = folder.path().join("frame.exr");
    let run = |options: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_tiltshift"))
            .args([&["filter", "frame.exr", "-o", "out.exr"], &LENS[..], options].concat())
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    };
    write(&path, &frame, &camera.film, &way("planar", Kind::Float, &[], |z, _| z));
    let (code, said) = run(&[]);
    assert!(code == Some(0) && said.contains("its depth: planar depth") && !said.contains("warning"), "{said}");
    let planar = read_picture(&folder.path().join("out.exr"), &ReadOptions::default()).unwrap().value;

    for (words, stored) in [
        ("distance along the ray", way("ray", Kind::Float, &[], |z, r| z * r)),
        ("inverse depth", way("1/z", Kind::Float, &[], |z, _| 1.0 / z)),
    ] {
        write(&path, &frame, &camera.film, &stored);
        let (code, said) = run(&[]);
        assert!(code == Some(0) && said.contains(&format!("warning: its depth is taken as {words}")), "{said}");
        let picture = read_picture(&folder.path().join("out.exr"), &ReadOptions::default()).unwrap().value;
        assert!(difference(&planar, &picture)[0] <= 1e-4, "{words}: {:?}", difference(&planar, &picture));
        let (code, said) = run(&["--depth-as", "planar"]);
        assert!(code == Some(0) && said.contains("warning: taken as planar depth, its depth looks like"), "{said}");
    }

    // Normalised depth is no distance
    write(&path, &frame, &camera.film, &way("0 to 1", Kind::Float, &[], |z, _| ((z - 1.0) / 30.0).clamp(0.0, 1.0)));
    let (code, said) = run(&[]);
    assert!(code == Some(2) && said.contains("as if it were normalised") && said.contains("--depth-range"), "{said}");
}

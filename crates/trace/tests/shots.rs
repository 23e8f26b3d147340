//! The project's scenes and their shots: their numbers stay fixed.
#![allow(clippy::print_stdout)] // tests say what they measured

use std::path::PathBuf;

use glam::DVec2;
use rgbd::{PixelWindow, Silent};
use trace::{LayerSettings, Margin, SceneFile, Shot};

/// Largest radius of the circle of confusion in pixels over the display window, sky included.
const SIMPLE: [(&str, f64); 10] = [
    ("blur", 6.64),
    ("double", 12.63),
    ("pinhole", 0.0),
    ("reverse", 9.11),
    ("shift", 6.75),
    ("swing", 9.84),
    ("swing_shift", 8.35),
    ("tilt", 6.32),
    ("tilt_shift", 6.31),
    ("tilt_swing_shift", 7.57),
];
const LANDSCAPE: [(&str, f64); 11] = [
    ("blur", 17.16),
    ("double", 34.47),
    ("hd", 20.0),
    ("miniature", 22.83),
    ("pan_focus", 17.23),
    ("pinhole", 0.0),
    ("shift", 17.14),
    ("silhouette", 20.31),
    ("swing", 20.87),
    ("tilt_shift", 24.96),
    ("tilt_swing_shift", 21.04),
];

fn scene(name: &str) -> SceneFile {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes").join(name);
    SceneFile::open(path).unwrap()
}

/// From the depth of every pixel's centre; also the share of pixels that show the sky.
fn largest_coc_radius(file: &SceneFile, shot: &Shot) -> (f64, f64) {
    let settings = LayerSettings { count: 1, margin: Margin::Pixels(0), color_samples: 2, seed: 1 };
    let made = trace::layers(file.scene(), &shot.camera, &settings, &Silent).unwrap();
    let depth = &made.frame.layers()[0].depth;
    let film = &shot.camera.film;
    let coc = |(x, y): (i32, i32)| {
        let q = film.q_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        shot.camera.coc_radius_px(q, 1.0 / f64::from(depth.at(x, y))).abs()
    };
    let window = PixelWindow::of_size(film.width(), film.height());
    let sky = depth.values().iter().filter(|z| z.is_infinite()).count() as f64 / window.area() as f64;
    (window.pixels().map(coc).fold(0.0, f64::max), sky)
}

fn check(name: &str, table: &[(&str, f64)], range: std::ops::RangeInclusive<f64>) {
    let file = scene(name);
    assert_eq!(
        file.shots().keys().map(String::as_str).collect::<Vec<_>>(),
        table.iter().map(|row| row.0).collect::<Vec<_>>()
    );
    for &(shot, wanted) in table {
        let (coc, sky) = largest_coc_radius(&file, file.shot(Some(shot)).unwrap());
        println!("{name} {shot:18} {coc:.3} px, sky {sky:.3}");
        // The table's digits
        assert!((coc - wanted).abs() < 0.006, "{name} {shot}: {coc} px instead of {wanted}");
        let film = file.shot(Some(shot)).unwrap().camera.film;
        let size = if shot == "hd" { (1280, 720) } else { (640, 360) };
        assert_eq!((film.width(), film.height()), size);
        match shot {
            "pinhole" => assert_eq!(coc, 0.0),
            "double" => assert!(range.contains(&(0.5 * coc))),
            _ => assert!(range.contains(&coc)),
        }
        let wanted_sky = if shot == "silhouette" { 0.3..0.8 } else { -1.0..1e-9 };
        assert!(wanted_sky.contains(&sky), "{name} {shot}: {sky} of the pixels show the sky");
    }
}

#[test]
fn the_simple_shots_blur_by_6_to_10_pixels() {
    check("simple.toml", &SIMPLE, 6.0..=10.0);
}

#[test]
fn the_landscape_shots_blur_by_15_to_25_pixels() {
    check("landscape.toml", &LANDSCAPE, 15.0..=25.0);
}

#[test]
fn the_tilted_shots_have_the_printed_angles() {
    // Nakane et al.: lens tilts of 7.62, -5.09 and +-2.58 degrees, printed with two digits
    let [simple, landscape] = ["simple.toml", "landscape.toml"].map(scene);
    for (file, shot, theta, tilt) in [
        (&simple, "tilt", 41.2, 7.62),
        (&simple, "reverse", -48.8, -5.09),
        (&landscape, "pan_focus", 45.0, 2.58),
        (&landscape, "miniature", -45.0, -2.58),
    ] {
        let shot = file.shot(Some(shot)).unwrap();
        let lens = shot.lens.unwrap();
        assert!((lens.tilt().to_degrees() - tilt).abs() < 0.005, "{}", lens.tilt().to_degrees());
        assert_eq!(lens.swing(), 0.0);
        let nakane = optics::Nakane::of(&shot.camera.focus).unwrap();
        assert!((nakane.theta().to_degrees() - theta).abs() < 1e-9);
        // The iris tilts with the lens
        assert!((shot.camera.iris.normal() - lens.axis()).length() < 1e-12);
    }
}

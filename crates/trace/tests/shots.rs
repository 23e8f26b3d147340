//! The project's scenes and their shots: their numbers stay fixed.

use std::path::PathBuf;

use glam::DVec2;
use rgbd::{PixelWindow, Silent};
use trace::{LayerSettings, Margin, SceneFile, Shot};

fn scene(name: &str) -> SceneFile {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes").join(name);
    SceneFile::open(path).unwrap()
}

/// Largest CoC radius over the display window in pixels, from the depth of every pixel's centre.
fn largest_coc_radius(file: &SceneFile, shot: &Shot) -> f64 {
    let settings = LayerSettings { count: 1, margin: Margin::Pixels(0), color_samples: 2, seed: 1 };
    let made = trace::layers(file.scene(), &shot.camera, &settings, &Silent).unwrap();
    let depth = &made.frame.layers()[0].depth;
    let film = &shot.camera.film;
    let coc = |(x, y): (i32, i32)| {
        let q = film.q_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        shot.camera.coc_radius_px(q, 1.0 / f64::from(depth.at(x, y))).abs()
    };
    PixelWindow::of_size(film.width(), film.height()).pixels().map(coc).fold(0.0, f64::max)
}

#[test]
fn print_all() {
    for name in ["simple.toml", "landscape.toml"] {
        let file = scene(name);
        for (shot, s) in file.shots() {
            let t = std::time::Instant::now();
            let coc = largest_coc_radius(&file, s);
            let lens = s.lens.map(|l| (l.tilt().to_degrees(), l.swing().to_degrees(), l.f_number(), l.focal_length()));
            eprintln!("{name} {shot} coc {coc:.3} lens {lens:?} {:?}", t.elapsed());
        }
    }
}

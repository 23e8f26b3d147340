//! Whether advice is good: every shot at two sizes, every rung run, and what was forecast of each.
//!
//! `cargo bench --bench advice -- SCENE [SHOT|all] [SAMPLES]` prints a line of CSV for each rung, with SAMPLES (0: none, only
//! forecasts) in the truth; `cargo bench --bench advice -- table FILE.csv` reads them again and says how often advice keeps
//! its word, and what it costs.

#[path = "advice/table.rs"]
mod table;

use std::path::Path;

use compare::{Comparison, Masks, Reference};
use optics::Camera;
use rgbd::{PixelWindow, Silent};
use study::{Evidence, Subject, forecasts, measure};
use trace::{LayerSettings, SceneFile};

/// Sizes of the pictures.
const SIZES: [[u32; 2]; 2] = [[320, 180], [640, 360]];

/// Seeds of the truth, of the frame's colour, and of what is advised.
const SEEDS: [u64; 3] = [1, 2, 3];

#[expect(clippy::print_stdout, reason = "the figures are what the bench is for")]
fn main() {
    // `cargo bench` passes --bench along
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let scene = words.first().map_or("simple", String::as_str);
    if let ("table", Some(file)) = (scene, words.get(1)) {
        return table::print(Path::new(file));
    }
    let samples: u32 = words.get(2).and_then(|word| word.parse().ok()).unwrap_or(4096);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{scene}.toml"));
    let file = SceneFile::open(&file).expect("a scene of the project");
    let folder = std::env::temp_dir().join(format!("tiltshift-advice-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    println!(
        "scene,shot,width,rung,forecast_s,kernel_s,command_s,forecast_rmse,rmse,forecast_flip,flip,doubt_rmse,doubt_flip"
    );
    for (name, shot) in file.shots() {
        if words.get(1).is_some_and(|wanted| wanted != name && wanted != "all") || shot.camera.iris.radius() == 0.0 {
            continue;
        }
        for [width, height] in SIZES {
            let film = shot.camera.film.resized(width, height).expect("a film");
            let camera = Camera { film, ..shot.camera };
            for line in case(file.scene(), &camera, samples, &folder) {
                println!("{scene},{name},{width},{line}");
            }
        }
    }
    std::fs::remove_dir_all(&folder).ok();
}

/// Forecast and truth of every rung.
fn case(scene: &trace::Scene, camera: &Camera, samples: u32, folder: &Path) -> Vec<String> {
    let window = PixelWindow::of_size(camera.film.width(), camera.film.height());
    let settings = LayerSettings { seed: SEEDS[1], ..LayerSettings::default() };
    let frame = trace::layers(scene, camera, &settings, &Silent).expect("a frame").frame;
    let evidence = Evidence { scene: Some(scene), camera, frame: &frame, seed: SEEDS[2] };
    let forecasts = forecasts(&evidence, true, &Silent).expect("forecasts");
    if samples == 0 {
        return forecasts.iter().map(|forecast| line(forecast, [f64::NAN; 4])).collect();
    }
    let truth = trace::truth(scene, camera, window, samples, SEEDS[0], &Silent).expect("a truth");
    let rungs: Vec<_> = forecasts.iter().map(|forecast| forecast.rung).collect();
    let subject = Subject { scene, camera, frame: &frame, seed: SEEDS[2], folder };
    // What takes long scatters less
    let (quick, slow): (Vec<_>, Vec<_>) = rungs.into_iter().partition(|rung| rung.samples().is_none());
    let mut measured = measure(&subject, &quick, 5, &Silent).expect("pictures");
    measured.extend(measure(&subject, &slow, 1, &Silent).expect("pictures"));
    let reference = Reference::from_truth(&truth).expect("a reference");
    let masks = Masks::without_depth(window);
    let lines = forecasts.iter().zip(&measured).map(|(forecast, measured)| {
        let comparison = Comparison::new(&reference, &measured.picture, &masks).expect("pictures of one window");
        let error = study::PointError::from(&comparison);
        line(forecast, [measured.kernel.median(), measured.command.median(), error.all.rmse, error.flip_hdr])
    });
    lines.collect()
}

/// What was forecast of a rung, and what was measured: seconds of the kernel and of the whole, RMS error, HDR-FLIP.
fn line(forecast: &study::Forecast, [kernel, command, rmse, flip]: [f64; 4]) -> String {
    let study::Forecast { rung, seconds, error, doubt, .. } = forecast;
    let (name, expected, expected_flip) = (rung.name(), error.rmse, error.hdr_flip.unwrap_or(f64::NAN));
    let [rmse_doubt, flip_doubt] = doubt.map_or([f64::NAN; 2], |doubt| [doubt.rmse, doubt.hdr_flip]);
    format!(
        "{name},{seconds:.5},{kernel:.5},{command:.5},{expected:.6},{rmse:.6},{expected_flip:.5},{flip:.5},\
         {rmse_doubt:.3},{flip_doubt:.3}"
    )
}

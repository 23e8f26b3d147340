//! Against converged pictures that another renderer made of the same triangles through the same lenses.
//!
//! Each case is rendered in a crop. What differs must be noise: ours is known from two halves; theirs is known for the
//! whole picture, and is taken to be spread over the picture as ours is. A wrong lens must not pass.
#![allow(clippy::print_stdout)] // tests say what they measured

mod reference_case;

use std::path::Path;
use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use optics::{Camera, Focus, Iris};
use reference_case::{CASES, Case};
use rgbd::{Picture, PixelWindow, Silent, Truth};
use trace::Scene;

const CROP: PixelWindow = PixelWindow { x: 208, y: 104, width: 208, height: 160 };
const CROP_SPP: u32 = 256;
/// Enough to learn how noise is spread over the picture.
const WHOLE_SPP: u32 = 16;
const BLOCK: i32 = 8;
/// The root mean square of a few hundred to some ten thousand differences is itself known to a few percent only.
const SLACK: f64 = 1.15;
/// One mean in 370 lies farther off by chance; the seeds are fixed.
const STANDARD_ERRORS: f64 = 3.0;

fn scene(folder: &Path, name: &str) -> &'static Scene {
    static SCENES: [OnceLock<Scene>; 2] = [OnceLock::new(), OnceLock::new()];
    SCENES[usize::from(name == "landscape")].get_or_init(|| reference_case::scene(folder, name))
}

/// How far two pictures are apart, over what their noise explains.
#[derive(Debug, Clone, Copy)]
struct Verdict {
    /// RMSE of pixels over the combined noise.
    pixels: f64,
    /// The same for means over blocks.
    blocks: f64,
    /// Difference of the means in standard errors.
    mean: f64,
}

impl Verdict {
    fn passes(&self) -> bool {
        self.pixels <= SLACK && self.blocks <= SLACK && self.mean.abs() <= STANDARD_ERRORS
    }
}

/// Values of all three channels of a picture, averaged over square cells of a window.
fn cells(picture: &Picture, window: PixelWindow, size: i32) -> Vec<[f64; 3]> {
    let mut cells = Vec::new();
    for y in (window.y..window.y_end()).step_by(size as usize) {
        for x in (window.x..window.x_end()).step_by(size as usize) {
            let cell = PixelWindow::from_corners(x, y, x + size, y + size);
            let mut sum = DVec3::ZERO;
            for (x, y) in cell.pixels() {
                let [r, g, b, _] = picture.at(x, y).map(f64::from);
                sum += DVec3::new(r, g, b);
            }
            cells.push((sum / cell.area() as f64).to_array());
        }
    }
    cells
}

fn rms(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    (a.iter().zip(b).map(square).sum::<f64>() / (3.0 * a.len() as f64)).sqrt()
}

fn mean(cells: &[[f64; 3]]) -> f64 {
    cells.iter().flatten().sum::<f64>() / (3.0 * cells.len() as f64)
}

/// Renders the crop through `camera` and compares it with the case's picture.
fn judge(case: &Case, scene: &Scene, camera: &Camera) -> Verdict {
    judge_crop(case, scene, camera, &trace::truth(scene, camera, CROP, CROP_SPP, 6, &Silent).unwrap())
}

/// Compares a render of the crop with the case's picture.
fn judge_crop(case: &Case, scene: &Scene, camera: &Camera, crop: &Truth) -> Verdict {
    let film = PixelWindow::of_size(camera.film.width(), camera.film.height());
    let whole = trace::truth(scene, camera, film, WHOLE_SPP, 5, &Silent).unwrap();
    // Their share of the noise in the crop
    let theirs = case.noise * whole.noise_rmse(CROP) / whole.noise_rmse(film);
    let compare = |size: i32| {
        let own = rms_of_halves(crop, size);
        let theirs = theirs / f64::from(size); // pixels are independent
        let difference = rms(&cells(&crop.picture(), CROP, size), &cells(&case.picture, CROP, size));
        difference / own.hypot(theirs)
    };
    // Channels go together: the mean over channels is as uncertain as a channel
    let error = rms_of_halves(crop, 1).hypot(theirs) / (CROP.area() as f64).sqrt();
    let off = mean(&cells(&crop.picture(), CROP, 1)) - mean(&cells(&case.picture, CROP, 1));
    Verdict { pixels: compare(1), blocks: compare(BLOCK), mean: off / error }
}

/// Noise of the mean of a truth's cells.
fn rms_of_halves(truth: &Truth, size: i32) -> f64 {
    let [a, b] = &truth.halves;
    0.5 * rms(&cells(a, CROP, size), &cells(b, CROP, size))
}

#[test]
fn every_case_agrees_within_noise() {
    let Some(folder) = reference_case::folder() else { return };
    let mut failed = Vec::new();
    for name in CASES {
        let case = Case::read(&folder, name);
        let verdict = judge(&case, scene(&folder, case.scene_name()), &case.camera);
        println!("{name:24} {verdict:.3?}");
        if !verdict.passes() {
            failed.push((name, verdict));
        }
    }
    assert!(failed.is_empty(), "{failed:.3?}");
}

#[test]
fn cases_agree_within_noise_where_samples_are_put_where_they_count() {
    let Some(folder) = reference_case::folder() else { return };
    for name in ["simple_tilt", "simple_combined", "landscape_reverse"] {
        let case = Case::read(&folder, name);
        let (scene, camera) = (scene(&folder, case.scene_name()), &case.camera);
        let crop = trace::truth_to_noise(scene, camera, CROP, 2.0 * case.noise, 1 << 14, 6, &Silent).unwrap();
        let verdict = judge_crop(&case, scene, camera, &crop);
        println!("{name:24} {verdict:.3?}");
        // Over eight seeds blocks scatter by 0.08 about 1.03, with and without adaptivity: allow three times that. The
        // wrong lens that is the hardest to find makes it 1.78.
        let Verdict { pixels, blocks, mean } = verdict;
        assert!(pixels < SLACK && blocks < 1.27 && mean.abs() < STANDARD_ERRORS, "{name}: {verdict:.3?}");
    }
}

fn wider(camera: Camera) -> Camera {
    Camera { iris: camera.iris.with_radius(1.05 * camera.iris.radius()).unwrap(), ..camera }
}

fn leaning(camera: Camera) -> Camera {
    let normal = glam::DQuat::from_rotation_x(10_f64.to_radians()) * camera.iris.normal();
    Camera { iris: Iris::new(normal, camera.iris.radius(), camera.iris.shape()).unwrap(), ..camera }
}

fn moved(camera: Camera) -> Camera {
    Camera { film: camera.film.shifted(DVec2::new(0.25, 0.0) / camera.film.pixels_per_q()), ..camera }
}

/// Everything blurs by half a pixel of radius more or less.
fn defocused(camera: Camera) -> Camera {
    let half_pixel = 0.5 / (camera.iris.radius() * camera.film.pixels_per_q().x);
    Camera { focus: Focus::new(camera.focus.w() + DVec3::new(0.0, 0.0, half_pixel)).unwrap(), ..camera }
}

#[test]
fn the_analytic_scene_agrees_with_the_mesh() {
    let Some(folder) = reference_case::folder() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/simple.toml");
    let file = trace::SceneFile::open(path).unwrap();
    let case = Case::read(&folder, "simple_pinhole");
    let camera = file.shot(Some("pinhole")).unwrap().camera;
    let film = PixelWindow::of_size(640, 360);
    let same = |a: DVec2, b: DVec2| (a - b).length() < 1e-12;
    assert!(same(camera.film.min(), case.camera.film.min()) && same(camera.film.max(), case.camera.film.max()));
    assert!((camera.pose.position - case.camera.pose.position).length() < 1e-9);
    let picture = trace::truth(file.scene(), &camera, film, 64, 5, &Silent).unwrap();
    // Only silhouettes differ: chords of the ball's and the pillar's polygons lie up to 0.0003 units inside the curves,
    // 0.02 px, and flat facets turn normals by up to a degree, 0.01 in radiance
    let [analytic, mesh] = [cells(&picture.picture(), film, 1), cells(&case.picture, film, 1)];
    let error = rms(&analytic, &mesh);
    let noise = picture.noise_rmse(film).hypot(case.noise);
    println!("analytic against mesh: rmse {error:.5}, noise {noise:.5}");
    assert!(error * error < noise * noise + 0.002_f64.powi(2), "{error} with noise {noise}");
    assert!((mean(&analytic) - mean(&mesh)).abs() < 1e-4);
}

#[test]
fn a_wrong_lens_is_found_out() {
    let Some(folder) = reference_case::folder() else { return };
    type Change = fn(Camera) -> Camera;
    let controls: [(&str, &str, Change); 7] = [
        ("aperture 5 % wider", "simple_untilted", wider),
        ("aperture 5 % wider", "landscape_reverse", wider),
        ("iris off by 10 degrees", "simple_combined", leaning),
        ("window off by a quarter pixel", "simple_tilt", moved),
        ("window off by a quarter pixel", "landscape_untilted", moved),
        ("focus off by half a pixel", "simple_combined", defocused),
        ("focus off by half a pixel", "landscape_reverse", defocused),
    ];
    let mut passed = Vec::new();
    for (what, name, change) in controls {
        let case = Case::read(&folder, name);
        let verdict = judge(&case, scene(&folder, case.scene_name()), &change(case.camera));
        println!("{what:30} {name:24} {verdict:.3?}");
        if verdict.passes() {
            passed.push((what, name, verdict));
        }
    }
    assert!(passed.is_empty(), "{passed:.3?}");
}

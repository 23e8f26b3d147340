//! Renders the reference cases until our noise is at most 1.5 times theirs, and says how far apart the pictures are.
//!
//! ```text
//! TILTSHIFT_SHARED=../shared cargo run --release -p trace --example converged_references -- OUT [CASE ...]
//! ```
//!
//! For each case `OUT/CASE.png` shows the signed difference of means over 8x8 blocks, red where ours is brighter, blue
//! where it is darker; full colour is four times the noise that such means have on average. Structure in it, other than
//! that of the noise, would be an error of one of the two.
#![allow(clippy::print_stdout)] // a program

#[path = "../tests/reference_case/mod.rs"]
mod reference_case;

use std::path::Path;
use std::time::Instant;

use reference_case::{CASES, Case};
use rgbd::{Picture, PixelWindow, Silent};

const BLOCK: i32 = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let out = args.next().ok_or("the first argument is a folder for the difference pictures")?;
    let named: Vec<String> = args.collect();
    let cases = if named.is_empty() { CASES.map(str::to_owned).to_vec() } else { named };
    let Some(folder) = reference_case::folder() else { return Ok(()) };
    std::fs::create_dir_all(&out)?;
    println!("case                       spp     own  theirs    rmse / expected    mean / error   seconds");
    for name in cases {
        let case = Case::read(&folder, &name);
        let scene = reference_case::scene(&folder, case.scene_name());
        compare(&case, &scene, &Path::new(&out).join(format!("{name}.png")))?;
    }
    Ok(())
}

fn compare(case: &Case, scene: &trace::Scene, heat_map: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let window = case.picture.window();
    let truth = trace::truth_to_noise(scene, &case.camera, window, 1.5 * case.noise, 16384, 11, &Silent)?;
    let own = truth.noise_rmse(window);
    let picture = truth.picture();
    let (mut squares, mut sum) = (0.0, 0.0);
    for (x, y) in window.pixels() {
        let (ours, theirs) = (picture.at(x, y), case.picture.at(x, y));
        for c in 0..3 {
            let difference = f64::from(ours[c]) - f64::from(theirs[c]);
            squares += difference * difference;
            sum += difference;
        }
    }
    let count = 3.0 * window.area() as f64;
    let expected = own.hypot(case.noise);
    println!(
        "{:24} {:5} {own:.5} {:.5} {:.5} / {:.3} {:9.1e} / {:6.2} {:7.1}",
        case.name,
        2 * truth.samples[0],
        case.noise,
        (squares / count).sqrt(),
        (squares / count).sqrt() / expected,
        sum / count,
        sum / count / (expected / (count / 3.0).sqrt()),
        start.elapsed().as_secs_f64()
    );
    write_difference(&picture, &case.picture, window, 4.0 * expected, heat_map)
}

/// Writes the signed difference of the means of R, G and B over blocks: white is none, red more, blue less; full colour
/// is `full` divided by the block's edge.
fn write_difference(
    ours: &Picture,
    theirs: &Picture,
    window: PixelWindow,
    full: f64,
    path: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut image = image::RgbImage::new(window.width, window.height);
    // Means over blocks show structure that the noise of pixels hides
    let mean = |x: i32, y: i32| {
        let block =
            PixelWindow::from_corners(x - x % BLOCK, y - y % BLOCK, x - x % BLOCK + BLOCK, y - y % BLOCK + BLOCK);
        let block = block.intersection(&window);
        let differences = block.pixels().map(|(x, y)| {
            let (a, b) = (ours.at(x, y), theirs.at(x, y));
            (0..3).map(|c| f64::from(a[c] - b[c])).sum::<f64>() / 3.0
        });
        differences.sum::<f64>() / block.area() as f64
    };
    for (x, y) in window.pixels() {
        let difference = mean(x, y) * f64::from(BLOCK) / full;
        let fade = (255.0 * (1.0 - difference.abs().min(1.0))) as u8;
        let color = if difference > 0.0 { [255, fade, fade] } else { [fade, fade, 255] };
        image.put_pixel(x as u32, y as u32, image::Rgb(color));
    }
    Ok(image.save(path)?)
}

#![allow(clippy::print_stderr)] // a program
//! Writes a shot as a PNG:  picture SCENE SHOT SPP OUT.png

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let file = trace::SceneFile::open(&args[1])?;
    let shot = file.shot(Some(&args[2]))?;
    let film = shot.camera.film;
    let window = rgbd::PixelWindow::of_size(film.width(), film.height());
    let start = std::time::Instant::now();
    let spp: u32 = args[3].parse()?;
    let truth = trace::truth(&file.scene_of(shot), &shot.camera, window, spp, 1, &rgbd::Silent)?;
    let seconds = start.elapsed().as_secs_f64();
    let rate = window.area() as f64 * f64::from(spp) / seconds * 1e-6;
    eprintln!("{seconds:.2} s, {rate:.2} M samples/s, noise {:.5}", truth.noise_rmse(window));
    let picture = truth.picture();
    let mut image = image::RgbImage::new(film.width(), film.height());
    for (x, y, pixel) in image.enumerate_pixels_mut() {
        let rgba = picture.at(x as i32, y as i32);
        pixel.0 = [0, 1, 2].map(|c| {
            let v = rgba[c].clamp(0.0, 1.0);
            let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
            (255.0 * v + 0.5) as u8
        });
    }
    image.save(&args[4])?;
    Ok(())
}

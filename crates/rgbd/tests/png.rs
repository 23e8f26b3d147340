//! What a PNG shows.

use rgbd::{Picture, PixelWindow, Plane, encode_png, srgb_byte, write_png};

/// The transfer as the standard prints it.
fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn every_byte_is_the_nearest_to_the_standard_transfer() {
    for i in 0..=100_000 {
        let linear = i as f32 / 100_000.0;
        let exact = 255.0 * srgb_from_linear(f64::from(linear));
        // The two pieces of the printed transfer meet within 3e-8, and borders are rounded to f32
        const SLACK: f64 = 1e-4;
        let byte = f64::from(srgb_byte(linear));
        assert!((byte - exact).abs() <= 0.5 + SLACK, "{linear}: {byte} for {exact}");
    }
}

#[test]
fn known_values_of_the_transfer() {
    // Middle grey: 0.18 is byte 118; 0.5 is 188; the linear toe ends at byte 10
    for (linear, byte) in [(0.0, 0), (0.18, 118), (0.5, 188), (1.0, 255), (0.003_130_8, 10), (0.215_861, 128)] {
        assert_eq!(srgb_byte(linear), byte, "{linear}");
    }
}

#[test]
fn what_is_no_colour_is_clipped() {
    for (linear, byte) in [(f32::NAN, 0), (-1.0, 0), (f32::NEG_INFINITY, 0), (f32::INFINITY, 255), (1e30, 255)] {
        assert_eq!(srgb_byte(linear), byte, "{linear}");
    }
}

#[test]
fn a_picture_decodes_to_its_bytes_at_the_asked_exposure() {
    let window = PixelWindow { x: -3, y: 5, width: 4, height: 2 };
    // Half-covered pixels: premultiplied colour over black is the colour itself
    let picture = Picture::from_fn(window, |x, y| [0.05 * (x + 4) as f32, 0.04 * y as f32, f32::NAN, 0.5]);
    let png = image::load_from_memory(&encode_png(&picture, 1.0).unwrap()).unwrap();
    assert_eq!(png.color(), image::ColorType::Rgb8);
    let png = png.into_rgb8();
    assert_eq!(png.dimensions(), (4, 2));
    for (x, y) in window.pixels() {
        let [r, g, _, _] = picture.at(x, y);
        let found = png.get_pixel((x - window.x) as u32, (y - window.y) as u32).0;
        assert_eq!(found, [srgb_byte(2.0 * r), srgb_byte(2.0 * g), 0]);
    }
}

#[test]
fn an_empty_picture_is_an_error_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let plane = Plane::filled(PixelWindow::of_size(0, 3), 0.0);
    let picture = Picture::from_planes([(); 4].map(|()| plane.clone())).unwrap();
    assert!(write_png(&folder.path().join("empty.png"), &picture, 0.0).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

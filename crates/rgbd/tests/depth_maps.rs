//! Depth maps in files of their own: what their numbers mean, and that no depth is ever made up between two.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use optics::Film;
use rgbd::{
    DepthConvention, DepthMap, MapMeaning, Picture, PixelWindow, Plane, ReadError, ReadOptions, fill_holes,
    fit_to_picture, read_depth_map,
};
use tempfile::TempDir;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 27;

/// A floor: inverse depth falls towards the top.
fn floor(x: f64, y: f64) -> f64 {
    1.0 / (0.1 + 0.02 * y / f64::from(HEIGHT) * 40.0 + 0.001 * x)
}

fn film() -> Film {
    Film::from_fov(0.9, WIDTH, HEIGHT).unwrap()
}

/// How much longer the ray of a pixel is than its depth.
fn ray(x: i32, y: i32) -> f64 {
    let q = film().q_from_pixel(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    q.extend(1.0).length()
}

/// The floor stored with 16 bits in a PNG.
fn stored(folder: &TempDir, number: impl Fn(i32, i32) -> f64) -> DepthMap {
    let window = PixelWindow::of_size(WIDTH, HEIGHT);
    let words: Vec<u8> =
        window.pixels().flat_map(|(x, y)| ((number(x, y) * 65535.0).round() as u16).to_ne_bytes()).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(&words, WIDTH, HEIGHT, ExtendedColorType::L16).unwrap();
    let path = folder.path().join("depth.png");
    std::fs::write(&path, bytes).unwrap();
    read_depth_map(&path, None, ReadOptions::MAX_PIXELS).unwrap()
}

#[test]
fn every_meaning_gives_the_same_depths() {
    let folder = TempDir::new().unwrap();
    let (near, far) = (0.9, 20.0);
    let (near_f, far_f) = (near as f32, far as f32);
    let depth = |x: i32, y: i32| floor(f64::from(x), f64::from(y));
    let linear = |z: f64| (z - near) / (far - near);
    let inverse = |z: f64| (1.0 / z - 1.0 / near) / (1.0 / far - 1.0 / near);
    let cases: [(DepthMap, DepthConvention, Option<[f32; 2]>); 6] = [
        (stored(&folder, |x, y| linear(depth(x, y))), DepthConvention::Planar, Some([near_f, far_f])),
        (stored(&folder, |x, y| 1.0 - linear(depth(x, y))), DepthConvention::Planar, Some([far_f, near_f])),
        (stored(&folder, |x, y| linear(depth(x, y) * ray(x, y))), DepthConvention::Ray, Some([near_f, far_f])),
        (stored(&folder, |x, y| inverse(depth(x, y))), DepthConvention::Inverse, Some([near_f, far_f])),
        (stored(&folder, |x, y| 1.0 - inverse(depth(x, y))), DepthConvention::Inverse, Some([far_f, near_f])),
        // Whole units, as sensors write them: half a millimetre here
        (stored(&folder, |x, y| depth(x, y) * 2000.0 / 65535.0), DepthConvention::Planar, None),
    ];
    for (i, (map, convention, range)) in cases.into_iter().enumerate() {
        let planar = map.planar(&MapMeaning { convention, range, background: None }, Some(&film()));
        for (x, y) in planar.window().pixels() {
            let unit = if range.is_none() { 2000.0 } else { 1.0 };
            let (found, wanted) = (f64::from(planar.at(x, y)) / unit, depth(x, y));
            // Half a step of 16 bits of the range, at the far end of an inverse depth 20 times as coarse in depth
            assert!((found / wanted - 1.0).abs() < 3e-4, "case {i} at ({x}, {y}): {found} for {wanted}");
        }
    }
}

#[test]
fn infinity_may_be_the_far_end_of_an_inverse_depth() {
    let folder = TempDir::new().unwrap();
    let map = stored(&folder, |x, _| if x < 10 { 0.0 } else { 0.5 });
    let range = Some([f32::INFINITY, 1.0]);
    let planar = map.planar(&MapMeaning { convention: DepthConvention::Inverse, range, background: None }, None);
    assert_eq!(planar.at(3, 3), f32::INFINITY);
    assert!((planar.at(20, 3) - 2.0).abs() < 1e-4);
}

#[test]
fn zero_is_a_hole_where_numbers_are_units() {
    let folder = TempDir::new().unwrap();
    let map = stored(&folder, |x, _| if x < 10 { 0.0 } else { 0.02 });
    let planar = map.planar(&MapMeaning { convention: DepthConvention::Planar, range: None, background: None }, None);
    assert!(planar.at(3, 3).is_nan() && planar.at(20, 3) == 1311.0);
}

#[test]
fn false_colours_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("jet.png");
    let pixels: Vec<u8> = (0..64 * 64_u32).flat_map(|i| [(i % 64) as u8 * 4, 255 - (i % 64) as u8 * 4, 90]).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(&pixels, 64, 64, ExtendedColorType::Rgb8).unwrap();
    std::fs::write(&path, bytes).unwrap();
    let error = read_depth_map(&path, None, ReadOptions::MAX_PIXELS).unwrap_err();
    assert!(matches!(error, ReadError::Unsupported { .. }), "{error}");
}

/// A map of floats in planar depth.
fn map_of(width: u32, height: u32, depth: impl Fn(f64, f64) -> f64) -> (DepthMap, MapMeaning) {
    let window = PixelWindow::of_size(width, height);
    let stored = Plane::from_fn(window, |x, y| depth(f64::from(x) + 0.5, f64::from(y) + 0.5) as f32);
    let map = DepthMap { stored, largest: None, is_named: true, found: String::new() };
    (map, MapMeaning { convention: DepthConvention::Planar, range: None, background: None })
}

#[test]
fn a_coarse_map_of_a_plane_is_that_plane() {
    let (map, meaning) = map_of(24, 16, |x, y| 1.0 / (0.2 + 0.01 * x + 0.03 * y));
    let guide = Picture::from_fn(PixelWindow::of_size(96, 64), |x, y| [0.01 * (x + y) as f32, 0.3, 0.2, 1.0]);
    let fitted = fit_to_picture(map.planar(&meaning, None), &guide, map.largest, &meaning);
    // Four pixels of the picture in each of the map; within half a pixel of the map from its border there is nothing to go by
    for y in 6..58 {
        for x in 6..90 {
            let wanted = 1.0 / (0.2 + 0.01 * (f64::from(x) + 0.5) / 4.0 + 0.03 * (f64::from(y) + 0.5) / 4.0);
            let error = f64::from(fitted.at(x, y)) / wanted - 1.0;
            assert!(error.abs() < 1e-5, "({x}, {y}): off by {error}"); // f32
        }
    }
}

#[test]
fn a_coarse_edge_follows_the_picture_and_nothing_lies_between() {
    // A leaning edge in the picture; the map knows it in steps of four pixels
    let is_near = |x: f64, y: f64| x < 40.0 + 0.3 * y;
    let depth = |x: f64, y: f64| if is_near(x, y) { 2.0 } else { 9.0 };
    let (map, meaning) = map_of(24, 16, |x, y| depth(4.0 * x, 4.0 * y));
    let color = |x: f64, y: f64| if is_near(x, y) { [0.7, 0.3, 0.1, 1.0] } else { [0.1, 0.3, 0.6, 1.0] };
    let centre = |x: i32| f64::from(x) + 0.5;
    let window = PixelWindow::of_size(96, 64);
    let guide = Picture::from_fn(window, |x, y| color(centre(x), centre(y)));
    let fitted = fit_to_picture(map.planar(&meaning, None), &guide, map.largest, &meaning);
    let mut wrong = 0;
    for (x, y) in window.pixels() {
        let found = f64::from(fitted.at(x, y));
        let nearest = if (found - 2.0).abs() < (found - 9.0).abs() { 2.0 } else { 9.0 };
        assert!((found / nearest - 1.0).abs() < 1e-6, "({x}, {y}): {found} lies on no surface");
        wrong += usize::from(nearest != depth(centre(x), centre(y)));
    }
    // The map alone would be wrong in about a pixel and a half on each of 64 rows
    assert!(wrong <= 12, "{wrong} pixels are on the wrong side");
}

#[test]
fn holes_end_where_things_end_and_take_depths_that_there_are() {
    // A hole over the edge of two colours, each of its own depth
    let window = PixelWindow::of_size(60, 20);
    let guide = Picture::from_fn(window, |x, _| if x < 33 { [0.8, 0.2, 0.1, 1.0] } else { [0.1, 0.2, 0.7, 1.0] });
    let is_hole = |x: i32, y: i32| (20..45).contains(&x) && (4..16).contains(&y);
    let depth = |x: i32| if x < 33 { 1.0 + 0.01 * x as f32 } else { 7.0 };
    let holed = Plane::from_fn(window, |x, y| if is_hole(x, y) { f32::NAN } else { depth(x) });
    let (filled, count) = fill_holes(holed.clone(), &guide);
    assert_eq!(count, 25 * 12);
    for (x, y) in window.pixels() {
        let found = filled.at(x, y);
        assert!(holed.values().contains(&found), "({x}, {y}): {found} is no depth of the map");
        assert_eq!(found > 5.0, x >= 33, "({x}, {y}): {found} is on the wrong side of the edge");
    }
    let nothing = Plane::filled(window, f32::NAN);
    assert_eq!(fill_holes(nothing, &guide).1, 0, "where nothing is known nothing is filled");
}

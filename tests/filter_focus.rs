//! Focus as people think of it, on a floor with a wall behind it: the CoC says whether the wish was met.

use std::path::Path;
use std::process::{Command, Output};

use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, ReadOptions, WriteOptions, read_planes, write_frame};
use tempfile::TempDir;

const SIZE: PixelWindow = PixelWindow { x: 0, y: 0, width: 192, height: 128 };

/// The camera: 35 mm on 36 mm of sensor, 1.6 m above the floor, looking down by this much.
const PITCH: f64 = 0.3;
const HEIGHT: f64 = 1.6;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

/// Inverse depth of the floor at a pixel; a wall stands at 12 m.
fn floor(x: i32, y: i32) -> f64 {
    let per_q = 192.0 * 35.0 / 36.0;
    let q = [(f64::from(x) + 0.5 - 96.0) / per_q, (64.0 - f64::from(y) - 0.5) / per_q];
    (-PITCH.cos() * q[1] + PITCH.sin()) / HEIGHT
}

/// The inverse depth that is seen.
fn seen(x: i32, y: i32) -> f64 {
    floor(x, y).max(1.0 / 12.0)
}

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let color = Picture::from_fn(SIZE, |x, y| [((x / 8 + y / 8) % 2) as f32, 0.4, 0.2, 1.0]);
    let depth = Plane::from_fn(SIZE, |x, y| (1.0 / seen(x, y)) as f32);
    let frame = Frame::new(SIZE, vec![Layer::from_raw_depth(color, depth)]).unwrap();
    write_frame(&folder.path().join("in.exr"), &frame, &WriteOptions::default()).unwrap();
    folder
}

/// The CoC radius in pixels, signed, of every pixel.
fn coc(folder: &Path, wish: &[&str]) -> Plane {
    let lens = ["--focal-length", "35", "--sensor", "full-frame", "--coc", "--overlay", "over.png"];
    let output = tiltshift(folder, &[&["filter", "in.exr", "-o", "out.exr"], &lens[..], wish].concat());
    assert!(output.status.success(), "{wish:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.join("over.png").is_file());
    read_planes(&folder.join("out.exr"), &["coc"], ReadOptions::MAX_PIXELS).unwrap().value.swap_remove(0)
}

/// What f32 depths and a fit to them leave of a CoC, in pixels.
const ROUNDING: f32 = 2e-3;

#[test]
fn the_ground_is_sharp_from_near_to_far_and_what_stands_on_it_is_not() {
    let folder = folder();
    let coc = coc(folder.path(), &["-N", "0.5", "--focus", "ground"]);
    for (x, y) in SIZE.pixels() {
        let is_floor = floor(x, y) > 1.0 / 12.0;
        assert!(!is_floor || coc.at(x, y).abs() < ROUNDING, "({x}, {y}): {} px on the floor", coc.at(x, y));
    }
    assert!(coc.at(96, 2).abs() > 0.3, "the wall is blurred above: {} px", coc.at(96, 2));
}

#[test]
fn a_miniature_is_sharp_in_a_strip_through_the_pixel() {
    let folder = folder();
    let coc = coc(folder.path(), &["-N", "0.5", "--focus", "miniature", "--focus-pixel", "96,80"]);
    for x in [2, 96, 190] {
        assert!(coc.at(x, 80).abs() < ROUNDING, "the strip is level: {} px at column {x}", coc.at(x, 80));
    }
    assert!(coc.at(96, 120) > 0.5 && coc.at(96, 40) < -0.3, "before and behind it is blurred");
    let upright = tiltshift(folder.path(), &["lens", "--list-presets", "--json"]);
    assert!(serde_json::from_slice::<serde_json::Value>(&upright.stdout).unwrap()["lenses"].is_array());
}

#[test]
fn a_band_blurs_by_a_pixel_at_its_borders() {
    let folder = folder();
    for tilt in ["0", "-4"] {
        let coc = coc(folder.path(), &["--focus-band", "60,100", "--tilt", tilt]);
        // The aperture follows
        for (row, wanted) in [(60, -1.0), (100, 1.0)] {
            let found = coc.at(96, row);
            assert!((found - wanted).abs() < ROUNDING, "tilt {tilt}, row {row}: {found} px");
        }
        assert!(coc.at(96, 80).abs() < 0.2 && coc.at(96, 126) > 1.2);
    }
    // A given aperture is kept, and off by the same at both borders
    let coc = coc(folder.path(), &["--focus-band", "60,100", "-N", "1"]);
    assert!((coc.at(96, 60) + coc.at(96, 100)).abs() < ROUNDING);
}

#[test]
fn two_pixels_are_both_sharp_without_swing() {
    let folder = folder();
    let coc = coc(folder.path(), &["-N", "0.5", "--focus-points", "20,120", "150,20"]);
    assert!(coc.at(20, 120).abs() < ROUNDING && coc.at(150, 20).abs() < ROUNDING);
    // Without swing a row of the plane of focus has one depth, and the floor one in each row
    assert!((coc.at(20, 100) - coc.at(150, 100)).abs() < ROUNDING);
}

#[test]
fn wishes_that_cannot_be_end_in_one_sentence() {
    let folder = folder();
    let wall = Picture::filled(SIZE, [0.5; 4]);
    let depth = Plane::filled(SIZE, 3.0);
    let frame = Frame::new(SIZE, vec![Layer::from_raw_depth(wall, depth)]).unwrap();
    write_frame(&folder.path().join("wall.exr"), &frame, &WriteOptions::default()).unwrap();
    let cases: [(&str, &[&str], &str); 6] = [
        ("wall.exr", &["-N", "1", "--focus", "ground"], "no ground was found"),
        ("in.exr", &["-N", "1", "--focus", "ground", "--focus-pixel", "2,2"], "leave out --focus-pixel"),
        ("in.exr", &["-N", "1", "--focus-points", "2,9", "80,9"], "same height"),
        ("in.exr", &["--focus-band", "10,500"], "row 500"),
        ("wall.exr", &["--focus-band", "10,50"], "equally far"),
        ("in.exr", &["--focus", "ground"], "--f-number"),
    ];
    for (input, wish, word) in cases {
        let lens = ["--focal-length", "35", "--sensor", "full-frame"];
        let output = tiltshift(folder.path(), &[&["filter", input, "-o", "out.exr"], &lens[..], wish].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{wish:?}: {said}");
        assert!(said.lines().last().unwrap().contains(word), "{wish:?}: {said}");
    }
}

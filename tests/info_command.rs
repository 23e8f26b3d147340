//! `tiltshift info` as a user types it, and deep files on the whole road.

mod support {
    pub(crate) mod shared;
}

#[path = "../crates/rgbd/tests/support/deep_file.rs"]
mod deep_file;

use std::path::Path;
use std::process::{Command, Output};

use deep_file::DeepFile;
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, ReadOptions, WriteOptions, read_picture, write_frame};
use support::shared;
use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn info(path: &Path, more: &[&str]) -> Output {
    tiltshift(Path::new("."), &[&["info", path.to_str().unwrap()], more].concat())
}

fn json(path: &Path, more: &[&str]) -> serde_json::Value {
    let output = info(path, &[&["--json"], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A frame with a floor, a hole and some sky.
fn written(path: &Path) {
    let window = PixelWindow { x: -2, y: -1, width: 20, height: 10 };
    let depth = Plane::from_fn(window, |x, y| match y {
        -1 => f32::INFINITY,
        0 if x == 3 => f32::NAN,
        _ => 12.5 - y as f32,
    });
    let frame = Frame::new(
        PixelWindow::of_size(16, 8),
        vec![Layer::from_raw_depth(Picture::filled(window, [0.5, 0.5, 0.5, 1.0]), depth)],
    );
    write_frame(path, &frame.unwrap(), &WriteOptions::default()).unwrap();
}

#[test]
fn a_frame_is_described_in_words_and_in_json() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("frame.exr");
    written(&path);
    let output = info(&path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    for wanted in [
        "tiltshift, as a frame",
        "display window 16x8 at (0, 0)",
        "data window    20x10 at (-2, -1)",
        "scan lines, compression RLE",
        "A B G R Z (float)",
        "colour         R, G, B, A",
        "depth          Z",
        "depth range    4.5 to 12.5 (float)",
        "background     20 pixels (10.0 %), stored as inf",
        "holes          one pixel, stored as NaN",
        "--focal-length and --sensor-width, or --fov",
    ] {
        assert!(words.contains(wanted), "no {wanted:?} in\n{words}");
    }
    let json = json(&path, &[]);
    assert_eq!(json["display_window"], serde_json::json!({ "x": 0, "y": 0, "width": 16, "height": 8 }));
    assert_eq!(json["parts"][0]["compression"], "RLE");
    assert_eq!(
        json["parts"][0]["channels"][4],
        serde_json::json!({ "name": "Z", "type": "float", "subsampled": false })
    );
    let frame = &json["frame"];
    assert_eq!(frame["depth_range"], serde_json::json!([4.5, 12.5]));
    assert_eq!(
        (frame["pixels_infinitely_far"].as_u64(), frame["pixels_of_unknown_depth"].as_u64()),
        (Some(20), Some(1))
    );
    assert_eq!((&frame["background_stored_as"], &frame["holes_stored_as"]), (&"inf".into(), &"nan".into()));
    assert!(json["refused_because"].is_null() && json["camera"].is_null());
}

#[test]
fn what_filter_would_refuse_is_described_with_the_reason() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("picture.exr");
    let window = PixelWindow::of_size(8, 4);
    let grey = Picture::from_fn(window, |x, y| [(x + y) as f32, (x + y) as f32, (x + y) as f32, 1.0]);
    rgbd::write_picture(&path, &grey, &rgbd::Head::new(window), &WriteOptions::default()).unwrap();
    let words = text(&info(&path, &[]).stdout);
    assert!(words.contains("colour         R, G, B, A") && words.contains("refuses it: no depth channel"), "{words}");
    assert!(words.contains("the same everywhere: if that is depth, name it with --depth"), "{words}");
    // Which does
    let named = json(&path, &["--depth", "R"]);
    assert_eq!(named["frame"]["depth_range"], serde_json::json!([1.0, 10.0]));
    assert_eq!(named["frame"]["pixels_of_unknown_depth"], 1, "a depth of 0");
}

#[test]
fn damaged_files_end_in_one_sentence_and_exit_code_2() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("cut.exr");
    written(&path);
    let whole = std::fs::read(&path).unwrap();
    let mut files = vec![folder.path().join("missing.exr"), path.clone()];
    std::fs::write(&path, &whole[..whole.len() - 5]).unwrap();
    if let Some(shared) = shared::folder() {
        files.extend(std::fs::read_dir(shared.join("data/damaged")).unwrap().map(|entry| entry.unwrap().path()));
    }
    for file in files {
        for more in [&[][..], &["--json"]] {
            let output = info(&file, more);
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{}: {said}", file.display());
            assert!(said.starts_with("tiltshift: ") && said.lines().count() == 1 && output.stdout.is_empty(), "{said}");
        }
    }
}

#[test]
fn every_valid_file_of_others_is_described_on_a_page() {
    let Some(shared) = shared::folder() else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(shared.join("data/exr")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "exr") {
            continue;
        }
        let output = info(&path, &[]);
        assert_eq!(output.status.code(), Some(0), "{}: {}", path.display(), text(&output.stderr));
        let words = text(&output.stdout);
        let parts = words.matches("\nPart").count();
        assert!(words.lines().count() <= 30 + 8 * parts, "{words}");
        seen += 1;
    }
    assert!(seen > 15, "{seen} files");
}

#[test]
fn a_deep_file_goes_through_the_filter() {
    let folder = TempDir::new().unwrap();
    let data = [0, 0, 64, 36];
    // A half open pane at 2 m before the left half of a wall at 4 m that has stripes, nothing on the right of it
    let samples = |x: i32, _: i32| {
        let wall = if x % 8 < 4 { 0.9 } else { 0.1 };
        let mut samples = vec![vec![1.0, wall, wall, wall, 4.0]];
        if (16..32).contains(&x) {
            samples.push(vec![0.5, 0.25, 0.25, 0.25, 2.0]);
        }
        if x < 48 { samples } else { Vec::new() }
    };
    let file = DeepFile::of_floats(exr::compression::Compression::ZIP1, data);
    std::fs::write(folder.path().join("deep.exr"), file.bytes(samples)).unwrap();
    let filter = |method: &str, result: &str| {
        let lens = ["--fov", "40", "--aperture-radius", "100", "--focal-length", "50", "--focus-distance", "4"];
        let arguments = [&["filter", "deep.exr", "-o", result, "--method", method], &lens[..]].concat();
        let output = tiltshift(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("deep, up to 2 samples a pixel"), "{}", text(&output.stderr));
        read_picture(&folder.path().join(result), &ReadOptions::default()).unwrap().value
    };
    let (flat, sharp_wall) = (filter("pinhole", "p.exr"), filter("merged", "m.exr"));
    // Flattening, by hand
    assert_eq!((flat.at(0, 9)[0], flat.at(17, 9)[0], flat.at(50, 9)), (0.9, 0.25 + 0.5 * 0.9, [0.0; 4]));
    // The wall is in focus, where nothing is before it
    assert!((0..8).all(|x| (sharp_wall.at(x, 18)[0] - flat.at(x, 18)[0]).abs() < 0.02));
}

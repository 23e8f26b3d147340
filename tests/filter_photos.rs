//! A photo and a depth map, as a user types them: what is asked, what comes out, and the real ones.

#![allow(clippy::print_stdout)]

mod support {
    pub(crate) mod shared;
}

use std::path::Path;
use std::process::{Command, Output};

use rgbd::{
    Encoding, Frame, Head, Layer, PhotoFormat, Picture, PixelWindow, Plane, ReadOptions, WriteOptions, read_photo,
    read_picture, write_frame, write_photo, write_picture,
};
use support::shared;
use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The light of a byte of sRGB.
fn light(byte: u8) -> f32 {
    let x = f64::from(byte) / 255.0;
    (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}

const SIZE: PixelWindow = PixelWindow { x: 0, y: 0, width: 96, height: 64 };

fn photo() -> Picture {
    Picture::from_fn(SIZE, |x, y| {
        let byte = |k: i32| light((k * 37 % 256) as u8);
        [byte(x / 3 + y), byte(x * y / 40), byte(y / 2), 1.0]
    })
}

/// Near at the left, far at the right.
fn depth(x: i32) -> f32 {
    if x < 48 { 2.0 } else { 6.0 }
}

/// A folder with a photo in PNG and maps of its depth: metres in PFM, a normalised one in PNG.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_photo(&path("photo.png"), &photo(), &Encoding::plain(PhotoFormat::Png), 0.0).unwrap();
    let grey = |value: &dyn Fn(i32, i32) -> f32| Picture::from_fn(SIZE, |x, y| [value(x, y); 4]);
    write_photo(&path("metres.pfm"), &grey(&|x, _| depth(x)), &Encoding::plain(PhotoFormat::Pfm), 0.0).unwrap();
    let byte = |x: i32, _| light(if x < 48 { 51 } else { 153 });
    write_photo(&path("grey.png"), &grey(&byte), &Encoding::plain(PhotoFormat::Png), 0.0).unwrap();
    folder
}

const LENS: [&str; 8] = ["--focal-length", "50", "--sensor-width", "36", "-N", "0.5", "--focus-pixel", "10,10"];

#[test]
fn what_a_map_means_is_asked_and_never_guessed() {
    let folder = folder();
    let refused = |more: &[&str], words: &[&str]| {
        let arguments = [&["filter", "photo.png", "-o", "out.png"], &LENS[..], more].concat();
        let output = tiltshift(folder.path(), &arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {said}");
        let sentence = said.lines().last().unwrap();
        assert!(words.iter().all(|word| sentence.contains(word)), "{more:?}: {sentence}");
        assert!(!folder.path().join("out.png").exists());
    };
    refused(&[], &["PNG picture, which has no depth", "--depth FILE"]);
    refused(&["--depth", "grey.png"], &["--depth-as", "--depth-range"]);
    refused(&["--depth", "grey.png", "--depth-as", "planar"], &["51 to 153", "--depth-range"]);
    refused(&["--depth", "metres.pfm"], &["2 to 6", "--depth-as"]);
    let ray = ["--depth", "metres.pfm", "--depth-as", "inverse", "--depth-range", "0,5"];
    refused(&ray, &["--depth-range", "at 0"]);
    refused(&["--depth", "metres.pfm", "--depth-as", "planar", "--coc"], &["--coc", ".exr"]);
    refused(&["--depth", "photo.png", "--depth-as", "planar"], &["in colours", "grey"]);
    refused(&["--depth", "absent.png", "--depth-as", "planar"], &["absent.png"]);

    // A map of another shape
    let narrow = Picture::filled(PixelWindow::of_size(64, 96), [2.0; 4]);
    let path = folder.path().join("narrow.pfm");
    write_photo(&path, &narrow, &Encoding::plain(PhotoFormat::Pfm), 0.0).unwrap();
    refused(&["--depth", "narrow.pfm", "--depth-as", "planar"], &["64x96", "96x64", "turn it"]);
}

#[test]
fn info_says_what_a_photo_and_a_map_hold() {
    let folder = folder();
    let words = |file: &str| {
        let output = tiltshift(folder.path(), &["info", file]);
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let photo = words("photo.png");
    assert!(photo.contains("PNG, 8 bit") && photo.contains("96 x 64") && photo.contains("sRGB"), "{photo}");
    assert!(words("grey.png").contains("numbers from 51 to 153"));
    let output = tiltshift(folder.path(), &["info", "metres.pfm", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["grey_from_to"], serde_json::json!([2.0, 6.0]));
}

#[test]
fn a_photo_without_blur_comes_back_byte_for_byte() {
    let folder = folder();
    let arguments = ["--depth", "metres.pfm", "--depth-as", "planar", "--method", "pinhole"];
    let arguments = [&["filter", "photo.png", "-o", "same.png"], &LENS[..], &arguments].concat();
    let output = tiltshift(folder.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("photo.png"), read("same.png"));
}

#[test]
fn a_map_beside_a_photo_is_as_good_as_depth_in_one_file() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let layer = Layer::from_raw_depth(photo(), Plane::from_fn(SIZE, |x, _| depth(x)));
    write_frame(&path("one.exr"), &Frame::new(SIZE, vec![layer]).unwrap(), &WriteOptions::default()).unwrap();
    // Depth three times in an EXR file, as some sensors' programs write it
    let grey = Picture::from_fn(SIZE, |x, _| [depth(x), depth(x), depth(x), 1.0]);
    write_picture(&path("grey.exr"), &grey, &Head::new(SIZE), &WriteOptions::default()).unwrap();
    let maps: [&[&str]; 5] = [
        &["one.exr"],
        &["photo.png", "--depth", "metres.pfm", "--depth-as", "planar"],
        // 51 and 153 of 255 are a fifth and three fifths of 10 m
        &["photo.png", "--depth", "grey.png", "--depth-as", "planar", "--depth-range", "0,10"],
        &["photo.png", "--depth", "grey.exr", "--depth-as", "planar"],
        // In colour from one EXR, and depth from another file
        &["one.exr", "--depth", "metres.pfm", "--depth-as", "planar"],
    ];
    let results = maps.map(|input| {
        let output = tiltshift(folder.path(), &[&["filter"], input, &["-o", "r.exr"], &LENS].concat());
        assert!(output.status.success(), "{input:?}: {}", stderr(&output));
        read_picture(&path("r.exr"), &ReadOptions::default()).unwrap().value
    });
    for (input, result) in maps.iter().zip(&results) {
        let off = result
            .planes()
            .iter()
            .zip(results[0].planes())
            .flat_map(|(a, b)| a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()));
        // The photo's bytes are decoded by a table, and depth is rounded once more
        const ROUNDING: f32 = 1e-5;
        assert!(off.fold(0.0, f32::max) <= ROUNDING, "{input:?} is as one.exr");
    }

    // Every format holds it, as well as it can
    let wanted = &results[1];
    for (name, format, loss) in [
        ("r.png", PhotoFormat::Png, 0.006),
        ("r.tif", PhotoFormat::Tiff, 0.006),
        ("r.jpg", PhotoFormat::Jpeg, 0.15),
        ("r.pfm", PhotoFormat::Pfm, 0.0),
    ] {
        let output = tiltshift(folder.path(), &[&["filter"], maps[1], &["-o", name], &LENS].concat());
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        let found = read_photo(&path(name), format, ReadOptions::MAX_PIXELS).unwrap().picture;
        let mut off = 0.0_f32;
        for (x, y) in SIZE.pixels() {
            off = found.at(x, y)[..3].iter().zip(wanted.at(x, y)).fold(off, |off, (a, b)| off.max((a - b).abs()));
        }
        // Half a step of 8 bits at white, what JPEG makes of noise, or nothing
        assert!(off <= loss, "{name}: off by {off}");
    }
}

#[test]
fn maps_as_data_sets_and_networks_write_them_are_taken_once_stated() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let sixteen = |name: &str, number: &dyn Fn(f32) -> f32| {
        let pixel = |x: u32, _: u32| image::Luma([number(depth(x as i32)).round() as u16]);
        image::ImageBuffer::from_fn(SIZE.width, SIZE.height, pixel).save(path(name)).unwrap();
    };
    sixteen("kitti.png", &|z| 256.0 * z);
    sixteen("tum.png", &|z| 5000.0 * z);
    sixteen("scannet.png", &|z| 1000.0 * z);
    // White is 1 m, black infinitely far: 2 and 6 m are a half and a sixth
    sixteen("midas.png", &|z| 65535.0 / z);
    sixteen("marigold.png", &|z| 65535.0 * (z - 1.0) / 9.0);
    // Focal length times baseline of 120 px m
    let grey = Picture::from_fn(SIZE, |x, _| [120.0 / depth(x); 4]);
    write_photo(&path("middlebury.pfm"), &grey, &Encoding::plain(PhotoFormat::Pfm), 0.0).unwrap();
    let result = |map: &[&str]| {
        let arguments = [&["filter", "photo.png", "-o", "r.exr", "--depth"], map, &LENS].concat();
        let output = tiltshift(folder.path(), &arguments);
        assert!(output.status.success(), "{map:?}: {}", stderr(&output));
        read_picture(&path("r.exr"), &ReadOptions::default()).unwrap().value
    };
    let wanted = result(&["metres.pfm", "--depth-as", "planar"]);
    for map in [
        &["kitti.png", "--depth-as", "planar", "--metres-per-unit", "0.00390625"][..],
        &["tum.png", "--depth-as", "planar", "--metres-per-unit", "0.0002"],
        &["scannet.png", "--depth-as", "planar", "--metres-per-unit", "0.001"],
        &["midas.png", "--depth-as", "inverse", "--depth-range", "inf,1"],
        &["marigold.png", "--depth-as", "planar", "--depth-range", "1,10"],
        &["middlebury.pfm", "--depth-as", "inverse", "--metres-per-unit", "120"],
    ] {
        let found = result(map);
        let pairs = found.planes().iter().zip(wanted.planes()).flat_map(|(a, b)| a.values().iter().zip(b.values()));
        let off = pairs.fold(0.0_f32, |off, (a, b)| off.max((a - b).abs()));
        // Half a step of 16 bits in depth, 1e-5 of it, moves no border of a disc by more than 1e-3 px
        assert!(off < 1e-3, "{map:?}: off by {off}");
    }
}

#[test]
fn real_photos_become_miniatures_with_one_command() {
    let Some(shared) = shared::folder() else { return };
    let photos = shared.join("data/photos");
    let photo = |name: &str| photos.join(name).to_string_lossy().into_owned();
    let folder = TempDir::new().unwrap();
    let phone = |name: &str| {
        [photo(&format!("{name}-alternative.jpg")), "--depth".into(), photo(&format!("{name}-depth.jpg"))].to_vec()
    };
    let inverse = ["--depth-as", "inverse", "--depth-range", "0.3,5", "--focus-pixel", "340,600"];
    let sensor = |name: &str| {
        let file = |end: &str| photo(&format!("cleargrasp_{name}{end}"));
        match name {
            "d435" => {
                vec![file("/000000123-opaque-rgb-img.jpg"), "--depth".into(), file("/000000123-opaque-depth-img.exr")]
            }
            _ => vec![file("/000000000-rgb.jpg"), "--depth".into(), file("/000000000-depth-rectified.exr")],
        }
    };
    let planar = ["--depth-as", "planar", "--focus-pixel", "640,400", "--fill-holes"];
    let cases = [
        (phone("flowers"), &inverse[..]),
        (phone("tunnel"), &inverse[..]),
        (sensor("d435"), &planar[..]),
        (sensor("blender"), &planar[..]),
    ];
    for (files, more) in cases {
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        let lens = ["-o", "m.jpg", "--focal-length", "28", "--sensor-width", "36", "-N", "2.8", "--tilt", "-2"];
        let output = tiltshift(folder.path(), &[&["filter"], &files[..], &lens, more].concat());
        assert!(output.status.success(), "{files:?}: {}", stderr(&output));
        println!("{}", stderr(&output));
        let result = read_photo(&folder.path().join("m.jpg"), PhotoFormat::Jpeg, ReadOptions::MAX_PIXELS).unwrap();
        let was = read_photo(Path::new(files[0]), PhotoFormat::Jpeg, ReadOptions::MAX_PIXELS).unwrap();
        assert_eq!(result.picture.window(), was.picture.window());
    }
}

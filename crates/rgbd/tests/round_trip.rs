//! What is written comes back bit for bit.

use std::path::PathBuf;

use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{
    Compression, Frame, Head, Layer, LensAttributes, Mask, Picture, PixelWindow, Plane, Primaries, ReadError,
    ReadOptions, Truth, WriteError, WriteOptions, read_frame, read_picture, read_truth, write_frame, write_picture,
    write_truth,
};
use tempfile::TempDir;

/// Overscan on all sides, at negative coordinates.
const DATA: PixelWindow = PixelWindow { x: -7, y: -12, width: 61, height: 47 };
const DISPLAY: PixelWindow = PixelWindow { x: 3, y: -5, width: 40, height: 30 };

fn place(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

/// Bits that look random and differ for every pixel and channel; among them NaN, infinities and subnormals.
fn noise(x: i32, y: i32, channel: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b9) ^ (y as u32).wrapping_mul(0x85eb_ca6b) ^ channel.wrapping_mul(77);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    f32::from_bits(h ^ (h >> 12))
}

fn noisy_picture(window: PixelWindow, seed: u32) -> Picture {
    Picture::from_fn(window, |x, y| [0, 1, 2, 3].map(|c| noise(x, y, seed + c)))
}

fn noisy_layer(seed: u32) -> Layer {
    Layer::from_raw_depth(noisy_picture(DATA, seed), Plane::from_fn(DATA, |x, y| noise(x, y, seed + 4)))
}

/// Numbers with long expansions, a negative zero, and a polygon for an iris.
fn camera() -> Camera {
    let pose = Pose::look_at(DVec3::new(0.1, -2.0 / 3.0, 1e-17), DVec3::new(7.3, 1.1, -9.7), DVec3::Y).unwrap();
    let film = Film::from_fov(1.234_567, 40, 30).unwrap().shifted(DVec2::new(-0.0, 1.0 / 7.0));
    let focus = Focus::new(DVec3::new(-0.0, 1.0 / 3.0, std::f64::consts::PI)).unwrap();
    let iris = Iris::new(DVec3::new(0.1, -0.2, 0.9), 0.1 / 3.0, ApertureShape::polygon(7, 0.1 + 0.2).unwrap());
    Camera { pose, film, focus, iris: iris.unwrap() }
}

fn bits(plane: &Plane) -> Vec<u32> {
    plane.values().iter().map(|value| value.to_bits()).collect()
}

fn assert_same_picture(a: &Picture, b: &Picture) {
    assert_eq!(a.window(), b.window());
    for (a, b) in a.planes().iter().zip(b.planes()) {
        assert!(bits(a) == bits(b), "pixels differ");
    }
}

fn assert_same_frame(a: &Frame, b: &Frame) {
    assert_eq!(Head::from(a), Head::from(b));
    assert_eq!(a.layers().len(), b.layers().len());
    for (a, b) in a.layers().iter().zip(b.layers()) {
        assert_same_picture(&a.color, &b.color);
        assert!(bits(&a.depth) == bits(&b.depth), "depth differs");
        assert_eq!(a.known, b.known);
    }
    assert!(a.planes.keys().eq(b.planes.keys()));
    assert!(a.planes.values().zip(b.planes.values()).all(|(a, b)| bits(a) == bits(b)), "planes differ");
}

/// Three layers, two planes, every head field set to something unusual.
fn rich_frame() -> Frame {
    let mut frame = Frame::new(DISPLAY, vec![noisy_layer(1), noisy_layer(11), noisy_layer(21)]).unwrap();
    frame.pixel_aspect = 1.1;
    frame.primaries = Primaries { red: [0.713, 0.293], ..Primaries::REC709 };
    frame.metres_per_unit = Some(0.1);
    frame.camera = Some(camera());
    frame.planes.insert("coc".into(), Plane::from_fn(DATA, |x, y| noise(x, y, 41)));
    frame.planes.insert("normal.Z".into(), Plane::from_fn(DATA, |x, y| noise(x, y, 42)));
    frame
}

fn options() -> WriteOptions {
    let lens = LensAttributes {
        focal_length_mm: Some(24.0),
        image_distance_mm: Some(24.1),
        f_number: Some(3.5),
        focus_distance_m: Some(f32::INFINITY),
        sensor_mm: Some([36.0, 24.0]),
        sensor_offset_um: Some([-0.5, 1200.0]),
        horizontal_fov_deg: Some(73.7),
        near: Some(0.1),
        far: Some(1e6),
        ..LensAttributes::default()
    };
    let notes = [("command", "render \"a b\" --α ∞"), ("empty", ""), ("two words", "line\nline")];
    let notes = notes.map(|(name, note)| (name.to_owned(), note.to_owned())).into();
    WriteOptions { lens, notes, ..WriteOptions::default() }
}

#[test]
fn a_frame_comes_back_bit_for_bit_in_every_compression() {
    let (_folder, path) = place("frame.exr");
    let frame = rich_frame();
    for compression in [Compression::None, Compression::Rle, Compression::Zips, Compression::Zip, Compression::Piz] {
        write_frame(&path, &frame, &WriteOptions { compression, ..options() }).unwrap();
        let read = read_frame(&path, &ReadOptions::default()).unwrap();
        assert_same_frame(&frame, &read.value);
        assert_eq!(read.notes, options().notes);
        assert_eq!(read.choice.hidden, ["L2", "L3"]);
        let camera_attributes = [read.lens.world_to_camera, read.lens.world_to_ndc];
        assert!(camera_attributes.iter().all(Option::is_some));
        let rest = LensAttributes { world_to_camera: None, world_to_ndc: None, ..read.lens };
        assert_eq!(rest, options().lens);
    }
}

#[test]
fn the_camera_comes_back_bit_for_bit() {
    let (_folder, path) = place("frame.exr");
    write_frame(&path, &rich_frame(), &WriteOptions::default()).unwrap();
    let read = read_frame(&path, &ReadOptions::default()).unwrap().value.camera.unwrap();
    // Equality would take -0 for 0
    assert_eq!(format!("{read:?}"), format!("{:?}", camera()));
    assert_eq!(read, camera());
}

#[test]
fn sky_stays_infinite_and_unknown_depth_stays_unknown() {
    let (_folder, path) = place("frame.exr");
    let window = PixelWindow::of_size(3, 1);
    let depth = Plane::from_values(window, vec![2.5, f32::INFINITY, f32::NAN]).unwrap();
    let frame = Frame::new(window, vec![Layer::from_raw_depth(Picture::filled(window, [1.0; 4]), depth)]).unwrap();
    write_frame(&path, &frame, &WriteOptions::default()).unwrap();
    let read = read_frame(&path, &ReadOptions::default()).unwrap().value;
    let layer = &read.layers()[0];
    assert_eq!(layer.known, Mask::from_fn(window, |x, _| x < 2));
    assert_eq!(layer.depth.values(), [2.5, f32::INFINITY, f32::INFINITY]);
}

#[test]
fn a_picture_comes_back_bit_for_bit() {
    let (_folder, path) = place("picture.exr");
    let picture = noisy_picture(DATA, 5);
    let head = Head { pixel_aspect: 2.0, metres_per_unit: Some(1.0 / 3.0), ..Head::new(DISPLAY).with_camera(camera()) };
    write_picture(&path, &picture, &head, &options()).unwrap();
    let read = read_picture(&path, &ReadOptions::default()).unwrap();
    assert_same_picture(&picture, &read.value);
    assert_eq!(read.head, head);
    assert_eq!(read.notes, options().notes);
}

#[test]
fn a_truth_comes_back_bit_for_bit_with_its_halves() {
    let (_folder, path) = place("truth.exr");
    let truth = Truth {
        display: DISPLAY,
        camera: Some(camera()),
        halves: [noisy_picture(DATA, 1), noisy_picture(DATA, 9)],
        samples: [1024, u32::MAX],
    };
    write_truth(&path, &truth, &options()).unwrap();
    let read = read_truth(&path, ReadOptions::MAX_PIXELS).unwrap().value;
    assert_eq!((read.display, read.camera, read.samples), (truth.display, truth.camera, truth.samples));
    for (a, b) in truth.halves.iter().zip(&read.halves) {
        assert_same_picture(a, b);
    }
    // Others see the mean
    assert_same_picture(&read_picture(&path, &ReadOptions::default()).unwrap().value, &truth.picture());
}

#[test]
fn a_picture_is_no_truth_and_has_no_depth() {
    let (_folder, path) = place("picture.exr");
    write_picture(&path, &noisy_picture(DATA, 5), &Head::new(DISPLAY), &WriteOptions::default()).unwrap();
    let error = read_truth(&path, ReadOptions::MAX_PIXELS).unwrap_err();
    assert!(matches!(error, ReadError::WrongKind { found: "a picture", .. }), "{error}");
    let error = read_frame(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.ends_with("picture.exr\" (channels: A, B, G, R); name one with --depth"), "{error}");
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    // Notes enough that a hash map would keep their order once in 10! runs
    let notes = (0..10).map(|i| (format!("note {i}"), i.to_string())).collect();
    let options = WriteOptions { notes, ..options() };
    let files = [(); 2].map(|()| {
        let (_folder, path) = place("frame.exr");
        write_frame(&path, &rich_frame(), &options).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(files[0] == files[1]);
}

#[test]
fn ndc_of_the_header_is_the_pixel() {
    let (_folder, path) = place("frame.exr");
    write_frame(&path, &rich_frame(), &WriteOptions::default()).unwrap();
    let lens = read_frame(&path, &ReadOptions::default()).unwrap().lens;
    let camera = camera();
    let pixel = DVec2::new(11.0, 22.5);
    let p_world = camera.pose.point_to_world(camera.film.q_from_pixel(pixel).extend(1.0) * 6.0).as_vec3();

    // Row vector times matrix, as OpenEXR has it
    let times = |m: [f32; 16]| {
        let p = [p_world.x, p_world.y, p_world.z, 1.0];
        [0, 1, 2, 3].map(|column| (0..4).map(|row| p[row] * m[4 * row + column]).sum::<f32>())
    };
    const SINGLE: f32 = 1e-5; // a few roundings of numbers about 10
    let in_camera = times(lens.world_to_camera.unwrap());
    assert!((in_camera[2] - 6.0).abs() < SINGLE, "{in_camera:?}");
    let ndc = times(lens.world_to_ndc.unwrap());
    let (x, y) = (ndc[0] / ndc[3], ndc[1] / ndc[3]);
    assert!((x - 11.0 / 40.0).abs() < SINGLE && (y - 22.5 / 30.0).abs() < SINGLE, "{x} {y}");
}

#[test]
fn a_plane_named_like_a_channel_is_refused_and_nothing_is_written() {
    let (folder, path) = place("frame.exr");
    for name in ["Z", "L2.R", "", "a\0b", &"n".repeat(256)] {
        let mut frame = rich_frame();
        frame.planes.insert(name.into(), Plane::filled(DATA, 0.0));
        let error = write_frame(&path, &frame, &WriteOptions::default()).unwrap_err();
        assert!(matches!(error, WriteError::BadName { .. }), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_camera_that_is_not_finite_is_refused() {
    let (_folder, path) = place("picture.exr");
    let mut broken = camera();
    broken.pose.position.y = f64::NAN;
    let head = Head::new(DISPLAY).with_camera(broken);
    let error = write_picture(&path, &noisy_picture(DATA, 1), &head, &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::BadNumber { .. }), "{error}");
}

#[test]
fn empty_windows_are_refused() {
    let (_folder, path) = place("picture.exr");
    let nothing = PixelWindow::of_size(0, 5);
    let options = WriteOptions::default();
    let empty_data = write_picture(&path, &noisy_picture(nothing, 1), &Head::new(DISPLAY), &options);
    assert!(matches!(empty_data, Err(WriteError::BadWindow { what: "data", .. })));
    let empty_display = write_picture(&path, &noisy_picture(DATA, 1), &Head::new(nothing), &options);
    assert!(matches!(empty_display, Err(WriteError::BadWindow { what: "display", .. })));
}

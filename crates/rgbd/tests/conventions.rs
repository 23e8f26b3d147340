//! Made-up files of other programs: names that leave the choice open, and what depth may mean.

use std::path::{Path, PathBuf};

use exr::prelude::*;
use optics::Film;
use rgbd::{DepthConvention, ReadError, ReadOptions, read_frame, read_picture};

const SIZE: (usize, usize) = (5, 3);

/// A float channel of one value.
fn channel(name: &str, value: f32) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32(vec![value; SIZE.0 * SIZE.1]))
}

/// Writes one part with these channels.
fn write(path: &Path, channels: Vec<AnyChannel<FlatSamples>>, change: impl FnOnce(&mut LayerAttributes)) {
    let mut layer = Layer::new(
        SIZE,
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    change(&mut layer.attributes);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("beauty.exr");
    (folder, path)
}

/// A file of float channels that hold 0.5 each.
fn named(names: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let (folder, path) = place();
    write(&path, names.iter().map(|name| channel(name, 0.5)).collect(), |_| {});
    (folder, path)
}

fn chosen(names: &[&str]) -> std::result::Result<(String, String), ReadError> {
    let (_folder, path) = named(names);
    let choice = read_frame(&path, &ReadOptions::default())?.choice;
    Ok((choice.color[0].clone(), choice.depth.unwrap()))
}

/// One row of depths as stored, read back by a convention; alpha 1, or 0 where told.
fn depths(stored: FlatSamples, alpha: Vec<f32>, options: &ReadOptions) -> Vec<(f32, bool)> {
    let (_folder, path) = place();
    let size = (alpha.len(), 1);
    let rgb = ["R", "G", "B"].map(|name| AnyChannel::new(name, FlatSamples::F32(vec![0.5; size.0])));
    let rest = [AnyChannel::new("A", FlatSamples::F32(alpha)), AnyChannel::new("Z", stored)];
    let channels = AnyChannels::sort(rgb.into_iter().chain(rest).collect());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let frame = read_frame(&path, options).unwrap().value;
    let layer = &frame.layers()[0];
    layer.depth.values().iter().copied().zip(layer.known.bits().iter().copied()).collect()
}

#[test]
fn names_of_common_renderers_are_understood() {
    for (names, color, depth) in [
        (&["R", "G", "B", "Z"][..], "R", "Z"),
        (&["R", "G", "B", "A", "depth.Z", "normals.X", "normals.Y", "normals.Z"], "R", "depth.Z"),
        (&["R", "G", "B", "A", "Z", "albedo.R", "albedo.G", "albedo.B", "P.X", "P.Y", "P.Z"], "R", "Z"),
        (&["beauty.R", "beauty.G", "beauty.B", "depth.V"], "beauty.R", "depth.V"),
        (&["red", "green", "blue", "Depth"], "red", "Depth"),
        (
            &["View Layer.Combined.R", "View Layer.Combined.G", "View Layer.Combined.B", "View Layer.Depth.Z"],
            "View Layer.Combined.R",
            "View Layer.Depth.Z",
        ),
        (&["R", "G", "B", "depth.R", "depth.G", "depth.B", "Z"], "R", "Z"),
        // Depth written three times
        (&["R", "G", "B", "A", "depth.R", "depth.G", "depth.B"], "R", "depth.R"),
        (&["diffuse.R", "diffuse.G", "diffuse.B", "Z Depth.R", "Z Depth.G", "Z Depth.B"], "diffuse.R", "Z Depth.R"),
        // Identities of objects are no colours
        (
            &["beauty.R", "beauty.G", "beauty.B", "Z", "crypto_object00.R", "crypto_object00.G", "crypto_object00.B"],
            "beauty.R",
            "Z",
        ),
        // Luminance alone is a grey picture
        (&["Y", "A", "Z"], "Y", "Z"),
    ] {
        assert_eq!(chosen(names).unwrap(), (color.to_owned(), depth.to_owned()), "{names:?}");
    }
}

#[test]
fn two_plausible_readings_are_an_error_that_lists_them() {
    let combined = |layer: &str| ["R", "G", "B", "A"].map(|name| format!("{layer}.Combined.{name}"));
    let names =
        [combined("Near").as_slice(), &combined("Far"), &["Near.Depth.Z".into(), "Far.Depth.Z".into()]].concat();
    let error = chosen(&names.iter().map(String::as_str).collect::<Vec<_>>()).unwrap_err();
    assert!(matches!(&error, ReadError::Ambiguous { what: "colour", .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("colour may be Far.Combined, Near.Combined; name one with --color"), "{text}");

    let error = chosen(&["R", "G", "B", "depth.Z", "depth_filtered.Z"]).unwrap_err().to_string();
    assert!(error.contains("depth may be depth.Z, depth_filtered.Z; name one with --depth"), "{error}");
}

#[test]
fn a_named_layer_settles_what_is_open() {
    let combined = |layer: &str| ["R", "G", "B", "A"].map(|name| format!("{layer}.Combined.{name}"));
    let names =
        [combined("Near").as_slice(), &combined("Far"), &["Near.Depth.Z".into(), "Far.Depth.Z".into()]].concat();
    let (_folder, path) = named(&names.iter().map(String::as_str).collect::<Vec<_>>());
    let near = ReadOptions { color: Some("Near.Combined".into()), ..ReadOptions::default() };
    let choice = read_frame(&path, &near).unwrap().choice;
    assert_eq!((choice.color[0].as_str(), choice.depth.as_deref()), ("Near.Combined.R", Some("Near.Depth.Z")));
    let missing = ReadOptions { color: Some("Middle".into()), ..ReadOptions::default() };
    let error = read_frame(&path, &missing).unwrap_err().to_string();
    assert!(error.contains("no colour layer \"Middle\"") && error.contains("Far.Combined, Near.Combined"), "{error}");
}

#[test]
fn what_only_ends_in_z_is_not_depth() {
    for names in [
        &["R", "G", "B", "A"][..],
        &["R", "G", "B", "N.X", "N.Y", "N.Z"],
        &["R", "G", "B", "Mist.Z"],
        &["R", "G", "B", "normals.Z"],
        &["R", "G", "B", "Position.Z", "P.Z", "velocity.Z"],
        &["R", "G", "B", "hero.R", "hero.G", "hero.B", "hero.Z"],
        &["R", "G", "B", "ZBack"],
    ] {
        let error = chosen(names).unwrap_err();
        assert!(matches!(error, ReadError::NoDepth { .. }), "{names:?}: {error}");
    }
    let error = chosen(&["R", "G", "B", "A"]).unwrap_err().to_string();
    assert!(error.ends_with("beauty.exr\" (channels: A, B, G, R); name one with --depth"), "{error}");
}

#[test]
fn planar_depth_is_taken_as_it_is_and_nonsense_is_unknown() {
    let stored = vec![2.0, 0.0, 0.0, -1.0, f32::NAN, f32::INFINITY, 1e10, 9.9e9, f32::MAX];
    let alpha = vec![1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let unknown = (f32::INFINITY, false);
    let sky = (f32::INFINITY, true);
    let read = depths(FlatSamples::F32(stored), alpha, &ReadOptions::default());
    assert_eq!(read, [(2.0, true), unknown, sky, unknown, unknown, sky, sky, (9.9e9, true), sky]);
}

#[test]
fn the_largest_half_is_the_sky_in_a_half_channel_only() {
    let half = FlatSamples::F16(vec![f16::MAX, f16::from_f32(65_472.0)]);
    let read = depths(half, vec![1.0; 2], &ReadOptions::default());
    assert_eq!(read, [(f32::INFINITY, true), (65_472.0, true)]);
    let float = FlatSamples::F32(vec![65_504.0]);
    assert_eq!(depths(float, vec![1.0], &ReadOptions::default()), [(65_504.0, true)]);
}

#[test]
fn inverse_depth_is_turned_over() {
    let options = ReadOptions { convention: DepthConvention::Inverse, ..ReadOptions::default() };
    let stored = FlatSamples::F32(vec![0.25, 0.0, -0.0, -2.0, f32::INFINITY]);
    let unknown = (f32::INFINITY, false);
    let sky = (f32::INFINITY, true);
    assert_eq!(depths(stored, vec![1.0; 5], &options), [(4.0, true), sky, sky, unknown, unknown]);
}

#[test]
fn distance_along_the_ray_becomes_planar_depth_with_the_film() {
    // Five columns over q from -1 to 1: centres at -0.8, -0.4, 0, 0.4, 0.8, one row at 0
    let film = Film::new((-1.0, -0.2).into(), (1.0, 0.2).into(), 5, 1).unwrap();
    let options = ReadOptions { convention: DepthConvention::Ray, film: Some(film), ..ReadOptions::default() };
    let plane = 3.0;
    let stored = [-0.8_f32, -0.4, 0.0, 0.4, 0.8].map(|q| plane * q.hypot(1.0)).to_vec();
    const ROUNDING: f32 = 1e-6; // three roundings of a number about 3
    for (z, known) in depths(FlatSamples::F32(stored), vec![1.0; 5], &options) {
        assert!(known && (z - plane).abs() < ROUNDING, "{z}");
    }

    let (_folder, path) = named(&["R", "G", "B", "Z"]);
    let blind = ReadOptions { convention: DepthConvention::Ray, ..ReadOptions::default() };
    let error = read_frame(&path, &blind).unwrap_err();
    assert!(matches!(error, ReadError::NeedsCamera { .. }) && error.to_string().contains("--fov"), "{error}");
}

#[test]
fn standard_camera_attributes_are_read_by_their_names() {
    let (_folder, path) = place();
    write(&path, ["R", "G", "B"].map(|name| channel(name, 0.5)).to_vec(), |attributes| {
        let vector = |x, y| AttributeValue::FloatVec2(Vec2(x, y));
        attributes.other = [
            ("effectiveFocalLength", AttributeValue::F32(35.0)),
            ("pinholeFocalLength", AttributeValue::F32(35.5)),
            ("sensorOverallDimensions", vector(36.0, 24.0)),
            ("sensorCenterOffset", vector(100.0, -200.0)),
        ]
        .map(|(name, value)| (Text::from(name), value))
        .into();
        attributes.aperture = Some(2.8);
        attributes.focus = Some(4.5);
    });
    let read = read_picture(&path, &ReadOptions { metres_per_unit: Some(0.01), ..ReadOptions::default() }).unwrap();
    let lens = read.lens;
    assert_eq!((lens.focal_length_mm, lens.image_distance_mm), (Some(35.0), Some(35.5)));
    assert_eq!((lens.sensor_mm, lens.sensor_offset_um), (Some([36.0, 24.0]), Some([100.0, -200.0])));
    assert_eq!((lens.f_number, lens.focus_distance_m), (Some(2.8), Some(4.5)));
    assert_eq!((read.head.camera, read.head.metres_per_unit), (None, Some(0.01)));
}

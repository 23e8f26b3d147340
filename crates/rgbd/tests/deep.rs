//! Deep files: what becomes of samples, and of bytes that are none.

#![expect(clippy::print_stderr, reason = "a test that is skipped says so")]

mod support {
    pub(crate) mod deep_file;
}

use exr::compression::Compression;
use exr::meta::attribute::SampleType;
use rgbd::{Frame, Loaded, PixelWindow, ReadError, ReadOptions, inspect, read_frame, read_picture};
use support::deep_file::{DeepFile, Sample};

const PACKINGS: [Compression; 3] = [Compression::Uncompressed, Compression::RLE, Compression::ZIP1];

/// Of numbers that are sums and products of a few halves.
const ROUNDING: f32 = 1e-6;

/// A sample of a grey `value` not yet multiplied by `alpha`, in the order A B G R Z.
fn grey(z: f32, value: f32, alpha: f32) -> Sample {
    let c = value * alpha;
    vec![alpha, c, c, c, z]
}

fn read(bytes: &[u8], options: &ReadOptions) -> Result<Loaded<Frame>, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.exr");
    std::fs::write(&path, bytes).unwrap();
    read_frame(&path, options)
}

/// The layers of one pixel with these samples: grey, alpha and depth of each.
fn layers(samples: &[Sample]) -> Vec<(f32, f32, f32)> {
    let file = DeepFile::of_floats(Compression::Uncompressed, [0, 0, 2, 1]);
    let loaded = read(&file.bytes(|x, _| if x == 0 { samples.to_vec() } else { Vec::new() }), &ReadOptions::default());
    let frame = loaded.unwrap().value;
    let of = |layer: &rgbd::Layer| {
        let [grey, _, _, alpha] = layer.color.at(0, 0);
        (grey, alpha, if layer.known.at(0, 0) { layer.depth.at(0, 0) } else { f32::NAN })
    };
    frame.layers().iter().map(of).collect()
}

fn assert_layers(found: &[(f32, f32, f32)], wanted: &[(f32, f32, f32)]) {
    let near = |a: f32, b: f32| a == b || (a - b).abs() < ROUNDING;
    let same = |(a, b): (&(f32, f32, f32), &(f32, f32, f32))| near(a.0, b.0) && near(a.1, b.1) && near(a.2, b.2);
    assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(same), "{found:?} is not {wanted:?}");
}

/// 0 to 4 samples a pixel, each pixel others.
fn many(x: i32, y: i32) -> Vec<Sample> {
    let count = (x + 2 * y).rem_euclid(5);
    (0..count).map(|i| grey(1.0 + (7 * i + x + y).rem_euclid(9) as f32, 0.1 * (i + 1) as f32, 0.5)).collect()
}

#[test]
fn every_way_to_store_samples_gives_the_same_layers() {
    let data = [-3, 2, 21, 13];
    let plain = DeepFile::of_floats(Compression::Uncompressed, data);
    let wanted = read(&plain.bytes(many), &ReadOptions::default()).unwrap();
    assert_eq!(wanted.value.data(), PixelWindow { x: -3, y: 2, width: 21, height: 13 });
    assert!(wanted.value.layers().len() > 2, "there is something to lose");
    for packing in PACKINGS {
        for (tile, many_parts) in [(None, false), (Some(8), false), (None, true), (Some(5), true)] {
            let file = DeepFile { packing, tile, many_parts, ..plain.clone() };
            let found = read(&file.bytes(many), &ReadOptions::default()).unwrap();
            assert_eq!(found.value, wanted.value, "{packing}, tiles {tile:?}, many parts {many_parts}");
        }
    }
}

#[test]
fn samples_come_as_surfaces_nearest_first_however_they_are_stored() {
    // In front an opaque card; behind it a pane, then a wall
    let samples = [grey(9.0, 0.2, 1.0), grey(2.0, 0.8, 1.0), grey(4.0, 0.6, 0.5)];
    assert_layers(&layers(&samples), &[(0.8, 1.0, 2.0), (0.3, 0.5, 4.0), (0.2, 1.0, 9.0)]);
}

#[test]
fn the_first_layer_is_the_flattened_picture() {
    // Over (Porter and Duff), by hand: 0.5 * 0.8 + 0.5 * (0.5 * 0.4 + 0.5 * 0.2)
    let samples = [grey(2.0, 0.8, 0.5), grey(4.0, 0.4, 0.5), grey(9.0, 0.2, 1.0)];
    assert_layers(&layers(&samples), &[(0.55, 1.0, 2.0), (0.2, 0.5, 4.0), (0.2, 1.0, 9.0)]);
}

#[test]
fn a_pixel_lies_where_most_of_it_is() {
    // An edge that covers a tenth of the wall's pixel, a haze, and the other way round
    assert_layers(&layers(&[grey(2.0, 1.0, 0.1), grey(8.0, 0.5, 1.0)]), &[(0.55, 1.0, 8.0)]);
    assert_layers(&layers(&[grey(2.0, 1.0, 0.9), grey(8.0, 0.5, 1.0)]), &[(0.95, 1.0, 2.0), (0.5, 1.0, 8.0)]);
    // Half of an edge over nothing is all there is
    assert_layers(&layers(&[grey(2.0, 1.0, 0.25)]), &[(0.25, 0.25, 2.0)]);
}

#[test]
fn samples_of_one_surface_are_not_hidden_layers() {
    // Four subpixel samples of a surface that is a little sloped, and a wall
    let surface = [0.0, 0.01, 0.02, 0.03].map(|rise| grey(4.0 + rise, 1.0, 0.5));
    let samples = [&surface[..], &[grey(8.0, 0.0, 1.0)]].concat();
    assert_layers(&layers(&samples), &[(0.9375, 1.0, 4.0), (0.0, 1.0, 8.0)]);
}

#[test]
fn more_surfaces_than_layers_are_merged_into_the_last_and_said() {
    let file = DeepFile::of_floats(Compression::ZIP1, [0, 0, 3, 2]);
    let samples = |x: i32, _| (0..10 * x).map(|i| grey(1.0 + i as f32, 1.0, 0.5)).collect();
    let loaded = read(&file.bytes(samples), &ReadOptions::default()).unwrap();
    assert_eq!(loaded.value.layers().len(), 8);
    assert_eq!(loaded.choice.hidden.len(), 7);
    let text = loaded.choice.to_string();
    assert!(
        text.contains("deep, up to 20 samples a pixel") && text.contains("in 4 pixels all beyond layer 8"),
        "{text}"
    );
    // The last layer: what is left of ten, laid over each other; opacity passes half at the first one
    let last = &loaded.value.layers()[7];
    assert!((last.color.at(1, 0)[3] - (1.0 - 0.5_f32.powi(3))).abs() < ROUNDING, "{:?}", last.color.at(1, 0));
    assert_eq!(last.depth.at(1, 0), 8.0);
}

#[test]
fn a_volume_lies_in_its_middle() {
    let channels = ["A", "B", "G", "R", "Z", "ZBack"].map(|name| (name, SampleType::F32)).to_vec();
    let file = DeepFile { channels, ..DeepFile::of_floats(Compression::RLE, [0, 0, 2, 1]) };
    // A cloud from 2 to 6, and a wall with as much behind as before
    let samples = |x: i32, _| {
        let (cloud, wall) = ([grey(2.0, 1.0, 0.5), vec![6.0]].concat(), [grey(9.0, 0.5, 1.0), vec![9.0]].concat());
        if x == 0 { vec![wall, cloud] } else { vec![wall] }
    };
    let loaded = read(&file.bytes(samples), &ReadOptions::default()).unwrap();
    let depths = |x: i32| loaded.value.layers().iter().map(|layer| layer.depth.at(x, 0)).collect::<Vec<_>>();
    assert_eq!((depths(0), depths(1)), (vec![4.0, 9.0], vec![9.0, f32::INFINITY]));
    assert!(loaded.choice.reason.contains("1 volumes taken at their middle"), "{}", loaded.choice);
}

#[test]
fn halves_whole_numbers_and_a_missing_alpha_are_read_too() {
    let channels = vec![("B", SampleType::F16), ("G", SampleType::U32), ("R", SampleType::F32), ("Z", SampleType::F16)];
    let file = DeepFile { channels, ..DeepFile::of_floats(Compression::ZIP1, [0, 0, 4, 3]) };
    let samples = |x: i32, _| vec![vec![0.5, 3.0, 0.25, 2.0]; usize::from(x > 0)];
    let frame = read(&file.bytes(samples), &ReadOptions::default()).unwrap().value;
    let layer = &frame.layers()[0];
    assert_eq!((layer.color.at(1, 1), layer.depth.at(1, 1)), ([0.25, 3.0, 0.5, 1.0], 2.0));
    // Without a sample there is nothing, infinitely far
    assert_eq!((layer.color.at(0, 1), layer.depth.at(0, 1), layer.known.at(0, 1)), ([0.0; 4], f32::INFINITY, true));
}

#[test]
fn a_depth_that_is_none_is_unknown_and_behind_all_others() {
    let samples = [grey(-1.0, 0.4, 1.0), grey(3.0, 0.8, 1.0), grey(f32::NAN, 0.4, 1.0)];
    let found = layers(&samples);
    assert_layers(&found[..1], &[(0.8, 1.0, 3.0)]);
    assert!(found.len() == 3 && found[1..].iter().all(|layer| layer.2.is_nan()), "{found:?}");
}

#[test]
fn a_deep_picture_without_depth_asked_for_is_flattened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.exr");
    let file = DeepFile::of_floats(Compression::ZIP1, [0, 0, 20, 10]);
    std::fs::write(&path, file.bytes(many)).unwrap();
    let frame = read_frame(&path, &ReadOptions::default()).unwrap().value;
    assert_eq!(read_picture(&path, &ReadOptions::default()).unwrap().value, frame.layers()[0].color);
    let inspection = inspect(&path, &ReadOptions::default()).unwrap();
    let understood = inspection.frame.unwrap();
    let deep = understood.deep.unwrap();
    assert_eq!((deep.samples, deep.most, deep.empty), (400, 4, 40));
    assert!(inspection.survey.parts[0].deep && understood.depth.infinite == 40);
}

#[test]
fn a_largest_number_of_samples_that_is_not_known_does_no_harm() {
    let mut bytes = DeepFile::of_floats(Compression::RLE, [0, 0, 9, 4]).bytes(many);
    let wanted = read(&bytes, &ReadOptions::default()).unwrap();
    let name = b"maxSamplesPerPixel\0int\0\x04\0\0\0";
    let at = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len();
    bytes[at..at + 4].copy_from_slice(&(-1_i32).to_le_bytes());
    assert_eq!(read(&bytes, &ReadOptions::default()).unwrap().value, wanted.value);
}

#[test]
fn a_deep_file_cut_short_anywhere_is_damaged() {
    for (packing, tile) in [(Compression::Uncompressed, None), (Compression::ZIP1, None), (Compression::RLE, Some(4))] {
        let file = DeepFile { tile, ..DeepFile::of_floats(packing, [0, 0, 9, 7]) };
        let bytes = file.bytes(many);
        for length in (0..bytes.len()).step_by(17).chain([bytes.len() - 1]) {
            let error = read(&bytes[..length], &ReadOptions::default()).unwrap_err();
            assert!(matches!(error, ReadError::Damaged { .. }), "{packing} cut to {length}: {error}");
        }
    }
}

#[test]
fn counts_and_sizes_that_lie_are_refused_before_anything_is_allocated_for_them() {
    let file = DeepFile::of_floats(Compression::Uncompressed, [0, 0, 4, 1]);
    let samples = |_, _| vec![grey(1.0, 0.5, 1.0)];
    let bytes = file.bytes(samples);
    // The block is the last thing in the file: y, three sizes, four counts, twenty numbers
    let block = bytes.len() - (4 + 3 * 8 + 4 * 4 + 4 * 20);
    let with = |at: usize, value: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        read(&bytes, &ReadOptions::default())
    };
    assert!(with(block, &0_i32.to_le_bytes()).is_ok(), "this is where the block starts");
    let huge = (1_u64 << 60).to_le_bytes();
    for (at, value, why) in [
        (block, &7_i32.to_le_bytes()[..], "another row"),
        (block + 4, &huge, "the counts of 2^60 bytes"),
        (block + 12, &huge, "samples of 2^60 bytes"),
        (block + 20, &huge, "samples that unpack to 2^60 bytes"),
        (block + 20, &81_u64.to_le_bytes(), "a byte too many"),
        (block + 28, &3_u32.to_le_bytes(), "counts that fall"),
        (block + 40, &u32::MAX.to_le_bytes(), "more samples than bytes"),
        (block + 40, &3_u32.to_le_bytes(), "fewer samples than bytes"),
    ] {
        let error = with(at, value).unwrap_err();
        assert!(matches!(error, ReadError::Damaged { .. }), "{why}: {error}");
    }
    // More than is unpacked at once, which the file could hold
    let error = with(block + 20, &(1_u64 << 27).to_le_bytes()).unwrap_err();
    assert!(matches!(error, ReadError::Damaged { .. }), "{error}");
}

#[test]
fn balls_of_weta_digital_are_read_as_two_layers() {
    let Some(folder) = std::env::var_os("TILTSHIFT_SHARED") else {
        eprintln!("skipped: TILTSHIFT_SHARED is not set");
        return;
    };
    let path = std::path::PathBuf::from(folder).join("data/exr/weta_deep_balls_lowres.exr");
    let loaded = read_frame(&path, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.value.data(), PixelWindow { x: 131, y: 170, width: 764, height: 406 });
    let understood = inspect(&path, &ReadOptions::default()).unwrap().frame.unwrap();
    let deep = understood.deep.unwrap();
    // As the sources of the shared data say: 0 to 2 samples, none in 192928 pixels, Z from 128 to 738 (rounded); the
    // farthest sample of all is a hidden one
    assert_eq!((deep.most, deep.empty, deep.merged), (2, 192_928, 0));
    let [near, far] = understood.depth.range.unwrap();
    assert!(near.round() == 128.0 && (730.0..738.5).contains(&far), "{near} to {far}");
    assert_eq!(loaded.value.layers().len(), 2);
}

#[test]
fn a_flat_part_is_read_beside_a_deep_one() {
    // Two parts by hand: the deep file's header and blocks, with those of a flat one behind each
    let (deep, flat) = support::deep_file::beside_a_flat_part();
    let options = |color: &str| ReadOptions { color: Some(color.into()), ..ReadOptions::default() };
    let found = read(&deep, &options("flat")).unwrap();
    assert_eq!(found.value.layers().len(), 1);
    let layer = &found.value.layers()[0];
    assert!(found.value.data().pixels().all(|(x, y)| layer.color.at(x, y)[0] == flat(x, y)), "{}", found.choice);
    let found = read(&deep, &options("deep")).unwrap();
    assert_eq!(found.value.layers()[0].color.at(0, 0), [0.25, 0.25, 0.25, 0.5]);
    // Two pictures are two readings
    let error = read(&deep, &ReadOptions::default()).map(|_| ()).unwrap_err();
    assert!(matches!(error, ReadError::Ambiguous { what: "colour", .. }), "{error}");
}

//! Ways to store one picture: compressions, tiles, types, parts, windows, names.

use std::path::PathBuf;

use exr::prelude::*;
use rgbd::{Frame, Loaded, PixelWindow, ReadError, ReadOptions, inspect, read_frame};

/// Channels of one part.
macro_rules! list {
    ($($channel:expr),*) => { SmallVec::from_vec(vec![$($channel),*]) };
}

/// Larger than a block of every compression but one, and no multiple of a tile.
const SIZE: (usize, usize) = (45, 37);

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("zoo.exr");
    (folder, path)
}

/// A smooth ramp that halves hold exactly.
fn ramp(i: usize) -> f32 {
    0.25 + (i % SIZE.0) as f32 / 64.0
}

fn halves(name: &str) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F16((0..SIZE.0 * SIZE.1).map(|i| f16::from_f32(ramp(i))).collect()))
}

fn floats(name: &str, size: (usize, usize), value: impl Fn(usize) -> f32) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32((0..size.0 * size.1).map(value).collect()))
}

/// Half colour, float depth, whole numbers of objects.
fn mixed() -> AnyChannels<FlatSamples> {
    let ids = AnyChannel::new("id", FlatSamples::U32((0..(SIZE.0 * SIZE.1) as u32).collect()));
    let depth = floats("Z", SIZE, |i| 1.0 + i as f32);
    AnyChannels::sort(list![halves("A"), halves("B"), halves("G"), halves("R"), depth, ids])
}

/// A part with this window.
fn part(
    name: &str,
    window: PixelWindow,
    channels: SmallVec<[AnyChannel<FlatSamples>; 4]>,
) -> Layer<AnyChannels<FlatSamples>> {
    let attributes = LayerAttributes::named(name).with_position(Vec2(window.x, window.y));
    let size = (window.width as usize, window.height as usize);
    Layer::new(size, attributes, Encoding::SMALL_FAST_LOSSLESS, AnyChannels::sort(channels))
}

/// Reads parts with the display window from (0, 0).
fn read(
    display: (usize, usize),
    parts: Vec<Layer<AnyChannels<FlatSamples>>>,
) -> std::result::Result<Loaded<Frame>, ReadError> {
    let (_folder, path) = place();
    let attributes = ImageAttributes::new(IntegerBounds::new(Vec2(0, 0), display));
    Image::from_layers(attributes, Layers::from(parts)).write().to_file(&path).unwrap();
    let loaded = read_frame(&path, &ReadOptions::default());
    // An inspection finds what reading does
    let understood = inspect(&path, &ReadOptions::default()).unwrap().frame;
    match (&loaded, &understood) {
        (Ok(loaded), Ok(understood)) => assert_eq!(loaded.choice, understood.choice),
        (Err(refused), Err(found)) => assert_eq!(refused.to_string(), found.to_string()),
        _ => panic!("reading gave {:?}, inspecting {understood:?}", loaded.as_ref().map(|loaded| &loaded.choice)),
    }
    loaded
}

#[test]
fn every_compression_in_lines_and_tiles_gives_the_same_picture() {
    // What a compression may lose of a smooth ramp of halves, and of floats: B44 keeps six bits of a step within 4 x 4
    // pixels, DWA what is seen, PXR24 15 bits of a float's fraction
    const EXACT: f32 = 0.0;
    const LOSSY: f32 = 0.03;
    let tiles = |x, y| Blocks::Tiles(Vec2(x, y));
    for (compression, of_color, of_depth) in [
        (Compression::Uncompressed, EXACT, EXACT),
        (Compression::RLE, EXACT, EXACT),
        (Compression::ZIP1, EXACT, EXACT),
        (Compression::ZIP16, EXACT, EXACT),
        (Compression::PIZ, EXACT, EXACT),
        (Compression::PXR24, EXACT, 0.5_f32.powi(15)),
        (Compression::B44, LOSSY, EXACT),
        (Compression::B44A, LOSSY, EXACT),
        (Compression::DWAA(None), LOSSY, EXACT),
        (Compression::DWAB(None), LOSSY, EXACT),
    ] {
        for blocks in [Blocks::ScanLines, tiles(16, 16), tiles(64, 8)] {
            let (_folder, path) = place();
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let layer = Layer::new(SIZE, LayerAttributes::default(), encoding, mixed());
            Image::from_layer(layer).write().to_file(&path).unwrap();
            let frame = read_frame(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}")).value;
            let layer = &frame.layers()[0];
            for (i, &z) in layer.depth.values().iter().enumerate() {
                let wanted = 1.0 + i as f32;
                assert!((z - wanted).abs() <= of_depth * wanted, "{compression}, {blocks:?}: depth {z} for {wanted}");
            }
            for plane in layer.color.planes() {
                for (i, &c) in plane.values().iter().enumerate() {
                    let off = (c - ramp(i)).abs();
                    assert!(off <= of_color * ramp(i), "{compression}, {blocks:?}: {c} for {}", ramp(i));
                }
            }
            // What is said of it is what it is
            let survey = inspect(&path, &ReadOptions::default()).unwrap().survey;
            assert_eq!(survey.parts[0].tile.is_some(), blocks != Blocks::ScanLines);
            let name = format!("{compression:?}").to_ascii_uppercase();
            let said = survey.parts[0].compression.to_ascii_uppercase();
            assert!(name.starts_with(&said) || matches!(said.as_str(), "NONE" | "ZIPS" | "ZIP"), "{said} for {name}");
        }
    }
}

#[test]
fn the_full_size_of_a_mip_map_is_read() {
    let (_folder, path) = place();
    let side = 16_usize;
    let level = |side: usize, value: f32| FlatSamples::F32(vec![value; side * side]);
    let channel = |name: &str, value: f32| {
        let level_data = (0..5).map(|i| level(side >> i, value + i as f32)).collect();
        AnyChannel::new(name, Levels::Mip { rounding_mode: exr::math::RoundingMode::Down, level_data })
    };
    let list = AnyChannels::sort(list![channel("B", 0.3), channel("G", 0.2), channel("R", 0.1), channel("Z", 7.0)]);
    let encoding = Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..Encoding::SMALL_FAST_LOSSLESS };
    let layer = Layer::new((side, side), LayerAttributes::default(), encoding, list);
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let frame = read_frame(&path, &ReadOptions::default()).unwrap().value;
    assert_eq!(frame.data(), PixelWindow::of_size(16, 16));
    assert!(frame.data().pixels().all(|(x, y)| frame.layers()[0].color.at(x, y) == [0.1, 0.2, 0.3, 1.0]));
    assert!(frame.layers()[0].depth.values().iter().all(|&z| z == 7.0));
    assert!(inspect(&path, &ReadOptions::default()).unwrap().survey.parts[0].has_levels);
}

/// Colour of one part with its window, depth of another with its own.
fn two_parts(display: (usize, usize), color: PixelWindow, depth: PixelWindow) -> Frame {
    let value = |name| floats(name, (color.width as usize, color.height as usize), |_| 0.5);
    let color = part("rgba", color, list![value("A"), value("B"), value("G"), value("R")]);
    let width = depth.width as usize;
    let z = |i: usize| 100.0 + (depth.x + (i % width) as i32) as f32 + 0.01 * (depth.y + (i / width) as i32) as f32;
    let depth = part("depth", depth, list![floats("Z", (width, depth.height as usize), z)]);
    let loaded = read(display, vec![color, depth]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.choice.depth.as_deref(), Some("depth/Z"));
    loaded.value
}

#[test]
fn windows_of_parts_may_differ_in_every_way() {
    let window = |x, y, width, height| PixelWindow { x, y, width, height };
    for (color, depth) in [
        // Within, beyond, negative, and with one pixel in common
        (window(2, 1, 10, 8), window(0, 0, 20, 12)),
        (window(-5, -4, 30, 20), window(3, 3, 4, 4)),
        (window(-9, -9, 10, 10), window(0, 0, 6, 6)),
        (window(19, 11, 7, 7), window(13, 5, 7, 7)),
    ] {
        let frame = two_parts((20, 12), color, depth);
        assert_eq!((frame.display, frame.data()), (PixelWindow::of_size(20, 12), color));
        let layer = &frame.layers()[0];
        for (x, y) in color.pixels() {
            let wanted = depth.contains(x, y).then_some(100.0 + x as f32 + 0.01 * y as f32);
            let found = layer.known.at(x, y).then(|| layer.depth.at(x, y));
            assert_eq!(found, wanted, "({x}, {y}) of {color} and {depth}");
        }
        // The whole picture can be covered
        let covered = frame.covering(PixelWindow::of_size(20, 12));
        assert!(covered.data().contains_window(&PixelWindow::of_size(20, 12)));
    }
}

#[test]
fn a_window_far_outside_the_picture_costs_nothing_and_shows_nothing() {
    // To cover both would take 10^14 pixels
    let far = PixelWindow { x: 10_000_000, y: 10_000_000, width: 3, height: 3 };
    let frame = two_parts((20, 12), far, far).covering(PixelWindow::of_size(20, 12));
    assert_eq!(frame.data(), PixelWindow::of_size(20, 12));
    assert!(frame.layers()[0].color.planes().iter().all(|plane| plane.values().iter().all(|&c| c == 0.0)));
    assert!(frame.layers()[0].depth.values().iter().all(|z| z.is_infinite()));
}

#[test]
fn a_picture_and_data_too_far_apart_for_the_limit_are_refused() {
    let (_folder, path) = place();
    let window = PixelWindow { x: 30, y: 30, width: 3, height: 3 };
    let value = |name| floats(name, (3, 3), |_| 0.5);
    let part = part("one", window, list![value("B"), value("G"), value("R"), value("Z")]);
    let attributes = ImageAttributes::new(IntegerBounds::new(Vec2(0, 0), (20, 20)));
    Image::from_layers(attributes, Layers::from(vec![part])).write().to_file(&path).unwrap();
    let limit = |max_pixels| read_frame(&path, &ReadOptions { max_pixels, ..ReadOptions::default() });
    assert!(limit(33 * 33).is_ok());
    let error = limit(33 * 33 - 1).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { pixels: 1089, limit: 1088, .. }), "{error}");
}

#[test]
fn depth_three_times_must_be_the_same_three_times() {
    let parts = |green: f32| {
        let color = ["R", "G", "B"].map(|name| floats(name, (4, 2), |_| 0.5));
        let depth = ["depth.R", "depth.B"].map(|name| floats(name, (4, 2), |i| 1.0 + i as f32));
        let green = floats("depth.G", (4, 2), |i| if i == 5 { green } else { 1.0 + i as f32 });
        vec![part("", PixelWindow::of_size(4, 2), color.into_iter().chain(depth).chain([green]).collect())]
    };
    let loaded = read((4, 2), parts(6.0)).unwrap();
    assert_eq!(loaded.value.layers()[0].depth.at(1, 1), 6.0);
    assert!(loaded.choice.reason.contains("three times the same"), "{}", loaded.choice);
    let error = read((4, 2), parts(6.5)).unwrap_err();
    assert!(matches!(error, ReadError::Ambiguous { what: "depth", .. }), "{error}");
}

#[test]
fn alpha_may_be_a_part_of_its_own() {
    let window = PixelWindow::of_size(4, 2);
    let value = |name, value: f32| floats(name, (4, 2), move |_| value);
    let parts = vec![
        part("rgb", window, list![value("B", 0.3), value("G", 0.2), value("R", 0.1)]),
        part("RGBA", window, list![value("A", 0.5)]),
        part("depth", window, list![value("Z", 4.0)]),
    ];
    let loaded = read((4, 2), parts).unwrap();
    assert_eq!(loaded.value.layers()[0].color.at(1, 1), [0.1, 0.2, 0.3, 0.5]);
    assert!(loaded.choice.reason.contains("RGBA/A is its alpha"), "{}", loaded.choice);
}

#[test]
fn names_may_be_long_have_spaces_and_a_view() {
    let layer = format!("View Layer.{}", "a very long name ".repeat(11));
    let names = ["R", "G", "B"].map(|base| format!("{layer}.Combined.{base}"));
    let depth = format!("{layer}.Depth.Z");
    let channels = names.iter().chain([&depth]).map(|name| floats(name, (4, 2), |_| 0.5)).collect();
    let loaded = read((4, 2), vec![part("", PixelWindow::of_size(4, 2), channels)]).unwrap();
    assert_eq!((loaded.choice.color, loaded.choice.depth), (names.to_vec(), Some(depth)));

    // Two eyes in parts of their own: the first is taken, or the one asked for
    let eye = |view: &str, value: f32| {
        let channels = ["R", "G", "B", "Z"].map(|name| floats(name, (4, 2), |_| value)).into_iter().collect();
        let mut part = part(&format!("rgba.{view} eye"), PixelWindow::of_size(4, 2), channels);
        part.attributes.view_name = Some(Text::from(format!("{view} eye").as_str()));
        part
    };
    let (_folder, path) = place();
    let attributes = ImageAttributes::new(IntegerBounds::new(Vec2(0, 0), (4, 2)));
    let parts = Layers::from(vec![eye("left", 0.25), eye("right", 0.75)]);
    Image::from_layers(attributes, parts).write().to_file(&path).unwrap();
    for (view, value) in [(None, 0.25), (Some("left eye"), 0.25), (Some("right eye"), 0.75)] {
        let options = ReadOptions { view: view.map(str::to_owned), ..ReadOptions::default() };
        let loaded = read_frame(&path, &options).unwrap();
        assert_eq!(loaded.value.layers()[0].color.at(0, 0)[0], value, "{}", loaded.choice);
    }
}

#[test]
fn luminance_with_chroma_is_refused_by_name_and_alone_is_grey() {
    let chroma = ["BY", "RY", "Y", "Z"].map(|name| floats(name, (4, 2), |_| 0.5)).into_iter().collect();
    let error = read((4, 2), vec![part("", PixelWindow::of_size(4, 2), chroma)]).unwrap_err().to_string();
    assert!(error.contains("luminance and chroma (Y, RY, BY), which is not read; write it with R, G and B"), "{error}");
    let grey = ["Y", "Z"].map(|name| floats(name, (4, 2), |i| i as f32)).into_iter().collect();
    let loaded = read((4, 2), vec![part("", PixelWindow::of_size(4, 2), grey)]).unwrap();
    assert_eq!(loaded.value.layers()[0].color.at(1, 1), [5.0, 5.0, 5.0, 1.0]);
}

#[test]
fn a_file_in_xyz_keeps_its_primaries_and_is_shown_in_those_of_the_screen() {
    // X, Y and Z of Rec. 709's own white and of its red (IEC 61966-2-1) in the channels R, G, B
    let (white, red) = ([0.9505, 1.0, 1.0891], [0.4124, 0.2126, 0.0193]);
    let channels = ["R", "G", "B"].into_iter().enumerate();
    let channels = channels.map(|(c, name)| floats(name, (2, 1), move |i| if i == 0 { white[c] } else { red[c] }));
    let channels = channels.chain([floats("Z", (2, 1), |_| 1.0)]).collect();
    let xyz = exr::meta::attribute::Chromaticities {
        red: Vec2(1.0, 0.0),
        green: Vec2(0.0, 1.0),
        blue: Vec2(0.0, 0.0),
        white: Vec2(1.0 / 3.0, 1.0 / 3.0),
    };
    let (_folder, path) = place();
    let window = IntegerBounds::new(Vec2(0, 0), (2, 1));
    let attributes = ImageAttributes { chromaticities: Some(xyz), ..ImageAttributes::new(window) };
    let part = part("", PixelWindow::of_size(2, 1), channels);
    Image::from_layers(attributes, Layers::from(vec![part])).write().to_file(&path).unwrap();
    let frame = read_frame(&path, &ReadOptions::default()).unwrap().value;
    assert_eq!((frame.primaries.red, frame.layers()[0].color.at(0, 0)[0]), ([1.0, 0.0], white[0]));
    let shown = frame.layers()[0].color.to_rec709(&frame.primaries);
    const PRINTED: f32 = 1e-3; // four digits
    for (x, wanted) in [(0, [1.0, 1.0, 1.0, 1.0]), (1, [1.0, 0.0, 0.0, 1.0])] {
        let found = shown.at(x, 0);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < PRINTED), "{found:?} is not {wanted:?}");
    }
}

//! Files of other programs: which channels are taken, and what comes of them.

#![expect(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::path::PathBuf;

use rgbd::{Frame, Layer, Loaded, PixelWindow, ReadError, ReadOptions, read_frame, read_picture, survey_file};

/// A file of the shared data, or `None` where there is none of it.
fn shared(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("TILTSHIFT_SHARED") else {
        eprintln!("skipped: TILTSHIFT_SHARED is not set");
        return None;
    };
    Some(PathBuf::from(folder).join(name))
}

fn read(path: &std::path::Path) -> Loaded<Frame> {
    read_frame(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Nearest and farthest finite known depth.
fn depth_range(layer: &Layer) -> (f32, f32) {
    let known = layer.depth.values().iter().zip(layer.known.bits()).filter(|(z, known)| **known && z.is_finite());
    known.fold((f32::MAX, 0.0), |(near, far), (&z, _)| (near.min(z), far.max(z)))
}

fn count(layer: &Layer, test: impl Fn(f32, bool, f32) -> bool) -> usize {
    let depth = layer.depth.values().iter().zip(layer.known.bits());
    let alpha = layer.color.planes()[3].values();
    depth.zip(alpha).filter(|((z, known), alpha)| test(**z, **known, **alpha)).count()
}

fn sky(layer: &Layer) -> usize {
    count(layer, |z, known, _| known && z.is_infinite())
}

fn unknown(layer: &Layer) -> usize {
    count(layer, |_, known, _| !known)
}

#[test]
fn blenders_multilayer_gives_the_combined_pass_and_the_depth_pass() {
    let Some(path) = shared("data/exr/blender_tabletop_multilayer.exr") else { return };
    let read = read(&path);
    let combined = ["R", "G", "B", "A"].map(|name| format!("ViewLayer.Combined.{name}"));
    assert_eq!(read.choice.color, combined);
    assert_eq!(read.choice.depth.as_deref(), Some("ViewLayer.Depth.Z"));
    // The other channels that end in Z are named as passed over
    for other in ["Mist", "Normal", "Position"] {
        assert!(read.choice.reason.contains(&format!("ViewLayer.{other}.Z")), "{}", read.choice);
    }
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (5.826_345, 13.774_343));
    assert_eq!((sky(layer), unknown(layer)), (116_144, 0));
    assert_eq!(read.value.display, PixelWindow::of_size(960, 540));
    assert!(read.lens.is_empty() && read.head.camera.is_none());
}

#[test]
fn blenders_half_colour_beside_float_depth() {
    let Some(path) = shared("data/exr/blender_tabletop_rgbaz_half_piz.exr") else { return };
    let read = read(&path);
    assert_eq!(read.choice.color, ["R", "G", "B", "A"]);
    assert_eq!(read.choice.depth.as_deref(), Some("Z"));
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (5.826_345, 13.774_343));
    assert_eq!(sky(layer), 116_144);

    // The same picture as the float one, as far as a half holds it
    let Some(float) = shared("data/exr/blender_tabletop_multilayer.exr") else { return };
    let float = self::read(&float).value;
    const HALF: f32 = 1.0 / 2048.0; // relative, half a step of an 11-bit mantissa
    for (a, b) in layer.color.planes().iter().zip(float.layers()[0].color.planes()) {
        let close = |(a, b): (&f32, &f32)| (a - b).abs() <= HALF * b.abs() + 1e-7;
        assert!(a.values().iter().zip(b.values()).all(close));
    }
}

#[test]
fn beachball_in_one_part_gives_the_default_eye() {
    let Some(path) = shared("data/exr/beachball_singlepart.0001.exr") else { return };
    let read = read(&path);
    assert_eq!(read.choice.view.as_deref(), Some("right"));
    assert_eq!(read.choice.color, ["R", "G", "B", "A"]);
    assert_eq!(read.choice.depth.as_deref(), Some("Z"));
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (9.0, 10.921_875));
    // Where nothing is, depth is infinite and known
    assert_eq!((sky(layer), unknown(layer)), (201_053, 0));
    assert_eq!(count(layer, |z, _, alpha| z.is_infinite() != (alpha == 0.0)), 0);
    assert_eq!(read.value.display, PixelWindow::of_size(2048, 1556));
    assert_eq!(read.value.data(), PixelWindow { x: 654, y: 245, width: 911, height: 876 });
}

#[test]
fn beachball_in_one_part_gives_the_other_eye_when_asked() {
    let Some(path) = shared("data/exr/beachball_singlepart.0001.exr") else { return };
    let left = ReadOptions { view: Some("left".into()), ..ReadOptions::default() };
    let read = read_frame(&path, &left).unwrap();
    assert_eq!(read.choice.color, ["left.R", "left.G", "left.B", "left.A"]);
    assert_eq!(read.choice.depth.as_deref(), Some("left.Z"));
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (9.0, 10.257_812_5));
    assert_eq!(sky(layer), 200_948);
    let neither = ReadOptions { view: Some("middle".into()), ..ReadOptions::default() };
    let error = read_frame(&path, &neither).unwrap_err().to_string();
    assert!(error.contains("no view \"middle\"") && error.contains("(right, left)"), "{error}");
}

#[test]
fn beachball_in_many_parts_gives_colour_and_depth_of_one_eye() {
    let Some(path) = shared("data/exr/beachball_multipart.0003.exr") else { return };
    let read = read(&path);
    assert_eq!(read.choice.view.as_deref(), Some("right"));
    assert_eq!(read.choice.color, ["R", "G", "B", "A"].map(|name| format!("rgba_right/{name}")));
    assert_eq!(read.choice.depth.as_deref(), Some("depth_right/Z"));
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (9.0, 10.273_437_5));
    assert_eq!((sky(layer), unknown(layer)), (163_028, 0));
    assert_eq!(read.value.data(), PixelWindow { x: 864, y: 481, width: 879, height: 855 });

    let left = ReadOptions { view: Some("left".into()), ..ReadOptions::default() };
    let read = read_frame(&path, &left).unwrap();
    assert_eq!(read.choice.depth.as_deref(), Some("depth_left/Z"));
    assert_eq!(depth_range(&read.value.layers()[0]), (9.0, 10.367_187_5));
    assert_eq!(read.value.data(), PixelWindow { x: 897, y: 481, width: 880, height: 855 });
}

#[test]
fn depth_of_another_window_is_brought_to_the_colours() {
    let Some(path) = shared("data/exr/beachball_multipart.0003.exr") else { return };
    // The other eye's depth is not for this one
    let names = ReadOptions { depth: Some("depth_left/Z".into()), ..ReadOptions::default() };
    let error = read_frame(&path, &names).unwrap_err();
    assert!(matches!(error, ReadError::NotFound { what: "depth channel", .. }), "{error}");
    // A mask of a smaller window in place of depth, of the same eye
    let names = ReadOptions { depth: Some("whitebarmask_right".into()), ..ReadOptions::default() };
    let read = read_frame(&path, &names).unwrap();
    assert_eq!(read.value.data(), PixelWindow { x: 864, y: 481, width: 879, height: 855 });
    let layer = &read.value.layers()[0];
    let mask = PixelWindow { x: 1283, y: 481, width: 393, height: 762 };
    let is_near = |&(x, y): &(i32, i32)| layer.known.at(x, y) && layer.depth.at(x, y) < 10.0;
    let near: Vec<(i32, i32)> = read.value.data().pixels().filter(is_near).collect();
    assert!(near.len() > 1000 && near.iter().all(|&(x, y)| mask.contains(x, y)));
}

#[test]
fn gaffers_parts_give_colour_with_alpha_and_the_depth_part() {
    let Some(path) = shared("data/exr/gaffer_multipart.exr") else { return };
    let read = read(&path);
    assert_eq!(read.choice.color, ["R", "G", "B", "A"].map(|name| format!("customRgba/{name}")));
    assert_eq!(read.choice.depth.as_deref(), Some("customDepth/Z"));
    assert!(read.choice.reason.contains("customRgb has not"), "{}", read.choice);
    let layer = &read.value.layers()[0];
    assert_eq!(depth_range(layer), (0.25, 0.5));
    assert_eq!(sky(layer) + unknown(layer), 1100);
    assert_eq!(read.value.data(), PixelWindow { x: 20, y: 20, width: 60, height: 60 });
    assert_eq!(read.value.display, PixelWindow::of_size(100, 100));
}

#[test]
fn the_pictures_own_depth_is_taken_and_not_a_characters() {
    for (name, colour, depth, tenth) in [
        // 0.1 as a float, and as a half
        ("gaffer_channelTestSinglePart", "R", "Z", 0.1),
        ("gaffer_channelTestNukeSinglePart", "R", "depth.Z", 0.099_975_586),
        ("gaffer_channelTestNukePartPerLayer", "rgba.main/R", "depth.main/Z", 0.099_975_586),
    ] {
        let Some(path) = shared(&format!("data/exr/{name}.exr")) else { return };
        let read = read(&path);
        assert_eq!(read.choice.color[0], colour);
        assert_eq!(read.choice.depth.as_deref(), Some(depth));
        assert_eq!(depth_range(&read.value.layers()[0]), (tenth, tenth));
        assert!(read.choice.reason.contains("character"), "{}", read.choice);
    }
}

#[test]
fn a_layer_that_is_asked_for_comes_with_its_own_depth() {
    let Some(path) = shared("data/exr/gaffer_channelTestSinglePart.exr") else { return };
    let character = ReadOptions { color: Some("character".into()), ..ReadOptions::default() };
    let read = read_frame(&path, &character).unwrap();
    assert_eq!(read.choice.color, ["R", "G", "B", "A"].map(|name| format!("character.{name}")));
    assert_eq!(read.choice.depth.as_deref(), Some("character.Z"));
    assert_eq!(depth_range(&read.value.layers()[0]), (0.5, 0.5));
    let back = ReadOptions { depth: Some("ZBack".into()), ..ReadOptions::default() };
    assert_eq!(depth_range(&read_frame(&path, &back).unwrap().value.layers()[0]), (0.2, 0.2));
}

#[test]
fn references_give_two_layers_with_overscan() {
    for (name, near, far, hidden, hidden_sky) in [
        ("simple", 8.323_519, 24.045_555, 5640, 4),
        ("simple_combined", 8.579_903, 29.241_426, 2977, 1),
        ("landscape", 29.978_334, 99.864_72, 26_270, 2),
    ] {
        let Some(path) = shared(&format!("reference/{name}_rgbd.exr")) else { return };
        let read = read(&path);
        assert_eq!(read.choice.color, ["R", "G", "B"]);
        assert_eq!((read.choice.depth.as_deref(), read.choice.hidden.as_slice()), (Some("Z"), &["L2".to_owned()][..]));
        assert_eq!(read.value.display, PixelWindow::of_size(640, 360));
        assert_eq!(read.value.data(), PixelWindow { x: -56, y: -56, width: 752, height: 472 });
        let [first, second] = read.value.layers() else { panic!("two layers") };
        assert_eq!(depth_range(first), (near, far));
        assert_eq!(count(first, |_, known, alpha| !known || alpha != 1.0), 0);
        // Present with alpha 1 and a depth, or absent with neither
        assert_eq!(count(second, |_, known, alpha| known && alpha == 1.0), hidden);
        assert_eq!(count(second, |_, known, alpha| known != (alpha == 1.0)), 0);
        assert_eq!(sky(second), hidden_sky);
    }
}

#[test]
fn blenders_references_have_sky_at_infinity() {
    for (name, near, far, infinite) in
        [("simple", 7.305_887, 14.404_972, 0), ("occluder", 2.190_962_3, 193.553_33, 206_178)]
    {
        let Some(path) = shared(&format!("reference/blender/{name}_pinhole_1280x720_64spp_RGBZ.exr")) else { return };
        let read = read(&path);
        assert_eq!(read.choice.color, ["R", "G", "B"]);
        let layer = &read.value.layers()[0];
        assert_eq!(depth_range(layer), (near, far));
        assert_eq!((sky(layer), unknown(layer)), (infinite, 0));
        assert_eq!(count(layer, |_, _, alpha| alpha != 1.0), 0);
    }
}

#[test]
fn references_without_depth_are_opaque_pictures() {
    for name in ["simple_tilt_ref.exr", "landscape_reverse_ref.exr", "blender/simple_dof40px_reference_192spp.exr"] {
        let Some(path) = shared(&format!("reference/{name}")) else { return };
        let read = read_picture(&path, &ReadOptions::default()).unwrap();
        assert_eq!(read.value.window(), read.head.display);
        assert!(read.value.planes()[3].values().iter().all(|&alpha| alpha == 1.0));
        let red = read.value.planes()[0].values();
        let mean = red.iter().sum::<f32>() / red.len() as f32;
        assert!((0.05..0.9).contains(&mean), "{mean}");
        let error = read_frame(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("(channels: B, G, R); name one with --depth"), "{error}");
    }
}

#[test]
fn chroma_files_are_refused_by_name() {
    let Some(path) = shared("data/exr/Rec709_YC.exr") else { return };
    for error in [
        read_frame(&path, &ReadOptions::default()).map(|_| ()).unwrap_err(),
        read_picture(&path, &ReadOptions::default()).map(|_| ()).unwrap_err(),
    ] {
        let text = error.to_string();
        assert!(matches!(error, ReadError::Unsupported { .. }) && text.contains("luminance and chroma"), "{text}");
    }
}

#[test]
fn a_survey_lists_parts_views_and_windows() {
    let Some(path) = shared("data/exr/beachball_multipart.0003.exr") else { return };
    let survey = survey_file(&path, ReadOptions::MAX_PIXELS).unwrap();
    assert_eq!(survey.views, ["right", "left"]);
    assert_eq!(survey.parts.len(), 10);
    let part = &survey.parts[1];
    assert_eq!((part.name.as_deref(), part.view.as_deref()), (Some("depth_left"), Some("left")));
    assert_eq!(part.window, PixelWindow { x: 897, y: 481, width: 880, height: 855 });
    assert_eq!(part.channels.len(), 1);
}

#[test]
fn damaged_files_are_refused() {
    let Some(folder) = shared("data/damaged") else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        seen += 1;
        // Pixels too: a header may be whole and what follows not
        assert!(read_frame(&path, &ReadOptions::default()).is_err(), "{}", path.display());
        let error = read_picture(&path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, ReadError::Damaged { .. }), "{error}");
    }
    assert_eq!(seen, 10);
}

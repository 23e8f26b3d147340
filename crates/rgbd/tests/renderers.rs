//! Small files with the names and numbers that renderers write: each is taken, or refused by name with what would do.

use std::path::{Path, PathBuf};

use exr::prelude::*;
use rgbd::{ReadError, ReadOptions, read_depth_map, read_frame};

const SIZE: (usize, usize) = (4, 3);

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shot.exr");
    (folder, path)
}

/// Float channels, all 0.5 but depth, and what repeats it in its layer.
fn write(path: &Path, names: &[&str], depth: &str, stored: f32) {
    let channel = |name: &&str| {
        let layer = |name: &str| name.rsplit_once('.').map(|(layer, _)| layer.to_owned());
        let is_depth = *name == depth || (layer(name).is_some() && layer(name) == layer(depth));
        let value = if is_depth { stored } else { 0.5 };
        AnyChannel::new(*name, FlatSamples::F32(vec![value; SIZE.0 * SIZE.1]))
    };
    let channels = AnyChannels::sort(names.iter().map(channel).collect());
    let layer = exr::prelude::Layer::new(SIZE, LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

#[test]
fn what_renderers_call_depth_is_found() {
    let rgba = ["R", "G", "B", "A"];
    for (who, names, color, depth) in [
        ("Arnold", &["Z"][..], "R", "Z"),
        ("Arnold, layer names", &["RGBA.R", "RGBA.G", "RGBA.B", "RGBA.A", "Z.Z"], "RGBA.R", "Z.Z"),
        ("V-Ray", &["VRayZDepth"], "R", "VRayZDepth"),
        ("V-Ray, grey", &["VRayZDepth.R", "VRayZDepth.G", "VRayZDepth.B"], "R", "VRayZDepth.R"),
        ("V-Ray, lonely", &["VRayZDepth.R"], "R", "VRayZDepth.R"),
        ("Redshift", &["Z", "N.X", "N.Y", "N.Z"], "R", "Z"),
        ("Octane", &["Z-Depth.R", "Z-Depth.G", "Z-Depth.B"], "R", "Z-Depth.R"),
        ("Octane, old", &["Info passes.Zdepth.Z"], "R", "Info passes.Zdepth.Z"),
        (
            "Unreal",
            &[
                "FinalImageMovieRenderQueue_WorldDepth.R",
                "FinalImageMovieRenderQueue_WorldDepth.G",
                "FinalImageMovieRenderQueue_WorldDepth.B",
                "FinalImageMovieRenderQueue_WorldDepth.A",
            ],
            "R",
            "FinalImageMovieRenderQueue_WorldDepth.R",
        ),
        ("Houdini Mantra", &["Pz", "N.x", "N.y", "N.z"], "R", "Pz"),
        ("Houdini Karma", &["depth.z", "P.x", "P.y", "P.z"], "R", "depth.z"),
        ("RenderMan", &["z", "zback"], "R", "z"),
        ("Corona", &["CESSENTIAL_ZDepth.R", "CESSENTIAL_ZDepth.G", "CESSENTIAL_ZDepth.B"], "R", "CESSENTIAL_ZDepth.R"),
        ("Clarisse", &["depth", "normal.x", "normal.y", "normal.z"], "R", "depth"),
        ("LuxCore", &["DEPTH.Z"], "R", "DEPTH.Z"),
        ("appleseed", &["depth.Y"], "R", "depth.Y"),
        ("Maya", &["Z", "mv.x", "mv.y"], "R", "Z"),
        ("Nuke", &["depth.Z", "forward.u", "forward.v"], "R", "depth.Z"),
        ("Blender", &["ViewLayer.Depth.Z", "ViewLayer.Mist.Z", "ViewLayer.Normal.Z"], "R", "ViewLayer.Depth.Z"),
        ("Cinema 4D", &["Depth", "Depth_error"], "R", "Depth"),
        ("3ds Max", &["ZDepth"], "R", "ZDepth"),
        ("two, of which one is told by its plain name", &["depth", "linear_depth"], "R", "depth"),
    ] {
        let (_folder, path) = place();
        let all: Vec<&str> = if names[0].starts_with("RGBA") { names.to_vec() } else { [&rgba, names].concat() };
        write(&path, &all, depth, 2.5);
        let read = read_frame(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{who}: {error}"));
        assert_eq!((read.choice.color[0].as_str(), read.choice.depth.as_deref()), (color, Some(depth)), "{who}");
        assert_eq!(read.value.layers()[0].depth.at(1, 1), 2.5, "{who}");
    }
}

#[test]
fn what_is_about_depth_is_no_depth() {
    for names in [
        &["R", "G", "B", "depth_mask"][..],
        &["R", "G", "B", "depth.variance"],
        &["R", "G", "B", "Px", "Py", "Pz"],
        &["R", "G", "B", "zback"],
        &["R", "G", "B", "depth_confidence.R", "depth_confidence.G", "depth_confidence.B"],
    ] {
        let (_folder, path) = place();
        write(&path, names, "", 1.0);
        let error = read_frame(&path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, ReadError::NoDepth { .. } | ReadError::Ambiguous { .. }), "{names:?}: {error}");
        assert!(error.to_string().contains("name one with --"), "{names:?}: {error}");
    }
}

#[test]
fn backgrounds_of_renderers_are_the_sky() {
    let (_folder, path) = place();
    for (who, stored) in [("Arnold", 1e30), ("Blender", 1e10), ("Redshift", f32::INFINITY), ("RenderMan", f32::MAX)] {
        write(&path, &["R", "G", "B", "Z"], "Z", stored);
        let frame = read_frame(&path, &ReadOptions::default()).unwrap().value;
        assert!(frame.layers()[0].known.at(1, 1) && frame.layers()[0].depth.at(1, 1).is_infinite(), "{who}");
    }
    // Any other once it is named
    for stored in [0.0, -1.0, 1000.0, f32::NAN] {
        write(&path, &["R", "G", "B", "Z"], "Z", stored);
        let options = ReadOptions { background: Some(stored), ..ReadOptions::default() };
        let frame = read_frame(&path, &options).unwrap().value;
        assert!(frame.layers()[0].known.at(1, 1) && frame.layers()[0].depth.at(1, 1).is_infinite(), "{stored}");
    }
}

#[test]
fn depth_along_an_axis_that_points_back_has_its_sign_turned_and_that_is_said() {
    let (_folder, path) = place();
    write(&path, &["R", "G", "B", "Pz"], "Pz", -3.5);
    let read = read_frame(&path, &ReadOptions::default()).unwrap();
    assert_eq!(read.value.layers()[0].depth.at(1, 1), 3.5);
    assert!(read.choice.to_string().contains("sign turned"), "{}", read.choice);
}

#[test]
fn a_composite_beside_its_layers_asks_which() {
    let (_folder, path) = place();
    let combined = |layer: &str| ["R", "G", "B", "A"].map(|name| format!("{layer}.Combined.{name}"));
    let names = [combined("Composite").as_slice(), &combined("ViewLayer"), &["ViewLayer.Depth.Z".into()]].concat();
    write(&path, &names.iter().map(String::as_str).collect::<Vec<_>>(), "ViewLayer.Depth.Z", 2.5);
    let error = read_frame(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("Composite.Combined, ViewLayer.Combined; name one with --color"), "{error}");
    let options = ReadOptions { color: Some("ViewLayer.Combined".into()), ..ReadOptions::default() };
    assert_eq!(read_frame(&path, &options).unwrap().choice.depth.as_deref(), Some("ViewLayer.Depth.Z"));
}

#[test]
fn files_of_other_kinds_are_called_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("depth");
    for (start, word) in [
        (&b"\x93NUMPY\x01\0v\0{'descr': '<f4'"[..], "NumPy"),
        (b"PIEH\x04\0\0\0\x03\0\0\0", "Sintel"),
        (b"P5\n640 480\n65535\n", "PGM"),
        (b"\x89HDF\r\n\x1a\n\0\0\0\0", "HDF5"),
        (b"\0\0\0\x24ftypheic\0\0\0\0", "HEIC"),
        (b"RIFF\x10\0\0\0WEBPVP8 ", "WebP"),
    ] {
        std::fs::write(&path, start).unwrap();
        for error in [
            read_frame(&path, &ReadOptions::default()).unwrap_err(),
            read_depth_map(&path, None, ReadOptions::MAX_PIXELS).unwrap_err(),
        ] {
            let said = error.to_string();
            assert!(said.contains(word) && said.contains("which is not read"), "{word}: {said}");
        }
    }
    // Any white space stands behind the word of a PFM
    for separator in ["\n", " ", "\r\n"] {
        let header = format!("Pf{separator}2 1\n-1.0\n");
        std::fs::write(&path, [header.as_bytes(), &[0, 0, 128, 63, 0, 0, 0, 64]].concat()).unwrap();
        let map = read_depth_map(&path, None, ReadOptions::MAX_PIXELS).unwrap();
        assert_eq!(map.stored.values(), [1.0, 2.0], "{separator:?}");
    }
}

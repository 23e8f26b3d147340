//! Models that other people made: each is rendered, or refused in one sentence.
//!
//! They lie in the folder that `TILTSHIFT_SHARED` names; without it these tests say so and pass.
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};

use optics::Camera;
use rgbd::{PixelWindow, Silent};
use trace::{LayerSettings, Margin, SceneFile};

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("TILTSHIFT_SHARED").map(|shared| Path::new(&shared).join("data/scenes"));
    let folder = folder.filter(|folder| folder.is_dir());
    if folder.is_none() {
        println!("skipped: TILTSHIFT_SHARED names no folder with data/scenes");
    }
    folder
}

/// All models below a folder, by name.
fn models(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let extension = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            _ if path.is_dir() => models(&path, found),
            Some("glb" | "gltf" | "obj") => found.push(path),
            _ => {}
        }
    }
}

#[test]
fn every_model_is_rendered_or_refused_in_one_sentence() {
    let Some(folder) = folder() else { return };
    let mut found = Vec::new();
    models(&folder, &mut found);
    assert!(found.len() > 15, "{found:?}");
    let mut refused = Vec::new();
    for path in &found {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let file = match SceneFile::open(path) {
            Ok(file) => file,
            Err(error) => {
                let message = error.to_string();
                assert!(!message.contains('\n') && message.contains(&name) && message.len() < 400, "{message}");
                println!("refused: {message}");
                refused.push(name);
                continue;
            }
        };
        for warning in file.warnings() {
            println!("{name}: {warning}");
            assert!(!warning.contains('\n'));
        }
        let shot = file.shot(None).unwrap();
        let camera = Camera { film: shot.camera.film.resized(16, 9).unwrap(), ..shot.camera };
        let truth = trace::truth(file.scene(), &camera, PixelWindow::of_size(16, 9), 8, 1, &Silent).unwrap();
        let picture = truth.picture();
        let values = || picture.window().pixels().flat_map(|(x, y)| picture.at(x, y));
        assert!(values().all(|value| value.is_finite() && value >= 0.0), "{name}");
        // Something is in the picture, and it is not all of one colour
        let settings = LayerSettings { margin: Margin::Pixels(0), color_samples: 2, ..LayerSettings::default() };
        let frame = trace::layers(file.scene(), &camera, &settings, &Silent).unwrap().frame;
        let depth = &frame.layers()[0].depth;
        let seen = depth.values().iter().filter(|depth| depth.is_finite()).count();
        // A spider is mostly legs
        assert!(seen >= 8, "{name}: {seen} pixels of 144 show something");
        let (least, most) = values().fold((f32::INFINITY, 0.0_f32), |(a, b), value| (a.min(value), b.max(value)));
        assert!(most > 0.0 && least < most, "{name}: {least} to {most}");
        println!(
            "{name}: {seen} of 144 pixels, {} bounces: {}",
            file.scene().bounces(),
            file.scene().needs().join(", ")
        );
    }
    // Their buffer and material library are not there
    assert_eq!(refused, ["space_in_material_name.obj", "Cameras.gltf"]);
}

#[test]
fn a_texture_that_is_missing_is_told_once_by_name() {
    let Some(folder) = folder() else { return };
    let copy = tempfile::tempdir().unwrap();
    let path = copy.path().join("alone.glb");
    std::fs::copy(folder.join("kenney_city/building-small-a.glb"), &path).unwrap();
    let file = SceneFile::open(&path).unwrap();
    assert_eq!(file.warnings().len(), 1, "{:?}", file.warnings());
    assert!(file.warnings()[0].contains("Textures/colormap.png"), "{}", file.warnings()[0]);
}

//! The scenes of the project are what they say they are.

use std::path::PathBuf;

use optics::Camera;
use rgbd::{PixelWindow, Silent};
use trace::SceneFile;

fn open(name: &str) -> SceneFile {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../data/scenes/{name}.toml"));
    SceneFile::open(path).unwrap()
}

#[test]
fn every_shot_shows_something() {
    for name in ["simple", "landscape", "town", "tabletop", "thicket", "traffic"] {
        let file = open(name);
        assert!(file.warnings().is_empty());
        assert!(file.shots().len() >= 4, "{name}");
        for (shot_name, shot) in file.shots() {
            let film = shot.camera.film.resized(32, 18).unwrap();
            let camera = Camera { film, ..shot.camera };
            let truth =
                trace::truth(&file.scene_of(shot), &camera, PixelWindow::of_size(32, 18), 8, 1, &Silent).unwrap();
            let picture = truth.picture();
            let greens: Vec<f32> = picture.window().pixels().map(|(x, y)| picture.at(x, y)[1]).collect();
            let mean = greens.iter().sum::<f32>() / greens.len() as f32;
            let spread = greens.iter().map(|green| (green - mean).abs()).sum::<f32>() / greens.len() as f32;
            // Neither dark nor burnt out nor blank, even in so small a picture
            assert!((0.02..3.0).contains(&mean) && spread > 0.01, "{name}/{shot_name}: mean {mean}, spread {spread}");
        }
    }
}

#[test]
fn only_gloss_and_motion_need_more_than_packets() {
    for name in ["simple", "landscape", "town", "thicket"] {
        assert!(open(name).scene().needs().is_empty(), "{name}: {:?}", open(name).scene().needs());
    }
    let traffic = open("traffic");
    assert!(traffic.scene().needs()[0].ends_with("moving things") && traffic.scene().bounces() == 0);
    let table = open("tabletop");
    assert_eq!(table.scene().bounces(), 8);
}

#[test]
fn tilts_of_the_shots_are_those_of_real_lenses() {
    for (name, shot, least, most) in
        [("town", "miniature", 7.9, 8.1), ("tabletop", "tilt", 5.0, 15.0), ("tabletop", "reverse", 6.9, 7.1)]
    {
        let lens = open(name).shot(Some(shot)).unwrap().lens.unwrap();
        let tilt = lens.axis().z.acos().to_degrees();
        assert!((least..=most).contains(&tilt), "{name}/{shot}: {tilt} degrees");
    }
}

//! A reference picture: its parameters, its pixels, and our rendering of the same thing.
#![allow(dead_code)] // each program uses its part

use std::path::{Path, PathBuf};

use exr::prelude::{ReadChannels, ReadLayers, read};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Picture, PixelWindow, Plane};
use trace::{Scene, SceneFile};

/// All cases through a lens or a pinhole.
pub(crate) const CASES: [&str; 9] = [
    "simple_pinhole",
    "simple_untilted",
    "simple_tilt",
    "simple_tilt_2R",
    "simple_combined",
    "simple_combined_pinhole",
    "landscape_pinhole",
    "landscape_untilted",
    "landscape_reverse",
];

/// The folder of the references, if there is one; says so if not.
pub(crate) fn folder() -> Option<PathBuf> {
    let shared = std::env::var_os("TILTSHIFT_SHARED").map(|shared| PathBuf::from(shared).join("reference"));
    if shared.is_none() {
        println!("skipped: TILTSHIFT_SHARED is not set");
    }
    shared
}

/// The triangles of a reference scene with the light and sky of its JSON.
///
/// Their renderer starts shadow rays off the surface by 8.9e-5 (1 + largest coordinate), 4 mm at 50 m: without the same
/// bias the shadows of the road's markings, 2 cm high, differ by more than the noise of `landscape_pinhole`.
pub(crate) fn scene(folder: &Path, name: &str) -> Scene {
    let scenes = folder.join("scenes");
    let json = json(&scenes.join(format!("{name}_scene.json")));
    let [x, y, z] = vector(&json["to_light"]).to_array();
    let text = format!(
        "format = 1\nsky = {sky}\nshadow_bias = 8.9e-5\n[meshes.all]\nfile = \"{name}.obj\"\n[[objects]]\nmesh = \"all\"\n[lights]\n\
         ambient = {{ ambient = {{ strength = {ambient} }} }}\n\
         sun = {{ sun = {{ toward = [{x:?}, {y:?}, {z:?}], strength = {sun} }} }}\n",
        sky = json["sky"],
        ambient = json["ambient"],
        sun = json["sun"],
    );
    SceneFile::parse(&text, scenes.join(format!("{name}.toml"))).expect("the reference scene").scene().clone()
}

/// A picture with the camera it was taken with.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) camera: Camera,
    pub(crate) picture: Picture,
    /// RMS error of the whole picture, as its file states.
    pub(crate) noise: f64,
}

impl Case {
    /// Reads `name_ref.exr` and `name.json`.
    pub(crate) fn read(folder: &Path, name: &str) -> Self {
        let json = json(&folder.join(format!("{name}.json")));
        let picture = picture(&folder.join(format!("{name}_ref.exr")));
        let noise = json["rmse_of_mean"].as_f64().expect("rmse_of_mean");
        Self { name: name.to_owned(), camera: camera(&json), picture, noise }
    }

    /// Which scene it shows.
    pub(crate) fn scene_name(&self) -> &'static str {
        if self.name.starts_with("simple") { "simple" } else { "landscape" }
    }
}

/// The camera of a JSON, whose y points down: qy, b and the y of the iris normal change their sign.
fn camera(json: &serde_json::Value) -> Camera {
    let number = |key: &str| json[key].as_f64().expect(key);
    let column = |i: usize| DVec3::from_array([0, 1, 2].map(|row| json["camera_to_world"][row][i].as_f64().unwrap()));
    let edge = |i: usize| json["window"][i].as_f64().unwrap();
    let size = |key: &str| json[key].as_u64().expect(key) as u32;
    let normal = vector(&json["lens_normal"]) * DVec3::new(1.0, -1.0, 1.0);
    let (min, max) = (DVec2::new(edge(0), -edge(3)), DVec2::new(edge(2), -edge(1)));
    Camera {
        pose: Pose::new(column(3), column(0), -column(1), column(2)).expect("a pose"),
        film: Film::new(min, max, size("width"), size("height")).expect("a film"),
        focus: Focus::new(DVec3::new(number("a"), -number("b"), number("c"))).expect("a plane of focus"),
        iris: Iris::new(normal, number("R"), ApertureShape::Disc).expect("an iris"),
    }
}

fn json(path: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("JSON")
}

fn vector(json: &serde_json::Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| json[i].as_f64().expect("a number")))
}

fn picture(path: &Path) -> Picture {
    let window = PixelWindow::of_size(640, 360);
    let [r, g, b] = ["R", "G", "B"].map(|channel| plane(path, channel, window));
    Picture::from_planes([r, g, b, Plane::filled(window, 1.0)]).expect("one size")
}

/// A channel of an EXR, which must cover `window`.
pub(crate) fn plane(path: &Path, channel: &str, window: PixelWindow) -> Plane {
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let layer = image.from_file(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).layer_data;
    let found = layer.channel_data.list.iter().find(|found| found.name == *channel).expect("the channel");
    Plane::from_values(window, found.sample_data.values_as_f32().collect()).expect("the size of the window")
}

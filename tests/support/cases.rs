//! The reference pictures of tilted lenses: their cameras, their RGB-D input and the truth.

use std::path::Path;

use compare::{GivenNoise, Masks, Reference};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, ReadOptions, read_frame, read_picture};
use serde_json::Value;

/// A case: what goes into a filter, and what should come out.
pub(crate) struct Case {
    pub(crate) frame: Frame,
    pub(crate) camera: Camera,
    pub(crate) masks: Masks,
    pub(crate) reference: Reference,
}

impl Case {
    /// Reads `NAME.json`, `NAME_ref.exr` and the RGB-D frame `RGBD.exr` of a folder.
    pub(crate) fn read(folder: &Path, name: &str, rgbd: &str) -> Self {
        let camera = camera(&json(&folder.join(format!("{name}.json"))));
        let frame = read_frame(&folder.join(format!("{rgbd}.exr")), &ReadOptions::default()).expect("an RGB-D frame");
        let frame = frame.value;
        assert_eq!(frame.layers().len(), 2, "{rgbd} holds a hidden layer");
        assert_eq!(frame.data(), frame.display.grown(56, 56), "{rgbd} holds an overscan of 56 px");

        let path = folder.join(format!("{name}_ref.exr"));
        let picture = read_picture(&path, &ReadOptions::default()).expect("a reference picture").value;
        let reference = Reference::from_picture(&picture, frame.display, GivenNoise::default()).expect("one window");
        let masks = Masks::from_frame(&frame, &camera, None).expect("a film of the frame's size");
        Self { frame, camera, masks, reference }
    }
}

/// The parameters that stand beside a picture.
pub(crate) fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A number of such a file.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The camera of a case. In its file y points down: with y up, w = (a, -b, c), the iris faces (nx, -ny, nz), and the
/// top of the window is -y0.
fn camera(case: &Value) -> Camera {
    let part = |key: &str| number(&case[key]);
    let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|i| number(&case["window"][i]));
    let [nx, ny, nz] = [0, 1, 2].map(|i| number(&case["lens_normal"][i]));
    let [width, height] = ["width", "height"].map(|key| part(key) as u32);
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::new(x0, -y1), DVec2::new(x1, -y0), width, height).expect("a window"),
        focus: Focus::new(DVec3::new(part("a"), -part("b"), part("c"))).expect("a plane of focus"),
        iris: Iris::new(DVec3::new(nx, -ny, nz), part("R"), ApertureShape::Disc).expect("an iris"),
    }
}

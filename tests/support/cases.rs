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
    /// Reads `NAME.json`, `NAME_ref.exr` and the RGB-D frame that belongs to it.
    pub(crate) fn read(folder: &Path, name: &str) -> Self {
        let rgbd = match name {
            "simple_combined" => "simple_combined_rgbd",
            _ if name.starts_with("simple") => "simple_rgbd",
            _ => "landscape_rgbd",
        };
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

impl Case {
    /// A picture that Blender's Cycles took through an untilted lens, of colour and depth without margin or hidden layer.
    ///
    /// Its edges reach 20 px, as those of the figures that other programs were measured by; the noise is given.
    pub(crate) fn of_cycles(folder: &Path, scene: &str) -> Self {
        let name = format!("{scene}_dof40px_reference_192spp");
        let said = json(&folder.join(format!("{name}.json")));
        let rgbz = folder.join(format!("{scene}_pinhole_1280x720_64spp_RGBZ.exr"));
        let frame = read_frame(&rgbz, &ReadOptions::default()).expect("colour and depth").value;

        // The focal length is given in pixels
        let half = 0.5 * DVec2::new(f64::from(frame.display.width), f64::from(frame.display.height));
        let half = half / number(&said["focal_px"]);
        let camera = Camera {
            pose: Pose::IDENTITY,
            film: Film::new(-half, half, frame.display.width, frame.display.height).expect("a window"),
            focus: Focus::at_depth(number(&said["focus_distance"])).expect("a depth"),
            iris: Iris::upright(0.5 * number(&said["aperture_diameter"]), ApertureShape::Disc).expect("a radius"),
        };
        let masks = Masks::from_frame(&frame, &camera, Some(20.0)).expect("a film of the frame's size");
        let noise = GivenNoise {
            all: Some(number(&said["noise_mse_full"])),
            edges: Some(number(&said["noise_mse_edge"])),
            interior: None,
        };
        let path = folder.join(format!("{name}.exr"));
        let picture = read_picture(&path, &ReadOptions::default()).expect("a reference picture").value;
        let reference = Reference::from_picture(&picture, frame.display, noise).expect("one window");
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

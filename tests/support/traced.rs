//! A shot of the project's scenes, traced twice: as the truth, and as the RGB-D frame that a filter starts from.

use std::path::Path;

use compare::{MaskKind, Masks, Reference};
use filter::{FrameView, Method};
use glam::DVec2;
use optics::{ApertureShape, Camera, Iris};
use rgbd::{Frame, Picture, PixelWindow, Silent};
use trace::{LayerSettings, SceneFile};

use crate::support::score::Score;

/// Size of the pictures; the shots' own windows, seen by half as many pixels across.
const SIZE: [u32; 2] = [320, 180];

/// Seeds of the truth and of the frame's colour: two pictures that share no sample.
const SEEDS: [u64; 2] = [11, 12];

/// Truth, frame and masks of a shot.
pub(crate) struct Traced {
    pub(crate) camera: Camera,
    /// Two layers, with all the margin that the lens needs.
    pub(crate) frame: Frame,
    pub(crate) masks: Masks,
    pub(crate) reference: Reference,
    /// The truth's two halves, which share no sample.
    #[allow(dead_code, reason = "only some tests need them")]
    pub(crate) halves: [Picture; 2],
}

impl Traced {
    /// Traces a shot with `samples` per pixel, its camera changed as wished.
    pub(crate) fn new(scene: &SceneFile, shot: &str, samples: u32, change: impl Fn(&Camera) -> Camera) -> Self {
        let mut camera = scene.shot(Some(shot)).expect("a shot of the scene").camera;
        let [width, height] = SIZE;
        camera.film = camera.film.resized(width, height).expect("a size in pixels");
        let camera = change(&camera);
        let display = PixelWindow::of_size(width, height);

        let [truth_seed, color_seed] = SEEDS;
        let (scene, silent) = (scene.scene(), &Silent);
        let truth = trace::truth(scene, &camera, display, samples, truth_seed, silent).expect("a truth");
        let settings = LayerSettings { seed: color_seed, ..LayerSettings::default() };
        let layered = trace::layers(scene, &camera, &settings, silent).expect("a frame");
        assert!(!layered.is_capped(), "{shot}: the margin holds all that the lens sees");
        let frame = layered.frame;
        let masks = Masks::from_frame(&frame, &camera, None).expect("a film of the frame's size");
        let reference = Reference::from_truth(&truth).expect("halves of the display window");
        Self { camera, frame, masks, reference, halves: truth.halves }
    }

    /// How near the frame, filtered with its own camera, comes to the truth.
    pub(crate) fn score(&self, method: Method) -> Score {
        self.score_of(&self.frame, &self.camera, method)
    }

    /// The same for another camera or another frame of the same view.
    pub(crate) fn score_of(&self, frame: &Frame, camera: &Camera, method: Method) -> Score {
        let filtered = filter::apply(&FrameView::whole(frame), camera, &method, frame.display, &Silent);
        let picture = filtered.expect("a frame of the camera's size").picture;
        Score::new(&self.reference, &picture, &self.masks)
    }

    /// PSNR of the truth's own noise over the whole picture, dB.
    pub(crate) fn noise_db(&self) -> f64 {
        compare::psnr_db(self.reference.noise_mse(&self.masks, MaskKind::All).expect("two halves"))
    }
}

/// A scene file of the project.
pub(crate) fn scene(name: &str) -> SceneFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes").join(format!("{name}.toml"));
    SceneFile::open(path).expect("a scene of the project")
}

/// The same camera with an iris of another shape.
pub(crate) fn with_shape(camera: &Camera, shape: ApertureShape) -> Camera {
    let iris = Iris::new(camera.iris.normal(), camera.iris.radius(), shape).expect("an iris");
    with_iris(camera, iris)
}

/// The same camera with another iris.
pub(crate) fn with_iris(camera: &Camera, iris: Iris) -> Camera {
    Camera { iris, ..*camera }
}

/// The frame with every depth mirrored about the plane of focus, 1/z' = 2 w(q) - 1/z, so that every defocus changes its
/// sign and nothing else; `None` where that would put something behind the camera.
pub(crate) fn mirrored(frame: &Frame, camera: &Camera) -> Option<Frame> {
    let mut layers = frame.clone().into_layers();
    for layer in &mut layers {
        for (x, y) in layer.window().pixels() {
            if layer.known.at(x, y) {
                let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let focus = camera.focus.inverse_depth(camera.film.q_from_pixel(center));
                let inverse = 2.0 * focus - 1.0 / f64::from(layer.depth.at(x, y));
                if inverse <= 0.0 {
                    return None;
                }
                layer.depth.set(x, y, (1.0 / inverse) as f32);
            }
        }
    }
    Some(Frame::new(frame.display, layers).expect("positive depths"))
}

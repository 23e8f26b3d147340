//! The shot that a suite is run on.

use glam::DVec2;
use optics::{Camera, Focus, ThinLens};
use trace::{Scene, Shot};

use crate::StudyError;

/// A scene, a camera before it, and the lens of that camera.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a> {
    scene: &'a Scene,
    camera: Camera,
    lens: ThinLens,
}

/// Image distance over focus distance of a camera that does not tell its own; any would do, as only tilt and swing in
/// degrees depend on it.
const GUESSED_IMAGE_DISTANCE: f64 = 0.05;

impl<'a> Stage<'a> {
    /// A shot of a scene, `width` x `height` pixels.
    ///
    /// It must have an open aperture and a plane of focus at a finite distance, as sweeps begin there.
    pub fn new(scene: &'a Scene, shot: &Shot, width: u32, height: u32) -> Result<Self, StudyError> {
        let camera = Camera { film: shot.camera.film.resized(width, height)?, ..shot.camera };
        let radius = camera.iris.radius();
        if radius == 0.0 {
            let what = "aperture radius of the shot";
            return Err(StudyError::BadSetting {
                what,
                value: radius,
                wanted: "more than 0, as there is no blur without",
            });
        }
        let distance = camera.focus.distance();
        if !distance.is_finite() {
            let (what, wanted) = ("distance of the plane of focus of the shot", "finite, as sweeps begin there");
            return Err(StudyError::BadSetting { what, value: distance, wanted });
        }
        let guess = || camera.thin_lens(camera.image_distance().unwrap_or(GUESSED_IMAGE_DISTANCE * distance));
        let lens = shot.lens.map_or_else(guess, Ok)?.with_aperture_radius(radius)?;
        Ok(Self { scene, camera, lens })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The shot's own camera.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The shot's own lens, in scene units.
    pub(super) fn lens(&self) -> &ThinLens {
        &self.lens
    }

    /// Distance of the shot's plane of focus.
    pub(super) fn focus_distance(&self) -> f64 {
        self.camera.focus.distance()
    }

    /// Pixels per unit of q.
    pub(super) fn scale(&self) -> f64 {
        self.camera.film.pixels_per_q().max_element()
    }

    /// The largest |q.x| or |q.y| of the picture.
    pub(super) fn half_extent(&self) -> DVec2 {
        self.camera.film.min().abs().max(self.camera.film.max().abs())
    }

    /// The camera with another plane of focus.
    pub(super) fn focused(&self, focus: Focus) -> Camera {
        Camera { focus, ..self.camera }
    }

    /// The camera behind another lens: same window, same opening; an iris that is tilted with the lens stays so.
    pub(super) fn with_lens(&self, lens: &ThinLens) -> Result<Camera, StudyError> {
        const TOGETHER: f64 = 1e-6; // cosine, far below any tilt that can be set
        let iris = self.camera.iris;
        let is_tilted = iris.normal().dot(self.lens.axis()) > 1.0 - TOGETHER;
        let iris = if is_tilted { lens.iris(iris.shape()).with_radius(iris.radius())? } else { iris };
        Ok(lens.camera(self.camera.pose, self.camera.film, iris)?)
    }
}

//! A walk through a bad point in small steps.

use std::borrow::Cow;

use optics::Camera;
use rgbd::Frame;
use trace::Scene;

use super::{Mode, Stage, lens_sweeps, own_sweeps, spoil};
use crate::StudyError;

/// The least number of steps that a sweep has.
const LEAST_STEPS: usize = 3;

/// A function of the place on a sweep.
pub(crate) type At<'a, T> = Box<dyn Fn(f64) -> Result<T, StudyError> + Sync + 'a>;

/// Where colour and depth come from.
pub(crate) enum Input {
    /// One frame for all steps, with what the lens at this place sees hidden.
    Fixed { widest: f64 },
    /// A frame of its own at each step: things or pixels move.
    Moving,
    /// One frame that is spoilt more and more.
    Spoilt(fn(&Frame, f64) -> Frame),
}

/// A walk through the bad point of one failure mode: scene, camera and RGB-D frame at each step.
pub struct Sweep<'a> {
    pub(crate) mode: Mode,
    pub(crate) places: Vec<f64>,
    pub(crate) scene_at: At<'a, Cow<'a, Scene>>,
    pub(crate) camera_at: At<'a, Camera>,
    pub(crate) input: Input,
    /// How many times as many samples its truth needs.
    pub(crate) samples_factor: u32,
}

impl<'a> Sweep<'a> {
    /// The sweep through a mode in `steps` pictures (3 at least; an odd number has the bad point itself among them).
    ///
    /// Lens settings, planes of focus and spoilt depth are swept on the stage; near, thin and bright things stand in small
    /// scenes of their own, as large as the stage's picture.
    pub fn new(mode: Mode, stage: &'a Stage<'a>, steps: usize) -> Result<Self, StudyError> {
        if steps < LEAST_STEPS {
            let what = "number of steps of a sweep";
            return Err(StudyError::BadSetting { what, value: steps as f64, wanted: "3 or more" });
        }
        Ok(match mode {
            Mode::FocusThroughLens => lens_sweeps::focus_through_lens(stage, steps),
            Mode::VanishingLine => lens_sweeps::vanishing_line(stage, steps),
            Mode::FocusBehindCamera => lens_sweeps::focus_behind_camera(stage, steps),
            Mode::ApertureClosing => lens_sweeps::aperture_closing(stage, steps),
            Mode::Tilt => lens_sweeps::tilt(stage, steps),
            Mode::Swing => lens_sweeps::swing(stage, steps),
            Mode::Shift => lens_sweeps::shift(stage, steps),
            Mode::FocusDistance => lens_sweeps::focus_distance(stage, steps),
            Mode::Aperture => lens_sweeps::aperture(stage, steps),
            Mode::DepthHoles => Self::spoilt(mode, stage, spoil::with_holes, linear(0.0, 0.3, steps)),
            Mode::InfiniteDepth => Self::spoilt(mode, stage, spoil::with_sky, linear(0.0, 0.1, steps)),
            Mode::DepthNoise => Self::spoilt(mode, stage, spoil::with_noise, linear(0.0, 0.05, steps)),
            Mode::QuantisedDepth => {
                Self::spoilt(mode, stage, spoil::quantised, geometric(1.0 / 4096.0, 1.0 / 32.0, steps))
            }
            Mode::SmallBlur => own_sweeps::small_blur(stage, steps)?,
            Mode::NearObject => own_sweeps::near_object(stage, steps)?,
            Mode::ThinOccluder => own_sweeps::thin_occluder(stage, steps)?,
            Mode::BrightLight => own_sweeps::bright_light(stage, steps)?,
        })
    }

    /// A sweep of the stage's lens over one frame of its scene.
    pub(crate) fn of_lens(
        mode: Mode,
        stage: &'a Stage<'a>,
        places: Vec<f64>,
        widest: f64,
        camera_at: impl Fn(f64) -> Result<Camera, StudyError> + Sync + 'a,
    ) -> Self {
        Self {
            mode,
            places,
            scene_at: Box::new(|_| Ok(Cow::Borrowed(stage.scene()))),
            camera_at: Box::new(camera_at),
            input: Input::Fixed { widest },
            samples_factor: 1,
        }
    }

    fn spoilt(mode: Mode, stage: &'a Stage<'a>, spoil: fn(&Frame, f64) -> Frame, places: Vec<f64>) -> Self {
        let camera_at = move |_: f64| Ok(*stage.camera());
        Self { input: Input::Spoilt(spoil), ..Self::of_lens(mode, stage, places, 0.0, camera_at) }
    }

    /// Which mode it leads through.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }
}

/// Places from one end to the other in equal steps.
pub(crate) fn linear(from: f64, to: f64, steps: usize) -> Vec<f64> {
    (0..steps).map(|i| from + (to - from) * i as f64 / (steps - 1) as f64).collect()
}

/// Places from one end to the other in equal factors.
pub(crate) fn geometric(from: f64, to: f64, steps: usize) -> Vec<f64> {
    linear(from.ln(), to.ln(), steps).into_iter().map(f64::exp).collect()
}

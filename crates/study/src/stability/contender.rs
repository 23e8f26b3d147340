//! Who takes part in the suite.

use filter::FrameView;
use optics::Camera;
use rgbd::{Frame, Picture, Progress};
use trace::Scene;

use crate::{Family, Rung, StudyError, hybrid};

/// What a method is given at one step.
#[derive(Debug, Clone, Copy)]
pub struct Staged<'a> {
    /// The scene, for methods that trace.
    pub scene: &'a Scene,
    /// The camera, whose film is the frame's display window.
    pub camera: &'a Camera,
    /// Colour and depth.
    pub frame: &'a Frame,
}

/// A method that makes the picture of the display window.
pub trait Contender: Sync {
    /// Its name in reports.
    fn name(&self) -> String;

    /// What it is drawn as.
    fn family(&self) -> Family;

    /// Its picture of the frame's display window.
    fn picture(&self, staged: &Staged<'_>, progress: &dyn Progress) -> Result<Picture, StudyError>;
}

impl Contender for Rung {
    fn name(&self) -> String {
        Self::name(self)
    }

    fn family(&self) -> Family {
        Self::family(self)
    }

    fn picture(&self, staged: &Staged<'_>, progress: &dyn Progress) -> Result<Picture, StudyError> {
        let Staged { scene, camera, frame } = *staged;
        match self {
            Self::Filter(method) => {
                Ok(filter::apply(&FrameView::whole(frame), camera, method, frame.display, progress)?.picture)
            }
            Self::Hybrid(settings) => Ok(hybrid(scene, camera, frame, settings, progress)?.picture),
            Self::Trace { samples } => {
                let pixels = frame.display.into();
                Ok(trace::render(scene, camera, &pixels, 0..samples.div_ceil(2), 1, progress)?.picture())
            }
        }
    }
}

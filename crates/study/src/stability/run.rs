//! A sweep taken: the truth and every method's picture at each step.

use std::sync::Arc;

use optics::Camera;
use rgbd::{Cancelled, Frame, Picture, PixelWindow, Progress, Truth};
use serde::Serialize;
use trace::{LayerSettings, Margin, Scene};

use super::figures::{Change, finite};
use super::sweep::Input;
use super::verdict::Judge;
use super::{Contender, Estimate, Mode, Staged, Sweep, SweepVerdict, TruthChange};
use crate::{Family, StudyError, step::Step};

/// How well pictures are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Quality {
    /// Samples per pixel of each truth.
    pub truth_samples: u32,
    /// Samples per pixel of the RGB-D frames' colour.
    pub frame_samples: u32,
    /// Seed of the truths, the same at every step; the frames' is one more.
    pub seed: u64,
}

impl Default for Quality {
    /// 128 samples, 64 of a frame, seed 1.
    fn default() -> Self {
        Self { truth_samples: 128, frame_samples: 64, seed: 1 }
    }
}

/// One method over a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// What it is drawn as.
    pub family: Family,
    /// Error at each step.
    pub error: Vec<Estimate>,
    /// Root mean square of the change to each step from the one before.
    pub change_rms: Vec<f64>,
    /// 99.9th percentile of that change.
    pub change_peak: Vec<f64>,
    /// How it fares.
    pub verdict: SweepVerdict,
}

/// All methods over a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepFigures {
    /// The bad point that it leads through.
    pub mode: Mode,
    /// The places that have a picture, in [`Mode::axis`]'s unit.
    pub at: Vec<f64>,
    /// Where the request has no meaning, and what was said.
    pub refused: Vec<(f64, String)>,
    /// The places that each change leads to.
    pub change_at: Vec<f64>,
    /// How much the truth changes.
    pub truth_change: Vec<TruthChange>,
    /// Error of no filter at each step.
    pub unfiltered: Vec<Estimate>,
    /// The methods.
    pub curves: Vec<Curve>,
}

impl Quality {
    /// The RGB-D frame of a view with a margin as wide as the largest blur that filters allow by default, so that it is the
    /// same at each step.
    pub(super) fn frame(&self, scene: &Scene, camera: &Camera, progress: &dyn Progress) -> Result<Frame, StudyError> {
        let margin = Margin::Pixels(camera.film.width().div_ceil(4));
        let seed = self.seed.wrapping_add(1);
        let settings = LayerSettings { margin, color_samples: self.frame_samples, seed, ..LayerSettings::default() };
        Ok(trace::layers(scene, camera, &settings, progress)?.frame)
    }

    pub(super) fn truth(
        &self,
        scene: &Scene,
        camera: &Camera,
        factor: u32,
        progress: &dyn Progress,
    ) -> Result<Truth, StudyError> {
        let display = PixelWindow::of_size(camera.film.width(), camera.film.height());
        let samples = self.truth_samples.saturating_mul(factor);
        Ok(trace::truth(scene, camera, display, samples, self.seed, progress)?)
    }
}

/// What one method has made so far.
struct Track {
    last: Option<Picture>,
    non_finite: usize,
    errors: Vec<Estimate>,
    changes: Vec<Change>,
}

/// Takes a sweep with every method.
///
/// The truth has the same seed at each step, so that its noise hardly changes; a method without picture at a step where
/// there is a truth ends the run with its error.
pub fn run_sweep(
    sweep: &Sweep,
    contenders: &[&dyn Contender],
    quality: &Quality,
    progress: &dyn Progress,
) -> Result<SweepFigures, StudyError> {
    let count = sweep.places.len();
    let mut takes = Takes { sweep, quality, frame: None, truth: None };
    let new = || Track { last: None, non_finite: 0, errors: Vec::new(), changes: Vec::new() };
    let mut tracks: Vec<Track> = contenders.iter().map(|_| new()).collect();
    let (mut at, mut change_at, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    let (mut truth_change, mut unfiltered) = (Vec::new(), Vec::new());
    let mut last_truth: Option<Truth> = None;
    for (index, &place) in sweep.places.iter().enumerate() {
        let step = Step { whole: progress, index, count };
        if progress.is_cancelled() {
            return Err(Cancelled.into());
        }
        let camera = match (sweep.camera_at)(place) {
            Ok(camera) => camera,
            Err(StudyError::Optics(error)) => {
                refused.push((place, error.to_string()));
                continue;
            }
            Err(error) => return Err(error),
        };
        let scene = (sweep.scene_at)(place)?;
        let frame = takes.frame(&scene, &camera, place, &Unheard(progress))?;
        let truth = takes.truth(&scene, &camera, &step)?;

        // How far is the truth from the step before, and from no filter?
        at.push(place);
        unfiltered.push(Estimate::new(&frame.layers()[0].color.cropped(frame.display), &truth));
        if let Some(last) = &last_truth {
            change_at.push(place);
            truth_change.push(TruthChange::between(last, &truth));
        }
        let staged = Staged { scene: &scene, camera: &camera, frame: &frame };
        for (track, contender) in tracks.iter_mut().zip(contenders) {
            let (picture, bad) = finite(contender.picture(&staged, &Unheard(progress))?);
            track.non_finite += bad;
            track.errors.push(Estimate::new(&picture, &truth));
            track.changes.extend(track.last.as_ref().map(|last| Change::between(last, &picture)));
            track.last = Some(picture);
        }
        last_truth = Some(truth);
        progress.report(index as u64 + 1, count as u64);
    }

    let judge = Judge {
        mode: sweep.mode,
        at: &at,
        change_at: &change_at,
        truth_change: &truth_change,
        unfiltered: &unfiltered,
    };
    let curves = contenders.iter().zip(tracks).map(|(contender, track)| Curve {
        name: contender.name(),
        family: contender.family(),
        verdict: judge.verdict(track.non_finite, &track.errors, &track.changes),
        error: track.errors,
        change_rms: track.changes.iter().map(|change| change.rms).collect(),
        change_peak: track.changes.iter().map(|change| change.peak).collect(),
    });
    let curves = curves.collect();
    Ok(SweepFigures { mode: sweep.mode, at, refused, change_at, truth_change, unfiltered, curves })
}

/// Frames and truths, each taken once where it stays the same.
struct Takes<'a, 's> {
    sweep: &'a Sweep<'s>,
    quality: &'a Quality,
    frame: Option<Arc<Frame>>,
    truth: Option<(Camera, Truth)>,
}

impl Takes<'_, '_> {
    fn frame(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        place: f64,
        progress: &dyn Progress,
    ) -> Result<Arc<Frame>, StudyError> {
        let widest = match self.sweep.input {
            Input::Moving => return Ok(Arc::new(self.quality.frame(scene, camera, progress)?)),
            Input::Fixed { widest } => (self.sweep.camera_at)(widest)?,
            Input::Spoilt(_) => *camera,
        };
        let frame = match &self.frame {
            Some(frame) => Arc::clone(frame),
            None => Arc::new(self.quality.frame(scene, &widest, progress)?),
        };
        self.frame = Some(Arc::clone(&frame));
        Ok(match self.sweep.input {
            Input::Spoilt(spoil) => Arc::new(spoil(&frame, place)),
            _ => frame,
        })
    }

    fn truth(&mut self, scene: &Scene, camera: &Camera, progress: &dyn Progress) -> Result<Truth, StudyError> {
        if let (Input::Spoilt(_), Some((of, truth))) = (&self.sweep.input, &self.truth)
            && of == camera
        {
            return Ok(truth.clone());
        }
        let truth = self.quality.truth(scene, camera, self.sweep.samples_factor, progress)?;
        if matches!(self.sweep.input, Input::Spoilt(_)) {
            self.truth = Some((*camera, truth.clone()));
        }
        Ok(truth)
    }
}

/// Work too short to be told; it can be stopped.
pub(super) struct Unheard<'a>(pub(super) &'a dyn Progress);

impl Progress for Unheard<'_> {
    fn report(&self, _done: u64, _total: u64) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

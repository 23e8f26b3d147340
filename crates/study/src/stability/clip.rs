//! Flicker: what a method adds to the movement of the truth from frame to frame.

use optics::Camera;
use rgbd::{Cancelled, Picture, Progress, Truth};
use serde::Serialize;

use super::figures::finite;
use super::run::Unheard;
use super::{Contender, Mode, Quality, Stage, Staged, Sweep};
use crate::{Family, StudyError, step::Step};

/// Moves of the lens over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clip {
    /// The plane of focus turns over the scene.
    Pan,
    /// Focus goes from near to far.
    Rack,
}

impl Clip {
    /// Both.
    pub const EVERY: [Self; 2] = [Self::Pan, Self::Rack];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pan => "pan of the plane of focus",
            Self::Rack => "rack focus",
        }
    }
}

/// How much one method flickers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flicker {
    /// The method's name.
    pub name: String,
    /// What it is drawn as.
    pub family: Family,
    /// RMS of the second temporal difference of (picture - truth), over that of the truth with its noise.
    pub index: f64,
}

impl Flicker {
    /// What rungs from the merged gather on may reach.
    pub const MOST: f64 = 0.5;

    /// Whether the method is one that must not flicker, and does.
    #[must_use]
    pub fn is_too_much(&self) -> bool {
        let is_bound = matches!(self.family, Family::Merged | Family::LensRays | Family::Hybrid | Family::Candidate);
        is_bound && (self.index.is_nan() || self.index > Self::MOST)
    }
}

/// All methods over one clip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flickers {
    /// What moves.
    pub clip: Clip,
    /// Number of frames.
    pub frames: usize,
    /// RMS of the truth's second temporal difference, with its noise.
    pub truth: f64,
    /// The methods.
    pub methods: Vec<Flicker>,
}

/// The last two moments of something, and the squares of its second differences.
struct Moments<T> {
    last: Vec<T>,
    sum: f64,
    count: f64,
}

impl<T> Moments<T> {
    fn new() -> Self {
        Self { last: Vec::new(), sum: 0.0, count: 0.0 }
    }

    /// Takes the next moment; `square` is the mean of the squared second difference over three.
    fn push(&mut self, next: T, square: impl Fn([&T; 3]) -> f64) {
        if let [a, b] = &self.last[..] {
            self.sum += square([a, b, &next]);
            self.count += 1.0;
            self.last.remove(0);
        }
        self.last.push(next);
    }

    fn rms(&self) -> f64 {
        (self.sum / f64::max(self.count, 1.0)).max(0.0).sqrt()
    }
}

/// Takes a clip of `frames` frames (3 at least), at rest at both ends, with every method on the stage.
///
/// The truth's own noise is dropped from the difference between picture and truth, as its two halves are independent.
pub fn run_clip(
    clip: Clip,
    stage: &Stage,
    frames: usize,
    contenders: &[&dyn Contender],
    quality: &Quality,
    progress: &dyn Progress,
) -> Result<Flickers, StudyError> {
    let mode = match clip {
        Clip::Pan => Mode::Tilt,
        Clip::Rack => Mode::FocusDistance,
    };
    let sweep = Sweep::new(mode, stage, frames)?;
    let (first, last) = (sweep.places[0], sweep.places[frames - 1]);
    let camera_at = |index: usize| -> Result<Camera, StudyError> {
        let t = index as f64 / (frames - 1) as f64;
        (sweep.camera_at)(first + (last - first) * t * t * (3.0 - 2.0 * t))
    };
    let scene = stage.scene();
    let frame = quality.frame(scene, &camera_at(0)?, &Unheard(progress))?;
    let mut truths = Moments::new();
    let mut tracks: Vec<Moments<[Picture; 2]>> = contenders.iter().map(|_| Moments::new()).collect();
    for index in 0..frames {
        if progress.is_cancelled() {
            return Err(Cancelled.into());
        }
        let camera = camera_at(index)?;
        let step = Step { whole: progress, index, count: frames };
        let truth = quality.truth(scene, &camera, 1, &step)?;
        truths.push(truth.picture(), |pictures| product(pictures, pictures));
        let staged = Staged { scene, camera: &camera, frame: &frame };
        for (track, contender) in tracks.iter_mut().zip(contenders) {
            let (picture, _) = finite(contender.picture(&staged, &Unheard(progress))?);
            track.push(beside(&picture, &truth), |[x, y, z]| product([&x[0], &y[0], &z[0]], [&x[1], &y[1], &z[1]]));
        }
    }
    let truth = truths.rms();
    let methods = contenders.iter().zip(&tracks).map(|(contender, track)| Flicker {
        name: contender.name(),
        family: contender.family(),
        index: track.rms() / truth.max(f64::MIN_POSITIVE),
    });
    Ok(Flickers { clip, frames, truth, methods: methods.collect() })
}

/// What a picture differs by from each half of the truth.
fn beside(picture: &Picture, truth: &Truth) -> [Picture; 2] {
    [0, 1].map(|half: usize| {
        Picture::from_fn(truth.display, |x, y| {
            let (p, t) = (picture.at(x, y), truth.halves[half].at(x, y));
            [0, 1, 2, 3].map(|c| p[c] - t[c])
        })
    })
}

/// Mean over pixels, R, G and B of the product of two second temporal differences.
fn product(a: [&Picture; 3], b: [&Picture; 3]) -> f64 {
    let second = |pictures: [&Picture; 3], x: i32, y: i32| {
        let [before, here, after] = pictures.map(|picture| picture.at(x, y));
        [0, 1, 2].map(|c| f64::from(before[c]) - 2.0 * f64::from(here[c]) + f64::from(after[c]))
    };
    let window = a[0].window();
    let sum: f64 = window
        .pixels()
        .map(|(x, y)| {
            let (a, b) = (second(a, x, y), second(b, x, y));
            (0..3).map(|c| a[c] * b[c]).sum::<f64>()
        })
        .sum();
    sum / (3.0 * window.area().max(1) as f64)
}

//! What doubtful depth costs: the error of each method where depth is noisy, coarse or beside its colour.

use rgbd::{Cancelled, Frame, Progress};
use serde::Serialize;

use super::figures::finite;
use super::run::Unheard;
use super::{Contender, Estimate, Quality, Stage, Staged, spoil};
use crate::{Family, StudyError, step::Step};

/// How depth is spoilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spoilt {
    /// Not at all.
    Clean,
    /// Noise of 0.1 % of the depth.
    NoiseTenthPercent,
    /// Noise of 1 %.
    NoiseOnePercent,
    /// Noise of 5 %.
    NoiseFivePercent,
    /// Half floats.
    Half,
    /// 256 levels of inverse depth.
    EightBits,
    /// The depth of the pixel to the left.
    FromLeft,
    /// The depth of the pixel to the right.
    FromRight,
    /// The depth of the pixel above.
    FromAbove,
    /// The depth of the pixel below.
    FromBelow,
}

impl Spoilt {
    /// All of them, clean depth first.
    pub const EVERY: [Self; 10] = [
        Self::Clean,
        Self::NoiseTenthPercent,
        Self::NoiseOnePercent,
        Self::NoiseFivePercent,
        Self::Half,
        Self::EightBits,
        Self::FromLeft,
        Self::FromRight,
        Self::FromAbove,
        Self::FromBelow,
    ];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::NoiseTenthPercent => "noise 0.1 %",
            Self::NoiseOnePercent => "noise 1 %",
            Self::NoiseFivePercent => "noise 5 %",
            Self::Half => "half",
            Self::EightBits => "8 bits",
            Self::FromLeft => "left 1 px",
            Self::FromRight => "right 1 px",
            Self::FromAbove => "up 1 px",
            Self::FromBelow => "down 1 px",
        }
    }

    fn of(self, frame: &Frame) -> Frame {
        match self {
            Self::Clean => frame.clone(),
            Self::NoiseTenthPercent => spoil::with_noise(frame, 0.001),
            Self::NoiseOnePercent => spoil::with_noise(frame, 0.01),
            Self::NoiseFivePercent => spoil::with_noise(frame, 0.05),
            Self::Half => spoil::as_half(frame),
            Self::EightBits => spoil::quantised(frame, 1.0 / 255.0),
            Self::FromLeft => spoil::moved(frame, (-1, 0)),
            Self::FromRight => spoil::moved(frame, (1, 0)),
            Self::FromAbove => spoil::moved(frame, (0, -1)),
            Self::FromBelow => spoil::moved(frame, (0, 1)),
        }
    }
}

/// One method's errors, one for each of [`Spoilt::EVERY`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Its name.
    pub name: String,
    /// What it is drawn as.
    pub family: Family,
    /// Error of each.
    pub error: Vec<Estimate>,
}

impl Sensitivity {
    /// How many times as large as with clean depth the error gets.
    #[must_use]
    pub fn growth(&self, spoilt: Spoilt) -> f64 {
        let at = |wanted: Spoilt| {
            let index = Spoilt::EVERY.iter().position(|&spoilt| spoilt == wanted);
            index.map_or(f64::NAN, |index| self.error[index].rmse())
        };
        at(spoilt) / at(Spoilt::Clean)
    }
}

/// Takes the stage's own shot with every method, from clean depth and from all that is spoilt.
pub fn run_sensitivity(
    stage: &Stage,
    contenders: &[&dyn Contender],
    quality: &Quality,
    progress: &dyn Progress,
) -> Result<Vec<Sensitivity>, StudyError> {
    let (scene, camera) = (stage.scene(), stage.camera());
    let count = Spoilt::EVERY.len() + 1;
    let truth = quality.truth(scene, camera, 1, &Step { whole: progress, index: 0, count })?;
    let frame = quality.frame(scene, camera, &Unheard(progress))?;
    let new = |contender: &&dyn Contender| Sensitivity {
        name: contender.name(),
        family: contender.family(),
        error: Vec::new(),
    };
    let mut methods: Vec<Sensitivity> = contenders.iter().map(new).collect();
    for (index, spoilt) in Spoilt::EVERY.into_iter().enumerate() {
        if progress.is_cancelled() {
            return Err(Cancelled.into());
        }
        let frame = spoilt.of(&frame);
        let staged = Staged { scene, camera, frame: &frame };
        for (method, contender) in methods.iter_mut().zip(contenders) {
            let (picture, _) = finite(contender.picture(&staged, &Unheard(progress))?);
            method.error.push(Estimate::new(&picture, &truth));
        }
        progress.report(index as u64 + 2, count as u64);
    }
    Ok(methods)
}

//! How near a picture comes to a reference, in dB, within each mask.

use compare::{Comparison, CorrectedError, MaskKind, Masks, Reference, psnr_db};
use rgbd::Picture;

/// What is scored.
const MASKS: [MaskKind; 3] = [MaskKind::All, MaskKind::Edges, MaskKind::Interior];

/// PSNR (linear values, peak 1) over all pixels, near edges, and in the interior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score(pub(crate) [f64; 3]);

impl Score {
    /// The figures without the reference's noise where that is known; below it, what they very probably exceed.
    pub(crate) fn new(reference: &Reference, picture: &Picture, masks: &Masks) -> Self {
        let comparison = Comparison::new(reference, picture, masks).expect("pictures of one window");
        assert_eq!(comparison.non_finite, 0, "every value of a picture is a number");
        Self(MASKS.map(|mask| {
            let figures = comparison.within(mask).expect("a mask with pixels in it");
            match figures.corrected {
                CorrectedError::Above { mse, .. } => psnr_db(mse),
                CorrectedError::BelowNoise { at_most } => psnr_db(at_most),
                CorrectedError::UnknownNoise => psnr_db(figures.mse),
            }
        }))
    }

    /// Over all pixels.
    pub(crate) fn all(&self) -> f64 {
        self.0[0]
    }

    /// Near edges.
    pub(crate) fn edges(&self) -> f64 {
        self.0[1]
    }

    /// What is missing to reach `floor` in each mask, said in words; empty where nothing is.
    pub(crate) fn shortfalls(&self, what: &str, floor: Self) -> Vec<String> {
        let masks = MASKS.into_iter().zip(self.0.into_iter().zip(floor.0));
        // A figure that is no number reaches nothing
        let short = masks.filter(|(_, (found, floor))| found.is_nan() || found < floor);
        short.map(|(mask, (found, floor))| format!("{what}, {}: {found:.2} < {floor:.2} dB", mask.name())).collect()
    }
}

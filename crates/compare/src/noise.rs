//! Errors without the noise of the reference in them.
//!
//! A candidate C is measured against a reference that is itself noisy. With two independent halves A and B of the
//! reference the noise drops out of the *cross product*: E[(C - A)(C - B)] = (C - truth)^2, whatever the noise.
//! Where only the reference's mean square noise is known, it is subtracted.

use serde::Serialize;

/// How far above 0 a corrected error must be, in its own standard errors, to count as seen. A perfect candidate
/// passes for wrong in 0.13 % of all cases.
pub(crate) const STANDARD_ERRORS: f64 = 3.0;

/// How well a noise that was given as one number is known. Two estimates of the noise of one 192-sample reference,
/// from three and from two renders, differ by 12 %.
const GIVEN_NOISE_UNCERTAINTY: f64 = 0.15;

/// A mean square error with the reference's noise taken off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum CorrectedError {
    /// The error can be told from the noise.
    Above {
        /// Mean square error against the noise-free truth.
        mse: f64,
        /// Its standard error.
        uncertainty: f64,
    },
    /// The error cannot be told from the noise of the reference.
    BelowNoise {
        /// The mean square error is very probably not above this.
        at_most: f64,
    },
    /// The noise of the reference is not known; the plain error holds it.
    UnknownNoise,
}

impl CorrectedError {
    /// The verdict on an estimate that scatters by `uncertainty`.
    pub(crate) fn from_estimate(mse: f64, uncertainty: f64) -> Self {
        if mse > STANDARD_ERRORS * uncertainty {
            Self::Above { mse, uncertainty }
        } else if mse == 0.0 && uncertainty == 0.0 {
            // Nothing differs and nothing is noisy: the error is 0, and known
            Self::Above { mse, uncertainty }
        } else {
            Self::BelowNoise { at_most: mse.max(0.0) + STANDARD_ERRORS * uncertainty }
        }
    }

    /// The plain error `mse` over `pixels` pixels with a given mean square noise taken off.
    pub(crate) fn from_given_noise(mse: f64, noise_mse: f64, pixels: usize) -> Self {
        // Noise spread evenly scatters its own mean square by sqrt(2 / n)
        let scatter = (2.0 / pixels.max(1) as f64).sqrt().max(GIVEN_NOISE_UNCERTAINTY / STANDARD_ERRORS);
        Self::from_estimate(mse - noise_mse, noise_mse * scatter)
    }

    /// Peak signal-to-noise ratio in dB for a peak of 1; `None` below the noise, for unknown noise, and for no error.
    #[must_use]
    pub fn psnr_db(&self) -> Option<f64> {
        match *self {
            Self::Above { mse, .. } if mse > 0.0 => Some(psnr_db(mse)),
            _ => None,
        }
    }
}

/// Peak signal-to-noise ratio in dB for a peak of 1; +inf for an error of 0.
#[must_use]
pub fn psnr_db(mse: f64) -> f64 {
    -10.0 * mse.log10()
}

/// The mean square noise of a reference that is given by figures, per mask; `None` where it is not known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct GivenNoise {
    /// Of the whole display window.
    pub all: Option<f64>,
    /// Of its edges.
    pub edges: Option<f64>,
    /// Of its interior.
    pub interior: Option<f64>,
}

impl GivenNoise {
    /// The noise of a mask; the third figure follows from two, as `all` is their mean weighted by `edge_share`.
    pub(crate) fn of(&self, mask: crate::MaskKind, edge_share: f64) -> Option<f64> {
        use crate::MaskKind;
        let rest = 1.0 - edge_share;
        match mask {
            MaskKind::All => self.all.or_else(|| Some(edge_share * self.edges? + rest * self.interior?)),
            MaskKind::Edges => self.edges.or_else(|| {
                let edges = (self.all? - rest * self.interior?) / edge_share;
                (edges >= 0.0 && edges.is_finite()).then_some(edges)
            }),
            MaskKind::Interior => self.interior.or_else(|| {
                let interior = (self.all? - edge_share * self.edges.unwrap_or(0.0)) / rest;
                let is_known = self.edges.is_some() || edge_share == 0.0;
                (is_known && interior >= 0.0 && interior.is_finite()).then_some(interior)
            }),
            MaskKind::Near | MaskKind::InFocus | MaskKind::Far | MaskKind::Highlights => None,
        }
    }
}

//! Figures that a picture must reach.

use std::str::FromStr;

use ::compare::{CorrectedError, Figures, psnr_db};
use anyhow::{anyhow, bail};

use crate::values::finite;

/// What is limited; errors with the reference's noise taken off where there are such.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Metric {
    Rmse,
    Psnr,
    Mae,
    RelMse,
    Ssim,
    Flip,
    HdrFlip,
}

impl Metric {
    const NAMES: [(&'static str, Self); 7] = [
        ("rmse", Self::Rmse),
        ("psnr", Self::Psnr),
        ("mae", Self::Mae),
        ("relmse", Self::RelMse),
        ("ssim", Self::Ssim),
        ("flip", Self::Flip),
        ("hdr-flip", Self::HdrFlip),
    ];

    /// Whether more of it is better.
    fn is_quality(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim)
    }

    fn of(self, figures: &Figures) -> f64 {
        let mse = match figures.corrected {
            CorrectedError::Above { mse, .. } => mse,
            CorrectedError::BelowNoise { .. } => 0.0,
            CorrectedError::UnknownNoise => figures.mse,
        };
        match self {
            Self::Rmse => mse.sqrt(),
            Self::Psnr => psnr_db(mse),
            Self::Mae => figures.mae,
            Self::RelMse => figures.rel_mse,
            Self::Ssim => figures.ssim,
            Self::Flip => figures.flip_ldr,
            Self::HdrFlip => figures.flip_hdr,
        }
    }

    /// A value of it in words.
    fn text(self, value: f64) -> String {
        match self {
            Self::Psnr => format!("PSNR {value:.2} dB"),
            Self::Rmse => format!("RMSE {value:.6}"),
            Self::Mae => format!("MAE {value:.6}"),
            Self::RelMse => format!("relMSE {value:.6}"),
            Self::Ssim => format!("SSIM {value:.5}"),
            Self::Flip => format!("FLIP {value:.5}"),
            Self::HdrFlip => format!("HDR-FLIP {value:.5}"),
        }
    }
}

/// The worst that a figure may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limit {
    pub(super) metric: Metric,
    pub(super) value: f64,
}

impl Limit {
    /// What is wrong with figures that are worse; `None` for others.
    pub(super) fn exceeded(&self, figures: &Figures) -> Option<String> {
        let Self { metric, value } = *self;
        let found = metric.of(figures);
        let unit = if metric == Metric::Psnr { " dB" } else { "" };
        let found_text = metric.text(found);
        if metric.is_quality() {
            (found < value).then(|| format!("{found_text} is below {value}{unit}"))
        } else {
            (found > value).then(|| format!("{found_text} is above {value}{unit}"))
        }
    }
}

impl FromStr for Limit {
    type Err = anyhow::Error;

    /// `METRIC=VALUE`, with or without dB after a PSNR.
    fn from_str(text: &str) -> anyhow::Result<Self> {
        let names = || Metric::NAMES.map(|(name, _)| name).join(", ");
        let (name, value) =
            text.split_once('=').ok_or_else(|| anyhow!("METRIC=VALUE please, with one of {}", names()))?;
        let (name, value) = (name.trim().to_ascii_lowercase(), value.trim());
        let Some((_, metric)) = Metric::NAMES.into_iter().find(|(known, _)| *known == name) else {
            bail!("{name:?} is no figure; there are {}", names());
        };
        let value = if metric == Metric::Psnr { value.strip_suffix("dB").unwrap_or(value).trim_end() } else { value };
        Ok(Self { metric, value: finite(value)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_a_metric_and_a_number() {
        let limit = |text: &str| text.parse::<Limit>().unwrap();
        assert_eq!(limit("flip=0.05"), Limit { metric: Metric::Flip, value: 0.05 });
        assert_eq!(limit(" PSNR = 35 dB"), Limit { metric: Metric::Psnr, value: 35.0 });
        assert_eq!(limit("hdr-flip=1e-2").value, 0.01);
        for text in ["", "flip", "flip=", "flop=1", "rmse=1dB", "ssim=nan"] {
            assert!(text.parse::<Limit>().is_err(), "{text}");
        }
    }
}

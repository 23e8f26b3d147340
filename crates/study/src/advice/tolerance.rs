//! How wrong a picture may be.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::ExpectedError;

/// How wrong a picture may be, over the whole display window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "figure", content = "value", rename_all = "kebab-case")]
pub enum Tolerance {
    /// The least peak signal-to-noise ratio in dB of linear values, peak 1.
    Psnr(f64),
    /// The largest root mean square error over R, G and B, linear values.
    Rmse(f64),
    /// The largest mean HDR-FLIP, 0 to 1.
    HdrFlip(f64),
}

impl Tolerance {
    /// How far an error exhausts it: 1 where it is just met, more where it is exceeded. A ratio of root mean square errors,
    /// or of mean FLIP.
    #[must_use]
    pub fn used_by(&self, error: &ExpectedError) -> f64 {
        match *self {
            Self::Psnr(db) => error.rmse / 10_f64.powf(-db / 20.0),
            Self::Rmse(most) => error.rmse / most,
            Self::HdrFlip(most) => error.hdr_flip.unwrap_or(f64::INFINITY) / most,
        }
    }

    /// Whether it is about HDR-FLIP, which takes time to tell.
    #[must_use]
    pub fn needs_flip(&self) -> bool {
        matches!(self, Self::HdrFlip(_))
    }

    /// An error in its own figure.
    #[must_use]
    pub fn text_of(&self, error: &ExpectedError) -> String {
        match self {
            Self::Psnr(_) => format!("PSNR {:.1} dB", compare::psnr_db(error.rmse * error.rmse)),
            Self::Rmse(_) => format!("RMSE {:.5}", error.rmse),
            Self::HdrFlip(_) => match error.hdr_flip {
                Some(flip) => format!("HDR-FLIP {flip:.4}"),
                None => "HDR-FLIP unknown".to_owned(),
            },
        }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Psnr(db) => write!(f, "PSNR {db} dB"),
            Self::Rmse(most) => write!(f, "RMSE {most}"),
            Self::HdrFlip(most) => write!(f, "HDR-FLIP {most}"),
        }
    }
}

impl FromStr for Tolerance {
    type Err = String;

    /// `psnr=40dB` (dB or not), `rmse=0.01` or `hdr-flip=0.02`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "psnr=DB, rmse=VALUE or hdr-flip=VALUE, please";
        let (name, value) = text.split_once('=').ok_or(wanted)?;
        let value = value.trim();
        let number = |text: &str| text.trim_end().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or(wanted);
        match name.trim().to_ascii_lowercase().as_str() {
            "psnr" => Ok(Self::Psnr(number(value.strip_suffix("dB").unwrap_or(value))?)),
            "rmse" => positive(number(value)?).map(Self::Rmse),
            "hdr-flip" => positive(number(value)?).map(Self::HdrFlip),
            _ => Err(wanted.to_owned()),
        }
    }
}

fn positive(value: f64) -> Result<f64, String> {
    if value > 0.0 { Ok(value) } else { Err(format!("{value} is no tolerance; it must be positive")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_is_a_figure_and_a_number() {
        assert_eq!("psnr=40dB".parse(), Ok(Tolerance::Psnr(40.0)));
        assert_eq!(" PSNR = 35.5 dB".parse(), Ok(Tolerance::Psnr(35.5)));
        assert_eq!("rmse=0.01".parse(), Ok(Tolerance::Rmse(0.01)));
        assert_eq!("hdr-flip=2e-2".parse(), Ok(Tolerance::HdrFlip(0.02)));
        for text in ["", "40", "psnr", "psnr=", "flip=0.1", "rmse=0", "hdr-flip=-1", "rmse=nan", "psnr=inf"] {
            assert!(text.parse::<Tolerance>().is_err(), "{text}");
        }
    }

    #[test]
    fn an_error_uses_up_a_tolerance_in_proportion() {
        const ROUNDING: f64 = 1e-12;
        let error = ExpectedError { rmse: 0.02, hdr_flip: Some(0.03) };
        assert!((Tolerance::Psnr(40.0).used_by(&error) - 2.0).abs() < ROUNDING, "40 dB are 0.01");
        assert!((Tolerance::Rmse(0.04).used_by(&error) - 0.5).abs() < ROUNDING);
        assert!((Tolerance::HdrFlip(0.03).used_by(&error) - 1.0).abs() < ROUNDING);
        let unknown = ExpectedError { hdr_flip: None, ..error };
        assert!(Tolerance::HdrFlip(0.03).used_by(&unknown) > 1.0, "what is not known is not met");
    }
}

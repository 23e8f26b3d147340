//! What a rung would cost and how wrong its picture would be.

use optics::KernelModel;
use serde::Serialize;

use crate::Rung;

/// How wrong a picture is expected to be, over the whole display window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedError {
    /// Root mean square error over R, G and B, linear values.
    pub rmse: f64,
    /// Mean HDR-FLIP, 0 to 1; `None` where nobody asked for it.
    pub hdr_flip: Option<f64>,
}

/// How far a forecast error that was held against a trace may be off: relative standard errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Doubt {
    /// Of the root mean square error.
    pub rmse: f64,
    /// Of HDR-FLIP.
    pub hdr_flip: f64,
}

/// What a rung would cost here, and how wrong its picture would be.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// The rung.
    pub rung: Rung,
    /// Seconds of the filter or the tracer alone, on this machine as it is now.
    pub seconds: f64,
    /// The error to expect: as likely too large as too small.
    pub error: ExpectedError,
    /// How far that may be off; `None` where the filter's own prediction is all there is.
    pub doubt: Option<Doubt>,
    /// The footprint that the filter takes; `None` for the tracer.
    pub kernel: Option<KernelModel>,
}

//! Model no more than needed: the simplest footprint whose predicted error is small enough.

use std::fmt;

use glam::DVec2;

use crate::{Camera, DepthRange, Film, Footprint, Reading};

/// How a footprint is modelled, from cheapest to truest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum KernelModel {
    /// The iris as if it stood parallel to the sensor.
    Disc,
    /// The foreshortened iris.
    Ellipse,
    /// Eq. (5) with its denominator.
    Exact,
}

/// The model that was chosen for a camera, and the predicted errors that decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelChoice {
    /// The simplest model that will do.
    pub model: KernelModel,
    /// Worst predicted departure of the disc from the exact footprint over the window, pixels.
    pub disc_error_px: f64,
    /// Worst predicted departure of the ellipse from the exact footprint over the window, pixels.
    pub ellipse_error_px: f64,
    /// What was tolerated, pixels.
    pub tolerance_px: f64,
}

impl KernelModel {
    /// The tolerance unless another is asked for, pixels.
    pub const DEFAULT_TOLERANCE_PX: f64 = 0.25;

    /// The simplest model whose predicted error is at most `tolerance_px` for every pixel of the camera's window and
    /// every depth of the range.
    ///
    /// Errors are predicted on a grid of 33 x 33 pixels, corners included, to within about 0.1 %.
    #[must_use]
    pub fn choose(camera: &Camera, reading: Reading, depths: &DepthRange, tolerance_px: f64) -> KernelChoice {
        let (mut disc_error_px, mut ellipse_error_px) = (0.0f64, 0.0f64);
        for q in grid(&camera.film) {
            for inverse_depth in depths.inverse() {
                let footprint = Footprint::new(camera, reading, q, inverse_depth).in_pixels(&camera.film);
                let skew = footprint.skew();
                ellipse_error_px = ellipse_error_px.max(skew);
                disc_error_px = disc_error_px.max(skew + footprint.foreshortening());
            }
        }
        let model = if disc_error_px <= tolerance_px {
            Self::Disc
        } else if ellipse_error_px <= tolerance_px {
            Self::Ellipse
        } else {
            Self::Exact
        };
        KernelChoice { model, disc_error_px, ellipse_error_px, tolerance_px }
    }
}

impl fmt::Display for KernelModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Disc => "disc",
            Self::Ellipse => "ellipse",
            Self::Exact => "exact",
        })
    }
}

impl fmt::Display for KernelChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, disc_error_px: disc, ellipse_error_px: ellipse, tolerance_px: tolerance } = self;
        match model {
            KernelModel::Disc => {
                write!(f, "disc kernel: its predicted error, {disc:.3} px, is within the tolerance of {tolerance} px")
            }
            KernelModel::Ellipse => write!(
                f,
                "ellipse kernel: a disc would be off by {disc:.3} px, more than the tolerance of {tolerance} px; the \
                 ellipse is off by {ellipse:.3} px"
            ),
            KernelModel::Exact => write!(
                f,
                "exact kernel: a disc would be off by {disc:.3} px and an ellipse by {ellipse:.3} px, more than the \
                 tolerance of {tolerance} px"
            ),
        }
    }
}

/// 33 x 33 pixel directions over the window, its borders included.
pub(crate) fn grid(film: &Film) -> impl Iterator<Item = DVec2> + use<> {
    const STEPS: u32 = 32;
    let (min, size) = (film.min(), film.max() - film.min());
    (0..=STEPS).flat_map(move |y| {
        (0..=STEPS).map(move |x| min + size * DVec2::new(f64::from(x), f64::from(y)) / f64::from(STEPS))
    })
}

//! The ways in which a method may fail, each with what it may do there.

use serde::Serialize;

/// A bad point that a sweep leads through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// The plane of focus passes through the lens centre.
    FocusThroughLens,
    /// The vanishing line w(q) = 0 of the plane of focus crosses the picture: focus at infinity there, behind the camera
    /// beyond.
    VanishingLine,
    /// Focus goes to infinity and on, behind the camera.
    FocusBehindCamera,
    /// The blur radius crosses 0, 0.5 and 1 pixel on both sides of the plane of focus.
    SmallBlur,
    /// The aperture closes to a pinhole.
    ApertureClosing,
    /// A ball comes between lens and focus and nearer than the focal length.
    NearObject,
    /// Pixels lose their depth: 0, negative and NaN.
    DepthHoles,
    /// Pixels get an infinite depth, which is a value: such a pixel is told to be sky.
    InfiniteDepth,
    /// A pole one pixel wide, out of focus, crosses pixels.
    ThinOccluder,
    /// A light of one pixel, 10,000 times as bright as the mean, passes through focus.
    BrightLight,
    /// Depth gets noisy.
    DepthNoise,
    /// Depth is quantised to fewer and fewer levels.
    QuantisedDepth,
    /// The lens tilts.
    Tilt,
    /// The lens swings.
    Swing,
    /// The lens shifts: texture and silhouettes cross pixels.
    Shift,
    /// The lens is focused from near to far.
    FocusDistance,
    /// The aperture opens.
    Aperture,
}

/// How much a picture may change from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "against")]
pub enum Steadiness {
    /// `k` times what the truth changes by in the same step, plus the truth's noise.
    Truth {
        /// The factor.
        k: f64,
    },
    /// `k` times the root mean square over the sweep of the method's own changes: where what comes in gets worse step by
    /// step, the truth stands still and the picture may go on changing, but no step may stand out.
    OwnMean {
        /// The factor.
        k: f64,
    },
}

impl Mode {
    /// All of them.
    pub const EVERY: [Self; 17] = [
        Self::FocusThroughLens,
        Self::VanishingLine,
        Self::FocusBehindCamera,
        Self::SmallBlur,
        Self::ApertureClosing,
        Self::NearObject,
        Self::DepthHoles,
        Self::InfiniteDepth,
        Self::ThinOccluder,
        Self::BrightLight,
        Self::DepthNoise,
        Self::QuantisedDepth,
        Self::Tilt,
        Self::Swing,
        Self::Shift,
        Self::FocusDistance,
        Self::Aperture,
    ];

    /// A change (linear values, RMS over R, G and B) that nobody sees: a tenth of a step of an 8-bit display.
    pub const UNSEEN: f64 = 0.1 / 255.0;

    /// How much a method's error may exceed that of no filter.
    pub const WORSE_THAN_UNFILTERED: f64 = 1.1;

    /// Its name on the command line and in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FocusThroughLens => "focus-through-lens",
            Self::VanishingLine => "vanishing-line",
            Self::FocusBehindCamera => "focus-behind-camera",
            Self::SmallBlur => "small-blur",
            Self::ApertureClosing => "aperture-closing",
            Self::NearObject => "near-object",
            Self::DepthHoles => "depth-holes",
            Self::InfiniteDepth => "infinite-depth",
            Self::ThinOccluder => "thin-occluder",
            Self::BrightLight => "bright-light",
            Self::DepthNoise => "depth-noise",
            Self::QuantisedDepth => "quantised-depth",
            Self::Tilt => "tilt",
            Self::Swing => "swing",
            Self::Shift => "shift",
            Self::FocusDistance => "focus-distance",
            Self::Aperture => "aperture",
        }
    }

    /// What is swept, with its unit.
    #[must_use]
    pub fn axis(self) -> &'static str {
        match self {
            Self::FocusThroughLens => "distance of the plane of focus, relative",
            Self::VanishingLine => "height of the vanishing line, half pictures",
            Self::FocusBehindCamera => "inverse depth of focus, relative",
            Self::SmallBlur => "blur radius of the wall, px",
            Self::ApertureClosing | Self::Aperture => "aperture, of the shot's",
            Self::NearObject => "depth of the ball, focal lengths",
            Self::DepthHoles => "share of pixels without depth",
            Self::InfiniteDepth => "share of pixels at infinity",
            Self::ThinOccluder => "place of the pole, px",
            Self::BrightLight => "blur radius of the light, px",
            Self::DepthNoise => "noise of the depth, of it",
            Self::QuantisedDepth => "step of inverse depth, of its range",
            Self::Tilt => "tilt beside the shot's, degrees",
            Self::Swing => "swing beside the shot's, degrees",
            Self::Shift => "shift, px",
            Self::FocusDistance => "focus, of the shot's distance",
        }
    }

    /// How much a picture may change from step to step there.
    #[must_use]
    pub fn steadiness(self) -> Steadiness {
        match self {
            // The truth knows nothing of bad depth
            Self::DepthHoles | Self::InfiniteDepth | Self::DepthNoise | Self::QuantisedDepth => {
                Steadiness::OwnMean { k: 4.0 }
            }
            // Depth is one sample of a pixel: the pole, which the truth moves by a 21st of a pixel, moves by a whole one in
            // the frame, if only in some rows at a step
            Self::ThinOccluder => Steadiness::Truth { k: 4.0 },
            // The frame knows of the round light that it is a square pixel, and the few pixels of a small disc get their
            // light by radius and not by area
            Self::BrightLight => Steadiness::Truth { k: 4.0 },
            _ => Steadiness::Truth { k: 2.0 },
        }
    }
}

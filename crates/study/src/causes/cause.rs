//! The named causes of a filter's error.

use serde::Serialize;

/// Why a filtered picture is wrong; in the order in which the chain of experiments switches them off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The lens sees more than the frame's margin holds.
    Border,
    /// Colour of too few samples; with lamps in the scene, undersampled highlights.
    SampledColor,
    /// Partial occlusion: what lies right behind the first surface is guessed.
    SecondLayer,
    /// Partial occlusion: what lies behind that is missing.
    FurtherLayers,
    /// Anti-aliased colour of two surfaces over the depth of one, at silhouettes.
    MixedColor,
    /// Discs of about a pixel, discretised: one colour a pixel cannot say where in it an edge runs.
    SmallDiscs,
    /// Disc in place of the tilted ellipse, or of the exact footprint.
    KernelShape,
    /// Occlusion by weights instead of lens point by lens point: blurred background leaks, neighbours merge.
    Leakage,
}

impl Cause {
    /// All of them, in the order of the chain.
    pub const EVERY: [Self; 8] = [
        Self::Border,
        Self::SampledColor,
        Self::SecondLayer,
        Self::FurtherLayers,
        Self::MixedColor,
        Self::SmallDiscs,
        Self::KernelShape,
        Self::Leakage,
    ];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Border => "frame border",
            Self::SampledColor => "undersampled colour",
            Self::SecondLayer => "hidden background",
            Self::FurtherLayers => "further hidden layers",
            Self::MixedColor => "mixed colour at silhouettes",
            Self::SmallDiscs => "small discs",
            Self::KernelShape => "kernel shape",
            Self::Leakage => "leakage",
        }
    }

    /// The experiment that switches it off.
    #[must_use]
    pub fn experiment(self) -> &'static str {
        match self {
            Self::Border => "all the margin that the lens sees",
            Self::SampledColor => "four times the colour samples",
            Self::SecondLayer => "the surface behind the first one, traced",
            Self::FurtherLayers => "all surfaces behind that, traced",
            Self::MixedColor => "filtered in finer pixels and averaged, where a silhouette is in reach",
            Self::SmallDiscs => "filtered in finer pixels and averaged, elsewhere",
            Self::KernelShape => "the exact footprint",
            Self::Leakage => "lens rays instead of the gather",
        }
    }

    /// Its colour on maps: sRGB.
    #[must_use]
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Border => [86, 180, 233],
            Self::SampledColor => [240, 228, 66],
            Self::SecondLayer => [213, 94, 0],
            Self::FurtherLayers => [240, 170, 40],
            Self::MixedColor => [214, 112, 176],
            Self::SmallDiscs => [0, 158, 115],
            Self::KernelShape => [40, 100, 200],
            Self::Leakage => [143, 95, 232],
        }
    }
}

/// All causes but these stand in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(crate) struct SwitchedOff(u16);

impl SwitchedOff {
    /// With one more switched off.
    pub(crate) fn with(self, cause: Cause) -> Self {
        Self(self.0 | 1 << cause as u16)
    }

    pub(crate) fn has(self, cause: Cause) -> bool {
        self.0 & (1 << cause as u16) != 0
    }
}

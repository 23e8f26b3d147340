//! Settings of the gathering methods.

use crate::KernelRule;

/// Settings of [`Method::Gather`](crate::Method::Gather) and [`Method::Merged`](crate::Method::Merged).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GatherSettings {
    /// Shape of the footprint.
    pub kernel: KernelRule,
    /// Largest radius (of the wider axis) of the circle of confusion in pixels; larger ones are cut to it. `None`: a quarter
    /// of the display window's width.
    pub max_radius_px: Option<f32>,
    /// How many of the frame's layers to use; 1 ignores hidden ones.
    pub layers: usize,
    /// What is blurred at all.
    pub sides: Sides,
    /// Whether [`Filtered::predicted_error`](crate::Filtered::predicted_error) is wanted too (not by
    /// [`Method::OwnCoc`](crate::Method::OwnCoc)).
    pub predict_error: bool,
}

/// On which side of the plane of focus things are blurred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sides {
    /// On both.
    #[default]
    Both,
    /// Only what is nearer than the plane of focus; the rest stays sharp.
    Near,
    /// Only what is farther.
    Far,
}

impl Sides {
    /// The inverse depth that a surface at `inverse_depth` is blurred with where `focus` is the inverse depth of focus.
    pub(crate) fn limited(self, inverse_depth: f32, focus: f32) -> f32 {
        match self {
            Self::Both => inverse_depth,
            Self::Near => inverse_depth.max(focus),
            Self::Far => inverse_depth.min(focus),
        }
    }
}

impl Default for GatherSettings {
    fn default() -> Self {
        Self {
            kernel: KernelRule::default(),
            max_radius_px: None,
            layers: usize::MAX,
            sides: Sides::Both,
            predict_error: false,
        }
    }
}

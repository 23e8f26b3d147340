//! How two ways of finding the same light share it.

/// By their densities (the balance heuristic of Veach and Guibas), or for tests otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Weighing {
    /// Each by its share of the sum of densities.
    #[default]
    Balanced,
    /// Only lights that are asked count, unless they cannot be.
    #[cfg(test)]
    LightsAlone,
    /// Only lights that a path meets count.
    #[cfg(test)]
    SurfacesAlone,
    /// Both count in full, which is wrong.
    #[cfg(test)]
    Doubled,
}

impl Weighing {
    /// What light counts that was asked for, over the density with which it was.
    pub(super) fn asked(self, light: f64, surface: f64) -> f64 {
        match self {
            Self::Balanced => 1.0 / (light + surface),
            #[cfg(test)]
            Self::LightsAlone | Self::Doubled => 1.0 / light,
            #[cfg(test)]
            Self::SurfacesAlone => 0.0,
        }
    }

    /// What light counts that a path met, which would have been asked for with a density that may be 0.
    pub(super) fn met(self, surface: f32, light: f32) -> f32 {
        match self {
            Self::Balanced => surface / (surface + light),
            #[cfg(test)]
            Self::LightsAlone => f32::from(u8::from(light <= 0.0)),
            #[cfg(test)]
            Self::SurfacesAlone | Self::Doubled => 1.0,
        }
    }
}

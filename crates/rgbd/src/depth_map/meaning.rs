//! What the numbers of a map mean.

use optics::Film;

use super::DepthMap;
use crate::depth_convention::DepthReading;
use crate::{DepthConvention, PixelWindow, Plane, SampleKind};

/// What the numbers of a map mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MapMeaning {
    /// What is linear in the stored numbers: planar depth, distance along the ray, or inverse depth.
    pub convention: DepthConvention,
    /// The distances at black (0) and at white (1), where the map is normalised: black may be the farther one. Without, the
    /// numbers are taken as they are stored, and 0 is a hole.
    pub range: Option<[f32; 2]>,
    /// A stored number that means that nothing was hit, so that the pixel is infinitely far; it may be NaN.
    pub background: Option<f32>,
}

impl DepthMap {
    /// Planar depth in (0, +inf], NaN where it is not known, in the map's own pixels; `film` is needed for distances along the
    /// ray only.
    #[must_use]
    pub fn planar(&self, meaning: &MapMeaning, film: Option<&Film>) -> Plane {
        self.clone().into_planar(meaning, film)
    }

    /// The same in the memory of the stored numbers.
    #[must_use]
    pub fn into_planar(self, meaning: &MapMeaning, film: Option<&Film>) -> Plane {
        // The film in pixels of the map
        let window = self.stored.window();
        let film = film.and_then(|film| film.resized(window.width, window.height).ok());
        let film = film.as_ref().map(|film| (film, window));
        let reading = DepthReading {
            range: meaning.range,
            largest: self.largest.unwrap_or(1.0),
            background: meaning.background,
            ..DepthReading::new(meaning.convention, SampleKind::Float, film)
        };
        reading.for_all_of(&self.stored).planar_plane(self.stored, None)
    }

    /// The pixels of the map.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.stored.window()
    }
}

impl MapMeaning {
    /// How far apart two neighbouring whole numbers up to `largest` are in inverse depth, at an inverse depth.
    pub(super) fn step(&self, largest: Option<f32>, inverse_depth: f32) -> f32 {
        let Some(largest) = largest else { return 0.0 };
        let span = self.range.map_or(1.0, |[black, white]| match self.convention {
            DepthConvention::Inverse => (white.recip() - black.recip()).abs() / largest,
            _ => (white - black).abs() / largest,
        });
        match self.convention {
            DepthConvention::Inverse => span,
            _ => span * inverse_depth * inverse_depth,
        }
    }
}

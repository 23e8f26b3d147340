//! What the numbers of a map mean.

use optics::Film;

use super::DepthMap;
use crate::depth_convention::{DepthReading, cosine};
use crate::{DepthConvention, PixelWindow, Plane, SampleKind};

/// What the numbers of a map mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapMeaning {
    /// What is linear in the stored numbers: planar depth, distance along the ray, or inverse depth.
    pub convention: DepthConvention,
    /// The distances at black (0) and at white (1), where the map is normalised: black may be the farther one. Without, the
    /// numbers are taken as they are stored, and 0 is a hole.
    pub range: Option<[f32; 2]>,
}

impl DepthMap {
    /// Planar depth in (0, +inf], NaN where it is not known, in the map's own pixels; `film` is needed for distances along the
    /// ray only.
    #[must_use]
    pub fn planar(&self, meaning: &MapMeaning, film: Option<&Film>) -> Plane {
        // The film in pixels of the map
        let window = self.stored.window();
        let film = film.and_then(|film| film.resized(window.width, window.height).ok());
        let film = film.as_ref().map(|film| (film, window));
        let Some([black, white]) = meaning.range else {
            let reading = DepthReading::new(meaning.convention, SampleKind::Float, film);
            let opaque = Plane::filled(window, 1.0);
            return reading.planar_plane(&self.stored, &opaque);
        };
        let normalised = |stored: f32| stored / self.largest.unwrap_or(1.0);
        let depth = |x: i32, y: i32| {
            let t = normalised(self.stored.at(x, y));
            let depth = match meaning.convention {
                DepthConvention::Planar => black + t * (white - black),
                DepthConvention::Ray => (black + t * (white - black)) * cosine(film, x, y),
                DepthConvention::Inverse => {
                    let inverse = black.recip() + t * (white.recip() - black.recip());
                    // A rounding below 0 is no distance behind the camera
                    let least = 1e-6 * black.recip().max(white.recip());
                    if inverse.abs() <= least { f32::INFINITY } else { inverse.recip() }
                }
            };
            if depth > 0.0 { depth } else { f32::NAN }
        };
        Plane::from_fn(window, depth)
    }

    /// How far apart two neighbouring stored numbers are in inverse depth, at an inverse depth.
    pub(super) fn step(&self, meaning: &MapMeaning, inverse_depth: f32) -> f32 {
        let Some(largest) = self.largest else { return 0.0 };
        let span = meaning.range.map_or(1.0, |[black, white]| match meaning.convention {
            DepthConvention::Inverse => (white.recip() - black.recip()).abs() / largest,
            _ => (white - black).abs() / largest,
        });
        match meaning.convention {
            DepthConvention::Inverse => span,
            _ => span * inverse_depth * inverse_depth,
        }
    }

    /// The pixels of the map.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.stored.window()
    }
}

//! What a depth channel holds, and how it becomes planar depth.

use optics::Film;

use crate::{PixelWindow, Plane, ReadOptions, SampleKind};

/// What the numbers of a depth channel mean. Planar depth is measured along the sensor's normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum DepthConvention {
    /// Planar depth in scene units.
    #[default]
    Planar,
    /// Distance from the lens centre along the pixel's ray.
    Ray,
    /// One over planar depth; 0 is infinitely far.
    Inverse,
}

impl std::fmt::Display for DepthConvention {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planar => "planar depth",
            Self::Ray => "distance along the ray",
            Self::Inverse => "inverse depth",
        })
    }
}

/// Depths from here on are a renderer's word for "nothing hit" (Blender 1e10, others 1e30 or the largest float).
const NOTHING: f32 = 1e10;

/// The largest finite half, to which a depth in a half channel saturates.
const LARGEST_HALF: f32 = 65504.0;

/// How the stored numbers of a depth channel become planar depths.
#[derive(Clone, Copy)]
pub(crate) struct DepthReading<'a> {
    pub(crate) convention: DepthConvention,
    /// The distances that 0 and `largest` stand for, where they are normalised.
    pub(crate) range: Option<[f32; 2]>,
    /// The stored number at the second of them.
    pub(crate) largest: f32,
    /// A stored number that means that nothing was hit; it may be NaN.
    pub(crate) background: Option<f32>,
    /// From here on a number means that nothing was hit.
    pub(crate) sky: f32,
    /// Whether the numbers are negative, as depth along an axis that points back at the camera is.
    pub(crate) is_turned: bool,
    /// The film and the display window that it covers, for depths along the ray.
    pub(crate) film: Option<(&'a Film, PixelWindow)>,
}

impl<'a> DepthReading<'a> {
    /// The reading of a channel that stores numbers of this kind.
    pub(crate) fn new(convention: DepthConvention, kind: SampleKind, film: Option<(&'a Film, PixelWindow)>) -> Self {
        let sky = if kind == SampleKind::Half { LARGEST_HALF } else { NOTHING };
        Self { convention, range: None, largest: 1.0, background: None, sky, is_turned: false, film }
    }

    /// The reading that the options ask for.
    pub(crate) fn of(options: &ReadOptions, kind: SampleKind, film: Option<(&'a Film, PixelWindow)>) -> Self {
        let ReadOptions { convention, depth_range: range, background, .. } = *options;
        Self { range, background, ..Self::new(convention, kind, film) }
    }

    /// The same for the numbers of a whole channel: where there are negative ones and no positive ones, their sign is turned.
    pub(crate) fn for_all_of(self, stored: &Plane) -> Self {
        let is_depth = |number: f32| number.is_finite() && number < self.sky && Some(number) != self.background;
        let is_turned = stored.values().iter().any(|&z| is_depth(z) && z < 0.0)
            && !stored.values().iter().any(|&z| is_depth(z) && z > 0.0);
        Self { is_turned: is_turned && self.range.is_none(), ..self }
    }

    /// Planar depth in (0, +inf], or NaN where it is not known, of a number stored at a pixel.
    ///
    /// Where `alpha` is zero, what is no distance (0, negative, NaN) is empty background, infinitely far; elsewhere it is
    /// unknown.
    pub(crate) fn planar(&self, stored: f32, alpha: f32, (x, y): (i32, i32)) -> f32 {
        let is_nothing = |nothing: f32| stored == nothing || (nothing.is_nan() && stored.is_nan());
        let stored = if self.is_turned && !self.background.is_some_and(is_nothing) { -stored } else { stored };
        let is_distance = stored > 0.0;
        if self.background.is_some_and(is_nothing) || (alpha == 0.0 && !is_distance) {
            return f32::INFINITY;
        }
        let depth = match (self.range, self.convention) {
            (None, DepthConvention::Planar | DepthConvention::Ray) if stored >= self.sky => f32::INFINITY,
            (None, DepthConvention::Planar) => stored,
            (None, DepthConvention::Ray) => stored * cosine(self.film, x, y),
            // 1 / -0 would be negative
            (None, DepthConvention::Inverse) if stored == 0.0 => f32::INFINITY,
            (None, DepthConvention::Inverse) => 1.0 / stored,
            (Some(range), _) => self.of_normalised(stored, range, (x, y)),
        };
        if depth > 0.0 { depth } else { f32::NAN }
    }

    /// Depth of a number between those of black and white; beyond them it goes on.
    fn of_normalised(&self, stored: f32, [black, white]: [f32; 2], (x, y): (i32, i32)) -> f32 {
        let t = stored / self.largest;
        match self.convention {
            DepthConvention::Planar | DepthConvention::Ray if stored >= self.sky => f32::INFINITY,
            DepthConvention::Planar => black + t * (white - black),
            DepthConvention::Ray => (black + t * (white - black)) * cosine(self.film, x, y),
            DepthConvention::Inverse => {
                let inverse = black.recip() + t * (white.recip() - black.recip());
                // A rounding below 0 is no distance behind the camera
                let least = 1e-6 * black.recip().max(white.recip());
                if inverse.abs() <= least { f32::INFINITY } else { inverse.recip() }
            }
        }
    }

    /// The planar depths of a whole channel, in its memory; `alpha` must have its window, and is 1 without.
    pub(crate) fn planar_plane(&self, stored: Plane, alpha: Option<&Plane>) -> Plane {
        let mut depth = stored;
        let pixels = depth.window().pixels();
        for ((i, pixel), z) in pixels.enumerate().zip(depth.values_mut()) {
            *z = self.planar(*z, alpha.map_or(1.0, |alpha| alpha.values()[i]), pixel);
        }
        depth
    }
}

/// Cosine of the angle between the pixel's chief ray and the sensor's normal; 1 without a film.
pub(crate) fn cosine(film: Option<(&Film, PixelWindow)>, x: i32, y: i32) -> f32 {
    film.map_or(1.0, |(film, display)| {
        let corner = glam::DVec2::new(f64::from(display.x), f64::from(display.y));
        let centre = glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - corner;
        (1.0 / film.q_from_pixel(centre).extend(1.0).length()) as f32
    })
}

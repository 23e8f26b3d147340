//! What a depth channel holds, and how it becomes planar depth.

use optics::Film;

use crate::{PixelWindow, Plane, SampleKind};

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
    convention: DepthConvention,
    /// From here on a number means that nothing was hit.
    sky: f32,
    /// The film and the display window that it covers, for depths along the ray.
    film: Option<(&'a Film, PixelWindow)>,
}

impl<'a> DepthReading<'a> {
    /// The reading of a channel that stores numbers of this kind.
    pub(crate) fn new(convention: DepthConvention, kind: SampleKind, film: Option<(&'a Film, PixelWindow)>) -> Self {
        let sky = if kind == SampleKind::Half { LARGEST_HALF } else { NOTHING };
        Self { convention, sky, film }
    }

    /// Planar depth in (0, +inf], or NaN where it is not known, of a number stored at a pixel.
    ///
    /// Zero where `alpha` is zero is empty background, infinitely far; zero elsewhere, negative depth and NaN are unknown.
    pub(crate) fn planar(&self, stored: f32, alpha: f32, (x, y): (i32, i32)) -> f32 {
        let far = if stored >= self.sky { f32::INFINITY } else { stored };
        let depth = match self.convention {
            _ if stored == 0.0 && alpha == 0.0 => f32::INFINITY,
            DepthConvention::Planar => far,
            DepthConvention::Ray => far * cosine(self.film, x, y),
            // 1 / -0 would be negative
            DepthConvention::Inverse if stored == 0.0 => f32::INFINITY,
            DepthConvention::Inverse => 1.0 / stored,
        };
        if depth > 0.0 { depth } else { f32::NAN }
    }

    /// The planar depths of a whole channel; `alpha` must have its window.
    pub(crate) fn planar_plane(&self, stored: &Plane, alpha: &Plane) -> Plane {
        let mut depth = stored.clone();
        let pixels = stored.window().pixels();
        for (pixel, (z, &a)) in pixels.zip(depth.values_mut().iter_mut().zip(alpha.values())) {
            *z = self.planar(*z, a, pixel);
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

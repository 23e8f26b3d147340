//! How far from the pixel a ray's colour is fetched.
//!
//! A pixel's colour is already an average over the pixel's box, and so is the result: what lies between must have the
//! variance of the footprint (see the [kernel](crate::kernel)). Interpolating between pixel centres blurs too, by
//! 1/6 per axis on average, so that colours are fetched a little nearer to the receiving pixel than the ray's hit: at
//! `scale(r)` times its distance, for a blur of r pixels. The blur goes to nothing with r.

use glam::Vec2;

use crate::lens_points::LensPoints;

/// Entries per pixel of radius.
const STEPS: f32 = 32.0;
/// Radius in pixels beyond which the closed form serves.
const LAST_RADIUS: usize = 8;

/// The scale of a fetch by blur radius in pixels.
pub(crate) struct FetchRadius {
    scales: Vec<f32>,
    variance: f32,
}

impl FetchRadius {
    /// For an opening whose points are spread with `variance`.
    pub(crate) fn new(points: &LensPoints, variance: f64) -> Self {
        let points = points.of_pixel(0, 0);
        // Variance of interpolated fetches at a radius
        let spread = |radius: f64| {
            let axis = |x: f32| {
                let x = f64::from(x) * radius;
                let low = x.floor();
                low * low + (x - low) * (2.0 * low + 1.0)
            };
            points.iter().map(|p: &Vec2| axis(p.x) + axis(p.y)).sum::<f64>() / (2.0 * points.len() as f64)
        };
        let scale = |i: usize| {
            let radius = i as f64 / f64::from(STEPS);
            let (mut low, mut high) = (0.0, radius);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                if spread(middle) <= variance * radius * radius { low = middle } else { high = middle }
            }
            (low / radius.max(1e-9)) as f32
        };
        Self { scales: (0..=LAST_RADIUS * STEPS as usize).map(scale).collect(), variance: variance as f32 }
    }

    /// The scale at a blur of `radius` pixels.
    #[inline(always)]
    pub(crate) fn scale(&self, radius: f32) -> f32 {
        let place = radius * STEPS;
        let i = place as usize;
        if let Some(&[low, high]) = self.scales.get(i..i + 2).and_then(|pair| <&[_; 2]>::try_from(pair).ok()) {
            return low + (place - i as f32) * (high - low);
        }
        (1.0 - 1.0 / (6.0 * self.variance * radius * radius)).max(0.0).sqrt()
    }
}

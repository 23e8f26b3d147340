//! First and second moments of a footprint.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};

use crate::ApertureShape;

/// Mean and covariance of the offsets of a [`crate::Footprint`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Mean offset.
    pub centroid: DVec2,
    /// Covariance of the offsets; symmetric.
    pub covariance: DMat2,
}

impl Moments {
    /// Moments of u / (1 - lean . u) for points u uniform in the unit opening; `None` where the denominator vanishes.
    ///
    /// In closed form for a disc. For polygons by Gauss-Legendre quadrature, to a relative 1e-12 for |lean| <= 0.5 and
    /// to 1e-5 for |lean| <= 0.9.
    pub(crate) fn of_opening(shape: ApertureShape, lean: DVec2) -> Option<Self> {
        match shape {
            ApertureShape::Disc => Self::of_disc(lean),
            ApertureShape::Polygon { .. } => Self::of_polygon(shape, lean),
        }
    }

    /// The same moments after a linear map of the offsets.
    pub(crate) fn mapped(self, map: DMat2) -> Self {
        Self { centroid: map * self.centroid, covariance: map * self.covariance * map.transpose() }
    }

    /// With x = u along the lean k: density 2/pi sqrt(1 - x^2), E[1/(1 - kx)] = 2/(1 + s) and E[1/(1 - kx)^2] =
    /// 2/(s (1 + s)), s = sqrt(1 - k^2); the moments are sums of these, with what cancels for small k divided out.
    fn of_disc(lean: DVec2) -> Option<Self> {
        let k_squared = lean.length_squared();
        if k_squared >= 1.0 {
            return None;
        }
        let s = (1.0 - k_squared).sqrt();
        let along = 2.0 / (s * (1.0 + s).powi(3));
        let across = (1.0 + s).powi(-2);
        let direction = lean.normalize_or_zero();
        let outer = DMat2::from_cols(direction * direction.x, direction * direction.y);
        Some(Self {
            centroid: lean / (1.0 + s).powi(2),
            covariance: DMat2::IDENTITY * across + outer * (along - across),
        })
    }

    fn of_polygon(shape: ApertureShape, lean: DVec2) -> Option<Self> {
        const ORDER: usize = 16;
        let corners: Vec<DVec2> = shape.corners().collect();
        if corners.iter().any(|corner| lean.dot(*corner) >= 1.0) {
            return None;
        }
        // Split the polygon into equal triangles at its centre, and each into (radius, place along the outline)
        let rule = gauss_legendre::<ORDER>();
        let (mut mean, mut square) = (DVec2::ZERO, DMat2::ZERO);
        for (i, &corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            for (radius, radius_weight) in rule {
                for (along, along_weight) in rule {
                    let u = radius * corner.lerp(next, along);
                    let weight = 2.0 * radius * radius_weight * along_weight / corners.len() as f64;
                    let offset = u / (1.0 - lean.dot(u));
                    mean += weight * offset;
                    square += DMat2::from_cols(offset * offset.x, offset * offset.y) * weight;
                }
            }
        }
        let covariance = square - DMat2::from_cols(mean * mean.x, mean * mean.y);
        Some(Self { centroid: mean, covariance })
    }
}

/// Points and weights of Gauss-Legendre quadrature on [0, 1]; the weights sum to 1.
fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    std::array::from_fn(|i| {
        // Find the root of the Legendre polynomial by Newton's method; six steps reach rounding from this start
        let mut x = (PI * (i as f64 + 0.75) / (N as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..6 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=N {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            slope = N as f64 * (x * value - last) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

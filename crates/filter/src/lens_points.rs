//! Points of the iris, in sets that fill it evenly.
//!
//! A pixel takes one of a fixed number of sets, so that neighbours err differently. Each set is an Owen-scrambled Sobol
//! sequence (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020), moved and stretched a little so that its mean and
//! covariance are exactly those of the opening: a flat or evenly graded surface then comes out without noise.

use glam::{DMat2, DVec2, Vec2};
use optics::ApertureShape;
use rayon::prelude::*;
use sobol_burley::sample_4d;

/// Length of the sequence.
pub(crate) const MAX_SAMPLES: u32 = 1 << 16;

/// Number of different sets.
const SETS: u32 = 64;

/// Sets of points of the unit opening.
pub(crate) struct LensPoints {
    samples: usize,
    points: Vec<Vec2>,
}

impl LensPoints {
    /// Sets of `samples` points each, 1 to 65,536.
    pub(crate) fn new(shape: ApertureShape, samples: u32) -> Self {
        let set = |set: u32| {
            let point = |index: u32| {
                let [u, v, _, _] = sample_4d(index, 0, mix(set)).map(f64::from);
                shape.sample(DVec2::new(u, v))
            };
            balanced((0..samples).map(point).collect(), shape.variance())
        };
        let sets: Vec<Vec<Vec2>> = (0..SETS).into_par_iter().map(set).collect();
        Self { samples: samples as usize, points: sets.concat() }
    }

    /// The set of pixel (x, y), counted from the display window's corner.
    pub(crate) fn of_pixel(&self, x: i32, y: i32) -> &[Vec2] {
        let set = mix(mix(x as u32) ^ y as u32) % SETS;
        let start = set as usize * self.samples;
        &self.points[start..start + self.samples]
    }
}

/// The points with mean 0 and the same `variance` along every axis; as they are where they are too few for that.
fn balanced(points: Vec<DVec2>, variance: f64) -> Vec<Vec2> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<DVec2>() / count;
    let mut covariance = DMat2::ZERO;
    for p in points.iter().map(|p| p - mean) {
        covariance += DMat2::from_cols(p * p.x, p * p.y) * (1.0 / count);
    }
    // The symmetric root of the covariance, undone
    let root = covariance.determinant().max(0.0).sqrt();
    let trace = covariance.x_axis.x + covariance.y_axis.y;
    let spread = (covariance + DMat2::IDENTITY * root) * (trace + 2.0 * root).sqrt().recip();
    let correct = if points.len() < 8 { DMat2::IDENTITY } else { spread.inverse() * variance.sqrt() };
    let mean = if points.len() < 2 { points[0] } else { mean };
    points.into_iter().map(|p| (correct * (p - mean)).as_vec2()).collect()
}

/// A well mixed number from a number (the finaliser of MurmurHash3).
fn mix(x: u32) -> u32 {
    let x = (x ^ 0x9e37_79b9).wrapping_add(0x7f4a_7c15);
    let x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

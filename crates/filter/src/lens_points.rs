//! Points of the iris, in sets that fill it evenly.
//!
//! A pixel takes one of a fixed number of sets, so that neighbours err differently. Each set is an Owen-scrambled Sobol
//! sequence (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020), moved and stretched a little so that its mean and
//! covariance are exactly those of the opening: a flat or evenly graded surface then comes out without noise.

use glam::{DMat2, DVec2, Vec2};
use optics::{ApertureShape, Opening};
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

/// The first `samples` points that are open, with the mean and the covariance of the open part, which `many` points tell; all
/// of them where none is open.
pub(crate) fn open_points(points: &[Vec2], samples: usize, opening: &Opening, many: &[Vec2]) -> Vec<Vec2> {
    let is_open = |p: &&Vec2| opening.is_within_rim(p.as_dvec2());
    let open: Vec<Vec2> = points.iter().filter(is_open).take(samples).copied().collect();
    if open.len() < 8 {
        return if open.is_empty() { points.to_vec() } else { open };
    }
    let (mean, found) = moments(&open);
    let many: Vec<Vec2> = many.iter().filter(is_open).copied().collect();
    let (center, wanted) = moments(&many);
    let correct = symmetric_root(wanted) * symmetric_root(found).inverse();
    open.into_iter().map(|p| (center + correct * (p.as_dvec2() - mean)).as_vec2()).collect()
}

/// Mean and covariance.
fn moments(points: &[Vec2]) -> (DVec2, DMat2) {
    let share = 1.0 / points.len() as f64;
    let mean = share * points.iter().map(|p| p.as_dvec2()).sum::<DVec2>();
    let from_mean = points.iter().map(|p| p.as_dvec2() - mean);
    (mean, from_mean.map(|p| DMat2::from_cols(p * p.x, p * p.y) * share).sum())
}

/// The symmetric square root of a covariance.
fn symmetric_root(covariance: DMat2) -> DMat2 {
    let root = covariance.determinant().max(0.0).sqrt();
    let trace = covariance.x_axis.x + covariance.y_axis.y;
    (covariance + DMat2::IDENTITY * root) * (trace + 2.0 * root).sqrt().recip()
}

/// The points with mean 0 and the same `variance` along every axis; as they are where they are too few for that.
fn balanced(points: Vec<DVec2>, variance: f64) -> Vec<Vec2> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<DVec2>() / count;
    let mut covariance = DMat2::ZERO;
    for p in points.iter().map(|p| p - mean) {
        covariance += DMat2::from_cols(p * p.x, p * p.y) * (1.0 / count);
    }
    let spread = symmetric_root(covariance);
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

//! Axis-aligned boxes in f32 that surely hold what was put in.

use glam::{DVec3, Vec3, Vec3A};

/// A box in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3A,
    pub(crate) high: Vec3A,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// The box around points, each side one step of f32 beyond them: nothing in it is flat.
    pub(crate) fn around(points: &[Vec3]) -> Self {
        let mut bounds = Self::EMPTY;
        points.iter().for_each(|&p| bounds.include(p.into()));
        let low = bounds.low.to_array().map(f32::next_down);
        let high = bounds.high.to_array().map(f32::next_up);
        Self { low: low.into(), high: high.into() }
    }

    /// The same of points in double precision, rounded outwards.
    pub(crate) fn around_exact(points: &[DVec3]) -> Self {
        let low = points.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        Self {
            low: low.to_array().map(|x| (x as f32).next_down()).into(),
            high: high.to_array().map(|x| (x as f32).next_up()).into(),
        }
    }

    #[inline]
    pub(crate) fn include(&mut self, p: Vec3A) {
        self.low = self.low.min(p);
        self.high = self.high.max(p);
    }

    #[inline]
    pub(crate) fn join(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    /// Half its surface: what the chance of a ray to meet it is proportional to. 0 if it is empty.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

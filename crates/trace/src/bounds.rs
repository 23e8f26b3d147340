//! Axis-aligned boxes in f32 that surely hold what was put in.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

/// A box around points; each side is rounded outwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    pub(crate) fn include(&mut self, p: DVec3) {
        self.low = self.low.min(p);
        self.high = self.high.max(p);
    }

    /// The box in single precision, at least as large.
    pub(crate) fn to_aabb(self) -> Aabb {
        let low = self.low.to_array().map(|x| (x as f32).next_down());
        let high = self.high.to_array().map(|x| (x as f32).next_up());
        Aabb::new(Vec3A::from_array(low), Vec3A::from_array(high))
    }
}

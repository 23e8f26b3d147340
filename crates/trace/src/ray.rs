//! A ray in world space, in the precision that intersection works in.

use glam::{DVec3, Vec3};

/// A half line: `origin + t direction` for t > 0, at some time of the exposure. The direction need not be of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    /// When: 0 as the shutter opens, 1 as it closes.
    pub time: f32,
}

impl Ray {
    /// The middle of an exposure.
    pub const MIDDLE: f32 = 0.5;

    /// A ray rounded to the tracer's precision, in the middle of the exposure.
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self::single(origin.as_vec3(), direction.as_vec3())
    }

    /// A ray in the middle of the exposure.
    #[inline(always)]
    pub(crate) fn single(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, time: Self::MIDDLE }
    }

    /// The same at another time, 0 to 1.
    #[must_use]
    pub fn timed(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// A ray that leaves a surface at `point` on the side that `normal` (unit length) points to.
    ///
    /// Rounding the origin to f32 moves it by up to sqrt(3) 2^-24 of its largest coordinate; lifting it by 2^-21 of that
    /// keeps it on its side of the surface, and moves a shadow by less than 5e-7 of the distance from the world's origin.
    #[must_use]
    pub fn leaving(point: DVec3, normal: DVec3, direction: DVec3) -> Self {
        const LIFT: f64 = 1.0 / (1 << 21) as f64;
        let lift = LIFT * point.abs().max_element().max(f64::from(f32::MIN_POSITIVE) / LIFT);
        Self::new(point + lift * normal, direction)
    }

    /// The point at `t`, in double precision.
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin.as_dvec3() + t * self.direction.as_dvec3()
    }
}

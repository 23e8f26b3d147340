//! Where rays enter and leave boxes: one formula for a ray against eight boxes and for eight rays against one.

use fearless_simd::{f32x8, prelude::*};

/// Rays prepared for boxes, one per lane or the same in all.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<S: Simd> {
    pub(crate) origin: [f32x8<S>; 3],
    pub(crate) inverse: [f32x8<S>; 3],
}

/// 1 over a component of a direction; a component of 0 becomes one so small that the ray stays in its slab, and 0 x inf
/// never arises.
#[inline(always)]
pub(crate) fn inverse<S: Simd>(simd: S, d: f32x8<S>) -> f32x8<S> {
    let tiny = f32x8::splat(simd, 1e-30);
    let d = d.abs().simd_lt(tiny).select(tiny.copysign(d), d);
    f32x8::splat(simd, 1.0) / d
}

impl<S: Simd> Slabs<S> {
    /// Where boxes are entered (0 if the ray starts inside) and left, both moved outwards so that rounding loses no box
    /// (Ize, "Robust BVH Ray Traversal", JCGT 2013): the ray meets the box iff enter <= leave.
    #[inline(always)]
    pub(crate) fn cross(&self, simd: S, low: [f32x8<S>; 3], high: [f32x8<S>; 3]) -> [f32x8<S>; 2] {
        // 1 -+ 2 gamma(3)
        const NARROW: f32 = 0.999_999_4;
        const WIDEN: f32 = 1.000_000_6;
        let mut enter = f32x8::splat(simd, 0.0);
        let mut leave = f32x8::splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let a = (low[axis] - self.origin[axis]) * self.inverse[axis];
            let b = (high[axis] - self.origin[axis]) * self.inverse[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        [enter * NARROW, leave * WIDEN]
    }
}

//! Triangles against rays without gaps between neighbours: four triangles against one ray, or one against eight rays.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): the triangle is sheared into a space where
//! the ray is the z axis; the signs of three edge functions, exactly antisymmetric in their end points, tell whether
//! the axis passes between the edges; an edge function of exactly 0 is decided in double precision.
//!
//! All lanes of all widths do the same operations in the same order, none of them fused: whether a processor has fused
//! multiply-add must not be seen in a picture, and doing it in software costs more than all the rest.

use fearless_simd::prelude::*;
use glam::Vec3;

use crate::Ray;

/// How rays are sheared: their axes with the largest component of the direction last, wound as x, y, z are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Axes {
    pub(crate) order: [usize; 3],
    /// Which of the six: twice the last axis, one more if its direction is negative.
    pub(crate) class: usize,
}

impl Axes {
    pub(crate) const CLASSES: usize = 6;

    /// The class of a direction.
    #[inline(always)]
    pub(crate) fn class_of(direction: Vec3) -> usize {
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        2 * z + usize::from(direction[z] < 0.0)
    }

    #[inline(always)]
    pub(crate) fn of_class(class: usize) -> Self {
        let z = class / 2;
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        // Keep the winding
        let order = if class % 2 == 1 { [y, x, z] } else { [x, y, z] };
        Self { order, class }
    }
}

/// A ray in sheared space: its origin in the order of the axes, and d.x / d.z, d.y / d.z, 1 / d.z.
#[derive(Clone, Copy)]
pub(crate) struct Sheared<F> {
    pub(crate) origin: [F; 3],
    pub(crate) shear: [F; 3],
}

impl Sheared<f32> {
    /// A ray and the axes that suit it.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> (Self, Axes) {
        let axes = Axes::of_class(Axes::class_of(ray.direction));
        let [dx, dy, dz] = axes.order.map(|axis| ray.direction[axis]);
        let origin = axes.order.map(|axis| ray.origin[axis]);
        (Self { origin, shear: [dx / dz, dy / dz, 1.0 / dz] }, axes)
    }

    #[inline(always)]
    pub(crate) fn splat<S: Simd, F: SimdFloat<S, Element = f32>>(&self, simd: S) -> Sheared<F> {
        Sheared { origin: splat(simd, self.origin), shear: splat(simd, self.shear) }
    }
}

/// Each number in all lanes. (A closure given to `map` would not be inlined, and would lose the vector instructions.)
#[inline(always)]
pub(crate) fn splat<S: Simd, F: SimdFloat<S, Element = f32>>(simd: S, [x, y, z]: [f32; 3]) -> [F; 3] {
    [F::splat(simd, x), F::splat(simd, y), F::splat(simd, z)]
}

/// Where lanes meet: the ray's parameter, and the weights of the second and third corner.
#[derive(Clone, Copy)]
pub(crate) struct Meeting<S: Simd, F: SimdBase<S>> {
    pub(crate) is_met: F::Mask,
    pub(crate) t: F,
    pub(crate) v: F,
    pub(crate) w: F,
}

impl<F: Copy> Sheared<F> {
    /// A corner seen along the ray, its z not yet scaled.
    #[inline(always)]
    fn sheared<S: Simd>(&self, &[x, y, z]: &[F; 3]) -> [F; 3]
    where
        F: SimdFloat<S, Element = f32>,
    {
        let dz = z - self.origin[2];
        [x - self.origin[0] - self.shear[0] * dz, y - self.origin[1] - self.shear[1] * dz, dz]
    }

    /// Meets triangles, `corners[k][axis]` with the axes in the rays' order, from either side at t > 0. NaN is never met.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, corners: &[[F; 3]; 3]) -> Option<Meeting<S, F>>
    where
        F: SimdFloat<S, Element = f32>,
    {
        // Shear the corners into the ray's space
        let [ax, ay, az] = self.sheared::<S>(&corners[0]);
        let [bx, by, bz] = self.sheared::<S>(&corners[1]);
        let [cx, cy, cz] = self.sheared::<S>(&corners[2]);

        // Reject where the edge functions differ in sign
        let zero = F::splat(simd, 0.0);
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        let mut inside = !(u.min(v).min(w).simd_lt(zero) & u.max(v).max(w).simd_gt(zero));
        if inside.all_false() {
            return None;
        }

        // Evaluate them again in double precision where one is 0
        let is_zero = (u.simd_eq(zero) | v.simd_eq(zero) | w.simd_eq(zero)) & inside;
        if is_zero.any_true() {
            let lanes = is_zero.to_bitmask();
            precise(lanes, u.as_mut_slice(), [&cx, &by, &cy, &bx].map(F::as_slice));
            precise(lanes, v.as_mut_slice(), [&ax, &cy, &ay, &cx].map(F::as_slice));
            precise(lanes, w.as_mut_slice(), [&bx, &ay, &by, &ax].map(F::as_slice));
            inside &= !(u.min(v).min(w).simd_lt(zero) & u.max(v).max(w).simd_gt(zero));
        }

        // Interpolate; lanes of NaN fail the comparison
        let sum = u + v + w;
        let share = F::splat(simd, 1.0) / sum;
        let t = (u * az + v * bz + w * cz) * share * self.shear[2];
        let is_met = inside & t.simd_gt(zero) & sum.simd_ne(zero);
        Some(Meeting { is_met, t, v: v * share, w: w * share })
    }
}

/// p q - r s in double precision in the lanes of a bit mask, the products exact.
#[cold]
#[inline(never)]
fn precise(lanes: u64, single: &mut [f32], [p, q, r, s]: [&[f32]; 4]) {
    for (i, single) in single.iter_mut().enumerate() {
        if lanes >> i & 1 == 1 {
            let [p, q, r, s] = [p[i], q[i], r[i], s[i]].map(f64::from);
            *single = (p * q - r * s) as f32;
        }
    }
}

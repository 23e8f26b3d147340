//! Four triangles at a time against one ray, without gaps between neighbours.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): the triangle is sheared into a space where
//! the ray is the z axis; the signs of three edge functions, exactly antisymmetric in their end points, tell whether
//! the axis passes between the edges; an edge function of exactly 0 is decided in double precision.

use glam::{BVec4A, Vec3, Vec4};

use crate::Ray;

/// A ray, sheared for [`Triangle4::hit`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedRay {
    origin: [Vec4; 3],
    axes: [usize; 3],
    shear: [Vec4; 3],
}

impl ShearedRay {
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        // Let z be the largest component; keep the winding
        let z = d.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        Self {
            origin: [x, y, z].map(|axis| Vec4::splat(ray.origin[axis])),
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]].map(Vec4::splat),
        }
    }
}

/// Where a ray meets a triangle: the ray's parameter and the weights of the three corners, which sum to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TriangleHit {
    pub(crate) t: f32,
    pub(crate) weights: Vec3,
    /// Which of the four.
    pub(crate) lane: usize,
}

/// Up to four triangles: `corners[k][axis]` holds corner k of each. Unused lanes are NaN and never hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle4 {
    corners: [[Vec4; 3]; 3],
}

impl Triangle4 {
    pub(crate) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut corners = [[Vec4::NAN; 3]; 3];
        for (lane, triangle) in triangles.iter().take(4).enumerate() {
            for (k, corner) in triangle.iter().enumerate() {
                for axis in 0..3 {
                    corners[k][axis][lane] = corner[axis];
                }
            }
        }
        Self { corners }
    }

    /// The same triangles but one.
    pub(crate) fn without(&self, lane: usize) -> Self {
        let mut rest = *self;
        rest.corners.iter_mut().flatten().for_each(|values| values[lane] = f32::NAN);
        rest
    }

    /// The nearest of the four hits with t in (0, `t_max`), from either side.
    #[inline]
    pub(crate) fn hit(&self, ray: &ShearedRay, t_max: f32) -> Option<TriangleHit> {
        // Shear the corners into the ray's space
        let [x, y, z] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let sheared = |k: usize| {
            let corner = &self.corners[k];
            let dz = corner[z] - ray.origin[2];
            (corner[x] - ray.origin[0] - sx * dz, corner[y] - ray.origin[1] - sy * dz, sz * dz)
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (sheared(0), sheared(1), sheared(2));

        // Evaluate the edge functions, again in double precision where one is 0
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        let zero = u.cmpeq(Vec4::ZERO) | v.cmpeq(Vec4::ZERO) | w.cmpeq(Vec4::ZERO);
        if zero.any() {
            u = precise(zero, u, [cx, by, cy, bx]);
            v = precise(zero, v, [ax, cy, ay, cx]);
            w = precise(zero, w, [bx, ay, by, ax]);
        }

        // Reject where the signs differ
        let negative = u.cmplt(Vec4::ZERO) | v.cmplt(Vec4::ZERO) | w.cmplt(Vec4::ZERO);
        let positive = u.cmpgt(Vec4::ZERO) | v.cmpgt(Vec4::ZERO) | w.cmpgt(Vec4::ZERO);
        let inside = !(negative & positive);
        if !inside.any() {
            return None;
        }

        // Keep the nearest of the rest; NaN lanes fail the comparisons
        let sum = u + v + w;
        let t = (u * az + v * bz + w * cz) / sum;
        let valid = inside & t.cmpgt(Vec4::ZERO) & t.cmplt(Vec4::splat(t_max)) & sum.cmpne(Vec4::ZERO);
        if !valid.any() {
            return None;
        }
        let t = Vec4::select(valid, t, Vec4::INFINITY);
        let lane = t.min_position();
        Some(TriangleHit { t: t[lane], weights: Vec3::new(u[lane], v[lane], w[lane]) / sum[lane], lane })
    }
}

/// p q - r s in double precision in the lanes of `which`, the products exact.
#[cold]
fn precise(which: BVec4A, single: Vec4, [p, q, r, s]: [Vec4; 4]) -> Vec4 {
    let double = (p.as_dvec4() * q.as_dvec4() - r.as_dvec4() * s.as_dvec4()).as_vec4();
    Vec4::select(which, double, single)
}

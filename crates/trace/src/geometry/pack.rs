//! Triangles as the leaves of the tree hold them, four side by side.

use fearless_simd::{f32x4, prelude::*};
use glam::Vec3;

use crate::triangle::{Axes, Meeting, Sheared};

/// Triangles of a pack.
pub(crate) const LANES: usize = 4;

/// A triangle in the world with its material.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    pub(crate) corners: [Vec3; 3],
    pub(crate) material: u32,
}

/// Up to four triangles: `corners[k][axis]` holds corner k of each. Unused lanes are NaN, which no ray meets.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Pack {
    pub(super) corners: [[[f32; LANES]; 3]; 3],
    materials: [u32; LANES],
}

impl Pack {
    const NO_MATERIAL: u32 = u32::MAX;

    /// A pack of one to four triangles.
    pub(super) fn new<'a>(triangles: impl Iterator<Item = &'a Triangle>) -> Self {
        let mut pack = Self { corners: [[[f32::NAN; LANES]; 3]; 3], materials: [Self::NO_MATERIAL; LANES] };
        for (lane, triangle) in triangles.enumerate() {
            for (k, corner) in triangle.corners.iter().enumerate() {
                for axis in 0..3 {
                    pack.corners[k][axis][lane] = corner[axis];
                }
            }
            pack.materials[lane] = triangle.material;
        }
        pack
    }

    /// The triangle of a lane.
    #[inline]
    pub(super) fn triangle(&self, lane: usize) -> Triangle {
        let corner = |k: usize| Vec3::from_array([0, 1, 2].map(|axis| self.corners[k][axis][lane]));
        Triangle { corners: [corner(0), corner(1), corner(2)], material: self.materials[lane] }
    }

    /// How many lanes are used.
    #[inline]
    pub(super) fn count(&self) -> usize {
        self.materials.iter().take_while(|&&material| material != Self::NO_MATERIAL).count()
    }

    /// Where one ray meets the four.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, ray: &Sheared<f32>, axes: Axes) -> Option<Meeting<S, f32x4<S>>> {
        let corners = [
            load(simd, &self.corners[0], axes),
            load(simd, &self.corners[1], axes),
            load(simd, &self.corners[2], axes),
        ];
        ray.splat::<S, f32x4<S>>(simd).meet(simd, &corners)
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, corner: &[[f32; LANES]; 3], axes: Axes) -> [f32x4<S>; 3] {
    let [x, y, z] = axes.order;
    [
        f32x4::load_array_ref(simd, &corner[x]),
        f32x4::load_array_ref(simd, &corner[y]),
        f32x4::load_array_ref(simd, &corner[z]),
    ]
}

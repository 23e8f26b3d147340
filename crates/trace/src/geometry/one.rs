//! One ray against all surfaces.

use fearless_simd::prelude::*;

use super::{Found, Geometry, LANES, Leaf, PrimitiveId};
use crate::Ray;
use crate::bvh::Visitor;
use crate::triangle::{Axes, Sheared};

/// Looks for the first surface.
pub(super) struct Nearest<'a> {
    geometry: &'a Geometry,
    ray: &'a Ray,
    sheared: Sheared<f32>,
    axes: Axes,
    skip: PrimitiveId,
    pub(super) found: Found,
}

impl<'a> Nearest<'a> {
    /// A search that leaves out the triangle `skip`.
    #[inline(always)]
    pub(super) fn new(geometry: &'a Geometry, ray: &'a Ray, skip: PrimitiveId) -> Self {
        let (sheared, axes) = Sheared::new(ray);
        Self { geometry, ray, sheared, axes, skip, found: Found::NOTHING }
    }

    /// Takes a shape's hit if it is the first so far.
    #[inline]
    pub(super) fn try_shape(&mut self, id: u32, enter: f32) {
        if let Some((t, _)) = self.geometry.shapes[id as usize].hit(self.ray, f64::INFINITY) {
            let primitive = Geometry::SHAPE | id;
            self.found.take(Found { t: (t as f32).max(enter), primitive, v: 0.0, w: 0.0 });
        }
    }

    /// Takes the hits of a pack.
    #[inline(always)]
    pub(super) fn try_pack<S: Simd>(&mut self, simd: S, index: usize, enter: f32) {
        let Some(meeting) = self.geometry.packs[index].meet(simd, &self.sheared, self.axes) else { return };
        let mut met = (meeting.is_met & meeting.t.simd_le(self.found.t)).to_bitmask();
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let primitive = (LANES * index + lane) as PrimitiveId;
            if primitive != self.skip {
                let t = meeting.t[lane].max(enter);
                self.found.take(Found { t, primitive, v: meeting.v[lane], w: meeting.w[lane] });
            }
        }
    }
}

impl<S: Simd> Visitor<S> for Nearest<'_> {
    #[inline(always)]
    fn t_far(&self) -> f32 {
        self.found.t
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: usize, enter: f32) -> bool {
        match Leaf::of(leaf) {
            Leaf::Pack(index) => self.try_pack(simd, index, enter),
            Leaf::Shape(id) => self.try_shape(id, enter),
        }
        false
    }
}

/// Looks for anything on a part of the ray.
pub(super) struct Anything<'a> {
    geometry: &'a Geometry,
    ray: &'a Ray,
    sheared: Sheared<f32>,
    axes: Axes,
    skip: PrimitiveId,
    t_max: f64,
    t_far: f32,
    pub(super) found: bool,
}

impl<'a> Anything<'a> {
    /// A search before `t_max` that leaves out the triangle `skip`.
    #[inline(always)]
    pub(super) fn new(geometry: &'a Geometry, ray: &'a Ray, t_max: f64, skip: PrimitiveId) -> Self {
        let (sheared, axes) = Sheared::new(ray);
        Self { geometry, ray, sheared, axes, skip, t_max, t_far: (t_max as f32).next_up().min(f32::MAX), found: false }
    }
}

impl<S: Simd> Visitor<S> for Anything<'_> {
    #[inline(always)]
    fn t_far(&self) -> f32 {
        self.t_far
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: usize, enter: f32) -> bool {
        self.found = match Leaf::of(leaf) {
            Leaf::Shape(id) => self.geometry.shapes[id as usize].hit(self.ray, self.t_max).is_some(),
            Leaf::Pack(index) => {
                let meeting = self.geometry.packs[index].meet(simd, &self.sheared, self.axes);
                meeting.is_some_and(|meeting| {
                    let mut met = meeting.is_met & meeting.t.max(enter).simd_lt(self.t_far);
                    let lane = self.skip.wrapping_sub((LANES * index) as PrimitiveId) as usize;
                    if lane < LANES {
                        met.set(lane, false);
                    }
                    met.any_true()
                })
            }
        };
        self.found
    }
}

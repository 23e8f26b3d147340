//! All rays of a packet at once against the eight boxes of a node.
//!
//! Intervals around the origins and directions of lens rays would hold far more than the rays do: a wide lens, each
//! point of which might look in any of the directions. But lens rays of a pixel meet in the plane of focus. So the rays
//! are described from where they are closest together, at a common t0 (negative parameters before it): an hourglass,
//! around which intervals fit well. Shadow rays are parallel, and t0 is 0.
//!
//! What is left out here is left out for sure: every bound is moved outwards by more than the rounding of the exact test
//! of each ray, [`Slabs`](super::Slabs). What is let in is tested again ray by ray before it counts.

use fearless_simd::{f32x8, prelude::*};

use super::{Node, WIDTH};
use crate::packet::{GROUP, Packet};

/// Rounding of a place, over its size; 8 times what it takes.
const PLACE_SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Rounding of a parameter, over its size.
const T_SLACK: f32 = 1.0 / (1 << 18) as f32;

/// What all rays of a packet do along an axis.
#[derive(Debug, Clone, Copy)]
struct Along {
    /// -1 or 1 if all run the same way, 0 if not.
    way: i32,
    /// Places at t0.
    origin: [f32; 2],
    direction: [f32; 2],
    inverse: [f32; 2],
}

impl Along {
    #[inline(always)]
    fn new<S: Simd>(simd: S, packet: &Packet, t0: f32, axis: usize) -> Self {
        let [low, high] = [f32x8::splat(simd, f32::INFINITY), f32x8::splat(simd, f32::NEG_INFINITY)];
        let (mut origin, mut direction, mut inverse) = ([low, high], [low, high], [low, high]);
        let mut largest = f32x8::splat(simd, 0.0);
        for group in 0..packet.groups() {
            let (o, d) = (packet.origin[axis].get(simd, group), packet.direction[axis].get(simd, group));
            let step = d * t0;
            let (at, i) = (o + step, packet.inverse(simd, axis, group));
            largest = largest.max(o.abs() + step.abs());
            origin = [origin[0].min(at), origin[1].max(at)];
            direction = [direction[0].min(d), direction[1].max(d)];
            inverse = [inverse[0].min(i), inverse[1].max(i)];
        }
        let slack = PLACE_SLACK * most(largest);
        let direction = [least(direction[0]), most(direction[1])];
        let way = i32::from(direction[0] > 0.0) - i32::from(direction[1] < 0.0);
        let origin = [least(origin[0]) - slack, most(origin[1]) + slack];
        Self { way, origin, direction, inverse: [least(inverse[0]), most(inverse[1])] }
    }
}

/// The intervals of a packet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    t0: f32,
    along: [Along; 3],
}

/// The boxes of a node that some ray of a packet might meet, as bits, and no more than where they are entered.
pub(crate) struct Touched<S: Simd> {
    pub(crate) boxes: u64,
    /// Relative to t0.
    pub(crate) enter: f32x8<S>,
}

impl Beam {
    /// The beam of a sealed packet.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, packet: &Packet) -> Self {
        let t0 = waist(simd, packet);
        Self {
            t0,
            along: [Along::new(simd, packet, t0, 0), Along::new(simd, packet, t0, 1), Along::new(simd, packet, t0, 2)],
        }
    }

    /// A parameter counted from t0, and a little more.
    #[inline(always)]
    pub(crate) fn far(&self, t: f32) -> f32 {
        (t - self.t0) + T_SLACK * (t.abs() + self.t0.abs())
    }

    /// The boxes that are touched between the rays' origins and `far`, which counts from t0.
    #[inline(always)]
    pub(crate) fn touch<S: Simd>(&self, simd: S, node: &Node, far: f32) -> Touched<S> {
        // Bound where boxes are entered and left along the axes on which all rays run the same way
        let mut enter = f32x8::splat(simd, -self.t0 - T_SLACK * self.t0.abs());
        let mut leave = f32x8::splat(simd, far.min(f32::MAX));
        for (axis, along) in self.along.iter().enumerate() {
            let (a, b) = match along.way {
                1 => (load(simd, &node.low[axis]) - along.origin[1], load(simd, &node.high[axis]) - along.origin[0]),
                -1 => (load(simd, &node.high[axis]) - along.origin[0], load(simd, &node.low[axis]) - along.origin[1]),
                _ => continue,
            };
            let [i, j] = along.inverse;
            enter = enter.max((a * i).min(a * j));
            leave = leave.min((b * i).max(b * j));
        }
        let size = f32x8::splat(simd, self.t0.abs());
        enter -= (enter.abs() + size) * T_SLACK;
        leave += (leave.abs() + size) * T_SLACK;
        let mut touched = enter.simd_le(leave);

        // Bound where the rays are in between along the others
        for (axis, along) in self.along.iter().enumerate().filter(|(_, along)| along.way == 0) {
            let [i, j] = along.direction;
            let (a, b, c, d) = (enter * i, enter * j, leave * i, leave * j);
            let low = a.min(b).min(c.min(d)) + along.origin[0];
            let high = a.max(b).max(c.max(d)) + along.origin[1];
            touched &= low.simd_le(load(simd, &node.high[axis])) & high.simd_ge(load(simd, &node.low[axis]));
        }
        Touched { boxes: touched.to_bitmask(), enter }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, side: &[f32; WIDTH]) -> f32x8<S> {
    f32x8::load_array_ref(simd, side)
}

/// Where the rays are closest together: the parameter at which the sum of squared distances from their middle is least.
#[inline(always)]
fn waist<S: Simd>(simd: S, packet: &Packet) -> f32 {
    let zero = f32x8::splat(simd, 0.0);
    let share = 1.0 / (packet.groups() * GROUP) as f32;
    let (mut together, mut spread) = (zero, zero);
    let mut size = 0.0;
    for axis in 0..3 {
        let (mut origin, mut direction) = (zero, zero);
        for group in 0..packet.groups() {
            origin += packet.origin[axis].get(simd, group);
            direction += packet.direction[axis].get(simd, group);
        }
        let (origin, direction) = (total(origin) * share, total(direction) * share);
        size += direction * direction;
        for group in 0..packet.groups() {
            let o = packet.origin[axis].get(simd, group) - origin;
            let d = packet.direction[axis].get(simd, group) - direction;
            together += o * d;
            spread += d * d;
        }
    }
    // Parallel rays are nowhere closer than where they start
    let (together, spread) = (total(together), total(spread));
    if spread * share > 1e-10 * size { (-together / spread).max(0.0) } else { 0.0 }
}

#[inline(always)]
fn total<S: Simd>(lanes: f32x8<S>) -> f32 {
    lanes.to_array().iter().sum()
}

#[inline(always)]
fn least<S: Simd>(lanes: f32x8<S>) -> f32 {
    lanes.to_array().into_iter().fold(f32::INFINITY, f32::min)
}

#[inline(always)]
fn most<S: Simd>(lanes: f32x8<S>) -> f32 {
    lanes.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max)
}

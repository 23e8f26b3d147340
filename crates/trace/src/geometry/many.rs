//! A packet of rays against all surfaces: what each hits first, and which of them are blocked.

use fearless_simd::{f32x8, i32x8, prelude::*};

use super::{Found, Geometry, LANES, Leaf, Pack, PrimitiveId};
use crate::bvh::{Beam, Child, Node};
use crate::packet::{GROUP, Lanes, Packet, RAYS};
use crate::triangle::splat;

/// What the rays of a packet find, and room to look for it.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    /// Where each ray ends so far; before its start if nothing is asked of it any more.
    t: Lanes,
    primitive: [i32; RAYS],
    v: Lanes,
    w: Lanes,
    /// Node, lane of the node, and where the box is entered at the earliest.
    stack: Vec<(Child, u32, f32)>,
}

/// An end before every start.
const DONE: f32 = -1.0;

impl Default for Search {
    fn default() -> Self {
        let stack = Vec::with_capacity(256);
        Self { t: Lanes::ZERO, primitive: [-1; RAYS], v: Lanes::ZERO, w: Lanes::ZERO, stack }
    }
}

impl Search {
    /// What the ray of a lane hit.
    #[inline(always)]
    pub(crate) fn found(&self, lane: usize) -> Found {
        let primitive = self.primitive[lane] as PrimitiveId;
        Found { t: self.t.0[lane], primitive, v: self.v.0[lane], w: self.w.0[lane] }
    }

    /// Whether the ray of a lane is blocked.
    #[inline(always)]
    pub(crate) fn is_blocked(&self, lane: usize) -> bool {
        self.t.0[lane] == DONE
    }

    fn start(&mut self, count: usize) {
        self.t.0[..count].fill(Found::NOTHING.t);
        self.t.0[count..].fill(DONE);
    }

    /// Looks for the first surface that each ray of a sealed packet hits.
    #[inline(always)]
    pub(crate) fn first<S: Simd>(&mut self, simd: S, geometry: &Geometry, packet: &Packet) {
        self.start(packet.count());
        self.primitive = [Geometry::NO_PRIMITIVE as i32; RAYS];
        for &id in &geometry.endless {
            self.try_shape::<false>(geometry, packet, id, 0, u64::MAX, &Lanes::ZERO.0);
        }
        self.walk::<S, false>(simd, geometry, packet, &[-1; RAYS]);
    }

    /// Looks whether anything but the triangle `skip` of its lane blocks each ray of a sealed packet.
    #[inline(always)]
    pub(crate) fn any<S: Simd>(&mut self, simd: S, geometry: &Geometry, packet: &Packet, skip: &[i32; RAYS]) {
        self.start(packet.count());
        for &id in &geometry.endless {
            self.try_shape::<true>(geometry, packet, id, 0, u64::MAX, &Lanes::ZERO.0);
        }
        self.walk::<S, true>(simd, geometry, packet, skip);
    }

    /// Goes through the tree, nearest boxes first.
    #[inline(always)]
    fn walk<S: Simd, const ANY: bool>(&mut self, simd: S, geometry: &Geometry, packet: &Packet, skip: &[i32; RAYS]) {
        let bvh = &geometry.bvh;
        let Some(mut current) = bvh.root() else { return };
        let beam = Beam::new(simd, packet);
        let mut far = beam.far(self.t_most(packet));
        self.stack.clear();
        loop {
            // Put the boxes that the beam touches on the stack, the nearest on top
            let touched = beam.touch(simd, bvh.node(current), far);
            let bottom = self.stack.len();
            let mut boxes = touched.boxes;
            while boxes != 0 {
                let lane = boxes.trailing_zeros();
                boxes &= boxes - 1;
                let enter = touched.enter[lane as usize];
                let mut at = self.stack.len();
                self.stack.push((current, lane, enter));
                while at > bottom && self.stack[at - 1].2 < enter {
                    self.stack.swap(at - 1, at);
                    at -= 1;
                }
            }

            // Look at leaves until there is an inner node
            current = loop {
                let Some((parent, lane, enter)) = self.stack.pop() else { return };
                if enter > far {
                    continue;
                }
                let node = bvh.node(parent);
                let child = node.child(lane as usize);
                let Some(leaf) = child.leaf() else { break child };
                if self.visit::<S, ANY>(simd, geometry, packet, (node, lane as usize), leaf, skip) {
                    let t = self.t_most(packet);
                    if t < 0.0 {
                        return;
                    }
                    far = beam.far(t);
                }
            };
        }
    }

    /// The farthest end of any ray.
    #[inline(always)]
    fn t_most(&self, packet: &Packet) -> f32 {
        self.t.0[..GROUP * packet.groups()].iter().fold(DONE, |most, &t| if t > most { t } else { most })
    }

    /// Tries a leaf on the rays that enter its box; whether any of them ends there.
    #[inline(always)]
    fn visit<S: Simd, const ANY: bool>(
        &mut self,
        simd: S,
        geometry: &Geometry,
        packet: &Packet,
        (node, lane): (&Node, usize),
        leaf: usize,
        skip: &[i32; RAYS],
    ) -> bool {
        let low = splat(simd, [node.low[0][lane], node.low[1][lane], node.low[2][lane]]);
        let high = splat(simd, [node.high[0][lane], node.high[1][lane], node.high[2][lane]]);
        let mut is_news = false;
        for group in 0..packet.groups() {
            let [enter, leave] = packet.slabs(simd, group).cross(simd, low, high);
            let is_entered = enter.simd_le(leave) & enter.simd_le(self.t.get(simd, group));
            if is_entered.all_false() {
                continue;
            }
            is_news |= match Leaf::of(leaf) {
                Leaf::Pack(index) => {
                    let pack = &geometry.packs[index];
                    let skip = i32x8::from_slice(simd, &skip[GROUP * group..GROUP * group + GROUP]);
                    self.try_pack::<S, ANY>(simd, packet, group, (index, pack), (enter, is_entered), skip)
                }
                Leaf::Shape(id) => {
                    let lanes = is_entered.to_bitmask() << (GROUP * group);
                    let mut enters = Lanes::ZERO;
                    enters.set(group, enter);
                    self.try_shape::<ANY>(geometry, packet, id, GROUP * group, lanes, &enters.0)
                }
            };
        }
        is_news
    }

    /// Tries the triangles of a pack on a group.
    #[inline(always)]
    fn try_pack<S: Simd, const ANY: bool>(
        &mut self,
        simd: S,
        packet: &Packet,
        group: usize,
        (index, pack): (usize, &Pack),
        (enter, is_entered): (f32x8<S>, <f32x8<S> as SimdBase<S>>::Mask),
        skip: i32x8<S>,
    ) -> bool {
        let rays = packet.sheared(simd, group);
        let [x, y, z] = packet.axes.order;
        let mut is_news = false;
        for lane in 0..pack.count() {
            let [a, b, c] = &pack.corners;
            let corners = [
                splat(simd, [a[x][lane], a[y][lane], a[z][lane]]),
                splat(simd, [b[x][lane], b[y][lane], b[z][lane]]),
                splat(simd, [c[x][lane], c[y][lane], c[z][lane]]),
            ];
            let Some(meeting) = rays.meet(simd, &corners) else { continue };
            let primitive = i32x8::splat(simd, (LANES * index + lane) as i32);
            let (end, t) = (self.t.get(simd, group), meeting.t.max(enter));
            let mut is_met = meeting.is_met & is_entered & t.simd_le(end);
            let range = GROUP * group..GROUP * group + GROUP;
            if ANY {
                is_met &= !primitive.simd_eq(skip);
            } else {
                let best = i32x8::from_slice(simd, &self.primitive[range.clone()]);
                // What was found at the same place stays if its number, as one without sign, is lower
                is_met &= t.simd_lt(end) | primitive.simd_lt(best) | best.simd_lt(0);
            }
            if is_met.all_false() {
                continue;
            }
            is_news = true;
            if ANY {
                self.t.set(group, is_met.select(f32x8::splat(simd, DONE), end));
            } else {
                self.t.set(group, is_met.select(t, end));
                self.v.set(group, is_met.select(meeting.v, self.v.get(simd, group)));
                self.w.set(group, is_met.select(meeting.w, self.w.get(simd, group)));
                let best = i32x8::from_slice(simd, &self.primitive[range.clone()]);
                is_met.select(primitive, best).store_slice(&mut self.primitive[range]);
            }
        }
        is_news
    }

    /// Tries a shape on the rays of some lanes, one by one.
    #[inline(never)]
    fn try_shape<const ANY: bool>(
        &mut self,
        geometry: &Geometry,
        packet: &Packet,
        id: u32,
        first: usize,
        lanes: u64,
        enter: &[f32; RAYS],
    ) -> bool {
        let mut is_news = false;
        for lane in (first..packet.count()).filter(|lane| lanes >> lane & 1 == 1) {
            let hit = geometry.shapes[id as usize].hit(&packet.ray(lane), f64::INFINITY);
            let Some((t, _)) = hit else { continue };
            if ANY {
                is_news = true;
                self.t.0[lane] = DONE;
                continue;
            }
            let mut found = self.found(lane);
            let shape = Found { t: (t as f32).max(enter[lane]), primitive: Geometry::SHAPE | id, v: 0.0, w: 0.0 };
            if found.take(shape) {
                is_news = true;
                self.t.0[lane] = found.t;
                self.primitive[lane] = found.primitive as i32;
            }
        }
        is_news
    }
}

//! One ray through the tree, against the eight boxes of a node at a time.

use fearless_simd::{f32x8, prelude::*};

use super::{Bvh, Child, Slabs, WIDTH, inverse};
use crate::Ray;
use crate::triangle::splat;

/// What looks at the leaves that a ray comes to.
pub(crate) trait Visitor<S: Simd> {
    /// Boxes that are entered farther away are left out.
    fn t_far(&self) -> f32;

    /// Looks at a leaf whose box is entered at `enter`; true ends the walk.
    fn visit(&mut self, simd: S, leaf: usize, enter: f32) -> bool;
}

impl Bvh {
    /// Shows `visitor` every leaf whose box the ray enters before its `t_far`, roughly from near to far.
    #[inline(always)]
    pub(crate) fn walk<S: Simd>(&self, simd: S, ray: &Ray, visitor: &mut impl Visitor<S>) {
        let Some(mut current) = self.root() else { return };
        let [dx, dy, dz] = splat(simd, ray.direction.to_array());
        let slabs = Slabs {
            origin: splat(simd, ray.origin.to_array()),
            inverse: [inverse(simd, dx), inverse(simd, dy), inverse(simd, dz)],
        };
        let mut stack = Stack::default();
        loop {
            // Find the boxes that the ray meets
            let node = self.node(current);
            let [enter, leave] = slabs.cross(simd, load(simd, &node.low), load(simd, &node.high));
            let mut met = (enter.simd_le(leave) & enter.simd_le(visitor.t_far())).to_bitmask();

            // Put them on the stack, the nearest on top
            let bottom = stack.count;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                stack.push_ordered(bottom, Entry { enter: enter[lane], child: node.child(lane) });
            }

            // Look at leaves until there is an inner node
            current = loop {
                let Some(entry) = stack.pop() else { return };
                if entry.enter > visitor.t_far() {
                    continue;
                }
                match entry.child.leaf() {
                    None => break entry.child,
                    Some(leaf) if visitor.visit(simd, leaf, entry.enter) => return,
                    Some(_) => {}
                }
            };
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, [x, y, z]: &[[f32; WIDTH]; 3]) -> [f32x8<S>; 3] {
    [f32x8::load_array_ref(simd, x), f32x8::load_array_ref(simd, y), f32x8::load_array_ref(simd, z)]
}

/// A box to go into.
#[derive(Clone, Copy)]
struct Entry {
    enter: f32,
    child: Child,
}

/// The boxes still to visit. A node leaves at most seven behind, and trees are not deep (`sah::MOST_CUTS`).
struct Stack {
    entries: [Entry; Self::ROOM],
    count: usize,
    spilt: Vec<Entry>,
}

impl Stack {
    const ROOM: usize = 96;

    /// Puts an entry on top of the nearer ones, but not below `bottom`.
    #[inline(always)]
    fn push_ordered(&mut self, bottom: usize, entry: Entry) {
        if self.count == Self::ROOM {
            // Order saves time, no more
            self.spilt.push(entry);
            return;
        }
        let mut at = self.count;
        while at > bottom && self.entries[at - 1].enter < entry.enter {
            self.entries[at] = self.entries[at - 1];
            at -= 1;
        }
        self.entries[at] = entry;
        self.count += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        if let Some(entry) = self.spilt.pop() {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.entries[self.count])
    }
}

impl Default for Stack {
    fn default() -> Self {
        let nothing = Entry { enter: 0.0, child: Child::NONE };
        Self { entries: [nothing; Self::ROOM], count: 0, spilt: Vec::new() }
    }
}

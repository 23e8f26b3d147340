//! A tree of boxes, eight children a node.
//!
//! Built as a binary tree (`sah`), then collapsed: a node with eight boxes side by side tests all of them with one set of
//! vector instructions and visits a quarter of the nodes.
//!
//! **What a ray meets does not depend on how it got there.** A ray enters a box at `enter` and leaves it at `leave`, as
//! [`Slabs`] rounds them; both are monotone, so that a ray that misses a box misses all boxes in it. A leaf belongs to
//! the ray iff `enter <= leave` for its own box; a hit in it counts as if it were not before `enter`, so that to leave
//! out boxes that are entered after the best hit so far leaves out nothing that would win; and of two hits at one place
//! that of the lower number wins. So one ray alone and the same ray in any packet find the same thing, to the bit.

mod beam;
mod sah;
mod slabs;
mod walk;

pub(crate) use beam::Beam;
pub(crate) use sah::Item;
pub(crate) use slabs::{Slabs, inverse};
pub(crate) use walk::Visitor;

use crate::bounds::Bounds;
use sah::Tree;

/// Children of a node.
pub(crate) const WIDTH: usize = 8;
/// Set in a child reference that names a leaf.
const LEAF: u32 = 1 << 31;

/// What a box of a node holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Child(u32);

impl Child {
    const ROOT: Self = Self(0);
    const NONE: Self = Self(u32::MAX);

    /// The leaf's number, if it is one.
    #[inline]
    pub(crate) fn leaf(self) -> Option<usize> {
        (self.0 & LEAF != 0).then_some((self.0 & !LEAF) as usize)
    }
}

/// Eight boxes, `low[axis]` and `high[axis]` of each, and what they hold. Unused lanes hold a point at infinity.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Node {
    pub(crate) low: [[f32; WIDTH]; 3],
    pub(crate) high: [[f32; WIDTH]; 3],
    children: [Child; WIDTH],
}

impl Node {
    const UNUSED: Self =
        Self { low: [[f32::INFINITY; WIDTH]; 3], high: [[f32::INFINITY; WIDTH]; 3], children: [Child::NONE; WIDTH] };

    /// What the box of a lane holds.
    #[inline]
    pub(crate) fn child(&self, lane: usize) -> Child {
        self.children[lane]
    }

    fn put(&mut self, lane: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.low[axis][lane] = bounds.low[axis];
            self.high[axis][lane] = bounds.high[axis];
        }
        self.children[lane] = child;
    }
}

/// The tree; what a leaf means is its owner's business.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
}

impl Bvh {
    /// A tree over items. `add_leaf` is told the items of each leaf, at most `LEAF_SIZE` of which none wants to be
    /// alone, or one that does; it returns the leaf's number, below 2^31.
    pub(crate) fn build(mut items: Vec<Item>, add_leaf: &mut dyn FnMut(&[Item]) -> u32) -> Self {
        let mut tree = Self::default();
        if !items.is_empty() {
            let binary = Tree::build(&mut items);
            tree.nodes.reserve_exact(items.len() / 16 + 1);
            tree.collapse(&binary, &mut |first, count| add_leaf(&items[first..first + count]));
            tree.nodes.shrink_to_fit();
        }
        tree
    }

    /// Copies a binary tree, taking in the largest inner child until a node has eight children; returns its place.
    fn collapse(&mut self, source: &Tree, add_leaf: &mut dyn FnMut(usize, usize) -> u32) -> usize {
        // Choose up to eight descendants
        let mut chosen = vec![source];
        while chosen.len() < WIDTH {
            let area = |i: usize| match chosen[i] {
                Tree::Inner { bounds, .. } => bounds.half_area(),
                Tree::Leaf { .. } => f32::NEG_INFINITY,
            };
            let Some(largest) = (0..chosen.len()).max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
            let Tree::Inner { parts, .. } = chosen[largest] else { break };
            chosen[largest] = &parts[0];
            chosen.push(&parts[1]);
        }
        // Write their boxes, and what is below them
        let place = self.nodes.len();
        self.nodes.push(Node::UNUSED);
        for (lane, tree) in chosen.into_iter().enumerate() {
            let child = match *tree {
                Tree::Leaf { first, count, .. } => Child(LEAF | add_leaf(first, count)),
                Tree::Inner { .. } => Child(self.collapse(tree, add_leaf) as u32),
            };
            self.nodes[place].put(lane, tree.bounds(), child);
        }
        place
    }

    /// The node at the top, unless there is nothing at all.
    #[inline]
    pub(crate) fn root(&self) -> Option<Child> {
        (!self.nodes.is_empty()).then_some(Child::ROOT)
    }

    /// The node that a child reference which is no leaf names.
    #[inline]
    pub(crate) fn node(&self, child: Child) -> &Node {
        &self.nodes[child.0 as usize]
    }

    /// Bytes that it occupies.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
    }
}

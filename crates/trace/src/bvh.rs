//! A tree of boxes, four children a node.
//!
//! Built as a binary tree by PLOC with reinsertion (`obvhs`), then collapsed: a node with four boxes side by side tests
//! all of them with one set of vector instructions and visits a third of the nodes.

use std::ops::ControlFlow;
use std::time::Duration;

use glam::Vec4;
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::Bvh2, bvh2::builder::build_bvh2};

use crate::Ray;

/// Set in a child reference that names a leaf.
const LEAF: u32 = 1 << 31;
/// Bounds that no ray meets stand in the unused lanes.
const NOTHING: Node =
    Node { low: [Vec4::INFINITY; 3], high: [Vec4::NEG_INFINITY; 3], children: [LEAF | (LEAF - 1); 4] };

/// Four boxes, `low[axis]` and `high[axis]` of each, and what they hold.
#[derive(Debug, Clone, Copy)]
struct Node {
    low: [Vec4; 3],
    high: [Vec4; 3],
    children: [u32; 4],
}

/// The tree; what a leaf means is its owner's business.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
}

impl Bvh {
    /// A tree over boxes, and for each of its leaves the boxes in it, at most `leaf_size`.
    pub(crate) fn build(boxes: &[Aabb], leaf_size: u32) -> (Self, Vec<Vec<u32>>) {
        if boxes.is_empty() {
            return (Self::default(), Vec::new());
        }
        let params = BvhBuildParams { max_prims_per_leaf: leaf_size, ..BvhBuildParams::medium_build() };
        let mut build_time = Duration::ZERO;
        let binary = build_bvh2(boxes, params, &mut build_time);
        let mut tree = Self::default();
        let mut leaves = Vec::new();
        tree.collapse(&binary, &mut leaves);
        (tree, leaves)
    }

    /// Copies a binary tree, taking in the largest inner child until a node has four children.
    fn collapse(&mut self, binary: &Bvh2, leaves: &mut Vec<Vec<u32>>) {
        self.nodes.push(NOTHING);
        let mut open = vec![(0_usize, 0_usize)]; // node of ours, node of the binary tree
        while let Some((node, source)) = open.pop() {
            // Choose up to four descendants
            let mut chosen = vec![source];
            while chosen.len() < 4 {
                let area = |&&i: &&usize| binary.nodes[i].aabb.half_area();
                let inner = chosen.iter().filter(|&&i| !binary.nodes[i].is_leaf());
                let Some(&largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
                chosen.retain(|&i| i != largest);
                let first = binary.nodes[largest].first_index as usize;
                chosen.extend([first, first + 1]);
            }
            // Write their boxes, and go on below the inner ones
            for (lane, &i) in chosen.iter().enumerate() {
                let child = &binary.nodes[i];
                for axis in 0..3 {
                    self.nodes[node].low[axis][lane] = child.aabb.min[axis];
                    self.nodes[node].high[axis][lane] = child.aabb.max[axis];
                }
                self.nodes[node].children[lane] = if child.is_leaf() {
                    let first = child.first_index as usize;
                    leaves.push(binary.primitive_indices[first..first + child.prim_count as usize].to_vec());
                    LEAF | (leaves.len() - 1) as u32
                } else {
                    self.nodes.push(NOTHING);
                    open.push((self.nodes.len() - 1, i));
                    (self.nodes.len() - 1) as u32
                };
            }
        }
    }

    /// Shows `visit` every leaf whose box the ray enters before `t_max`, roughly from near to far; what it returns is
    /// the new `t_max`, or the end.
    #[inline]
    pub(crate) fn traverse(
        &self,
        ray: &Ray,
        mut t_max: f32,
        mut visit: impl FnMut(usize, f32) -> ControlFlow<(), f32>,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let slabs = Slabs::new(ray);
        let mut stack = Stack::default();
        let mut current = 0;
        loop {
            // Order the children that the ray enters, farthest on top of the stack last
            let node = &self.nodes[current as usize];
            let (entered, t_enter) = slabs.enter(node, t_max);
            let mut nearest = None;
            if entered != 0 {
                let mut waiting: [(f32, u32); 4] = [(0.0, 0); 4];
                let mut count = 0;
                for lane in 0..4 {
                    if entered >> lane & 1 == 1 {
                        let mut at = count;
                        while at > 0 && waiting[at - 1].0 < t_enter[lane] {
                            waiting[at] = waiting[at - 1];
                            at -= 1;
                        }
                        waiting[at] = (t_enter[lane], node.children[lane]);
                        count += 1;
                    }
                }
                for &entry in &waiting[..count - 1] {
                    stack.push(entry);
                }
                nearest = Some(waiting[count - 1]);
            }

            // Go on with the nearest; visit leaves until there is an inner node
            loop {
                let Some((t, child)) = nearest.take().or_else(|| stack.pop()) else { return };
                if t > t_max {
                    continue;
                }
                if child & LEAF == 0 {
                    current = child;
                    break;
                }
                match visit((child & !LEAF) as usize, t_max) {
                    ControlFlow::Continue(t) => t_max = t,
                    ControlFlow::Break(()) => return,
                }
            }
        }
    }
}

/// A ray prepared for boxes.
struct Slabs {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    backwards: [bool; 3],
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        // A direction of 0 becomes one so small that it stays in its slab, and 0 x inf never arises
        let inverse = ray.direction.to_array().map(|d| 1.0 / if d.abs() < 1e-30 { 1e-30_f32.copysign(d) } else { d });
        Self {
            origin: ray.origin.to_array().map(Vec4::splat),
            inverse: inverse.map(Vec4::splat),
            backwards: inverse.map(|i| i < 0.0),
        }
    }

    /// Which of a node's boxes the ray meets in (0, `t_max`), as bits, and where it enters them.
    #[inline]
    fn enter(&self, node: &Node, t_max: f32) -> (u32, Vec4) {
        // 1 + 2 gamma(3): makes the slab test conservative (Ize, "Robust BVH Ray Traversal", JCGT 2013)
        const WIDEN: f32 = 1.000_000_6;
        let mut enter = Vec4::ZERO;
        let mut leave = Vec4::splat(t_max);
        for axis in 0..3 {
            let (near, far) = if self.backwards[axis] {
                (node.high[axis], node.low[axis])
            } else {
                (node.low[axis], node.high[axis])
            };
            enter = enter.max((near - self.origin[axis]) * self.inverse[axis]);
            leave = leave.min((far - self.origin[axis]) * self.inverse[axis] * WIDEN);
        }
        (enter.cmple(leave).bitmask(), enter)
    }
}

/// The nodes still to visit; deep trees spill to the heap.
struct Stack {
    near: [(f32, u32); 64],
    count: usize,
    spilt: Vec<(f32, u32)>,
}

impl Default for Stack {
    fn default() -> Self {
        Self { near: [(0.0, 0); 64], count: 0, spilt: Vec::new() }
    }
}

impl Stack {
    #[inline]
    fn push(&mut self, entry: (f32, u32)) {
        match self.near.get_mut(self.count) {
            Some(slot) => {
                *slot = entry;
                self.count += 1;
            }
            None => self.spilt.push(entry),
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(f32, u32)> {
        if let Some(entry) = self.spilt.pop() {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.near[self.count])
    }
}

//! A binary tree of boxes by the surface area heuristic, built from the root on all threads.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies" (IEEE RT 2007): centroids are counted in bins
//! along each axis, and the cut between bins with the least expected cost is taken. Minima, maxima and counts do not
//! depend on an order, so that neither does the tree depend on the number of threads.

use glam::Vec3A;
use rayon::prelude::*;

use crate::bounds::Bounds;

/// Bins along an axis.
const BINS: usize = 16;
/// Most items of a leaf.
pub(super) const LEAF_SIZE: usize = 4;
/// Cost of testing a box, over that of a triangle.
const BOX_COST: f32 = 1.2;
/// Levels after which halves are taken whatever the cost, so that no input makes a deep tree.
const MOST_CUTS: u32 = 48;
/// Items from which on the two parts are built at the same time.
const PARALLEL: usize = 2048;
/// Items that one thread counts at a time.
const CHUNK: usize = 1 << 15;

/// Something to be put into the tree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Item {
    pub(crate) bounds: Bounds,
    /// What its owner calls it.
    pub(crate) id: u32,
    /// Whether it wants a leaf of its own.
    pub(crate) alone: bool,
}

impl Item {
    /// Twice the centroid.
    #[inline]
    fn place(&self) -> Vec3A {
        self.bounds.low + self.bounds.high
    }
}

/// A tree over a slice of items.
#[derive(Debug)]
pub(super) enum Tree {
    /// Items `first..first + count` of the sorted slice.
    Leaf {
        bounds: Bounds,
        first: usize,
        count: usize,
    },
    Inner {
        bounds: Bounds,
        parts: Box<[Tree; 2]>,
    },
}

impl Tree {
    pub(super) fn bounds(&self) -> &Bounds {
        match self {
            Self::Leaf { bounds, .. } | Self::Inner { bounds, .. } => bounds,
        }
    }

    /// A tree over at least one item; sorts them.
    pub(super) fn build(items: &mut [Item]) -> Self {
        Self::grow(items, 0, 0)
    }

    fn grow(items: &mut [Item], first: usize, cuts: u32) -> Self {
        let count = items.len();
        let [bounds, places] = extent(items);
        if count == 1 {
            return Self::Leaf { bounds, first, count };
        }
        // Cut where it costs least; in halves where nothing tells the items apart, or the tree gets deep
        let is_leaf = count <= LEAF_SIZE && items.iter().all(|item| !item.alone);
        let cut = if cuts < MOST_CUTS { Cut::best(items, &places) } else { None };
        if is_leaf && cut.is_none_or(|cut| bounds.half_area() * (count as f32 - BOX_COST) <= cut.cost) {
            return Self::Leaf { bounds, first, count };
        }
        let middle = match cut {
            Some(cut) => partition(items, |item| cut.bin(item) <= cut.last),
            None => count / 2,
        };
        let (left, right) = items.split_at_mut(middle);
        let mut grow_left = || Self::grow(left, first, cuts + 1);
        let mut grow_right = || Self::grow(right, first + middle, cuts + 1);
        let (left, right) =
            if count < PARALLEL { (grow_left(), grow_right()) } else { rayon::join(grow_left, grow_right) };
        Self::Inner { bounds, parts: Box::new([left, right]) }
    }
}

/// The box around all items, and the box around their places.
fn extent(items: &[Item]) -> [Bounds; 2] {
    let of = |items: &[Item]| {
        items.iter().fold([Bounds::EMPTY; 2], |[mut bounds, mut places], item| {
            bounds.join(&item.bounds);
            places.include(item.place());
            [bounds, places]
        })
    };
    let join = |mut a: [Bounds; 2], b: [Bounds; 2]| {
        a.iter_mut().zip(&b).for_each(|(a, b)| a.join(b));
        a
    };
    if items.len() <= CHUNK {
        return of(items);
    }
    items.par_chunks(CHUNK).map(of).reduce(|| [Bounds::EMPTY; 2], join)
}

/// A plane between two bins.
#[derive(Debug, Clone, Copy)]
struct Cut {
    axis: usize,
    /// Place of the first bin, and bins per unit.
    start: f32,
    scale: f32,
    /// The last bin on the near side.
    last: usize,
    /// Area times number of items, summed over both sides.
    cost: f32,
}

/// Items of a bin.
type Bin = (Bounds, u32);

impl Cut {
    #[inline]
    fn bin(&self, item: &Item) -> usize {
        (((item.place()[self.axis] - self.start) * self.scale) as usize).min(BINS - 1)
    }

    /// The cheapest cut with items on both sides.
    fn best(items: &[Item], places: &Bounds) -> Option<Self> {
        let scale = Vec3A::splat(BINS as f32) / (places.high - places.low);
        let bins = count(items, places.low, scale);
        let mut best: Option<Self> = None;
        for axis in 0..3 {
            if !scale[axis].is_finite() {
                continue;
            }
            // Sweep from the far end, then from the near end
            let mut far = [(0.0, 0); BINS];
            let (mut bounds, mut number) = (Bounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                bounds.join(&bins[axis][bin].0);
                number += bins[axis][bin].1;
                far[bin] = (bounds.half_area(), number);
            }
            (bounds, number) = (Bounds::EMPTY, 0);
            for last in 0..BINS - 1 {
                bounds.join(&bins[axis][last].0);
                number += bins[axis][last].1;
                let (far_area, far_number) = far[last + 1];
                let cost = bounds.half_area() * number as f32 + far_area * far_number as f32;
                if number > 0 && far_number > 0 && best.is_none_or(|best| cost < best.cost) {
                    best = Some(Self { axis, start: places.low[axis], scale: scale[axis], last, cost });
                }
            }
        }
        best
    }
}

/// Counts items in the bins of each axis.
fn count(items: &[Item], start: Vec3A, scale: Vec3A) -> [[Bin; BINS]; 3] {
    let empty = || [[(Bounds::EMPTY, 0); BINS]; 3];
    let of = |items: &[Item]| {
        let mut bins = empty();
        for item in items {
            let place = (item.place() - start) * scale;
            for (axis, bins) in bins.iter_mut().enumerate() {
                let (bounds, number) = &mut bins[(place[axis] as usize).min(BINS - 1)];
                bounds.join(&item.bounds);
                *number += 1;
            }
        }
        bins
    };
    if items.len() <= CHUNK {
        return of(items);
    }
    items.par_chunks(CHUNK).map(of).reduce(empty, |mut a, b| {
        for ((bounds, number), (more, count)) in a.iter_mut().flatten().zip(b.iter().flatten()) {
            bounds.join(more);
            *number += count;
        }
        a
    })
}

/// Moves what belongs to the near side to the front, and says how many.
fn partition(items: &mut [Item], is_near: impl Fn(&Item) -> bool) -> usize {
    let (mut near, mut end) = (0, items.len());
    while near < end {
        if is_near(&items[near]) {
            near += 1;
        } else {
            end -= 1;
            items.swap(near, end);
        }
    }
    near
}

//! Surfaces merged into ever larger squares, so that a large blur needs no more neighbours than a small one.
//!
//! Every square of 16x16 pixels holds trees: the leaves are the pixels' own pieces of surface, a branch stands for pieces
//! in a square of 2, 4, 8 or 16 pixels whose blur differs little: their mean place, depth and slope, the sum of their
//! cover and colour. A square in which a near and a far surface meet holds a branch for each. Squares are anchored at
//! pixel (0, 0), so that a part of a frame has the same trees as the whole.

use rayon::prelude::*;
use rgbd::PixelWindow;

use crate::{fragment::Fragment, prepare::Prepared, surface::Surface};

/// Side of the squares that hold trees, in pixels.
pub(crate) const SQUARE: i32 = 16;

/// Pieces are merged if their blur radii differ by at most this, in sides of the square.
const MERGED_SPREAD: f32 = 0.25;

/// A piece of surface, of one pixel or merged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    /// Centre of what it covers, in pixels; a pixel's centre is a whole number.
    pub(crate) x: f32,
    pub(crate) y: f32,
    /// Side of its square in pixels.
    pub(crate) size: f32,
    pub(crate) inverse_depth: f32,
    /// Smallest and largest inverse depth that were merged.
    pub(crate) range: [f32; 2],
    pub(crate) slope: [f32; 2],
    /// Sum over pixels of what it fills of them.
    pub(crate) cover: f32,
    /// Sum over pixels of colour premultiplied with the cover.
    pub(crate) rgba: [f32; 4],
    /// Mean over the cover of how far the colour may be off.
    pub(crate) doubt: f32,
    /// Where its parts stand in the list of its square, and how many there are; none for a pixel's own.
    parts: (u32, u32),
}

/// The trees of one square.
#[derive(Debug, Default)]
struct Trees {
    /// Merged pieces.
    branches: Vec<Piece>,
    /// Parts of the branches: a branch of this square, or with [`LEAF`] a leaf of the forest.
    parts: Vec<u32>,
    /// The pieces that are part of no other.
    roots: (u32, u32),
    /// Smallest and largest inverse depth.
    range: [f32; 2],
}

const LEAF: u32 = 1 << 31;

/// All trees of a view.
pub(crate) struct Forest {
    prepared: Prepared,
    /// First square's column and row, in squares, and their number.
    first: (i32, i32),
    columns: i32,
    rows: i32,
    trees: Vec<Trees>,
    range: [f32; 2],
}

impl Forest {
    /// Grows the trees; `px` is the blur radius in pixels of a unit of inverse depth. `levels` is how often squares are
    /// doubled, at most 4; 0 merges nothing.
    pub(crate) fn new(prepared: Prepared, px: f32, levels: u32) -> Self {
        let window = prepared.window();
        let first = (window.x.div_euclid(SQUARE), window.y.div_euclid(SQUARE));
        let last = ((window.x_end() - 1).div_euclid(SQUARE), (window.y_end() - 1).div_euclid(SQUARE));
        let (columns, rows) = (last.0 - first.0 + 1, last.1 - first.1 + 1);
        let row_starts = row_starts(window, &prepared.fragments);
        let square = |i: i32| (first.0 + i % columns, first.1 + i / columns);
        let grower = Grower { prepared: &prepared, row_starts: &row_starts, px };
        let trees: Vec<Trees> = (0..columns * rows)
            .into_par_iter()
            .map_init(Vec::new, |items, i| grower.grow(square(i), levels, items))
            .collect();
        let range = trees.iter().fold(EMPTY, |range, trees| joined(range, trees.range));
        Self { prepared, first, columns, rows, trees, range }
    }

    /// The surfaces it was grown from.
    pub(crate) fn first_surface(&self) -> &Surface {
        &self.prepared.first
    }

    /// Calls `take` for pieces that together are everything that may touch `tile`, each piece once.
    ///
    /// `reach` tells how many pixels a range of inverse depth reaches at most, `serves` whether a merged piece may stand
    /// for its parts.
    pub(crate) fn visit(
        &self,
        tile: PixelWindow,
        reach: &impl Fn([f32; 2]) -> f32,
        serves: &impl Fn(&Piece) -> bool,
        take: &mut impl FnMut(&Piece),
    ) {
        let margin = reach(self.range).min(1e6) as i32 + SQUARE;
        let column = |x: i32| (x.div_euclid(SQUARE) - self.first.0).clamp(0, self.columns - 1);
        let row = |y: i32| (y.div_euclid(SQUARE) - self.first.1).clamp(0, self.rows - 1);
        let center =
            [tile.x as f32 + 0.5 * (tile.width as f32 - 1.0), tile.y as f32 + 0.5 * (tile.height as f32 - 1.0)];
        let half = [0.5 * (tile.width as f32 - 1.0), 0.5 * (tile.height as f32 - 1.0)];
        let touches = |x: f32, y: f32, size: f32, range: [f32; 2]| {
            let reach = reach(range) + size;
            let gap = [(x - center[0]).abs() - half[0], (y - center[1]).abs() - half[1]].map(|gap| gap.max(0.0));
            gap[0] * gap[0] + gap[1] * gap[1] <= reach * reach
        };
        let mut stack: Vec<u32> = Vec::new();
        for j in row(tile.y - margin)..=row(tile.y_end() + margin) {
            for i in column(tile.x - margin)..=column(tile.x_end() + margin) {
                let trees = &self.trees[(j * self.columns + i) as usize];
                let middle = |k: i32| ((k * SQUARE) as f32) + 0.5 * (SQUARE as f32 - 1.0);
                let (x, y) = (middle(self.first.0 + i), middle(self.first.1 + j));
                if trees.roots.1 == 0 || !touches(x, y, 0.75 * SQUARE as f32, trees.range) {
                    continue;
                }
                let parts = |(start, count): (u32, u32)| &trees.parts[start as usize..(start + count) as usize];
                stack.clear();
                stack.extend(parts(trees.roots).iter().rev());
                while let Some(part) = stack.pop() {
                    if part & LEAF != 0 {
                        let piece = self.prepared.leaf(part & !LEAF);
                        if touches(piece.x, piece.y, 0.0, piece.range) {
                            take(&piece);
                        }
                        continue;
                    }
                    let piece = &trees.branches[part as usize];
                    if !touches(piece.x, piece.y, piece.size, piece.range) {
                        continue;
                    }
                    if serves(piece) {
                        take(piece);
                    } else {
                        stack.extend(parts(piece.parts).iter().rev());
                    }
                }
            }
        }
    }
}

const EMPTY: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

fn joined(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Where each row's fragments start, and where the last row's end.
fn row_starts(window: PixelWindow, fragments: &[Fragment]) -> Vec<usize> {
    let row_start = |row: usize| fragments.partition_point(|f| (f.index as usize) < row * window.width as usize);
    (0..=window.height as usize).map(row_start).collect()
}

impl Prepared {
    /// A leaf: the first layer's pixels come first, then the fragments.
    fn leaf(&self, i: u32) -> Piece {
        let window = self.window();
        let count = window.area() as u32;
        let at = |i: u32| ((i % window.width) as i32 + window.x, (i / window.width) as i32 + window.y);
        if i < count {
            let (first, (x, y)) = (&self.first, at(i));
            let i = i as usize;
            let s = first.inverse_depth[i];
            let (x, y) = (x as f32, y as f32);
            let (slope, cover, rgba) = (first.slope[i], first.cover[i], first.rgba[i]);
            Piece { x, y, size: 1.0, inverse_depth: s, range: [s; 2], slope, cover, rgba, doubt: 0.0, parts: (0, 0) }
        } else {
            self.fragment(&self.fragments[(i - count) as usize])
        }
    }

    fn fragment(&self, fragment: &Fragment) -> Piece {
        let window = self.window();
        let s = fragment.inverse_depth;
        Piece {
            x: ((fragment.index % window.width) as i32 + window.x) as f32,
            y: ((fragment.index / window.width) as i32 + window.y) as f32,
            size: 1.0,
            inverse_depth: s,
            range: [s; 2],
            slope: fragment.slope,
            cover: fragment.cover,
            rgba: fragment.rgba,
            doubt: fragment.doubt,
            parts: (0, 0),
        }
    }
}

/// A piece on its way up a tree, and what it is called as a part.
type Item = (Piece, u32);

struct Grower<'a> {
    prepared: &'a Prepared,
    row_starts: &'a [usize],
    px: f32,
}

impl Grower<'_> {
    /// The trees of a square.
    fn grow(&self, (column, row): (i32, i32), levels: u32, items: &mut Vec<Item>) -> Trees {
        let window = self.prepared.window();
        let corner = (column * SQUARE, row * SQUARE);
        let mut trees = Trees { range: EMPTY, ..Trees::default() };

        // Take the leaves in an order in which those of each square of 2, 4, ... pixels lie together
        items.clear();
        let area = window.area() as u32;
        let mut starts = [0; (SQUARE * SQUARE) as usize + 1];
        let mut cursors = [0; SQUARE as usize];
        for (row, cursor) in cursors.iter_mut().enumerate() {
            let y = corner.1 + row as i32;
            if (window.y..window.y_end()).contains(&y) {
                let of_row = (y - window.y) as usize;
                let fragments = &self.prepared.fragments[self.row_starts[of_row]..self.row_starts[of_row + 1]];
                let from = window.index(corner.0.max(window.x), y) as u32;
                *cursor = self.row_starts[of_row] + fragments.partition_point(|f| f.index < from);
            }
        }
        for z in 0..(SQUARE * SQUARE) as usize {
            let (dx, dy) = from_z_order(z as i32);
            let (x, y) = (corner.0 + dx, corner.1 + dy);
            if window.contains(x, y) {
                let i = window.index(x, y) as u32;
                if self.prepared.first.cover[i as usize] > 0.0 {
                    items.push((self.prepared.leaf(i), i | LEAF));
                }
                let cursor = &mut cursors[dy as usize];
                while let Some(fragment) = self.prepared.fragments.get(*cursor).filter(|f| f.index == i) {
                    let leaf = area + *cursor as u32;
                    items.push((self.prepared.fragment(fragment), leaf | LEAF));
                    *cursor += 1;
                }
            }
            starts[z + 1] = items.len();
        }

        // Merge four squares into one, level by level; what is merged takes the place of its parts
        let mut squares = (SQUARE * SQUARE) as usize;
        for level in 1..=levels {
            let size = (1 << level) as f32;
            squares /= 4;
            let mut end = 0;
            for square in 0..squares {
                let (from, to) = (starts[4 * square], starts[4 * square + 4]);
                let count = self.merge(&mut items[from..to], size, &mut trees);
                items.copy_within(from..from + count, end);
                starts[square] = end;
                end += count;
            }
            starts[squares] = end;
            items.truncate(end);
        }
        trees.range = items.iter().fold(EMPTY, |range, (piece, _)| joined(range, piece.range));
        trees.roots = (trees.parts.len() as u32, items.len() as u32);
        trees.parts.extend(items.iter().map(|&(_, name)| name));
        trees
    }

    /// Merges the pieces of a square of `size` pixels whose blur is alike; those that are left come first, and their
    /// number is returned.
    fn merge(&self, items: &mut [Item], size: f32, trees: &mut Trees) -> usize {
        if items.len() < 2 {
            return items.len();
        }
        let spread = MERGED_SPREAD * size / self.px.max(f32::MIN_POSITIVE);
        let range = items.iter().fold(EMPTY, |range, (piece, _)| joined(range, piece.range));
        if range[1] - range[0] <= spread {
            items[0] = branch(items, size, trees);
            return 1;
        }
        items.sort_by(|a, b| b.0.inverse_depth.total_cmp(&a.0.inverse_depth));
        let (mut count, mut start) = (0, 0);
        while start < items.len() {
            // Take nearest first what lies within the spread
            let mut range = items[start].0.range;
            let mut end = start + 1;
            while end < items.len() {
                let wider = joined(range, items[end].0.range);
                if wider[1] - wider[0] > spread {
                    break;
                }
                range = wider;
                end += 1;
            }
            items[count] = branch(&items[start..end], size, trees);
            count += 1;
            start = end;
        }
        count
    }
}

/// A branch of several items; a single one is left as it is.
fn branch(items: &[Item], size: f32, trees: &mut Trees) -> Item {
    if let [item] = items {
        return *item;
    }
    let mut sum = Piece { size, range: EMPTY, parts: (trees.parts.len() as u32, items.len() as u32), ..NOTHING };
    for (piece, name) in items {
        let cover = piece.cover;
        sum.x += cover * piece.x;
        sum.y += cover * piece.y;
        sum.inverse_depth += cover * piece.inverse_depth;
        sum.slope = [sum.slope[0] + cover * piece.slope[0], sum.slope[1] + cover * piece.slope[1]];
        sum.rgba.iter_mut().zip(piece.rgba).for_each(|(sum, c)| *sum += c);
        sum.doubt += cover * piece.doubt;
        sum.cover += cover;
        sum.range = joined(sum.range, piece.range);
        trees.parts.push(*name);
    }
    let share = 1.0 / sum.cover;
    for value in [&mut sum.x, &mut sum.y, &mut sum.inverse_depth, &mut sum.doubt] {
        *value *= share;
    }
    sum.slope = sum.slope.map(|s| s * share);
    let name = trees.branches.len() as u32;
    trees.branches.push(sum);
    (sum, name)
}

const NOTHING: Piece = Piece {
    x: 0.0,
    y: 0.0,
    size: 1.0,
    inverse_depth: 0.0,
    range: EMPTY,
    slope: [0.0; 2],
    cover: 0.0,
    rgba: [0.0; 4],
    doubt: 0.0,
    parts: (0, 0),
};

/// The pixel at a place of the order in which the pixels of each square of 2, 4 and 8 lie together.
fn from_z_order(z: i32) -> (i32, i32) {
    let of_bits = |z: i32| (0..4).map(|bit| ((z >> (2 * bit)) & 1) << bit).sum();
    (of_bits(z), of_bits(z >> 1))
}

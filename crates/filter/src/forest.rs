//! Surfaces merged into ever larger squares, so that a large blur needs no more neighbours than a small one.
//!
//! Every square of 16x16 pixels holds trees: the leaves are the pixels' own pieces of surface, a branch stands for pieces
//! in a square of 2, 4, 8 or 16 pixels whose blur differs little: their mean place, depth and slope, the sum of their
//! cover and colour. A square in which a near and a far surface meet holds a branch for each. Squares are anchored at
//! pixel (0, 0), so that a part of a frame has the same trees as the whole.

use std::sync::OnceLock;

use rgbd::PixelWindow;

use crate::{
    cells::{EMPTY, Range, SQUARE, joined},
    fragment::Fragment,
    prepare::Prepared,
};

/// Pieces are merged if their blur radii differ by at most this, in sides of the square.
const MERGED_SPREAD: f32 = 0.125;

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
    pub(crate) range: Range,
    pub(crate) slope: [f32; 2],
    /// Sum over pixels of what it fills of them.
    pub(crate) cover: f32,
    /// Sum over pixels of colour premultiplied with the cover.
    pub(crate) rgba: [f32; 4],
    /// Mean over the cover of how far the colour may be off.
    pub(crate) doubt: f32,
    /// Whether all of it belongs to the first surface.
    pub(crate) is_first: bool,
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
}

const LEAF: u32 = 1 << 31;

/// All trees of a view.
pub(crate) struct Forest<'a> {
    prepared: &'a Prepared,
    row_starts: Vec<usize>,
    /// Grown when a tile asks for them; what each square holds at most is known before.
    trees: Vec<OnceLock<Trees>>,
    ranges: Vec<Range>,
    range: Range,
    px: f32,
    levels: u32,
}

impl<'a> Forest<'a> {
    /// Prepares the trees; `px` is the blur radius in pixels of a unit of inverse depth. `levels` is how often squares are
    /// doubled, at most 4; 0 merges nothing.
    pub(crate) fn new(prepared: &'a Prepared, px: f32, levels: u32) -> Self {
        let row_starts = row_starts(prepared.window(), &prepared.fragments);
        let mut ranges = prepared.cells.square_ranges.clone();
        for fragment in &prepared.fragments {
            let (x, y) = prepared.place(fragment.index);
            let range = &mut ranges[prepared.cells.squares.index(x, y)];
            *range = joined(*range, [fragment.inverse_depth; 2]);
        }
        let range = ranges.iter().fold(EMPTY, |all, &range| joined(all, range));
        let trees = ranges.iter().map(|_| OnceLock::new()).collect();
        Self { prepared, row_starts, trees, ranges, range, px, levels }
    }

    /// The trees of a square.
    fn trees(&self, square: usize) -> &Trees {
        self.trees[square].get_or_init(|| {
            let grower = Grower { prepared: self.prepared, row_starts: &self.row_starts, px: self.px };
            grower.grow(self.prepared.cells.squares.corner(square), self.levels, &mut Vec::new())
        })
    }

    /// Calls `take` for pieces that together are everything that may touch `tile`, each piece once.
    ///
    /// `reach` tells how many pixels a range of inverse depth reaches at most, `serves` whether a merged piece may stand
    /// for its parts, `merges` whether one within a range may at all.
    #[inline(always)]
    pub(crate) fn visit(
        &self,
        tile: PixelWindow,
        reach: &impl Fn(Range) -> f32,
        serves: &impl Fn(&Piece) -> bool,
        merges: &impl Fn(Range) -> bool,
        take: &mut impl FnMut(&Piece),
    ) {
        let squares = self.prepared.cells.squares;
        let half = [tile.width, tile.height].map(|side| 0.5 * (side as f32 - 1.0));
        let center = [tile.x as f32 + half[0], tile.y as f32 + half[1]];
        let touches = |x: f32, y: f32, size: f32, range: Range| {
            let reach = reach(range) + size;
            let gap = [(x - center[0]).abs() - half[0], (y - center[1]).abs() - half[1]].map(|gap| gap.max(0.0));
            gap[0] * gap[0] + gap[1] * gap[1] <= reach * reach
        };
        let mut stack: Vec<u32> = Vec::new();
        for square in squares.around(tile, reach(self.range).min(1e6) as i32 + SQUARE) {
            let (x, y) = squares.corner(square);
            let middle = |start: i32| start as f32 + 0.5 * (SQUARE as f32 - 1.0);
            let range = self.ranges[square];
            if !touches(middle(x), middle(y), 0.75 * SQUARE as f32, range) {
                continue;
            }
            if self.levels == 0 || !merges(range) {
                self.visit_leaves((x, y), |x, y, s| touches(x, y, 0.0, [s; 2]), take);
                continue;
            }
            let trees = self.trees(square);
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

    /// Calls `look` for the range of each square that may touch `tile`.
    pub(crate) fn ranges_around(&self, tile: PixelWindow, reach: &impl Fn(Range) -> f32, mut look: impl FnMut(Range)) {
        let squares = self.prepared.cells.squares;
        for square in squares.around(tile, reach(self.range).min(1e6) as i32) {
            let reach = reach(self.ranges[square]);
            if squares.squared_gap(square, tile) <= reach * reach {
                look(self.ranges[square]);
            }
        }
    }

    /// The pieces of the square whose first pixel is `corner`, row by row, without those of which the place and the inverse
    /// depth touch nothing.
    #[inline(always)]
    fn visit_leaves(&self, corner: (i32, i32), touches: impl Fn(f32, f32, f32) -> bool, take: &mut impl FnMut(&Piece)) {
        let (window, first) = (self.prepared.window(), &self.prepared.first);
        let columns = corner.0.max(window.x)..(corner.0 + SQUARE).min(window.x_end());
        for y in corner.1.max(window.y)..(corner.1 + SQUARE).min(window.y_end()) {
            let row = (y - window.y) as usize;
            let fragments = &self.prepared.fragments[self.row_starts[row]..self.row_starts[row + 1]];
            let from = window.index(columns.start, y);
            let mut next = fragments.partition_point(|f| (f.index as usize) < from);
            for (i, x) in (from..).zip(columns.clone()) {
                let touches = |s: f32| touches(x as f32, y as f32, s);
                if first.cover[i] > 0.0 && touches(first.inverse_depth[i]) {
                    take(&self.prepared.first_leaf(i, (x, y)));
                }
                while let Some(fragment) = fragments.get(next).filter(|f| f.index as usize == i) {
                    if touches(fragment.inverse_depth) {
                        take(&self.prepared.fragment(fragment));
                    }
                    next += 1;
                }
            }
        }
    }
}

/// Where each row's fragments start, and where the last row's end.
fn row_starts(window: PixelWindow, fragments: &[Fragment]) -> Vec<usize> {
    let row_start = |row: usize| fragments.partition_point(|f| (f.index as usize) < row * window.width as usize);
    (0..=window.height as usize).map(row_start).collect()
}

impl Prepared {
    /// The pixel at a row-major index.
    fn place(&self, i: u32) -> (i32, i32) {
        let window = self.window();
        ((i % window.width) as i32 + window.x, (i / window.width) as i32 + window.y)
    }

    /// A leaf: the first layer's pixels come first, then the fragments.
    fn leaf(&self, i: u32) -> Piece {
        let window = self.window();
        let count = window.area() as u32;
        if i < count {
            self.first_leaf(i as usize, self.place(i))
        } else {
            self.fragment(&self.fragments[(i - count) as usize])
        }
    }

    /// The first layer's pixel at a row-major index and a place.
    #[inline(always)]
    fn first_leaf(&self, i: usize, (x, y): (i32, i32)) -> Piece {
        let first = &self.first;
        let s = first.inverse_depth[i];
        Piece {
            x: x as f32,
            y: y as f32,
            inverse_depth: s,
            range: [s; 2],
            slope: first.slope(i, (x - first.window.x) as usize),
            cover: first.cover[i],
            rgba: first.rgba[i],
            doubt: first.doubt[i],
            ..NOTHING
        }
    }

    fn fragment(&self, fragment: &Fragment) -> Piece {
        let s = fragment.inverse_depth;
        let (x, y) = self.place(fragment.index);
        Piece {
            x: x as f32,
            y: y as f32,
            inverse_depth: s,
            range: [s; 2],
            slope: fragment.slope,
            cover: fragment.cover,
            rgba: fragment.rgba,
            doubt: fragment.doubt,
            is_first: false,
            ..NOTHING
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
    /// The trees of the square whose first pixel is `corner`.
    fn grow(&self, corner: (i32, i32), levels: u32, items: &mut Vec<Item>) -> Trees {
        let window = self.prepared.window();
        let mut trees = Trees::default();

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
                    items.push((self.prepared.first_leaf(i as usize, (x, y)), i | LEAF));
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
        sum.is_first &= piece.is_first;
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
    is_first: true,
    parts: (0, 0),
};

/// The pixel at a place of the order in which the pixels of each square of 2, 4 and 8 lie together.
fn from_z_order(z: i32) -> (i32, i32) {
    let of_bits = |z: i32| (0..4).map(|bit| ((z >> (2 * bit)) & 1) << bit).sum();
    (of_bits(z), of_bits(z >> 1))
}

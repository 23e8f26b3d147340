//! Which blocks of pixels see nothing but one continuous surface.
//!
//! Where no edge is in reach of the blur there is nothing to hide and nothing to guess: a gather there is a plain sum, and
//! most pixels of most pictures lie there. The first surface is looked at in cells of 4x4 pixels: where inverse depth
//! steps between neighbouring pixels, the cell has an edge, and every block of 8x8 pixels from which some lens point may
//! see that edge is marked.

use rayon::prelude::*;
use rgbd::{PixelWindow, Rest};

use crate::surface::{Surface, rest_at};

/// Side of a cell in pixels. Cells, blocks and squares are anchored at pixel (0, 0).
const CELL: i32 = 4;

/// Side of a block that either sees an edge or does not, in pixels.
pub(crate) const BLOCK: i32 = 8;

/// Side of a square of which the range of depth is known, in pixels.
pub(crate) const SQUARE: i32 = 16;

/// The corners of a tile's blocks.
pub(crate) fn blocks_of(tile: PixelWindow) -> impl Iterator<Item = (i32, i32)> {
    let starts = |from: i32, end: i32| (from..end).step_by(BLOCK as usize);
    starts(tile.y, tile.y_end()).flat_map(move |y| starts(tile.x, tile.x_end()).map(move |x| (x, y)))
}

/// Smallest and largest inverse depth.
pub(crate) type Range = [f32; 2];

/// The range of nothing.
pub(crate) const EMPTY: Range = [f32::INFINITY, f32::NEG_INFINITY];

/// The range of both.
#[inline(always)]
pub(crate) fn joined(a: Range, b: Range) -> Range {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// A grid of squares over a window.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Side of a square in pixels.
    side: i32,
    /// Column and row of the first square, in squares.
    first: (i32, i32),
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Grid {
    pub(crate) fn new(window: PixelWindow, side: i32) -> Self {
        let first = (window.x.div_euclid(side), window.y.div_euclid(side));
        let last = ((window.x_end() - 1).div_euclid(side), (window.y_end() - 1).div_euclid(side));
        Self { side, first, columns: (last.0 - first.0 + 1) as usize, rows: (last.1 - first.1 + 1) as usize }
    }

    fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// The first pixel of a square.
    pub(crate) fn corner(&self, index: usize) -> (i32, i32) {
        let (column, row) = ((index % self.columns) as i32, (index / self.columns) as i32);
        ((self.first.0 + column) * self.side, (self.first.1 + row) * self.side)
    }

    /// The square that holds a pixel of the window.
    pub(crate) fn index(&self, x: i32, y: i32) -> usize {
        let (column, row) = (x.div_euclid(self.side) - self.first.0, y.div_euclid(self.side) - self.first.1);
        row as usize * self.columns + column as usize
    }

    /// The square of the gap between a square and a window, in pixels.
    pub(crate) fn squared_gap(&self, index: usize, window: PixelWindow) -> f32 {
        let (x, y) = self.corner(index);
        let gap = |at: i32, start: i32, end: i32| (start - (at + self.side)).max(at - end).max(0) as f32;
        let (across, down) = (gap(x, window.x, window.x_end()), gap(y, window.y, window.y_end()));
        across * across + down * down
    }

    /// The squares that lie within `margin` pixels of a window along both axes, row by row.
    pub(crate) fn around(&self, window: PixelWindow, margin: i32) -> impl Iterator<Item = usize> + use<> {
        let clamped = |at: i32, first: i32, count: usize| (at.div_euclid(self.side) - first).clamp(0, count as i32 - 1);
        let column = |x: i32| clamped(x, self.first.0, self.columns) as usize;
        let row = |y: i32| clamped(y, self.first.1, self.rows) as usize;
        let (left, right) = (column(window.x - margin), column(window.x_end() + margin));
        let (top, bottom) = (row(window.y - margin), row(window.y_end() + margin));
        let columns = self.columns;
        (top..=bottom).flat_map(move |j| (left..=right).map(move |i| j * columns + i))
    }
}

/// The cells of a surface.
pub(crate) struct Cells {
    window: PixelWindow,
    cells: Grid,
    /// Range of each cell's pixels and the pixels beside them.
    ranges: Vec<Range>,
    has_edge: Vec<bool>,
    /// The same ranges over squares.
    pub(crate) squares: Grid,
    pub(crate) square_ranges: Vec<Range>,
}

impl Cells {
    /// The cells of a surface. A step counts as an edge if three neighbouring pixels, or a pixel and its rest, differ by more
    /// than `jump` in inverse depth.
    pub(crate) fn new(surface: &Surface, rest: Option<Rest>, jump: f32) -> Self {
        let window = surface.window;
        let (cells, squares) = (Grid::new(window, CELL), Grid::new(window, SQUARE));
        let mut ranges = vec![EMPTY; cells.len()];
        let mut has_edge = vec![false; cells.len()];
        let rows = ranges.par_chunks_mut(cells.columns).zip(has_edge.par_chunks_mut(cells.columns)).enumerate();
        rows.for_each_init(
            || Line::new(window),
            |line, (row, (ranges, has_edge))| {
                line.look(&surface.inverse_depth, window, (cells.first.1 + row as i32) * CELL);
                line.reduce(window, cells.first.0, jump, ranges, has_edge);
            },
        );
        if let Some(rest) = rest {
            for (x, y) in window.pixels() {
                let Some((inverse, _)) = rest_at(rest, x, y) else { continue };
                if (inverse - surface.inverse_depth[window.index(x, y)]).abs() > jump {
                    let cell = cells.index(x, y);
                    has_edge[cell] = true;
                    ranges[cell] = joined(ranges[cell], [inverse; 2]);
                }
            }
        }
        let mut square_ranges = vec![EMPTY; squares.len()];
        for (i, &range) in ranges.iter().enumerate() {
            let (x, y) = cells.corner(i);
            let square = &mut square_ranges[squares.index(x, y)];
            *square = joined(*square, range);
        }
        Self { window, cells, ranges, has_edge, squares, square_ranges }
    }

    /// The same edges, with the ranges of a surface that was changed.
    pub(crate) fn with_ranges_of(self, surface: &Surface) -> Self {
        Self { has_edge: self.has_edge, ..Self::new(surface, None, f32::INFINITY) }
    }

    /// Whether there is an edge in the cell of each pixel of a row; called for each cell: its columns in the window.
    pub(crate) fn edges_of_row(&self, row: usize) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let y = self.window.y + row as i32;
        let start = self.cells.index(self.window.x, y);
        let with_edge = (start..start + self.cells.columns).filter(|&i| self.has_edge[i]);
        with_edge.map(|i| {
            let column = |x: i32| (x.clamp(self.window.x, self.window.x_end()) - self.window.x) as usize;
            let (x, _) = self.cells.corner(i);
            column(x)..column(x + CELL)
        })
    }

    /// The blocks from which an edge is seen; `reach` tells from how far, in pixels, an edge with a range of inverse depth
    /// at a place is seen at most.
    pub(crate) fn in_sight(&self, reach: impl Fn(Range, f32, f32) -> f32) -> InSight {
        // Each edge marks a span of blocks in every row; a span is a start and an end
        let blocks = Grid::new(self.window, BLOCK);
        let mut steps = vec![0_i32; (blocks.columns + 1) * blocks.rows];
        for i in (0..self.cells.len()).filter(|&i| self.has_edge[i]) {
            let (x, y) = self.cells.corner(i);
            let middle = 0.5 * (CELL - 1) as f32;
            let reach = reach(self.ranges[i], x as f32 + middle, y as f32 + middle);
            let far = reach.min(1e6) as i32 + 1;
            let row = |y: i32| (y.div_euclid(BLOCK) - blocks.first.1).clamp(0, blocks.rows as i32 - 1);
            let column = |x: i32| (x.div_euclid(BLOCK) - blocks.first.0).clamp(0, blocks.columns as i32 - 1) as usize;
            for row in row(y - far)..=row(y + CELL + far) {
                let top = (blocks.first.1 + row) * BLOCK;
                let gap = (top - (y + CELL)).max(y - (top + BLOCK)).max(0) as f32;
                if gap <= reach {
                    let wide = (reach * reach - gap * gap).sqrt().min(1e6) as i32 + 1;
                    let row = &mut steps[row as usize * (blocks.columns + 1)..][..=blocks.columns];
                    row[column(x - wide)] += 1;
                    row[column(x + CELL - 1 + wide) + 1] -= 1;
                }
            }
        }
        let mut sees_edge = Vec::with_capacity(blocks.len());
        for row in steps.chunks(blocks.columns + 1) {
            let mut spans = 0;
            sees_edge.extend(row[..blocks.columns].iter().map(|step| {
                spans += step;
                spans > 0
            }));
        }
        InSight { blocks, sees_edge }
    }
}

/// Which blocks see an edge.
pub(crate) struct InSight {
    blocks: Grid,
    sees_edge: Vec<bool>,
}

impl InSight {
    /// Whether an edge may be in sight from the block at a pixel, which may start outside the window.
    pub(crate) fn at(&self, x: i32, y: i32) -> bool {
        let column = x.div_euclid(BLOCK) - self.blocks.first.0;
        let row = y.div_euclid(BLOCK) - self.blocks.first.1;
        let is_inside =
            (0..self.blocks.columns as i32).contains(&column) && (0..self.blocks.rows as i32).contains(&row);
        !is_inside || self.sees_edge[row as usize * self.blocks.columns + column as usize]
    }
}

/// What the columns of a row of cells hold: least, largest, and the largest difference among nine neighbours.
struct Line {
    low: Vec<f32>,
    high: Vec<f32>,
    rise: Vec<f32>,
    /// The same over three pixels above each other.
    column_low: Vec<f32>,
    column_high: Vec<f32>,
}

impl Line {
    fn new(window: PixelWindow) -> Self {
        let line = || vec![0.0; window.width as usize];
        Self { low: line(), high: line(), rise: line(), column_low: line(), column_high: line() }
    }

    /// Looks at the pixels of the cells whose first row is `top`.
    fn look(&mut self, inverse_depth: &[f32], window: PixelWindow, top: i32) {
        let width = window.width as usize;
        self.low.fill(f32::INFINITY);
        self.high.fill(f32::NEG_INFINITY);
        self.rise.fill(0.0);
        for y in top.max(window.y)..(top + CELL).min(window.y_end()) {
            let row = (y - window.y) as usize;
            let line = |row: usize| &inverse_depth[row * width..(row + 1) * width];
            let (above, here, below) =
                (line(row.saturating_sub(1)), line(row), line((row + 1).min(window.height as usize - 1)));
            let columns = self.column_low.iter_mut().zip(&mut self.column_high);
            for ((((low, high), &a), &b), &c) in columns.zip(above).zip(here).zip(below) {
                *low = least([a, b, c]);
                *high = largest([a, b, c]);
            }
            // The first and the last pixel have two columns beside them only
            for x in [0, width - 1] {
                let beside = x.saturating_sub(1)..(x + 2).min(width);
                let low = self.column_low[beside.clone()].iter().copied().fold(f32::INFINITY, f32::min);
                let high = self.column_high[beside].iter().copied().fold(f32::NEG_INFINITY, f32::max);
                self.low[x] = self.low[x].min(low);
                self.high[x] = self.high[x].max(high);
                self.rise[x] = self.rise[x].max(high - low);
            }
            if width > 2 {
                let inner = 1..width - 1;
                let out = self.low[inner.clone()].iter_mut().zip(&mut self.high[inner.clone()]);
                let out = out.zip(&mut self.rise[inner]);
                let beside = |line| <&[f32; 3]>::try_from(line).map_or([0.0; 3], |line| *line);
                let lows = self.column_low.windows(3).zip(self.column_high.windows(3));
                for (((low, high), rise), (lows, highs)) in out.zip(lows) {
                    let (least, largest) = (least(beside(lows)), largest(beside(highs)));
                    *low = if least < *low { least } else { *low };
                    *high = if largest > *high { largest } else { *high };
                    *rise = if largest - least > *rise { largest - least } else { *rise };
                }
            }
        }
    }

    /// From columns to cells.
    fn reduce(&self, window: PixelWindow, first: i32, jump: f32, ranges: &mut [Range], has_edge: &mut [bool]) {
        for (k, (range, has_edge)) in ranges.iter_mut().zip(has_edge).enumerate() {
            let left = (first + k as i32) * CELL;
            let column = |x: i32| (x.clamp(window.x, window.x_end()) - window.x) as usize;
            let columns = column(left)..column(left + CELL);
            let pairs = self.low[columns.clone()].iter().zip(&self.high[columns.clone()]);
            *range = pairs.fold(EMPTY, |range, (&low, &high)| joined(range, [low, high]));
            *has_edge = self.rise[columns].iter().any(|&rise| rise > jump);
        }
    }
}

#[inline(always)]
fn least([a, b, c]: [f32; 3]) -> f32 {
    let ab = if a < b { a } else { b };
    if ab < c { ab } else { c }
}

#[inline(always)]
fn largest([a, b, c]: [f32; 3]) -> f32 {
    let ab = if a > b { a } else { b };
    if ab > c { ab } else { c }
}

//! The range of inverse depth in blocks of pixels, so that a ray skips what it cannot meet.

use rgbd::PixelWindow;

/// Levels above the single pixel; a block of level l has a side of 2^(2 l) pixels.
pub(crate) const LEVELS: usize = 3;

/// Pixels per side of a block, as a power of 2, by level.
pub(crate) const SHIFTS: [u32; LEVELS] = [0, 2, 4];

/// Smallest and largest inverse depth; crossed where there is nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f32,
    pub(crate) high: f32,
}

impl Range {
    pub(crate) const EMPTY: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY };

    pub(crate) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(crate) fn is_empty(self) -> bool {
        self.low > self.high
    }
}

/// Ranges of the blocks of a window, by level. They only cull: they never change a result.
pub(crate) struct DepthPyramid {
    window: PixelWindow,
    levels: Vec<Level>,
}

struct Level {
    columns: usize,
    rows: usize,
    ranges: Vec<Range>,
}

impl DepthPyramid {
    /// From the range of each pixel of `window`, row by row.
    pub(crate) fn new(window: PixelWindow, pixels: Vec<Range>) -> Self {
        let (columns, rows) = (window.width as usize, window.height as usize);
        let mut levels = vec![Level { columns, rows, ranges: pixels }];
        for pair in SHIFTS.windows(2) {
            let step = 1 << (pair[1] - pair[0]);
            let below = &levels[levels.len() - 1];
            let (columns, rows) = (below.columns.div_ceil(step), below.rows.div_ceil(step));
            let mut ranges = vec![Range::EMPTY; columns * rows];
            for (i, &range) in below.ranges.iter().enumerate() {
                let block = (i / below.columns / step) * columns + i % below.columns / step;
                ranges[block] = ranges[block].union(range);
            }
            levels.push(Level { columns, rows, ranges });
        }
        Self { window, levels }
    }

    /// The range of the block of `level` that holds the pixel in column and row of the window.
    #[inline(always)]
    pub(crate) fn block(&self, level: usize, column: i32, row: i32) -> Range {
        let shift = SHIFTS[level];
        let level = &self.levels[level];
        level.ranges[(row >> shift) as usize * level.columns + (column >> shift) as usize]
    }

    /// A range that holds all pixels of `part` (and perhaps some around it).
    pub(crate) fn over(&self, part: PixelWindow) -> Range {
        let part = part.intersection(&self.window);
        if part.is_empty() {
            return Range::EMPTY;
        }
        let level = &self.levels[LEVELS - 1];
        let block = |from: i32| (from >> SHIFTS[LEVELS - 1]) as usize;
        let columns = block(part.x - self.window.x)..=block(part.x_end() - 1 - self.window.x);
        let rows = block(part.y - self.window.y)..=block(part.y_end() - 1 - self.window.y);
        rows.flat_map(|row| columns.clone().map(move |column| level.ranges[row * level.columns + column]))
            .fold(Range::EMPTY, Range::union)
    }
}

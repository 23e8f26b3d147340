//! A rectangle of pixels.

/// A rectangle of pixels: x right, y down, `(x, y)` its top left pixel.
///
/// Display windows and data windows are both of this type; unlike OpenEXR's boxes it may be empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PixelWindow {
    /// Column of the leftmost pixel.
    pub x: i32,
    /// Row of the topmost pixel.
    pub y: i32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl PixelWindow {
    /// A window at (0, 0).
    #[must_use]
    pub fn of_size(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// The window of all pixels from (`x0`, `y0`) up to but without (`x1`, `y1`); empty if they cross.
    #[must_use]
    pub fn from_corners(x0: i32, y0: i32, x1: i32, y1: i32) -> Self {
        let span = |a: i32, b: i32| (i64::from(b) - i64::from(a)).clamp(0, i64::from(i32::MAX)) as u32;
        Self { x: x0, y: y0, width: span(x0, x1), height: span(y0, y1) }
    }

    /// One past the rightmost column.
    #[must_use]
    pub fn x_end(&self) -> i32 {
        self.x.saturating_add_unsigned(self.width)
    }

    /// One past the lowest row.
    #[must_use]
    pub fn y_end(&self) -> i32 {
        self.y.saturating_add_unsigned(self.height)
    }

    /// Number of pixels.
    #[must_use]
    pub fn area(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether there is no pixel in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// Whether a pixel lies in it.
    #[must_use]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        (self.x..self.x_end()).contains(&x) && (self.y..self.y_end()).contains(&y)
    }

    /// Whether all of `other` lies in it.
    #[must_use]
    pub fn contains_window(&self, other: &Self) -> bool {
        other.is_empty() || self.intersection(other) == *other
    }

    /// What both cover; empty if they do not meet.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self::from_corners(
            self.x.max(other.x),
            self.y.max(other.y),
            self.x_end().min(other.x_end()),
            self.y_end().min(other.y_end()),
        )
    }

    /// The smallest window that holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self::from_corners(
            self.x.min(other.x),
            self.y.min(other.y),
            self.x_end().max(other.x_end()),
            self.y_end().max(other.y_end()),
        )
    }

    /// The window with `margin_x` columns and `margin_y` rows more on each side.
    #[must_use]
    pub fn grown(&self, margin_x: u32, margin_y: u32) -> Self {
        Self {
            x: self.x.saturating_sub_unsigned(margin_x),
            y: self.y.saturating_sub_unsigned(margin_y),
            width: self.width.saturating_add(margin_x.saturating_mul(2)),
            height: self.height.saturating_add(margin_y.saturating_mul(2)),
        }
    }

    /// The smallest window around it whose corners lie at multiples of `side` pixels, which must be positive.
    #[must_use]
    pub fn aligned_to(&self, side: i32) -> Self {
        let down = |at: i32| at.div_euclid(side) * side;
        let up = |at: i32| -down(-at);
        Self::from_corners(down(self.x), down(self.y), up(self.x_end()), up(self.y_end()))
    }

    /// Row-major index of a pixel, which must lie in the window (checked in debug builds).
    #[must_use]
    pub fn index(&self, x: i32, y: i32) -> usize {
        debug_assert!(self.contains(x, y), "pixel ({x}, {y}) is outside {self}");
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }

    /// All pixels (x, y), row by row.
    pub fn pixels(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let window = *self;
        (window.y..window.y_end()).flat_map(move |y| (window.x..window.x_end()).map(move |x| (x, y)))
    }
}

impl std::fmt::Display for PixelWindow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{} at ({}, {})", self.width, self.height, self.x, self.y)
    }
}

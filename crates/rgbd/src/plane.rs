//! One channel of a picture.

use crate::PixelWindow;

/// One f32 per pixel of a window, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    window: PixelWindow,
    values: Vec<f32>,
}

impl Plane {
    /// A plane of one value.
    #[must_use]
    pub fn filled(window: PixelWindow, value: f32) -> Self {
        Self { window, values: vec![value; window.area()] }
    }

    /// A plane from its values, row by row; `None` unless there is one for each pixel.
    #[must_use]
    pub fn from_values(window: PixelWindow, values: Vec<f32>) -> Option<Self> {
        (values.len() == window.area()).then_some(Self { window, values })
    }

    /// A plane whose values are a function of the pixel (x, y).
    #[must_use]
    pub fn from_fn(window: PixelWindow, mut value: impl FnMut(i32, i32) -> f32) -> Self {
        Self { window, values: window.pixels().map(|(x, y)| value(x, y)).collect() }
    }

    /// The pixels it covers.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }

    /// All values, row by row.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, row by row, to write to.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// The values themselves, row by row.
    #[must_use]
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// The values of row `y`, which must lie in the window.
    #[must_use]
    pub fn row(&self, y: i32) -> &[f32] {
        let width = self.window.width as usize;
        let start = (y - self.window.y) as usize * width;
        &self.values[start..start + width]
    }

    /// The value at a pixel of the window.
    #[must_use]
    pub fn at(&self, x: i32, y: i32) -> f32 {
        self.values[self.window.index(x, y)]
    }

    /// The value at a pixel, `None` outside the window.
    #[must_use]
    pub fn get(&self, x: i32, y: i32) -> Option<f32> {
        self.window.contains(x, y).then(|| self.at(x, y))
    }

    /// Sets the value at a pixel of the window.
    pub fn set(&mut self, x: i32, y: i32, value: f32) {
        let i = self.window.index(x, y);
        self.values[i] = value;
    }

    /// The part inside `window`, which must lie within the plane's own.
    #[must_use]
    pub fn cropped(&self, window: PixelWindow) -> Self {
        assert!(self.window.contains_window(&window), "cannot crop {} to {window}", self.window);
        let mut values = Vec::with_capacity(window.area());
        for y in window.y..window.y_end() {
            let start = (window.x - self.window.x) as usize;
            values.extend_from_slice(&self.row(y)[start..start + window.width as usize]);
        }
        Self { window, values }
    }

    /// The same plane on a window that holds its own, `outside` where it is new.
    #[must_use]
    pub fn covering(&self, window: PixelWindow, outside: f32) -> Self {
        let mut plane = Self::filled(window, outside);
        let inside = self.window.intersection(&window);
        for y in inside.y..inside.y_end() {
            let (to, from) = (window.index(inside.x, y), self.window.index(inside.x, y));
            let width = inside.width as usize;
            plane.values[to..to + width].copy_from_slice(&self.values[from..from + width]);
        }
        plane
    }
}

/// One bit per pixel of a window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    window: PixelWindow,
    set: Vec<bool>,
}

impl Mask {
    /// A mask that is the same everywhere.
    #[must_use]
    pub fn filled(window: PixelWindow, set: bool) -> Self {
        Self { window, set: vec![set; window.area()] }
    }

    /// A mask whose bits are a function of the pixel (x, y).
    #[must_use]
    pub fn from_fn(window: PixelWindow, mut set: impl FnMut(i32, i32) -> bool) -> Self {
        Self { window, set: window.pixels().map(|(x, y)| set(x, y)).collect() }
    }

    /// The pixels it covers.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }

    /// All bits, row by row.
    #[must_use]
    pub fn bits(&self) -> &[bool] {
        &self.set
    }

    /// All bits, row by row, to write to.
    pub fn bits_mut(&mut self) -> &mut [bool] {
        &mut self.set
    }

    /// The bit at a pixel of the window.
    #[must_use]
    pub fn at(&self, x: i32, y: i32) -> bool {
        self.set[self.window.index(x, y)]
    }

    /// Sets the bit at a pixel of the window.
    pub fn set(&mut self, x: i32, y: i32, bit: bool) {
        let i = self.window.index(x, y);
        self.set[i] = bit;
    }

    /// How many bits are set.
    #[must_use]
    pub fn count(&self) -> usize {
        self.set.iter().filter(|&&bit| bit).count()
    }

    /// The part inside `window`, which must lie within the mask's own.
    #[must_use]
    pub fn cropped(&self, window: PixelWindow) -> Self {
        assert!(self.window.contains_window(&window), "cannot crop {} to {window}", self.window);
        Self::from_fn(window, |x, y| self.at(x, y))
    }
}

//! Which pixels to work on.

use std::sync::Arc;

use rgbd::{Mask, PixelWindow};

/// A set of pixels: a whole window, or what a mask selects.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// All pixels of a window.
    Window(PixelWindow),
    /// The pixels whose bit is set.
    Mask(Arc<Mask>),
}

impl Pixels {
    /// The window that holds them all.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        match self {
            Self::Window(window) => *window,
            Self::Mask(mask) => mask.window(),
        }
    }

    /// Whether a pixel belongs to the set.
    #[must_use]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        match self {
            Self::Window(window) => window.contains(x, y),
            Self::Mask(mask) => mask.window().contains(x, y) && mask.at(x, y),
        }
    }

    /// Whether two sets have a pixel in common.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        let common = self.window().intersection(&other.window());
        common.pixels().any(|(x, y)| self.contains(x, y) && other.contains(x, y))
    }
}

impl From<PixelWindow> for Pixels {
    fn from(window: PixelWindow) -> Self {
        Self::Window(window)
    }
}

impl From<Mask> for Pixels {
    fn from(mask: Mask) -> Self {
        Self::Mask(Arc::new(mask))
    }
}

//! Colour without depth.

use crate::{PixelWindow, Plane, Primaries};

/// Premultiplied linear colour with alpha: what a filter or a tracer makes.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Red, green, blue, alpha; all of one window.
    planes: [Plane; 4],
}

impl Picture {
    /// A picture of one colour.
    #[must_use]
    pub fn filled(window: PixelWindow, rgba: [f32; 4]) -> Self {
        Self { planes: rgba.map(|value| Plane::filled(window, value)) }
    }

    /// A picture from its four planes; `None` unless all have the same window.
    #[must_use]
    pub fn from_planes(planes: [Plane; 4]) -> Option<Self> {
        let window = planes[0].window();
        planes.iter().all(|plane| plane.window() == window).then_some(Self { planes })
    }

    /// A picture whose colours are a function of the pixel (x, y).
    #[must_use]
    pub fn from_fn(window: PixelWindow, mut rgba: impl FnMut(i32, i32) -> [f32; 4]) -> Self {
        let mut picture = Self::filled(window, [0.0; 4]);
        for (x, y) in window.pixels() {
            picture.set(x, y, rgba(x, y));
        }
        picture
    }

    /// The picture of each colour's function.
    #[must_use]
    pub fn map(&self, rgba: impl Fn([f32; 4]) -> [f32; 4]) -> Self {
        Self::from_fn(self.window(), |x, y| rgba(self.at(x, y)))
    }

    /// The same picture with the primaries of Rec. 709, where its own are others that have a map to them.
    #[must_use]
    pub fn to_rec709(&self, own: &Primaries) -> Self {
        match own.to_rec709() {
            Some(map) if *own != Primaries::REC709 => self.map(|[r, g, b, alpha]| {
                let [r, g, b] = map.map(|row| row[0] * r + row[1] * g + row[2] * b);
                [r, g, b, alpha]
            }),
            _ => self.clone(),
        }
    }

    /// The pixels it covers.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.planes[0].window()
    }

    /// Red, green, blue, alpha.
    #[must_use]
    pub fn planes(&self) -> &[Plane; 4] {
        &self.planes
    }

    /// Red, green, blue, alpha, to write to.
    pub fn planes_mut(&mut self) -> &mut [Plane; 4] {
        &mut self.planes
    }

    /// The four planes themselves.
    #[must_use]
    pub fn into_planes(self) -> [Plane; 4] {
        self.planes
    }

    /// The colour at a pixel of the window.
    #[must_use]
    pub fn at(&self, x: i32, y: i32) -> [f32; 4] {
        let i = self.window().index(x, y);
        [0, 1, 2, 3].map(|c| self.planes[c].values()[i])
    }

    /// Sets the colour at a pixel of the window.
    pub fn set(&mut self, x: i32, y: i32, rgba: [f32; 4]) {
        let i = self.window().index(x, y);
        for (plane, value) in self.planes.iter_mut().zip(rgba) {
            plane.values_mut()[i] = value;
        }
    }

    /// The same picture on a window that holds its own, transparent where it is new.
    #[must_use]
    pub fn covering(&self, window: PixelWindow) -> Self {
        Self { planes: [0, 1, 2, 3].map(|c| self.planes[c].covering(window, 0.0)) }
    }

    /// The part inside `window`, which must lie within the picture's own.
    #[must_use]
    pub fn cropped(&self, window: PixelWindow) -> Self {
        Self { planes: [0, 1, 2, 3].map(|c| self.planes[c].cropped(window)) }
    }
}

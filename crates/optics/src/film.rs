//! The window of q that a picture shows, and its size in pixels.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{OpticsError, error::in_range};

/// The rectangle of chief-ray directions that the display window covers, and how many pixels it has.
///
/// Pixel coordinates are continuous: (0, 0) is the top left corner of the display window, (width, height) its bottom
/// right corner, pixel (i, j) has its centre at (i + 0.5, j + 0.5). Coordinates outside are fine (overscan).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Film {
    min: DVec2,
    max: DVec2,
    width: u32,
    height: u32,
}

impl Film {
    /// The window from `min` (left, bottom) to `max` (right, top) in q, seen by `width` x `height` pixels.
    pub fn new(min: DVec2, max: DVec2, width: u32, height: u32) -> Result<Self, OpticsError> {
        in_range("picture width in pixels", f64::from(width), "1 to 1000000", |x| (1.0..=1e6).contains(&x))?;
        in_range("picture height in pixels", f64::from(height), "1 to 1000000", |x| (1.0..=1e6).contains(&x))?;
        in_range("left edge of the window", min.x, "finite", |_| true)?;
        in_range("bottom edge of the window", min.y, "finite", |_| true)?;
        in_range("width of the window", max.x - min.x, "positive", |x| x > 0.0)?;
        in_range("height of the window", max.y - min.y, "positive", |x| x > 0.0)?;
        Ok(Self { min, max, width, height })
    }

    /// A window centred on the optical axis for a horizontal field of view (radians, full angle) and square pixels.
    pub fn from_fov(horizontal_fov: f64, width: u32, height: u32) -> Result<Self, OpticsError> {
        let half_turn = |x| x > 0.0 && x < std::f64::consts::PI;
        let fov = in_range("horizontal field of view in radians", horizontal_fov, "between 0 and pi", half_turn)?;
        let x = (0.5 * fov).tan();
        let y = x * f64::from(height) / f64::from(width.max(1));
        Self::new(DVec2::new(-x, -y), DVec2::new(x, y), width, height)
    }

    /// The same film with its window moved by `by` in q: a shift of h at image distance v moves it by h / v.
    #[must_use]
    pub fn shifted(self, by: DVec2) -> Self {
        Self { min: self.min + by, max: self.max + by, ..self }
    }

    /// The same window seen by another number of pixels.
    pub fn resized(self, width: u32, height: u32) -> Result<Self, OpticsError> {
        Self::new(self.min, self.max, width, height)
    }

    /// Left and bottom edge in q.
    #[must_use]
    pub fn min(&self) -> DVec2 {
        self.min
    }

    /// Right and top edge in q.
    #[must_use]
    pub fn max(&self) -> DVec2 {
        self.max
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Pixels per unit of q, in x and y (both positive).
    #[must_use]
    pub fn pixels_per_q(&self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height)) / (self.max - self.min)
    }

    /// The chief-ray direction at a continuous pixel coordinate.
    #[must_use]
    pub fn q_from_pixel(&self, pixel: DVec2) -> DVec2 {
        let scale = self.pixels_per_q();
        DVec2::new(self.min.x + pixel.x / scale.x, self.max.y - pixel.y / scale.y)
    }

    /// The continuous pixel coordinate of a chief-ray direction.
    #[must_use]
    pub fn pixel_from_q(&self, q: DVec2) -> DVec2 {
        let scale = self.pixels_per_q();
        DVec2::new((q.x - self.min.x) * scale.x, (self.max.y - q.y) * scale.y)
    }

    /// The four corners in q: top left, top right, bottom left, bottom right.
    #[must_use]
    pub fn corners(&self) -> [DVec2; 4] {
        let (a, b) = (self.min, self.max);
        [DVec2::new(a.x, b.y), b, a, DVec2::new(b.x, a.y)]
    }
}

/// The film as it stands in a file; checked before it becomes one.
#[derive(Deserialize)]
struct Written {
    min: DVec2,
    max: DVec2,
    width: u32,
    height: u32,
}

impl TryFrom<Written> for Film {
    type Error = OpticsError;

    fn try_from(written: Written) -> Result<Self, OpticsError> {
        Self::new(written.min, written.max, written.width, written.height)
    }
}

//! What of the first layer's colour belongs to another surface than its depth.

use crate::{Frame, Plane};

/// Names of the planes of a frame that hold it.
const NAMES: [&str; 5] = ["rest.R", "rest.G", "rest.B", "rest.A", "rest.Z"];

/// The rest of every pixel: what of the first layer's colour belongs to another surface than the one whose depth the layer
/// holds.
///
/// A pixel of anti-aliased colour is the mean over its area, its depth that of one point. Where both belong to more than one
/// surface a filter must take them apart again, and can only guess. A renderer knows, and a frame of the tracer says so in
/// the planes `rest.R`, `rest.G`, `rest.B`, `rest.A` and `rest.Z`: colour premultiplied with the share of the pixel that
/// this other surface fills (`rest.A`, 0 where there is none), and its planar depth, +inf for the sky. The first layer's
/// colour less this rest is what its own depth belongs to.
#[derive(Debug, Clone, Copy)]
pub struct Rest<'a> {
    planes: [&'a Plane; 5],
}

/// What another surface fills of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRest {
    /// Colour, premultiplied with the share of the pixel that it fills; alpha is that share.
    pub rgba: [f32; 4],
    /// Planar depth in scene units, +inf for the sky.
    pub depth: f32,
}

impl Rest<'_> {
    /// The rest of a pixel of the data window; none where nothing, or no depth in (0, +inf], is stored.
    #[must_use]
    pub fn at(&self, x: i32, y: i32) -> Option<PixelRest> {
        let share = self.planes[3].at(x, y);
        let depth = self.planes[4].at(x, y);
        if !(share > 0.0 && share <= 1.0 && depth > 0.0) {
            return None;
        }
        let [r, g, b] = [0, 1, 2].map(|c| self.planes[c].at(x, y));
        Some(PixelRest { rgba: [r, g, b, share], depth })
    }
}

impl Frame {
    /// The rest of every pixel, where the frame knows it.
    #[must_use]
    pub fn rest(&self) -> Option<Rest<'_>> {
        let [r, g, b, a, z] = NAMES.map(|name| self.planes.get(name));
        Some(Rest { planes: [r?, g?, b?, a?, z?] })
    }

    /// The same frame that knows the rest of every pixel from a function of it.
    #[must_use]
    pub fn with_rest(mut self, rest: impl Fn(i32, i32) -> Option<PixelRest>) -> Self {
        let mut planes = NAMES.map(|_| Plane::filled(self.data(), 0.0));
        for (x, y) in self.data().pixels() {
            if let Some(PixelRest { rgba: [r, g, b, a], depth }) = rest(x, y) {
                planes.iter_mut().zip([r, g, b, a, depth]).for_each(|(plane, value)| plane.set(x, y, value));
            }
        }
        self.planes.extend(NAMES.map(str::to_owned).into_iter().zip(planes));
        self
    }

    /// The same frame that does not know it.
    #[must_use]
    pub fn without_rest(mut self) -> Self {
        for name in NAMES {
            self.planes.remove(name);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layer, Picture, PixelWindow};

    #[test]
    fn what_is_no_share_or_no_depth_is_no_rest() {
        let window = PixelWindow::of_size(4, 1);
        let layer = Layer::from_raw_depth(Picture::filled(window, [1.0; 4]), Plane::filled(window, 2.0));
        let frame = Frame::new(window, vec![layer]).unwrap();
        assert!(frame.rest().is_none());
        let rest = |a: f32, depth: f32| PixelRest { rgba: [0.1, 0.2, 0.3, a], depth };
        let values =
            [Some(rest(0.5, f32::INFINITY)), Some(rest(1.5, 1.0)), Some(rest(0.5, f32::NAN)), Some(rest(0.0, 1.0))];
        let frame = frame.with_rest(|x, _| values[x as usize]);
        let kept: Vec<_> = (0..4).map(|x| frame.rest().and_then(|rest| rest.at(x, 0))).collect();
        assert_eq!(kept, [values[0], None, None, None]);
        assert!(frame.with_layers(1).rest().is_none(), "the first layer alone is what any renderer writes");
    }
}

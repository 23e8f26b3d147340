//! How a pixel's neighbours map onto the iris: equation (5) read as a gather.
//!
//! Pixel q sees a point at inverse depth s and pixel p through the iris point (a, b) iff
//! `p - q = d A (a, b) / (1 - w R e_z.(a, b))` with `d = s - w(q)`, `A(q) = R [e1.xy - e1.z q, e2.xy - e2.z q]` and
//! `e_z = (e1.z, e2.z)`; for a squeezed iris R differs from axis to axis. Solved for the iris point: with
//! `y = A^-1 (p - q) / d`, `(a, b) = y / (1 + w R e_z.y)`.

use glam::{DMat2, DVec2, DVec3};
use optics::{Camera, KernelModel};

use crate::{kernel::ellipse_share, oval::Oval};

/// How the shape of a pixel's footprint is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KernelRule {
    /// The simplest whose predicted departure from the exact footprint stays below this many pixels.
    Auto {
        /// Largest departure in pixels, positive.
        tolerance_px: f64,
    },
    /// Always this one.
    Forced(KernelModel),
}

impl Default for KernelRule {
    /// A quarter of a pixel.
    fn default() -> Self {
        Self::Auto { tolerance_px: KernelModel::DEFAULT_TOLERANCE_PX }
    }
}

/// A(q) in pixels (x right, y down): the offsets of the iris's axes for a unit of defocus.
pub(crate) fn spread(camera: &Camera, q: DVec2) -> DMat2 {
    let (iris, px) = (&camera.iris, camera.film.pixels_per_q());
    let to_px = DVec2::new(px.x, -px.y);
    let axis = |e: DVec3, half_size: f64| to_px * half_size * (e.truncate() - e.z * q);
    let half = iris.half_sizes();
    DMat2::from_cols(axis(iris.e1(), half.x), axis(iris.e2(), half.y))
}

/// w R e_z: how an iris that leans through the plane of focus skews the footprint.
pub(crate) fn skew(camera: &Camera, focus: f64) -> DVec2 {
    let iris = &camera.iris;
    DVec2::new(iris.e1().z, iris.e2().z) * (focus * iris.half_sizes())
}

/// The lens as one pixel sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PixelLens {
    /// Inverse depth of focus w(q).
    pub(crate) focus: f32,
    /// Pixels of blur radius per unit of defocus: of the disc as large as the footprint.
    pub(crate) scale: f32,
    /// Largest such radius in any direction.
    pub(crate) widest: f32,
    /// From a pixel offset (x right, y down) to iris coordinates scaled by the blur radius, row by row.
    pub(crate) to_iris: [f32; 4],
    /// The same in the middle of an upright iris: along x, and 1 over it upwards.
    pub(crate) upright: f32,
    /// w R e_z: the skew of the exact footprint.
    pub(crate) skew: [f32; 2],
}

impl PixelLens {
    /// How much wider than its mean radius a footprint is at most; 1 for a disc.
    #[inline(always)]
    pub(crate) fn stretch(&self) -> f32 {
        if self.scale > 0.0 { self.widest / self.scale } else { 1.0 }
    }

    /// The lens seen from chief-ray direction q.
    pub(crate) fn new(camera: &Camera, model: KernelModel, q: DVec2) -> Self {
        let focus = camera.focus.inverse_depth(q);
        if model == KernelModel::Disc {
            let scale = camera.pixels_per_defocus().max_element() as f32;
            let to_iris = [1.0, 0.0, 0.0, -1.0];
            return Self { focus: focus as f32, scale, widest: scale, to_iris, upright: 1.0, skew: [0.0; 2] };
        }

        let map = spread(camera, q);
        let scale = map.determinant().abs().sqrt();
        if scale == 0.0 {
            return Self {
                focus: focus as f32,
                scale: 0.0,
                widest: 0.0,
                to_iris: [1.0, 0.0, 0.0, -1.0],
                upright: 1.0,
                skew: [0.0; 2],
            };
        }
        let inverse = map.inverse() * scale;
        let frobenius = map.x_axis.length_squared() + map.y_axis.length_squared();
        // Largest singular value of a 2x2 matrix from its norm and determinant
        let widest = (0.5 * (frobenius + (frobenius * frobenius - 4.0 * scale.powi(4)).max(0.0).sqrt())).sqrt();

        // An iris leaning through the plane of focus skews the disc
        let skew = match model {
            KernelModel::Exact => skew(camera, focus),
            _ => DVec2::ZERO,
        };
        let stretch = 1.0 / (1.0 - skew.length()).max(0.5);
        Self {
            focus: focus as f32,
            scale: scale as f32,
            widest: (widest * stretch) as f32,
            to_iris: [inverse.x_axis.x, inverse.y_axis.x, inverse.x_axis.y, inverse.y_axis.y].map(|v| v as f32),
            upright: Oval::of(camera).0,
            skew: [skew.x as f32, skew.y as f32],
        }
    }

    /// The map to iris coordinates that a footprint is drawn with, with a share of the departure from an upright iris.
    #[inline(always)]
    pub(crate) fn drawn(&self, ellipse: f32) -> [f32; 4] {
        let upright = [self.upright, 0.0, 0.0, -1.0 / self.upright];
        std::array::from_fn(|i| upright[i] + ellipse * (self.to_iris[i] - upright[i]))
    }

    /// Whether it departs from an upright iris.
    pub(crate) fn is_elliptic(&self) -> bool {
        self.to_iris != self.drawn(0.0)
    }

    /// An offset (x right, y down) in iris coordinates scaled by the blur radius, as if there were no skew.
    #[cfg(test)]
    pub(crate) fn unskewed(&self, x: f32, y: f32) -> [f32; 2] {
        let m = &self.to_iris;
        [m[0] * x + m[1] * y, m[2] * x + m[3] * y]
    }

    /// An offset (x right, y down) in iris coordinates scaled by the blur radius, the iris turned upside down behind the
    /// plane of focus, as it is drawn; `defocus` is the neighbour's, in pixels of radius, before any limit to the `radius`.
    #[inline(always)]
    pub(crate) fn iris_offset(&self, x: f32, y: f32, defocus: f32, radius: f32) -> [f32; 2] {
        let ellipse = ellipse_share(radius);
        let m = self.drawn(ellipse);
        let (mut a, mut b) = (m[0] * x + m[1] * y, m[2] * x + m[3] * y);
        // Undo the skew where the footprint is large enough to have a shape
        if self.skew != [0.0; 2] && defocus.abs() > 0.5 {
            let lean = ellipse * (self.skew[0] * a + self.skew[1] * b) / defocus;
            let factor = 1.0 / (1.0 + lean).clamp(0.5, 2.0);
            (a, b) = (a * factor, b * factor);
        }
        let sign = if defocus < 0.0 { -1.0 } else { 1.0 };
        [sign * a, sign * b]
    }
}

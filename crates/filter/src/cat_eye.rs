//! The cat's eye over a footprint: what a second rim leaves of it ([`optics::Opening`]).
//!
//! In iris coordinates the rim is a disc as large as the footprint, moved by a part of its radius. A kernel falls with its
//! metric, so that the smaller of its weights at both metrics draws the intersection with the same ramp; divided by the open
//! share it sums to 1 again, since a pixel is the mean over the open lens. Sum, centroid and variance on the lattice are
//! right within 3 % from 3 px of radius; the two corners of the eye lose an eighth of a pixel each to the ramps, which is
//! made up for. Below 2 px the whole footprint is mixed in and below half a pixel it is all: a shape of that size is no more
//! than its centroid, and that is then off by less than half a pixel.

use fearless_simd::{f32x8, prelude::*};
use glam::DVec2;
use optics::Camera;

use crate::{
    kernel::{Kernel, KernelTable},
    outline::Outline,
    row::{BlockTap, Footprint, LANES, Lanes, Shaped, Shared},
};

/// Radius in pixels up to which the whole footprint is drawn, and the pixels in which the eye comes in.
const EYE_FROM: f32 = 0.5;
const EYE_OVER: f32 = 1.5;

/// What the corners lose to the ramps, in shares of the unit disc times the squared radius in pixels.
const CORNERS: f32 = 0.08;

/// What a pixel sees open of its lens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eye {
    /// Centre of the rim in the unit opening.
    rim: [f32; 2],
    /// The open share of the lens, and what its corners lose of that at a radius of one pixel.
    share: f32,
    corners: f32,
    /// Centroid of the open part, and the symmetric map (xx, xy, yy) that makes it as wide as high as the unit disc.
    center: [f32; 2],
    to_disc: [f32; 3],
}

impl Eye {
    /// What pixel direction q sees; all of it if the camera's iris has no cat's eye.
    pub(crate) fn new(camera: &Camera, q: DVec2) -> Self {
        let opening = camera.iris.opening(q);
        let (rim, shift) = (opening.rim(), opening.rim().length());
        // Half sizes of the intersection of two discs along and across the shift, as those of an ellipse of its variances
        let (chord, angle) = (0.5 * shift, (0.5 * shift).acos());
        let (sin, cos) = angle.sin_cos();
        let half_area = 0.5 * (angle - sin * cos);
        let quarter = 0.125 * angle - (4.0 * angle).sin() / 32.0;
        let along = (quarter - 2.0 * chord * sin.powi(3) / 3.0 + chord * chord * half_area) / half_area;
        let across = (0.375 * angle - 0.25 * (2.0 * angle).sin() + (4.0 * angle).sin() / 32.0) / (3.0 * half_area);
        let [along, across] = [along, across].map(|variance| 0.5 / variance.sqrt());
        let axis = rim.try_normalize().unwrap_or(DVec2::X);
        let stretch = along - across;
        Self {
            rim: rim.as_vec2().to_array(),
            share: opening.share() as f32,
            corners: CORNERS * (2.0 * shift).min(1.0) as f32,
            center: (0.5 * rim).as_vec2().to_array(),
            to_disc: [
                across + stretch * axis.x * axis.x,
                stretch * axis.x * axis.y,
                across + stretch * axis.y * axis.y,
            ]
            .map(|v| v as f32),
        }
    }

    /// The same if the camera's iris has a cat's eye.
    pub(crate) fn of(camera: &Camera, q: DVec2) -> Option<Self> {
        (camera.iris.cat_eye() > 0.0).then(|| Self::new(camera, q))
    }

    /// How far it is drawn in a footprint of `radius` pixels, and what a weight within it counts.
    fn drawn(&self, radius: f32) -> [f32; 2] {
        let open = (self.share - self.corners / radius.max(EYE_FROM).powi(2)).max(0.5 * self.share);
        [((radius - EYE_FROM) / EYE_OVER).clamp(0.0, 1.0), 1.0 / open]
    }

    /// The weight of the pixel at an offset in iris coordinates, in a footprint of `radius` pixels with this kernel.
    pub(crate) fn weight(&self, table: &KernelTable, offset: [f32; 2], radius: f32, kernel: &Kernel) -> f32 {
        let whole = table.weight(offset, radius, kernel);
        let ([drawn, gain], stretch) = (self.drawn(radius), table.stretch(radius));
        let [x, y] = [offset[0] * stretch - radius * self.rim[0], offset[1] / stretch - radius * self.rim[1]];
        let open = whole.min(kernel.at(table.outline().rim_metric(x, y)));
        whole + drawn * (gain * open - whole)
    }

    /// A lens point as one of a disc that stands for the open part.
    #[cfg(test)]
    pub(crate) fn on_disc(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let (x, y) = (x - self.center[0], y - self.center[1]);
        [self.to_disc[0] * x + self.to_disc[1] * y, self.to_disc[1] * x + self.to_disc[2] * y]
    }

    /// Half the width of the open part of a disc where it is narrowest, for a radius of 1.
    pub(crate) fn narrowest(&self) -> f32 {
        1.0 - 0.5 * self.rim[0].hypot(self.rim[1])
    }
}

impl Outline {
    /// The metric of an offset from the centre of a rim that is as large as the unit circle.
    fn rim_metric(&self, x: f32, y: f32) -> f32 {
        match self {
            Self::Disc => x * x + y * y,
            Self::Polygon { apothem, .. } => apothem * x.hypot(y),
        }
    }
}

/// Any iris behind a second rim; the eyes of a row of pixels.
#[derive(Clone, Copy)]
pub(crate) struct CatEye<'a> {
    iris: Shaped<'a>,
    rim: [[f32; LANES]; 2],
    share: [f32; LANES],
    corners: [f32; LANES],
    center: [[f32; LANES]; 2],
    to_disc: [[f32; LANES]; 3],
}

impl<'a> CatEye<'a> {
    /// Draws an iris; all of it is open until a row is set.
    pub(crate) fn new(outline: &'a Outline) -> Self {
        let nothing = [0.0; LANES];
        let to_disc = [[1.0; LANES], nothing, [1.0; LANES]];
        let share = [1.0; LANES];
        Self { iris: Shaped(outline), rim: [nothing; 2], share, corners: nothing, center: [nothing; 2], to_disc }
    }
}

impl Footprint for CatEye<'_> {
    const IS_CUT: bool = true;

    #[inline(always)]
    fn over_row(&self, eyes: impl FnOnce() -> [Eye; LANES]) -> Self {
        let eyes = eyes();
        Self {
            iris: self.iris,
            rim: [0, 1].map(|axis| eyes.map(|eye| eye.rim[axis])),
            share: eyes.map(|eye| eye.share),
            corners: eyes.map(|eye| eye.corners),
            center: [0, 1].map(|axis| eyes.map(|eye| eye.center[axis])),
            to_disc: [0, 1, 2].map(|k| eyes.map(|eye| eye.to_disc[k])),
        }
    }

    #[inline(always)]
    fn weight<S: Simd>(
        &self,
        tap: &BlockTap,
        shared: &Shared,
        x: f32x8<S>,
        y: f32x8<S>,
        kernel: &Lanes<S>,
        by: f32x8<S>,
    ) -> f32x8<S> {
        let [u, v] = self.iris.offset(tap, shared.lens, x, y);
        let whole = self.iris.weight_at(tap, [u, v], kernel);

        // Where the rim stands, and what is open there
        let radius = ((by + tap.weight.defocus) * tap.weight.sign).max(0.0).min(shared.max_radius);
        let simd = radius.simd;
        let lanes = |values: &[f32; LANES]| f32x8::from_slice(simd, values);
        let (u, v) = (u - radius * lanes(&self.rim[0]), v - radius * lanes(&self.rim[1]));
        let squared = u.mul_add(u, v * v);
        let metric = match self.iris.0 {
            Outline::Disc => squared,
            Outline::Polygon { apothem, .. } => squared.sqrt() * *apothem,
        };
        let open = whole.min(kernel.at(metric));

        // Draw it as far as the footprint has a shape
        let wide = radius.max(EYE_FROM);
        let share = lanes(&self.share);
        let drawn = ((radius - EYE_FROM) * (1.0 / EYE_OVER)).max(0.0).min(1.0);
        let share = (share - lanes(&self.corners) / (wide * wide)).max(share * 0.5);
        (open / share - whole).mul_add(drawn, whole)
    }

    #[inline(always)]
    fn to_iris<S: Simd>(&self, lens: &crate::lens_map::PixelLens, x: f32x8<S>, y: f32x8<S>) -> [f32x8<S>; 2] {
        self.iris.to_iris(lens, x, y)
    }

    #[inline(always)]
    fn on_disc<S: Simd>(&self, [x, y]: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
        let simd = x.simd;
        let lanes = |values: &[f32; LANES]| f32x8::from_slice(simd, values);
        let (x, y) = (x - lanes(&self.center[0]), y - lanes(&self.center[1]));
        let [xx, xy, yy] = [0, 1, 2].map(|k| lanes(&self.to_disc[k]));
        [xx.mul_add(x, xy * y), xy.mul_add(x, yy * y)]
    }
}

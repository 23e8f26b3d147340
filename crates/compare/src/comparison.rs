//! One candidate against one reference: all figures, and the maps behind them.

use rgbd::{Picture, PixelWindow, Plane};

use crate::{
    CompareError, Exposures, Figures, MaskKind, Masks, PIXELS_PER_DEGREE, Reference,
    figures::{PerceptualMaps, figures},
    flip_hdr::hdr_flip_map,
    flip_ldr::Flip,
    rgb::Rgb,
    ssim::ssim_map,
};

/// How a candidate differs from the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Figures per mask, the whole display window first.
    pub figures: Vec<Figures>,
    /// How many of the candidate's pixels held a value that was not finite; they count as 0.
    pub non_finite: usize,
    /// The exposures over which HDR-FLIP took the worst.
    pub exposures: Exposures,
    /// SSIM per pixel, mean over channels.
    pub ssim: Plane,
    /// LDR-FLIP per pixel at exposure 0.
    pub flip_ldr: Plane,
    /// HDR-FLIP per pixel.
    pub flip_hdr: Plane,
    /// The candidate as it was compared: the display window, every value finite; alpha 1.
    pub candidate: Picture,
}

impl Comparison {
    /// Compares `candidate`, which must cover the reference's display window, over `masks` of that window.
    ///
    /// The perceptual figures of a mask are means of maps made from the whole window.
    pub fn new(reference: &Reference, candidate: &Picture, masks: &Masks) -> Result<Self, CompareError> {
        let display = reference.display();
        let rgb = Rgb::from_picture(candidate, display, "the candidate")?;

        // Draw the perceptual maps
        let flip = Flip::new(PIXELS_PER_DEGREE);
        let exposures = Exposures::of(&reference.rgb);
        let ssim = ssim_map(&reference.rgb, &rgb);
        let flip_ldr = flip.map(&reference.rgb, &rgb);
        let flip_hdr = hdr_flip_map(&flip, exposures, &reference.rgb, &rgb);

        // Take the figures
        let maps = PerceptualMaps { ssim: &ssim, flip_ldr: &flip_ldr, flip_hdr: &flip_hdr };
        let figures = figures(reference, &rgb, masks, &maps)?;
        let [ssim, flip_ldr, flip_hdr] = [ssim, flip_ldr, flip_hdr].map(|map| plane_of(display, &map));
        let candidate = picture_of(&rgb, display);
        Ok(Self { figures, non_finite: rgb.non_finite, exposures, ssim, flip_ldr, flip_hdr, candidate })
    }

    /// The figures within a mask; `None` if it holds no pixel or no depth was known.
    #[must_use]
    pub fn within(&self, mask: MaskKind) -> Option<&Figures> {
        self.figures.iter().find(|figures| figures.mask == mask)
    }

    /// The figures of the whole display window.
    #[must_use]
    pub fn all(&self) -> &Figures {
        &self.figures[0]
    }
}

/// The values of a window, row by row, as a plane.
fn plane_of(window: PixelWindow, values: &[f32]) -> Plane {
    let mut plane = Plane::filled(window, 0.0);
    plane.values_mut().copy_from_slice(values);
    plane
}

/// The colours of a window as an opaque picture.
pub(crate) fn picture_of(rgb: &Rgb, window: PixelWindow) -> Picture {
    let mut picture = Picture::filled(window, [0.0, 0.0, 0.0, 1.0]);
    for (plane, channel) in picture.planes_mut().iter_mut().zip(&rgb.channels) {
        plane.values_mut().copy_from_slice(channel);
    }
    picture
}

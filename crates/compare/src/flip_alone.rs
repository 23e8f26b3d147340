//! HDR-FLIP and nothing else, where the other figures would cost time for nothing.

use rgbd::{Picture, PixelWindow, Plane};

use crate::{CompareError, Exposures, PIXELS_PER_DEGREE, flip_hdr::hdr_flip_map, flip_ldr::Flip, rgb::Rgb};

/// Mean HDR-FLIP (0 to 1) of `candidate` against `reference`, linear Rec. 709, over `display`, which both must cover: the
/// same as [`crate::Figures::flip_hdr`] of a whole picture.
pub fn mean_flip_hdr(reference: &Picture, candidate: &Picture, display: PixelWindow) -> Result<f64, CompareError> {
    let exposures = Exposures::of_picture(reference, display)?;
    let map = flip_hdr_at(reference, candidate, display, exposures)?;
    Ok(map.values().iter().map(|&error| f64::from(error)).sum::<f64>() / map.values().len().max(1) as f64)
}

/// HDR-FLIP (0 to 1) of every pixel of `display`, which both pictures must cover, at exposures that may be those of a larger
/// picture.
pub fn flip_hdr_at(
    reference: &Picture,
    candidate: &Picture,
    display: PixelWindow,
    exposures: Exposures,
) -> Result<Plane, CompareError> {
    let reference = Rgb::from_picture(reference, display, "the reference")?;
    let candidate = Rgb::from_picture(candidate, display, "the candidate")?;
    let map = hdr_flip_map(&Flip::new(PIXELS_PER_DEGREE), exposures, &reference, &candidate);
    Ok(Plane::from_values(display, map).expect("a value for every pixel"))
}

impl Exposures {
    /// The exposures for a reference in linear Rec. 709, over a window that it must cover.
    pub fn of_picture(reference: &Picture, window: PixelWindow) -> Result<Self, CompareError> {
        Ok(Self::of(&Rgb::from_picture(reference, window, "the reference")?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Comparison, GivenNoise, Masks, Reference};

    #[test]
    fn it_is_that_of_a_whole_comparison() {
        let display = PixelWindow::of_size(40, 24);
        let picture = |gain: f32| {
            Picture::from_fn(display, |x, y| {
                let v = gain * ((x * 7 + y * 13) % 11) as f32 / 11.0;
                [v, v * v, 0.5 * v, 1.0]
            })
        };
        let (reference, candidate) = (picture(1.0), picture(1.2));
        let whole = Reference::from_picture(&reference, display, GivenNoise::default()).unwrap();
        let whole = Comparison::new(&whole, &candidate, &Masks::without_depth(display)).unwrap();
        let alone = mean_flip_hdr(&reference, &candidate, display).unwrap();
        assert_eq!(alone, whole.all().flip_hdr);
        assert!(alone > 0.01, "{alone}: the pictures hardly differ");
    }
}

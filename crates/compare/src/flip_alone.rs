//! HDR-FLIP and nothing else, where the other figures would cost time for nothing.

use rgbd::{Picture, PixelWindow};

use crate::{CompareError, Exposures, PIXELS_PER_DEGREE, flip_hdr::hdr_flip_map, flip_ldr::Flip, rgb::Rgb};

/// Mean HDR-FLIP (0 to 1) of `candidate` against `reference`, linear Rec. 709, over `display`, which both must cover: the
/// same as [`crate::Figures::flip_hdr`] of a whole picture.
pub fn mean_flip_hdr(reference: &Picture, candidate: &Picture, display: PixelWindow) -> Result<f64, CompareError> {
    let reference = Rgb::from_picture(reference, display, "the reference")?;
    let candidate = Rgb::from_picture(candidate, display, "the candidate")?;
    let map = hdr_flip_map(&Flip::new(PIXELS_PER_DEGREE), Exposures::of(&reference), &reference, &candidate);
    Ok(map.iter().map(|&error| f64::from(error)).sum::<f64>() / map.len().max(1) as f64)
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

//! Error figures of one candidate over one mask.

use serde::Serialize;

use crate::{
    CompareError, CorrectedError, Interval, MaskKind, Masks, Reference, interval::TileSums, psnr_db,
    reference::NoiseSource, rgb::Rgb,
};

/// What is added to the square of the reference in relMSE, so that black does not divide by 0.
const RELATIVE_FLOOR: f64 = 0.01;

/// How wrong a candidate is within one mask. Linear values, peak 1, means over pixels and R, G, B.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Which pixels.
    pub mask: MaskKind,
    /// Their share in the display window, 0 to 1.
    pub share: f64,
    /// How many they are.
    pub pixels: usize,
    /// Mean square error, the reference's noise included.
    pub mse: f64,
    /// Mean square error with the reference's noise taken off.
    pub corrected: CorrectedError,
    /// Mean of the signed difference, candidate minus reference.
    pub bias: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of d^2 / (R^2 + 0.01).
    pub rel_mse: f64,
    /// Structural similarity, at most 1; the mean of the whole map. (scikit-image's own mean leaves out 5 px of border.)
    pub ssim: f64,
    /// LDR-FLIP at exposure 0, 0 to 1.
    pub flip_ldr: f64,
    /// HDR-FLIP, 0 to 1.
    pub flip_hdr: f64,
    /// How sure they are.
    pub intervals: Intervals,
}

/// 95 % confidence intervals of [`Figures`], from the scatter between tiles of the picture; `None` where the mask meets too
/// few tiles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Intervals {
    /// Of the mean square error with the reference's noise taken off (the plain one where the noise is unknown); its ends are
    /// a factor away from it. `None` also for an error below the noise.
    pub corrected_mse: Option<Interval>,
    /// Of the bias.
    pub bias: Option<Interval>,
    /// Of the mean absolute error.
    pub mae: Option<Interval>,
    /// Of relMSE.
    pub rel_mse: Option<Interval>,
    /// Of SSIM.
    pub ssim: Option<Interval>,
    /// Of LDR-FLIP.
    pub flip_ldr: Option<Interval>,
    /// Of HDR-FLIP.
    pub flip_hdr: Option<Interval>,
}

impl Figures {
    /// Root mean square error.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        self.mse.sqrt()
    }

    /// Peak signal-to-noise ratio in dB, the reference's noise included; +inf for an error of 0.
    #[must_use]
    pub fn psnr_db(&self) -> f64 {
        psnr_db(self.mse)
    }
}

/// The error maps from which perceptual figures are taken.
pub(crate) struct PerceptualMaps<'a> {
    pub(crate) ssim: &'a [f32],
    pub(crate) flip_ldr: &'a [f32],
    pub(crate) flip_hdr: &'a [f32],
}

/// The figures of `candidate` within each mask that has some.
pub(crate) fn figures(
    reference: &Reference,
    candidate: &Rgb,
    masks: &Masks,
    maps: &PerceptualMaps<'_>,
) -> Result<Vec<Figures>, CompareError> {
    if masks.window() != reference.display() {
        let what = "the mask".to_owned();
        return Err(CompareError::WindowMismatch { what, found: masks.window(), wanted: reference.display() });
    }
    Ok(masks.kinds().into_iter().map(|mask| figures_of(reference, candidate, masks, mask, maps)).collect())
}

fn figures_of(
    reference: &Reference,
    candidate: &Rgb,
    masks: &Masks,
    mask: MaskKind,
    maps: &PerceptualMaps<'_>,
) -> Figures {
    let pixels = masks.count(mask);
    let chosen = || (0..candidate.len()).filter(|&i| masks.holds(mask, i));
    let mean = |sum: f64| sum / pixels.max(1) as f64;
    let mean_of = |map: &[f32]| mean(chosen().map(|i| f64::from(map[i])).sum());

    // Add up the differences, pixel by pixel in a fixed order
    let [mut square, mut signed, mut absolute, mut relative] = [0.0; 4];
    let mut tiles = TileSums::<7>::new(candidate.width, candidate.height);
    for i in chosen() {
        let before = [signed, absolute, relative];
        for (r, c) in reference.rgb.at(i).into_iter().zip(candidate.at(i)) {
            let (r, d) = (f64::from(r), f64::from(c) - f64::from(r));
            square += d * d;
            signed += d;
            absolute += d.abs();
            relative += d * d / (r * r + RELATIVE_FLOOR);
        }
        let [signed, absolute, relative] = [signed - before[0], absolute - before[1], relative - before[2]];
        let squared = reference.squared_error_at(candidate, i);
        let maps = [maps.ssim, maps.flip_ldr, maps.flip_hdr].map(|map| f64::from(map[i]));
        tiles.add(i, [squared, signed / 3.0, absolute / 3.0, relative / 3.0, maps[0], maps[1], maps[2]]);
    }
    let [mse, bias, mae, rel_mse] = [square, signed, absolute, relative].map(|sum| mean(sum / 3.0));

    // Take the reference's noise off
    let corrected = match &reference.noise {
        NoiseSource::Halves { halves, .. } => cross_error(&reference.rgb, halves, candidate, chosen()),
        NoiseSource::Given(_) => match reference.noise_mse(masks, mask) {
            Some(noise) => CorrectedError::from_given_noise(mse, noise, pixels),
            None => CorrectedError::UnknownNoise,
        },
    };

    // Noise that was given as a figure is itself uncertain; that of halves is in the scatter of their products
    let (less, more) = match (&reference.noise, corrected) {
        (NoiseSource::Given(_), CorrectedError::Above { mse: above, uncertainty }) => (mse - above, uncertainty),
        _ => (0.0, 0.0),
    };
    let is_below = matches!(corrected, CorrectedError::BelowNoise { .. });
    let not_negative = [0.0, f64::INFINITY];
    let intervals = Intervals {
        corrected_mse: tiles.relative(0, less, more).filter(|_| !is_below),
        bias: tiles.within(1, [f64::NEG_INFINITY, f64::INFINITY]),
        mae: tiles.within(2, not_negative),
        rel_mse: tiles.within(3, not_negative),
        ssim: tiles.within(4, [-1.0, 1.0]),
        flip_ldr: tiles.within(5, [0.0, 1.0]),
        flip_hdr: tiles.within(6, [0.0, 1.0]),
    };

    Figures {
        mask,
        share: masks.share(mask),
        pixels,
        mse,
        corrected,
        bias,
        mae,
        rel_mse,
        ssim: mean_of(maps.ssim),
        flip_ldr: mean_of(maps.flip_ldr),
        flip_hdr: mean_of(maps.flip_hdr),
        intervals,
    }
}

/// The mean of (C - A)(C - B), free of noise, with its standard error.
///
/// With m = C - mean(A, B) and d = A - B the variance of one pixel's product is E[(m d)^2]: for Gaussian noise exactly,
/// whatever C's own error, and the same with the mean over channels inside the square, however they are correlated.
/// Noise is taken as independent from pixel to pixel.
fn cross_error(mean: &Rgb, halves: &[Rgb; 2], candidate: &Rgb, pixels: impl Iterator<Item = usize>) -> CorrectedError {
    let (mut count, mut products, mut variances) = (0_usize, 0.0, 0.0);
    for i in pixels {
        let (m, [a, b], c) = (mean.at(i), [halves[0].at(i), halves[1].at(i)], candidate.at(i));
        let [mut product, mut scatter] = [0.0, 0.0];
        for k in 0..3 {
            let [m, a, b, c] = [m[k], a[k], b[k], c[k]].map(f64::from);
            product += (c - a) * (c - b) / 3.0;
            scatter += (c - m) * (a - b) / 3.0;
        }
        products += product;
        variances += scatter * scatter;
        count += 1;
    }
    let n = count.max(1) as f64;
    CorrectedError::from_estimate(products / n, variances.sqrt() / n)
}

//! A traced picture that knows its own noise.

use optics::Camera;

use crate::{Picture, PixelWindow};

/// Two independently scrambled half pictures of the same thing; the picture is their mean.
///
/// The noise comes from their difference: the sample variance of a low-discrepancy set would overstate it.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The picture proper; the halves' window may be larger or smaller.
    pub display: PixelWindow,
    /// The camera it was taken with, where known.
    pub camera: Option<Camera>,
    /// The two half pictures, of one window.
    pub halves: [Picture; 2],
    /// Samples per pixel in each half; where pixels have different numbers, equal in both halves, the fewest.
    pub samples: [u32; 2],
}

impl Truth {
    /// The picture: the mean of the halves, weighted by their sample counts.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let total = self.samples.iter().map(|&n| u64::from(n)).sum::<u64>().max(1) as f32;
        let [wa, wb] = self.samples.map(|n| n as f32 / total);
        let [a, b] = &self.halves;
        Picture::from_fn(a.window(), |x, y| {
            let (a, b) = (a.at(x, y), b.at(x, y));
            [0, 1, 2, 3].map(|c| wa * a[c] + wb * b[c])
        })
    }

    /// Root mean square error of the mean over R, G and B of `window`, from the difference of the halves.
    ///
    /// With equal halves this is rms(a - b) / 2.
    #[must_use]
    pub fn noise_rmse(&self, window: PixelWindow) -> f64 {
        let [na, nb] = self.samples.map(f64::from);
        // Var(a - b) = s / na + s / nb, and the mean's variance is s / (na + nb)
        let share = (na * nb).sqrt() / (na + nb);
        let [a, b] = &self.halves;
        let window = window.intersection(&a.window());
        let squares: f64 = window
            .pixels()
            .map(|(x, y)| {
                let (a, b) = (a.at(x, y), b.at(x, y));
                (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>()
            })
            .sum();
        share * (squares / (3.0 * window.area().max(1) as f64)).sqrt()
    }
}

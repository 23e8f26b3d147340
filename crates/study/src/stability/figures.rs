//! Errors and changes of pictures, with the truth's own noise told apart.

use rgbd::{Picture, PixelWindow, Truth};
use serde::Serialize;

/// A mean square error (linear values, mean over R, G and B) without the truth's noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The mean square error; noise may make it negative where there is none.
    pub mse: f64,
    /// One standard error that the truth's noise leaves in it.
    pub standard_error: f64,
}

/// How many standard errors an estimate is given: beyond lies one of 740 by chance.
const STANDARD_ERRORS: f64 = 3.0;

impl Estimate {
    /// The root mean square error, 0 where noise makes the square negative.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        self.mse.max(0.0).sqrt()
    }

    /// What the root mean square error very probably exceeds.
    #[must_use]
    pub fn low(&self) -> f64 {
        (self.mse - STANDARD_ERRORS * self.standard_error).max(0.0).sqrt()
    }

    /// What it very probably does not exceed.
    #[must_use]
    pub fn high(&self) -> f64 {
        (self.mse + STANDARD_ERRORS * self.standard_error).max(0.0).sqrt()
    }

    /// The error of a picture of the truth's display window.
    ///
    /// Both halves a and b differ from the perfect picture by independent noise, so that (p - a)(p - b) is the squared
    /// error on average; its variance is about e^2 (a - b)^2 + (a - b)^4 / 4.
    pub(crate) fn new(picture: &Picture, truth: &Truth) -> Self {
        let [a, b] = &truth.halves;
        let (mut sum, mut variance, mut count) = (0.0, 0.0, 0.0);
        for (x, y) in truth.display.pixels() {
            let (p, a, b) = (picture.at(x, y), a.at(x, y), b.at(x, y));
            for c in 0..3 {
                let [p, a, b] = [p[c], a[c], b[c]].map(f64::from);
                let (error, noise) = ((p - a) * (p - b), (a - b).powi(2));
                sum += error;
                variance += error.max(0.0) * noise + 0.25 * noise * noise;
                count += 1.0;
            }
        }
        Self { mse: sum / count, standard_error: variance.sqrt() / count }
    }
}

/// How much a picture changes from one step to the next (linear values, RMS over R, G and B of a pixel).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Change {
    /// Root mean square over the pixels.
    pub(crate) rms: f64,
    /// 99.9th percentile over the pixels.
    pub(crate) peak: f64,
}

impl Change {
    /// From one picture to another.
    pub(crate) fn between(before: &Picture, after: &Picture) -> Self {
        let change = |(x, y): (i32, i32)| {
            let (before, after) = (before.at(x, y), after.at(x, y));
            [0, 1, 2].map(|c| f64::from(after[c]) - f64::from(before[c]))
        };
        Self::of(before.window().pixels().map(change))
    }

    fn of(changes: impl Iterator<Item = [f64; 3]>) -> Self {
        let squares: Vec<f64> = changes.map(|c| c.iter().map(|c| c * c).sum::<f64>() / 3.0).collect();
        let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        Self { rms, peak: percentile(squares, 0.999).sqrt() }
    }
}

/// The value below which a `share` of the values lies.
fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// How much the truth changes from one step to the next (linear values, RMS over R, G and B of a pixel).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct TruthChange {
    /// Root mean square over the pixels, without noise.
    pub rms: f64,
    /// 99.9th percentile over the pixels, with noise.
    pub peak: f64,
    /// Root mean square of the noise in the change.
    pub noise_rms: f64,
    /// Its 99.9th percentile.
    pub noise_peak: f64,
}

impl TruthChange {
    /// From one truth to the next: the halves change by the same, and by what their noise changes by.
    pub(crate) fn between(before: &Truth, after: &Truth) -> Self {
        let changes = |x: i32, y: i32| {
            [0, 1].map(|half: usize| {
                let (before, after) = (before.halves[half].at(x, y), after.halves[half].at(x, y));
                [0, 1, 2].map(|c| f64::from(after[c]) - f64::from(before[c]))
            })
        };
        let window = after.display;
        let mean = |(x, y): (i32, i32)| {
            let [a, b] = changes(x, y);
            [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
        };
        let noise = |(x, y): (i32, i32)| {
            let [a, b] = changes(x, y);
            [0, 1, 2].map(|c| 0.5 * (a[c] - b[c]))
        };
        let (mean, noise) = (Change::of(window.pixels().map(mean)), Change::of(window.pixels().map(noise)));
        let rms = (mean.rms * mean.rms - noise.rms * noise.rms).max(0.0).sqrt();
        Self { rms, peak: mean.peak, noise_rms: noise.rms, noise_peak: noise.peak }
    }
}

/// The picture with 0 where it is not finite, and how many pixels that was.
pub(crate) fn finite(picture: Picture) -> (Picture, usize) {
    let window: PixelWindow = picture.window();
    let is_bad = |(x, y): &(i32, i32)| picture.at(*x, *y).iter().any(|value| !value.is_finite());
    let bad: Vec<(i32, i32)> = window.pixels().filter(is_bad).collect();
    let mut picture = picture;
    for &(x, y) in &bad {
        picture.set(x, y, [0.0; 4]);
    }
    (picture, bad.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentile_leaves_one_in_a_thousand_above() {
        let values: Vec<f64> = (0..10_001).map(f64::from).rev().collect();
        assert_eq!(percentile(values, 0.999), 9990.0);
        assert_eq!(percentile(vec![3.0], 0.999), 3.0);
    }

    #[test]
    fn noise_drops_out_of_the_error_and_of_the_change() {
        const EXACT: f64 = 1e-6; // f32 pictures
        let window = PixelWindow::of_size(20, 10);
        // Noise that differs in sign between the halves, and changes its sign over the picture
        let sign = |x: i32, y: i32| if (x + y) % 2 == 0 { 0.1_f32 } else { -0.1 };
        let truth = |level: f32, noise: f32| {
            let half = |sense: f32| {
                Picture::from_fn(window, |x, y| {
                    let value = level + sense * noise * sign(x, y);
                    [value, value, value, 1.0]
                })
            };
            Truth { display: window, camera: None, halves: [half(1.0), half(-1.0)], samples: [1, 1] }
        };
        let picture = Picture::filled(window, [0.5, 0.5, 0.5, 1.0]);
        let error = Estimate::new(&picture, &truth(0.2, 1.0));
        assert!((error.mse - (0.09 - 0.01)).abs() < EXACT, "anticorrelated noise is taken off twice: {error:?}");
        let change = TruthChange::between(&truth(0.2, 1.0), &truth(0.5, 2.0));
        assert!((change.peak - 0.3).abs() < EXACT && (change.noise_rms - 0.1).abs() < EXACT, "{change:?}");
    }

    #[test]
    fn pixels_that_are_no_numbers_are_counted() {
        let window = PixelWindow::of_size(4, 1);
        let value = |x: i32| [1.0, f32::NAN, f32::INFINITY, 2.0][x as usize];
        let (picture, bad) = finite(Picture::from_fn(window, |x, _| [value(x); 4]));
        assert_eq!((bad, picture.at(1, 0), picture.at(3, 0)), (2, [0.0; 4], [2.0; 4]));
    }
}

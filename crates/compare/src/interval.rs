//! How sure an error figure is: its 95 % confidence interval, from the scatter between tiles of the picture.
//!
//! Neighbouring pixels err alike, so that a picture holds far fewer independent errors than pixels. The picture is cut into
//! tiles of [`TILE`] pixels, more than the reach of most errors, which stand for the clusters of a sample (Cochran 1977,
//! *Sampling Techniques*, section 2.11; to first order the jackknife that leaves out one tile after the other):
//!
//! ```text
//! SE^2 = m / (m - 1) sum over tiles of (S_t - mean N_t)^2 / N^2
//! ```
//!
//! with the sum S_t over the N_t pixels that a tile has in the mask, m tiles, and N pixels in all. So an interval says how
//! the figure might come out on another cut-out of the same kind; it is the same at every run.

use serde::Serialize;

/// Side of a tile in pixels.
pub(crate) const TILE: usize = 16;

/// With fewer tiles no interval is given.
const LEAST_TILES: usize = 8;

/// A 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// Sums over the tiles of a picture, of the pixels within one mask.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TileSums<const N: usize> {
    width: usize,
    tiles: Vec<(f64, [f64; N])>,
}

impl<const N: usize> TileSums<N> {
    /// The tiles of a picture, in none of which there is anything yet.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, tiles: vec![(0.0, [0.0; N]); width.div_ceil(TILE) * height.div_ceil(TILE)] }
    }

    /// Adds the values of pixel `i` (row by row).
    pub(crate) fn add(&mut self, i: usize, values: [f64; N]) {
        let (column, row) = (i % self.width / TILE, i / self.width / TILE);
        let (count, sums) = &mut self.tiles[row * self.width.div_ceil(TILE) + column];
        *count += 1.0;
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }

    /// The interval around the mean of value `k` whose ends are a factor away from it: for sizes that scatter over orders of
    /// magnitude. `more` is a standard error of another source, `less` is taken off the mean.
    pub(crate) fn relative(&self, k: usize, less: f64, more: f64) -> Option<Interval> {
        let (mean, half) = self.half_width(k, more)?;
        let mean = mean - less;
        (mean > 0.0).then(|| {
            let factor = (half / mean).min(700.0).exp();
            Interval { low: mean / factor, high: mean * factor }
        })
    }

    /// The interval around the mean of value `k`, equally far on both sides, within `limits`.
    pub(crate) fn within(&self, k: usize, limits: [f64; 2]) -> Option<Interval> {
        let (mean, half) = self.half_width(k, 0.0)?;
        Some(Interval { low: (mean - half).max(limits[0]), high: (mean + half).min(limits[1]) })
    }

    /// The mean of value `k` and half the width of its interval.
    fn half_width(&self, k: usize, more: f64) -> Option<(f64, f64)> {
        let tiles = || self.tiles.iter().filter(|(count, _)| *count > 0.0);
        let m = tiles().count();
        if m < LEAST_TILES {
            return None;
        }
        let count: f64 = tiles().map(|(count, _)| count).sum();
        let mean = tiles().map(|(_, sums)| sums[k]).sum::<f64>() / count;
        let scatter: f64 = tiles().map(|(count, sums)| (sums[k] - mean * count).powi(2)).sum();
        let degrees = m as f64 - 1.0;
        let standard_error = (m as f64 / degrees * scatter).sqrt() / count;
        Some((mean, student(degrees) * standard_error.hypot(more)))
    }
}

/// The 97.5 % point of Student's t, within 0.5 % from 7 degrees of freedom on.
fn student(degrees: f64) -> f64 {
    1.96 + 2.37 / degrees + 2.8 / (degrees * degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_students_t_are_the_tabled_ones() {
        for (degrees, tabled) in [(7.0, 2.3646), (10.0, 2.2281), (30.0, 2.0423), (120.0, 1.9799)] {
            assert!((student(degrees) / tabled - 1.0).abs() < 0.005, "{degrees}: {}", student(degrees));
        }
    }

    #[test]
    fn a_constant_error_is_known_exactly_and_few_tiles_tell_nothing() {
        let mut sums = TileSums::<1>::new(64, 48);
        (0..64 * 48).for_each(|i| sums.add(i, [0.25]));
        assert_eq!(sums.within(0, [0.0, 1.0]), Some(Interval { low: 0.25, high: 0.25 }));
        assert_eq!(sums.relative(0, 0.0, 0.0), Some(Interval { low: 0.25, high: 0.25 }));
        let mut sums = TileSums::<1>::new(64, 16);
        (0..64 * 16).for_each(|i| sums.add(i, [0.25]));
        assert_eq!(sums.within(0, [0.0, 1.0]), None, "four tiles");
    }

    #[test]
    fn the_interval_holds_the_true_mean_as_often_as_it_says() {
        // Errors alike within blocks of 8 pixels: a tenth of the blocks err by 1 (a mean of 0.1), the others not at all
        const TRIALS: u64 = 400;
        let hash = |mut z: u64| {
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ (z >> 31)) >> 11
        };
        let [mut within, mut relative] = [0, 0];
        for trial in 0..TRIALS {
            let mut sums = TileSums::<1>::new(256, 144);
            for i in 0..256 * 144_u64 {
                let block = (i % 256 / 8) + 32 * (i / 256 / 8);
                let seed = (trial * 1000 + block + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                sums.add(i as usize, [if hash(seed) % 10 == 0 { 1.0 } else { 0.0 }]);
            }
            let holds = |interval: Option<Interval>| interval.is_some_and(|i| i.low <= 0.1 && 0.1 <= i.high);
            within += u32::from(holds(sums.within(0, [0.0, 1.0])));
            relative += u32::from(holds(sums.relative(0, 0.0, 0.0)));
        }
        // 95 % of 400 are 380 with a standard deviation of 4.4: 4 of those on either side, false alarm 6e-5
        for held in [within, relative] {
            assert!((362..=398).contains(&held), "{held} of {TRIALS}");
        }
    }
}

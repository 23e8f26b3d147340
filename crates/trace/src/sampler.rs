//! Where in the pixel and where on the lens a sample lies.

use glam::DVec2;
use sobol_burley::sample_4d;

/// Length of a pixel's sequence in each half.
pub const MAX_SAMPLES: u32 = 1 << 16;

/// How many other points of the lens a sample may try; the least open lens, a fifth of it, blocks that many in a row once in
/// 10^9 samples.
pub(crate) const MAX_ATTEMPTS: u32 = 96;

/// The Owen-scrambled Sobol sequence of one pixel in one half (Burley, "Practical Hash-based Owen Scrambling", JCGT
/// 2020): four dimensions well spread together, pixel x, y and lens u, v.
///
/// A point depends on (pixel, half, sample index, seed) alone. Every pixel and half has a scramble of its own, so that
/// errors of neighbours, and of the halves, are independent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampler {
    scramble: u32,
}

/// One sample: its offset in the pixel and its point on the lens, both in [0, 1)^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) pixel: DVec2,
    pub(crate) lens: DVec2,
}

impl Sampler {
    /// The sequence of pixel (x, y), counted from the display window's top left corner.
    pub(crate) fn new(seed: u64, x: i32, y: i32, half: usize) -> Self {
        let place = u64::from(x as u32) << 32 | u64::from(y as u32);
        let mixed = mix(mix(seed ^ (half as u64) << 63) ^ place);
        Self { scramble: (mixed >> 32) as u32 }
    }

    /// Sample `index`, below [`MAX_SAMPLES`].
    #[inline]
    pub(crate) fn sample(&self, index: u32) -> Sample {
        let [x, y, u, v] = sample_4d(index, 0, self.scramble).map(f64::from);
        Sample { pixel: DVec2::new(x, y), lens: DVec2::new(u, v) }
    }

    /// Another point on the lens for sample `index`, should the lens block the first: one for each `attempt` from 1 to
    /// [`MAX_ATTEMPTS`], from dimensions of its own.
    #[inline]
    pub(crate) fn other_lens(&self, index: u32, attempt: u32) -> DVec2 {
        let [a, b, c, d] = sample_4d(index, attempt.div_ceil(2), self.scramble).map(f64::from);
        if attempt % 2 == 1 { DVec2::new(a, b) } else { DVec2::new(c, d) }
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014), after one step of its counter.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_halves_and_seeds_differ() {
        let first = |seed, x, y, half| Sampler::new(seed, x, y, half).scramble;
        let all = [first(1, 0, 0, 0), first(1, 1, 0, 0), first(1, 0, 1, 0), first(1, 0, 0, 1), first(2, 0, 0, 0)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b), "{all:?}");
        }
        assert_ne!(first(1, -1, 0, 0), first(1, 0, -1, 0));
    }

    #[test]
    fn every_power_of_two_is_stratified_in_pixel_and_lens() {
        // 16 samples fall into each cell of a 4 x 4 grid once, in the pixel and on the lens
        let sampler = Sampler::new(7, 12, 34, 1);
        let cell = |p: DVec2| (p * 4.0).floor().dot(DVec2::new(1.0, 4.0)) as usize;
        for first in [0, 16, 48] {
            let (mut pixel, mut lens) = ([0; 16], [0; 16]);
            for index in first..first + 16 {
                let sample = sampler.sample(index);
                pixel[cell(sample.pixel)] += 1;
                lens[cell(sample.lens)] += 1;
            }
            assert_eq!((pixel, lens), ([1; 16], [1; 16]));
        }
    }
}

//! Where in the pixel and where on the lens a sample lies.

use std::sync::LazyLock;

use fearless_simd::{f32x8, prelude::*, u32x8};
use glam::DVec2;
use sobol_burley::parts::sobol_rev;
use sobol_burley::{sample, sample_4d};

use crate::Ray;

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
    /// Whether there is a time too.
    is_timed: bool,
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
        Self { scramble: (mixed >> 32) as u32, is_timed: false }
    }

    /// The same with a time in the exposure as fifth dimension, if anything moves in it; the first four stay.
    pub(crate) fn timed(self, is_timed: bool) -> Self {
        Self { is_timed, ..self }
    }

    /// When sample `index` is taken: 0 as the shutter opens, 1 as it closes; its middle where nothing moves.
    #[inline]
    pub(crate) fn time(&self, index: u32) -> f32 {
        if self.is_timed { sample(index, 4, self.scramble) } else { Ray::MIDDLE }
    }

    /// The first set of four dimensions that nothing above has taken.
    #[inline]
    pub(crate) fn free_set(&self) -> u32 {
        1 + u32::from(self.is_timed)
    }

    /// What tells this sequence from all others.
    pub(crate) fn scramble(&self) -> u32 {
        self.scramble
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
        let [a, b, c, d] = sample_4d(index, attempt.div_ceil(2) - 1 + self.free_set(), self.scramble).map(f64::from);
        if attempt % 2 == 1 { DVec2::new(a, b) } else { DVec2::new(c, d) }
    }
}

/// What each bit of a sample index does to each of the four dimensions, bits reversed.
static DIRECTIONS: LazyLock<[[u32; 4]; 16]> =
    LazyLock::new(|| std::array::from_fn(|bit| std::array::from_fn(|k| sobol_rev(1 << (31 - bit), k as u32))));

/// Eight samples at once, of any sequences: pixel x, y and lens u, v, the same bits as [`Sampler::sample`].
#[inline(always)]
pub(crate) fn eight_samples<S: Simd>(simd: S, samplers: &[Sampler; 8], indices: &[u32; 8]) -> [f32x8<S>; 4] {
    let mut seeds = [0; 8];
    for (seed, sampler) in seeds.iter_mut().zip(samplers) {
        *seed = sampler.scramble;
    }
    let seeds = u32x8::load_array(simd, seeds);
    let indices = reversed(u32x8::load_array_ref(simd, indices));
    let shuffled = scrambled(indices, hashed(seeds ^ 0x79c6_8e4a));

    // Sum up the directions of the bits that are set
    let mut sobol = [u32x8::splat(simd, 0); 4];
    for (bit, directions) in DIRECTIONS.iter().enumerate() {
        let is_set = u32x8::splat(simd, 0) - ((shuffled >> (31 - bit as u32)) & 1);
        sobol[0] ^= is_set & directions[0];
        sobol[1] ^= is_set & directions[1];
        sobol[2] ^= is_set & directions[2];
        sobol[3] ^= is_set & directions[3];
    }

    // Scramble each dimension in its own way
    let seeds = seeds * 0x9c8f_2d3b;
    [
        unit(scrambled(sobol[0], hashed(seeds ^ 0x912f_69ba))),
        unit(scrambled(sobol[1], hashed(seeds ^ 0x174f_18ab))),
        unit(scrambled(sobol[2], hashed(seeds ^ 0x691e_72ca))),
        unit(scrambled(sobol[3], hashed(seeds ^ 0xb40c_c1b8))),
    ]
}

/// `sobol_burley::parts::owen_scramble_rev` in lanes.
#[inline(always)]
fn scrambled<S: Simd>(mut n: u32x8<S>, scramble: u32x8<S>) -> u32x8<S> {
    n ^= n * 0x3d20_adea;
    n += scramble;
    n *= (scramble >> 16) | 1;
    n ^= n * 0x0552_6c56;
    n ^ (n * 0x53a2_2864)
}

/// `sobol_burley::parts::hash` in lanes.
#[inline(always)]
fn hashed<S: Simd>(mut n: u32x8<S>) -> u32x8<S> {
    n ^= 0xe6fe_3beb;
    n ^= n >> 16;
    n *= 0x7feb_352d;
    n ^= n >> 15;
    n *= 0x846c_a68b;
    n ^ (n >> 16)
}

/// Bits in reverse order.
#[inline(always)]
fn reversed<S: Simd>(mut n: u32x8<S>) -> u32x8<S> {
    n = ((n >> 1) & 0x5555_5555) | ((n & 0x5555_5555) << 1);
    n = ((n >> 2) & 0x3333_3333) | ((n & 0x3333_3333) << 2);
    n = ((n >> 4) & 0x0f0f_0f0f) | ((n & 0x0f0f_0f0f) << 4);
    n = ((n >> 8) & 0x00ff_00ff) | ((n & 0x00ff_00ff) << 8);
    (n >> 16) | (n << 16)
}

/// Reversed integers as numbers in [0, 1).
#[inline(always)]
fn unit<S: Simd>(n: u32x8<S>) -> f32x8<S> {
    let from_one_to_two: f32x8<S> = ((reversed(n) >> 9) | 0x3f80_0000).bitcast();
    from_one_to_two - 1.0
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
    use fearless_simd::dispatch;

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
    fn samples_in_lanes_have_the_same_bits() {
        for level in crate::levels::all() {
            for first in [0_u32, 1000, 65_528] {
                let samplers = std::array::from_fn(|i| Sampler::new(3, 17, 1 << i, i % 2));
                let indices = std::array::from_fn(|i| first + i as u32);
                let lanes = dispatch!(level, simd => eight_samples(simd, &samplers, &indices).map(SimdBase::to_array));
                for i in 0..8 {
                    let Sample { pixel, lens } = samplers[i].sample(indices[i]);
                    let found = lanes.map(|n| f64::from(n[i]));
                    assert_eq!(found, [pixel.x, pixel.y, lens.x, lens.y], "{level:?}, sample {}", indices[i]);
                }
            }
        }
    }

    #[test]
    fn time_is_stratified_and_spread_over_pixel_and_lens() {
        const COUNT: u32 = 64;
        let mut squares = [0.0_f64; 4];
        for x in 0..200 {
            let sampler = Sampler::new(5, x, 4, 0).timed(true);
            let untimed = Sampler::new(5, x, 4, 0);
            let mut counts = [0; COUNT as usize];
            let mut sums = [0.0_f64; 4];
            for index in 0..COUNT {
                let (sample, time) = (sampler.sample(index), sampler.time(index));
                assert_eq!((sample, untimed.time(index)), (untimed.sample(index), Ray::MIDDLE));
                counts[(time * COUNT as f32) as usize] += 1;
                let place = [sample.pixel.x, sample.pixel.y, sample.lens.x, sample.lens.y];
                sums.iter_mut().zip(place).for_each(|(sum, x)| *sum += (x - 0.5) * (f64::from(time) - 0.5));
            }
            assert_eq!(counts, [1; COUNT as usize]);
            squares.iter_mut().zip(sums).for_each(|(square, sum)| *square += sum * sum / 200.0);
        }
        // Independent numbers would have sums with a standard deviation of sqrt(64) / 12
        let shares = squares.map(|square| square.sqrt() / (f64::from(COUNT).sqrt() / 12.0));
        assert!(shares.iter().all(|&share| share < 0.8), "{shares:?}");
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

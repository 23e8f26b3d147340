//! Random numbers of one path, one set of four after the other.

use sobol_burley::{NUM_DIMENSION_SETS_4D, sample_4d};

use crate::sampler::{MAX_ATTEMPTS, Sampler};

/// The dimensions of one sample that come after those of pixel and lens.
///
/// Sets of four follow each other in the pixel's own Sobol sequence; when it has no more, the same sets come again, newly
/// scrambled. So a number depends on (pixel, half, sample index, seed, dimension) alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream {
    scramble: u32,
    index: u32,
    set: u32,
    /// Numbers that no sequence holds: how often something was left to chance.
    chances: u32,
}

impl Stream {
    /// What follows sample `index`. With `after_lens` the sets are left out of which the lens may have taken another point.
    pub(crate) fn new(sampler: &Sampler, index: u32, after_lens: bool) -> Self {
        let set = sampler.free_set() + if after_lens { MAX_ATTEMPTS / 2 } else { 0 };
        Self { scramble: sampler.scramble(), index, set, chances: 0 }
    }

    /// Four numbers in [0, 1), well spread together over the samples of a pixel.
    #[inline]
    pub(crate) fn four(&mut self) -> [f32; 4] {
        let set = self.set;
        self.set += 1;
        if set < NUM_DIMENSION_SETS_4D {
            return sample_4d(self.index, set, self.scramble);
        }
        sample_4d(self.index, 0, mixed(self.scramble ^ mixed(set)))
    }

    /// A number in [0, 1) by chance.
    #[inline]
    pub(crate) fn chance(&mut self) -> f32 {
        self.chances += 1;
        let bits = mixed(self.scramble ^ mixed(self.index ^ mixed(self.chances)));
        (bits >> 8) as f32 / (1 << 24) as f32
    }
}

/// A bijection of 32 bits (Wellons, "Prospecting for Hash Functions", 2018).
fn mixed(mut x: u32) -> u32 {
    x = x.wrapping_add(0x9e37_79b9);
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_fills_each_cell_once_and_sets_differ() {
        let sampler = Sampler::new(3, 5, 7, 0);
        // Beyond the sequence's own sets too
        for set in [0, 1, 30, 61, 62, 63, 80] {
            let at = |index: u32| {
                let mut stream = Stream::new(&sampler, index, false);
                (0..set).for_each(|_| _ = stream.four());
                stream.four()
            };
            for axis in 0..4 {
                let mut counts = [0; 16];
                (0..16).for_each(|index| counts[(at(index)[axis] * 16.0) as usize] += 1);
                assert_eq!(counts, [1; 16], "set {set}, dimension {axis}");
            }
        }
        let mut stream = Stream::new(&sampler, 0, false);
        let sets: Vec<_> = (0..100).map(|_| stream.four()).collect();
        assert!((1..100).all(|i| !sets[..i].contains(&sets[i])));
    }

    #[test]
    fn chance_is_uniform() {
        // 20,000 numbers in 20 classes: chi-square with 19 degrees of freedom exceeds 36.2 once in a hundred
        let mut counts = [0_i32; 20];
        for index in 0..100 {
            let mut stream = Stream::new(&Sampler::new(1, 2, 3, 1), index, false);
            (0..200).for_each(|_| counts[(stream.chance() * 20.0) as usize] += 1);
        }
        let chi: f64 = counts.iter().map(|&n| f64::from((n - 1000).pow(2)) / 1000.0).sum();
        assert!(chi < 36.2, "{chi}");
    }
}

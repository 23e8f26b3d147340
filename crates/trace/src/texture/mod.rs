//! Pictures on surfaces: decoded once, filtered by how much of them a ray sees.

mod decode;
mod map;

use glam::{Vec2, Vec4};

pub(crate) use decode::decode;
pub use decode::{Encoding, TextureError};
pub use map::{TextureMap, Wrap};

/// A picture with all its halvings, in linear values of 16 bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    levels: Vec<Level>,
}

/// One size of a texture, rows from the top.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[u16; 4]>,
}

impl Level {
    fn at(&self, x: usize, y: usize) -> Vec4 {
        let [r, g, b, a] = self.texels[y * self.width + x].map(f32::from);
        Vec4::new(r, g, b, a) / f32::from(u16::MAX)
    }

    /// The mean of each two by two texels; colours count as much as they are opaque.
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let texel = |i: usize| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            let (x1, y1) = ((x + 1).min(self.width - 1), (y + 1).min(self.height - 1));
            let four = [self.at(x, y), self.at(x1, y), self.at(x, y1), self.at(x1, y1)];
            let alpha = four.iter().map(|texel| texel.w).sum::<f32>();
            let plain = four.iter().sum::<Vec4>() / 4.0;
            let weighted = four.iter().map(|&texel| texel * texel.w).sum::<Vec4>() / alpha.max(f32::MIN_POSITIVE);
            let mean = if alpha > 0.0 { weighted.truncate().extend(alpha / 4.0) } else { plain };
            mean.to_array().map(|value| (value * f32::from(u16::MAX) + 0.5) as u16)
        };
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }

    /// Bilinear between the centres of texels.
    fn smooth(&self, uv: Vec2, wrap: [Wrap; 2]) -> Vec4 {
        let along = |t: f32, size: usize, wrap: Wrap| {
            let place = wrap.into_unit(t) * size as f32 - 0.5;
            let first = place.floor();
            let index = |i: i64| wrap.index(i, size);
            (index(first as i64), index(first as i64 + 1), place - first)
        };
        let (x0, x1, fx) = along(uv.x, self.width, wrap[0]);
        let (y0, y1, fy) = along(uv.y, self.height, wrap[1]);
        let above = self.at(x0, y0).lerp(self.at(x1, y0), fx);
        let below = self.at(x0, y1).lerp(self.at(x1, y1), fx);
        above.lerp(below, fy)
    }
}

impl Texture {
    /// A texture of linear RGBA in [0, 1], row by row from the top; `None` unless there are as many texels as it says.
    #[must_use]
    pub fn from_linear(width: usize, height: usize, texels: &[[f32; 4]]) -> Option<Self> {
        if texels.is_empty() || width.checked_mul(height) != Some(texels.len()) {
            return None;
        }
        let coded = |texel: &[f32; 4]| texel.map(|value| (value.clamp(0.0, 1.0) * f32::from(u16::MAX) + 0.5) as u16);
        Some(Self::new(width, height, texels.iter().map(coded).collect()))
    }

    fn new(width: usize, height: usize, texels: Vec<[u16; 4]>) -> Self {
        let mut levels = vec![Level { width, height, texels }];
        while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
            let next = last.halved();
            levels.push(next);
        }
        Self { levels }
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The value at (u, v), v down from the top, averaged over about `texels` of its texels: between the two nearest
    /// halvings, each bilinear.
    #[must_use]
    pub fn sample(&self, uv: Vec2, wrap: [Wrap; 2], texels: f32) -> Vec4 {
        let level = texels.max(1.0).log2().min((self.levels.len() - 1) as f32);
        let fine = level.floor();
        let (index, share) = (fine as usize, level - fine);
        let value = self.levels[index].smooth(uv, wrap);
        if share <= 0.0 { value } else { value.lerp(self.levels[index + 1].smooth(uv, wrap), share) }
    }

    /// The mean over all of it.
    #[must_use]
    pub fn mean(&self) -> Vec4 {
        self.levels[self.levels.len() - 1].at(0, 0)
    }

    /// Adds it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        let base = &self.levels[0];
        fingerprint.update(&(base.width as u64).to_le_bytes());
        base.texels.iter().flatten().for_each(|value| fingerprint.update(&value.to_le_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a step of 16 bits, and f32 after it.
    const CODED: f32 = 1e-5;

    fn checker() -> Texture {
        let texel = |i: i32| if (i % 4 + i / 4) % 2 == 0 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
        Texture::from_linear(4, 4, &(0..16).map(texel).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn texel_centres_are_exact_and_between_them_it_is_linear() {
        let texture = checker();
        let red = |u: f32, v: f32| texture.sample(Vec2::new(u, v), [Wrap::Repeat; 2], 0.0).x;
        assert_eq!((red(0.125, 0.125), red(0.375, 0.125)), (1.0, 0.0));
        assert!((red(0.25, 0.125) - 0.5).abs() < CODED);
        assert!((red(0.3125, 0.125) - 0.25).abs() < CODED);
    }

    #[test]
    fn a_wide_footprint_sees_the_mean() {
        let texture = checker();
        for texels in [4.0, 100.0, f32::INFINITY] {
            let value = texture.sample(Vec2::new(0.3, 0.8), [Wrap::Repeat; 2], texels);
            assert!((value.x - 0.5).abs() < CODED, "{value}");
        }
        assert!((texture.mean().x - 0.5).abs() < CODED);
    }

    #[test]
    fn what_is_transparent_does_not_colour_what_is_not() {
        let leaf = [[0.0, 1.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0; 4]];
        let texture = Texture::from_linear(2, 2, &leaf).unwrap();
        assert!((texture.mean() - Vec4::new(0.0, 1.0, 0.0, 0.25)).abs().max_element() < CODED);
    }

    #[test]
    fn wrapping_repeats_mirrors_or_stays_at_the_rim() {
        let ramp: Vec<_> = (0..4).map(|i| [i as f32 / 4.0; 4]).collect();
        let texture = Texture::from_linear(4, 1, &ramp).unwrap();
        let at = |u: f32, wrap: Wrap| texture.sample(Vec2::new(u, 0.5), [wrap; 2], 0.0).x;
        for u in [0.125, 0.6, 0.875] {
            assert!((at(u + 7.0, Wrap::Repeat) - at(u, Wrap::Repeat)).abs() < 1e-4);
            assert!((at(u - 3.0, Wrap::Repeat) - at(u, Wrap::Repeat)).abs() < 1e-4);
            assert!((at(2.0 - u, Wrap::Mirror) - at(u, Wrap::Mirror)).abs() < 1e-4);
            assert!((at(u + 4.0, Wrap::Mirror) - at(u, Wrap::Mirror)).abs() < 1e-4);
        }
        assert_eq!((at(-5.0, Wrap::Clamp), at(9.0, Wrap::Clamp)), (0.0, at(0.875, Wrap::Clamp)));
        // Neither numbers that are none nor huge ones fall out of the picture
        for u in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!(at(u, wrap).is_finite());
            }
        }
    }
}

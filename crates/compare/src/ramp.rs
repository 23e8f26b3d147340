//! Colours for numbers: lightness follows the number, so that the maps also read in grey.
//!
//! Anchor colours are joined in Oklab (Ottosson 2020) and placed by their own lightness, which makes lightness exactly
//! linear in the number.

use rgbd::srgb_byte;

use crate::transfer::linear_from_srgb;

/// Darkness to pale yellow, for errors from 0 up.
const SEQUENTIAL: [u32; 7] = [0x08_0a18, 0x2b_1d5c, 0x6b_2a7d, 0xb6_3a6b, 0xea_6247, 0xfb_a63c, 0xfd_f3b0];
/// Paper to dark blue, for what is too dark.
const NEGATIVE: [u32; 4] = [0xf6_f5f2, 0x8d_bfe3, 0x2f_74b5, 0x0c_2a5e];
/// Paper to dark red, for what is too bright.
const POSITIVE: [u32; 4] = [0xf6_f5f2, 0xf2_ab7f, 0xc4_463a, 0x5e_0f1c];

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ramp {
    /// 0 dark, 1 light; for sizes.
    Sequential,
    /// -1 dark blue, 0 paper, 1 dark red; for signed differences.
    Diverging,
}

impl Ramp {
    /// Colour in linear Rec. 709 of a number, clipped to the ramp's range.
    #[must_use]
    pub fn color(self, t: f32) -> [f32; 3] {
        let t = f64::from(t);
        match self {
            Self::Sequential => along(&SEQUENTIAL, t),
            Self::Diverging if t < 0.0 => along(&NEGATIVE, -t),
            Self::Diverging => along(&POSITIVE, t),
        }
        .map(|value| value as f32)
    }

    /// The same as a CSS colour.
    #[must_use]
    pub fn css(self, t: f32) -> String {
        let [r, g, b] = self.color(t).map(srgb_byte);
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// The colour at `t` in [0, 1] of anchors whose Oklab lightness rises or falls throughout.
fn along(anchors: &[u32], t: f64) -> [f64; 3] {
    let lab = |i: usize| oklab_from_linear(anchor(anchors[i]));
    let (first, last) = (lab(0)[0], lab(anchors.len() - 1)[0]);
    let place = |i: usize| (lab(i)[0] - first) / (last - first);

    // Find the pair of anchors around t
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let next = (1..anchors.len() - 1).find(|&i| place(i) >= t).unwrap_or(anchors.len() - 1);
    let (a, b) = (lab(next - 1), lab(next));
    let share = (t - place(next - 1)) / (place(next) - place(next - 1));
    linear_from_oklab([0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))).map(|value| value.clamp(0.0, 1.0))
}

/// Linear Rec. 709 of 0xRRGGBB.
fn anchor(rgb: u32) -> [f64; 3] {
    [16, 8, 0].map(|shift| linear_from_srgb(f64::from((rgb >> shift) & 0xff) / 255.0))
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Oklab of linear Rec. 709.
fn oklab_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let lms = times(
        &[
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ],
        rgb,
    );
    times(
        &[
            [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ],
        lms.map(f64::cbrt),
    )
}

/// Linear Rec. 709 of Oklab.
fn linear_from_oklab(lab: [f64; 3]) -> [f64; 3] {
    let lms = times(
        &[
            [1.0, 0.396_337_777_4, 0.215_803_757_3],
            [1.0, -0.105_561_345_8, -0.063_854_172_8],
            [1.0, -0.089_484_177_5, -1.291_485_548_0],
        ],
        lab,
    );
    times(
        &[
            [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
            [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
            [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
        ],
        lms.map(|value| value.powi(3)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_is_linear_in_the_number() {
        const GAMUT: f64 = 0.02; // between two anchors a mixture may touch the edge of Rec. 709
        for (ramp, sign) in [(Ramp::Sequential, 1.0), (Ramp::Diverging, 1.0), (Ramp::Diverging, -1.0)] {
            let lightness = |i: i32| oklab_from_linear(ramp.color(sign * i as f32 / 64.0).map(f64::from))[0];
            let (first, last) = (lightness(0), lightness(64));
            assert!((first - last).abs() > 0.5, "{ramp:?} spans most of the lightness");
            for i in 0..=64 {
                let expected = first + (last - first) * f64::from(i) / 64.0;
                assert!((lightness(i) - expected).abs() < GAMUT, "{ramp:?} at {i}/64");
            }
        }
    }

    #[test]
    fn the_ends_are_the_anchors_and_beyond_them_nothing_changes() {
        assert_eq!(Ramp::Sequential.css(0.0), "#080a18");
        assert_eq!(Ramp::Sequential.css(7.0), "#fdf3b0");
        assert_eq!([-9.0, 0.0, 1.0].map(|t| Ramp::Diverging.css(t)), ["#0c2a5e", "#f6f5f2", "#5e0f1c"]);
        assert_eq!(Ramp::Sequential.css(f32::NAN), Ramp::Sequential.css(0.0));
    }
}

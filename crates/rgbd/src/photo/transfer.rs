//! From stored numbers to light and back.

use std::sync::Arc;

use crate::srgb_byte;

/// What a stored number, from 0 to 1, is in light.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Transfer {
    /// Itself.
    Linear,
    /// IEC 61966-2-1.
    Srgb,
    /// For red, green and blue the light of each of 65536 stored numbers; never falling.
    Curves(Arc<[Vec<f32>; 3]>),
}

/// Stored numbers of a curve.
pub(super) const STEPS: usize = 1 << 16;

impl Transfer {
    /// Light of all stored numbers of `count` (256 or 65536) in channel `c`.
    pub(super) fn table(&self, c: usize, count: usize) -> Vec<f32> {
        let last = (count - 1) as f64;
        let steps_apart = (STEPS - 1) / (count - 1);
        let light = |i: usize| match self {
            Self::Linear => (i as f64 / last) as f32,
            Self::Srgb => srgb_decoded(i as f64 / last) as f32,
            Self::Curves(curves) => curves[c][i * steps_apart],
        };
        (0..count).map(light).collect()
    }

    /// The byte nearest to a light; below 0 and NaN give 0, above 1 gives 255.
    pub(super) fn byte(&self, c: usize, light: f32) -> u8 {
        match self {
            Self::Srgb => srgb_byte(light),
            _ => (255.0 * self.stored(c, light)).round() as u8,
        }
    }

    /// The 16-bit number nearest to a light; below 0 and NaN give 0, above 1 gives 65535.
    pub(super) fn word(&self, c: usize, light: f32) -> u16 {
        (65535.0 * self.stored(c, light)).round() as u16
    }

    /// The stored number, from 0 to 1, of a light.
    fn stored(&self, c: usize, light: f32) -> f64 {
        let light = if light > 0.0 { light.min(1.0) } else { 0.0 };
        match self {
            Self::Linear => f64::from(light),
            Self::Srgb => srgb_encoded(f64::from(light)),
            Self::Curves(curves) => {
                // Between the two steps around it
                let curve = &curves[c];
                let above = curve.partition_point(|&step| step < light).min(STEPS - 1);
                let below = above.saturating_sub(1);
                let gap = curve[above] - curve[below];
                let part = if gap > 0.0 { ((light - curve[below]) / gap).clamp(0.0, 1.0) } else { 1.0 };
                (below as f64 + f64::from(part) * (above - below) as f64) / (STEPS - 1) as f64
            }
        }
    }
}

/// sRGB's transfer from a stored number to light.
pub(super) fn srgb_decoded(stored: f64) -> f64 {
    if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

fn srgb_encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

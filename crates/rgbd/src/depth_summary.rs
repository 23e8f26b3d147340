//! What there is in a depth channel, in a few numbers.

use crate::{Layer, Plane};

/// How near and how far, and how much of it is sky or not known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DepthSummary {
    /// Nearest and farthest finite depth, planar, in scene units; `None` where there is none.
    pub range: Option<[f32; 2]>,
    /// Pixels of finite depth.
    pub finite: u64,
    /// Pixels that are infinitely far: the sky.
    pub infinite: u64,
    /// Pixels whose depth is not known: holes.
    pub unknown: u64,
    /// The stored number that is taken as infinitely far, where it is one number in all pixels.
    pub background: Option<f32>,
    /// The stored number that is taken as not known, where it is one number in all pixels; it may be NaN.
    pub hole: Option<f32>,
}

/// The one number that was met, if it was one.
#[derive(Default)]
enum OnlyOne {
    #[default]
    None,
    One(f32),
    Many,
}

impl OnlyOne {
    fn meet(&mut self, value: f32) {
        *self = match *self {
            Self::None => Self::One(value),
            Self::One(one) if one == value || (one.is_nan() && value.is_nan()) => Self::One(one),
            _ => Self::Many,
        };
    }

    fn value(&self) -> Option<f32> {
        if let Self::One(value) = *self { Some(value) } else { None }
    }
}

impl DepthSummary {
    /// Of pairs of a stored number and the planar depth it means, NaN where that is not known.
    pub(crate) fn of(pixels: impl Iterator<Item = (f32, f32)>) -> Self {
        let mut summary = Self::default();
        let (mut background, mut hole) = (OnlyOne::None, OnlyOne::None);
        for (stored, depth) in pixels {
            if depth.is_nan() {
                summary.unknown += 1;
                hole.meet(stored);
            } else if depth.is_infinite() {
                summary.infinite += 1;
                background.meet(stored);
            } else {
                let [near, far] = summary.range.unwrap_or([depth; 2]);
                summary.range = Some([near.min(depth), far.max(depth)]);
                summary.finite += 1;
            }
        }
        Self { background: background.value(), hole: hole.value(), ..summary }
    }

    /// Of planar depths, NaN where they are not known.
    #[must_use]
    pub fn of_depths(depths: &Plane) -> Self {
        Self { background: None, hole: None, ..Self::of(depths.values().iter().map(|&z| (z, z))) }
    }

    /// Of a layer, whose stored numbers are not there any more.
    pub(crate) fn of_planar(layer: &Layer) -> Self {
        let depths = layer.depth.values().iter().zip(layer.known.bits());
        let pixels = depths.map(|(&z, &known)| if known { (z, z) } else { (f32::NAN, f32::NAN) });
        Self { background: None, hole: None, ..Self::of(pixels) }
    }
}

//! HDR-FLIP: the worst LDR-FLIP over the exposures at which one might look at the picture.
//!
//! Andersson, Nilsson, Shirley, Akenine-Moller: *Visualizing Errors in Rendered High Dynamic Range Images*,
//! Eurographics 2021. Tone mapper: ACES as fitted by Narkowicz, with its pre-exposure of 0.6 cancelled.

use serde::Serialize;

use crate::{flip_ldr::Flip, rgb::Rgb};

/// ACES: `(c0 x^2 + c1 x + c2) / (c3 x^2 + c4 x + c5)`.
const ACES: [f64; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// The display value that the brightest pixel is exposed to at the start, the median at the stop.
const TARGET: f64 = 0.85;

/// The exposures over which HDR-FLIP looks for the largest error, in stops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Exposures {
    /// At which the brightest pixel of the reference is not yet burnt out.
    pub start: f64,
    /// At which its median is not yet.
    pub stop: f64,
    /// How many, spread evenly from start to stop, both included; at least 2.
    pub count: u32,
}

impl Exposures {
    /// The exposures for a reference, from its largest and its median luminance.
    ///
    /// The paper leaves a black picture or median open: then the median of what is not black counts, and stop 0 where
    /// all is black.
    pub(crate) fn of(reference: &Rgb) -> Self {
        // Solve for the linear value that is mapped to the target
        let [a, b, c] = [0, 1, 2].map(|i| ACES[i] - TARGET * ACES[i + 3]);
        let half = -0.5 * b / a;
        let white = half + (half * half - c / a).sqrt();

        // Find the largest and the median luminance
        let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let mut luminances: Vec<f32> = (0..reference.len()).map(|i| luminance(reference.at(i))).collect();
        luminances.sort_unstable_by(f32::total_cmp);
        let brightest = luminances[luminances.len() - 1];
        let mut median = luminances[luminances.len() / 2];
        if median <= 0.0 {
            let first_lit = luminances.partition_point(|&y| y <= 0.0);
            median = luminances[first_lit..].get((luminances.len() - first_lit) / 2).copied().unwrap_or(0.0);
        }
        if median <= 0.0 {
            return Self { start: 0.0, stop: 0.0, count: 2 };
        }

        let [start, stop] = [brightest, median].map(|y| (white / f64::from(y)).log2());
        Self { start, stop, count: (stop - start).ceil().max(2.0) as u32 }
    }

    /// The exposures themselves.
    pub fn stops(&self) -> impl Iterator<Item = f64> + use<> {
        let step = (self.stop - self.start) / f64::from(self.count - 1);
        let start = self.start;
        (0..self.count).map(move |i| start + f64::from(i) * step)
    }
}

/// HDR-FLIP per pixel, in [0, 1], of two pictures in linear Rec. 709.
pub(crate) fn hdr_flip_map(flip: &Flip, exposures: Exposures, reference: &Rgb, candidate: &Rgb) -> Vec<f32> {
    let mut worst = vec![0.0_f32; reference.len()];
    for stop in exposures.stops() {
        let factor = stop.exp2() as f32;
        let expose = |picture: &Rgb| picture.map(|value| aces(value * factor));
        let errors = flip.map(&expose(reference), &expose(candidate));
        worst.iter_mut().zip(errors).for_each(|(worst, error)| *worst = worst.max(error));
    }
    worst
}

/// The tone curve; below 0 light is 0.
fn aces(x: f32) -> f32 {
    let [c0, c1, c2, c3, c4, c5] = ACES.map(|c| c as f32);
    let x = x.clamp(0.0, 1e15); // beyond it the squares would overflow; the curve is flat long before
    (((x * c0 + c1) * x + c2) / ((x * c3 + c4) * x + c5)).clamp(0.0, 1.0)
}

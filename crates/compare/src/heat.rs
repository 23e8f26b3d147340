//! Heat maps: where and how a candidate differs, in colours with a stated scale.

use rgbd::{Picture, Plane};

use crate::{Comparison, Ramp, Reference};

/// The share of the values that a chosen scale shows without clipping.
const SHOWN: f64 = 0.995;

/// What a heat map shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeatKind {
    /// Candidate minus reference, mean over R, G, B: red too bright, blue too dark.
    Signed,
    /// Size of the difference, mean over R, G, B of the absolute values.
    Absolute,
    /// HDR-FLIP.
    Flip,
}

impl HeatKind {
    /// All three, in the order of reports.
    pub const EVERY: [Self; 3] = [Self::Signed, Self::Absolute, Self::Flip];

    /// The colours it is drawn in.
    #[must_use]
    pub fn ramp(self) -> Ramp {
        if self == Self::Signed { Ramp::Diverging } else { Ramp::Sequential }
    }

    /// The numbers behind the map, over the display window.
    #[must_use]
    pub fn values(self, reference: &Reference, comparison: &Comparison) -> Plane {
        if self == Self::Flip {
            return comparison.flip_hdr.clone();
        }
        let mut plane = Plane::filled(reference.display(), 0.0);
        for (channel, candidate) in reference.rgb.channels.iter().zip(comparison.candidate.planes()) {
            for ((sum, r), c) in plane.values_mut().iter_mut().zip(channel).zip(candidate.values()) {
                let d = (c - r) / 3.0;
                *sum += if self == Self::Signed { d } else { d.abs() };
            }
        }
        plane
    }

    /// The map as a picture in linear light, to be encoded at exposure 0; `scale` (positive) is the value at the end of
    /// the ramp, larger ones look the same.
    #[must_use]
    pub fn draw(self, values: &Plane, scale: f32) -> Picture {
        let ramp = self.ramp();
        // Look the colours up: they are the same but for the last bit of an 8-bit picture
        const STEPS: usize = 1024;
        let at_step = |i: usize| ramp.color(i as f32 / STEPS as f32 * 2.0 - 1.0);
        let colors: Vec<[f32; 3]> = (0..=STEPS).map(at_step).collect();
        Picture::from_fn(values.window(), |x, y| {
            let t = (values.at(x, y) / scale).clamp(-1.0, 1.0);
            let [r, g, b] = colors[(0.5 * (t + 1.0) * STEPS as f32).round() as usize];
            [r, g, b, 1.0]
        })
    }
}

/// A round scale (1, 2 or 5 times a power of ten) that shows all but the largest 0.5 % of the absolute values; 0.001 at
/// least, as 8-bit pictures show no less.
#[must_use]
pub fn round_scale(planes: &[&Plane]) -> f32 {
    let mut sizes: Vec<f32> = planes.iter().flat_map(|plane| plane.values()).map(|value| value.abs()).collect();
    if sizes.is_empty() {
        return 1e-3;
    }
    let rank = ((sizes.len() - 1) as f64 * SHOWN) as usize;
    let (_, &mut wanted, _) = sizes.select_nth_unstable_by(rank, f32::total_cmp);

    // Round up to the next figure
    let wanted = f64::from(wanted).max(1e-3) * (1.0 - 1e-6);
    let power = 10_f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0, 10.0].iter().map(|digit| digit * power).find(|&scale| scale >= wanted).unwrap_or(power) as f32
}

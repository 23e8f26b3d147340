//! ICC profiles: those of three curves and three primaries, which most cameras, phones and programs embed.

use std::sync::Arc;

use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve, Xyzd};

use super::transfer::{STEPS, Transfer, srgb_decoded};
use crate::Primaries;

/// What a profile says, as far as it is understood.
pub(super) struct Understood {
    pub(super) transfer: Transfer,
    pub(super) primaries: Primaries,
}

/// What a profile of an RGB picture says; `None` for one of another kind (tables, grey, CMYK) or of nonsense.
pub(super) fn understand(bytes: &[u8]) -> Option<Understood> {
    let profile = ColorProfile::new_from_slice(bytes).ok()?;
    let has_table = profile.lut_a_to_b_perceptual.is_some() || profile.lut_a_to_b_colorimetric.is_some();
    if profile.color_space != DataColorSpace::Rgb || profile.pcs != DataColorSpace::Xyz || has_table {
        return None;
    }
    let [red, green, blue] = [&profile.red_trc, &profile.green_trc, &profile.blue_trc].map(|curve| curve.as_ref());
    let curves = [curve(red?)?, curve(green?)?, curve(blue?)?];

    // Colorants are adapted to D50, and so is their white
    let xy = |Xyzd { x, y, z }: Xyzd| {
        let sum = x + y + z;
        (sum.abs() > 1e-6 && sum.is_finite()).then(|| [(x / sum) as f32, (y / sum) as f32])
    };
    let [r, g, b] = [profile.red_colorant, profile.green_colorant, profile.blue_colorant];
    let white = Xyzd { x: r.x + g.x + b.x, y: r.y + g.y + b.y, z: r.z + g.z + b.z };
    let primaries = Primaries { red: xy(r)?, green: xy(g)?, blue: xy(b)?, white: xy(white)? };

    // sRGB under any name is sRGB
    let map = primaries.to_rec709()?;
    let is_identity = (0..3).all(|i| (0..3).all(|j| (map[i][j] - f32::from(i == j)).abs() < 0.004));
    let is_srgb = |curve: &Vec<f32>| {
        (0..STEPS).all(|i| (curve[i] - srgb_decoded(i as f64 / (STEPS - 1) as f64) as f32).abs() < 5e-4)
    };
    if is_identity && curves.iter().all(is_srgb) {
        return Some(Understood { transfer: Transfer::Srgb, primaries: Primaries::REC709 });
    }
    Some(Understood { transfer: Transfer::Curves(Arc::new(curves)), primaries })
}

/// The light of every stored number; `None` where the curve makes no sense.
fn curve(trc: &ToneReprCurve) -> Option<Vec<f32>> {
    let light: Box<dyn Fn(f64) -> f64> = match trc {
        ToneReprCurve::Lut(table) => match table.as_slice() {
            [] => Box::new(|x| x),
            // A number of 8.8 bits
            &[gamma] => Box::new(move |x: f64| x.powf(f64::from(gamma) / 256.0)),
            table => Box::new(move |x| {
                let at = x * (table.len() - 1) as f64;
                let i = (at as usize).min(table.len() - 2);
                let [a, b] = [table[i], table[i + 1]].map(f64::from);
                (a + (b - a) * (at - i as f64)) / 65535.0
            }),
        },
        ToneReprCurve::Parametric(numbers) => parametric(numbers)?,
    };
    let mut steps = Vec::with_capacity(STEPS);
    let mut last = 0.0_f32;
    for i in 0..STEPS {
        let step = light(i as f64 / (STEPS - 1) as f64) as f32;
        // A curve that falls cannot be gone back
        if !step.is_finite() || step < last - 1e-4 {
            return None;
        }
        last = step.max(last);
        steps.push(last);
    }
    // Light of 0 everywhere, or many times white, is no curve of a picture
    (0.5..=1.5).contains(&last).then_some(steps)
}

/// The parametric curves of ICC.1:2022, 10.18, by how many numbers they have.
fn parametric(numbers: &[f32]) -> Option<Box<dyn Fn(f64) -> f64>> {
    let n: Vec<f64> = numbers.iter().map(|&number| f64::from(number)).collect();
    let (g, a, b, c, d, e, f) = match n[..] {
        [g] => (g, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        [g, a, b] => (g, a, b, 0.0, -b / a, 0.0, 0.0),
        [g, a, b, c] => (g, a, b, 0.0, -b / a, c, c),
        [g, a, b, c, d] => (g, a, b, c, d, 0.0, 0.0),
        [g, a, b, c, d, e, f] => (g, a, b, c, d, e, f),
        _ => return None,
    };
    Some(Box::new(move |x| if x >= d { (a * x + b).max(0.0).powf(g) + e } else { c * x + f }))
}

/// The ICC profile in the first directory of a TIFF file, which the decoder does not always find.
pub(super) fn tiff_profile(bytes: &[u8]) -> Option<Vec<u8>> {
    const ICC_PROFILE: u64 = 34675;
    let is_little_endian = bytes.starts_with(b"II*\0");
    if !is_little_endian && !bytes.starts_with(b"MM\0*") {
        return None;
    }
    let number = |at: usize, size: usize| {
        let digits = bytes.get(at..at.checked_add(size)?)?.iter().map(|&byte| u64::from(byte));
        let append = |number: u64, byte: u64| number << 8 | byte;
        Some(if is_little_endian { digits.rev().fold(0, append) } else { digits.fold(0, append) })
    };
    let directory = number(4, 4)? as usize;
    let entries = (0..number(directory, 2)? as usize).map(|i| directory + 2 + 12 * i);
    let entry = entries.into_iter().find(|&at| number(at, 2) == Some(ICC_PROFILE))?;
    let (length, start) = (number(entry + 4, 4)? as usize, number(entry + 8, 4)? as usize);
    Some(bytes.get(start..start.checked_add(length)?)?.to_vec())
}

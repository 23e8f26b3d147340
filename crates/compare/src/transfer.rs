//! The sRGB transfer function (IEC 61966-2-1).

/// Display value in [0, 1] of linear light, clipped to [0, 1] first.
pub(crate) fn srgb_from_linear(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light of a display value in [0, 1].
pub(crate) fn linear_from_srgb(display: f64) -> f64 {
    if display <= 0.040_45 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }
}

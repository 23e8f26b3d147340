//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004).
//!
//! As scikit-image computes it with `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1`:
//!
//! ```text
//! S = (2 ux uy + C1) (2 vxy + C2) / ((ux^2 + uy^2 + C1) (vx + vy + C2)),  C1 = 0.01^2, C2 = 0.03^2
//! ```
//!
//! on display values (sRGB, clipped to 0..1), Gaussian windows of 11x11 pixels, mirrored at the border, mean over R, G, B.

use rayon::prelude::*;

use crate::{
    convolve::{Border, Kernel, along_x, along_y},
    rgb::Rgb,
    transfer::srgb_from_linear,
};

const SIGMA: f64 = 1.5;
const RADIUS: usize = 5; // floor(3.5 sigma + 0.5)
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// SSIM per pixel, in [-1, 1]; 1 where the pictures agree.
pub(crate) fn ssim_map(reference: &Rgb, candidate: &Rgb) -> Vec<f32> {
    let gauss: Vec<f64> = (0..=RADIUS).map(|k| (-0.5 * (k as f64 / SIGMA).powi(2)).exp()).collect();
    let sum = gauss[0] + 2.0 * gauss[1..].iter().sum::<f64>();
    let kernel = Kernel::even(gauss.iter().map(|g| g / sum).collect());

    // Add up the three channels
    let mut total = vec![0.0; reference.len()];
    for (r, c) in reference.channels.iter().zip(&candidate.channels) {
        let display = |values: &[f32]| values.par_iter().map(|&v| srgb_from_linear(f64::from(v))).collect::<Vec<_>>();
        let channel = ssim_channel(&display(r), &display(c), reference.width, &kernel);
        total.iter_mut().zip(channel).for_each(|(t, s)| *t += s);
    }
    total.iter().map(|t| (t / 3.0) as f32).collect()
}

/// SSIM of one channel; in f64, because variances here are small differences of large moments.
fn ssim_channel(x: &[f64], y: &[f64], width: usize, kernel: &Kernel<f64>) -> Vec<f64> {
    let blur = |values: &[f64]| {
        let [blurred] = along_x(values, width, Border::Reflect, [kernel]);
        along_y(&blurred, width, Border::Reflect, kernel)
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>();

    // Take the local moments
    let (ux, uy) = (blur(x), blur(y));
    let (uxx, uyy, uxy) = (blur(&product(x, x)), blur(&product(y, y)), blur(&product(x, y)));

    // Compare means and variances
    (0..x.len())
        .into_par_iter()
        .map(|i| {
            let (mx, my) = (ux[i], uy[i]);
            let (vx, vy, vxy) = (uxx[i] - mx * mx, uyy[i] - my * my, uxy[i] - mx * my);
            (2.0 * mx * my + C1) * (2.0 * vxy + C2) / ((mx * mx + my * my + C1) * (vx + vy + C2))
        })
        .collect()
}

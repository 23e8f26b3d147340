//! LDR-FLIP: how different two pictures look when one flips between them.
//!
//! Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: *FLIP: A Difference Evaluator for Alternating
//! Images*, HPG 2020. A colour pipeline (contrast sensitivity of the eye, then a colour distance in [0, 1]) and a
//! feature pipeline (edges and points) are joined: `error = colour ^ (1 - feature)`.
//!
//! The filters are separated as in the reference implementation (version 1.7), which this one equals but for rounding.

use rayon::prelude::*;

use crate::{
    convolve::{Border, Kernel, along_x, along_y},
    flip_color::{ColorDistance, ycxcz_from_rgb},
    rgb::Rgb,
};

/// Pixels per degree of visual angle: 0.7 m from a screen 0.7 m and 3840 pixels wide, FLIP's default (67.02).
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Width of the feature detectors in degrees, w in the paper.
const FEATURE_WIDTH: f64 = 0.082;

/// The filters of the two pipelines.
pub(crate) struct Flip {
    /// Contrast sensitivity in Y and Cx, one Gaussian each.
    luma: Kernel<f32>,
    red_green: Kernel<f32>,
    /// And in Cz, the sum of two separable Gaussians.
    blue_yellow: [Kernel<f32>; 2],
    /// Gaussian, its first and its second derivative.
    smooth: Kernel<f32>,
    edge: Kernel<f32>,
    point: Kernel<f32>,
    distance: ColorDistance,
}

impl Flip {
    /// The filters for a viewing distance.
    pub(crate) fn new(pixels_per_degree: f64) -> Self {
        let [luma, red_green, blue_yellow] = contrast_filters(pixels_per_degree);
        let [smooth, edge, point] = feature_filters(pixels_per_degree);
        let [luma, red_green] = [luma, red_green].map(|[only, _]| only);
        Self { luma, red_green, blue_yellow, smooth, edge, point, distance: ColorDistance::new() }
    }

    /// FLIP per pixel, in [0, 1], of two pictures in linear Rec. 709, clipped to 0..1 first.
    pub(crate) fn map(&self, reference: &Rgb, candidate: &Rgb) -> Vec<f32> {
        let width = reference.width;
        let [a, b] = [reference, candidate].map(|picture| self.prepare(picture, width));
        (0..reference.len())
            .into_par_iter()
            .map(|i| {
                let colour = self.distance.between(a.color_at(i), b.color_at(i));
                let edge = (a.edge_at(i) - b.edge_at(i)).abs();
                let point = (a.point_at(i) - b.point_at(i)).abs();
                let feature = (std::f32::consts::FRAC_1_SQRT_2 * edge.max(point)).sqrt();
                colour.powf(1.0 - feature)
            })
            .collect()
    }

    /// Runs both pipelines on one picture.
    fn prepare(&self, picture: &Rgb, width: usize) -> Prepared {
        const EDGE: Border = Border::Clamp;

        // Go to the opponent space
        let mut opponent = [0; 3].map(|_| vec![0.0_f32; picture.len()]);
        let [y, cx, cz] = &mut opponent;
        y.par_iter_mut().zip(cx).zip(cz).enumerate().for_each(|(i, ((y, cx), cz))| {
            [*y, *cx, *cz] = ycxcz_from_rgb(picture.at(i).map(|value| value.clamp(0.0, 1.0)));
        });
        let [y, cx, cz] = opponent;

        // See it as the eye does
        let both = |channel: &[f32], kernel| {
            let [row] = along_x(channel, width, EDGE, [kernel]);
            along_y(&row, width, EDGE, kernel)
        };
        let [narrow, wide] = &self.blue_yellow;
        let mut blue_yellow = both(&cz, narrow);
        blue_yellow.par_iter_mut().zip(both(&cz, wide)).for_each(|(sum, term)| *sum += term);
        let color = [both(&y, &self.luma), both(&cx, &self.red_green), blue_yellow];

        // Find edges and points in the luma, brought to 0..1
        let gray: Vec<f32> = y.par_iter().map(|y| (y + 16.0) / 116.0).collect();
        let [dx, ddx, smooth] = along_x(&gray, width, EDGE, [&self.edge, &self.point, &self.smooth]);
        Prepared {
            color,
            edge: [along_y(&dx, width, EDGE, &self.smooth), along_y(&smooth, width, EDGE, &self.edge)],
            point: [along_y(&ddx, width, EDGE, &self.smooth), along_y(&smooth, width, EDGE, &self.point)],
        }
    }
}

/// One picture after both pipelines.
struct Prepared {
    color: [Vec<f32>; 3],
    edge: [Vec<f32>; 2],
    point: [Vec<f32>; 2],
}

impl Prepared {
    fn color_at(&self, i: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.color[c][i])
    }

    fn edge_at(&self, i: usize) -> f32 {
        (self.edge[0][i] * self.edge[0][i] + self.edge[1][i] * self.edge[1][i]).sqrt()
    }

    fn point_at(&self, i: usize) -> f32 {
        (self.point[0][i] * self.point[0][i] + self.point[1][i] * self.point[1][i]).sqrt()
    }
}

/// The whole sum of an even kernel of taps 0..=r.
fn even_sum(taps: &[f64]) -> f64 {
    taps[0] + 2.0 * taps[1..].iter().sum::<f64>()
}

fn even(taps: &[f64], factor: f64) -> Kernel<f32> {
    Kernel::even(taps.iter().map(|tap| (tap * factor) as f32).collect())
}

/// The contrast sensitivity filters of Y, Cx and Cz: `a sqrt(pi / b) exp(-pi^2 x^2 / b)`, x in degrees, each as the sum
/// of two products of 1-D kernels (Y and Cx: of one, the second is not used).
fn contrast_filters(ppd: f64) -> [[Kernel<f32>; 2]; 3] {
    const A1_B1: [[f64; 2]; 3] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04]];
    const A2_B2: [[f64; 2]; 3] = [[0.0, 1e-5], [0.0, 1e-5], [13.5, 0.025]];
    use std::f64::consts::PI;

    // Reach three standard deviations of the widest of them
    let widest = 0.04;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * ppd).ceil() as usize;

    [0, 1, 2].map(|channel| {
        // The square root of the factor goes to each direction
        let terms = [A1_B1[channel], A2_B2[channel]].map(|[a, b]| {
            let tap = |k: usize| (a * (PI / b).sqrt()).sqrt() * (-PI * PI * (k as f64 / ppd).powi(2) / b).exp();
            (0..=radius).map(tap).collect::<Vec<f64>>()
        });
        let sum = terms.iter().map(|taps| even_sum(taps).powi(2)).sum::<f64>().sqrt();
        terms.map(|taps| even(&taps, 1.0 / sum))
    })
}

/// Gaussian, first and second derivative; the Gaussian sums to 1, the positive and the negative weights of each
/// derivative to 1 and -1.
fn feature_filters(ppd: f64) -> [Kernel<f32>; 3] {
    let sigma = 0.5 * FEATURE_WIDTH * ppd;
    let radius = (3.0 * sigma).ceil() as usize;
    let gauss: Vec<f64> = (0..=radius).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();

    let slope: Vec<f64> = gauss.iter().enumerate().map(|(k, g)| -(k as f64) * g).collect();
    let slope_sum: f64 = slope.iter().map(|s| s.abs()).sum();

    let bend: Vec<f64> = gauss.iter().enumerate().map(|(k, g)| ((k as f64 / sigma).powi(2) - 1.0) * g).collect();
    let side = |sign: f64| even_sum(&bend.iter().map(|b| (sign * b).max(0.0)).collect::<Vec<_>>());
    let (above, below) = (side(1.0), side(-1.0));
    let balanced: Vec<f64> = bend.iter().map(|&b| b / if b > 0.0 { above } else { below }).collect();

    let slope = slope.iter().map(|s| (s / slope_sum) as f32).collect();
    [even(&gauss, 1.0 / even_sum(&gauss)), Kernel::odd(slope), even(&balanced, 1.0)]
}

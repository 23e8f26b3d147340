//! How far a filtered pixel may be from the truth, and why.
//!
//! The causes are predicted one by one, each as a root mean square over R, G and B in the units of the picture, and are
//! taken for independent: their squares add up.
//!
//! - *Texture*: the weights of a disc of about a pixel stand for an integral over its outline. What they miss at an edge
//!   depends on how the edge lies to the pixels, which the fourth difference of the colour along both axes tells, less 5/4
//!   of the mixed one; its share is known from geometry alone. A little is added for what is no straight edge.
//! - *Guess*: the mean of what the gathered colours may be off, at silhouettes taken apart and in filled-in background.
//!   Where the blur is smaller than a pixel both parts of a silhouette come down again on their own pixel, and little of it
//!   is seen.
//! - *Border*: the part of the iris that found nothing, times the contrast around.
//! - *Unknown depth*: where the pixel's own depth is a guess, so is its blur: the contrast around.
//!
//! The shares of a straight edge are the root mean square, over all directions and places of the edge, of what the kernels
//! miss (no picture was looked at). The others were fitted on `simple/tilt`, `simple/double`, `simple/reverse`,
//! `simple/blur`, `landscape/miniature` and `landscape/pan_focus`, 320x180, 512 samples, 2026-11-25. On shots that no fit
//! saw (`cargo test --release --test predicted_error -- --nocapture`; merged gather with one layer, with two, lens rays with
//! one; precision and recall of errors above 0.02):
//!
//! | shot | rank correlation | precision | recall |
//! | --- | --- | --- | --- |
//! | `simple/swing_shift` | 0.72, 0.72, 0.78 | 0.65, 0.61, 0.67 | 0.68, 0.68, 0.64 |
//! | `simple/tilt_shift` | 0.84, 0.84, 0.85 | 0.87, 0.86, 0.77 | 0.76, 0.75, 0.73 |
//! | `simple/shift` | 0.65, 0.65, 0.74 | 0.76, 0.73, 0.76 | 0.67, 0.66, 0.65 |
//! | `landscape/shift` | 0.73, 0.72, 0.82 | 0.48, 0.24, 0.39 | 0.40, 0.34, 0.41 |
//! | `landscape/tilt_shift` | 0.62, 0.61, 0.71 | 0.34, 0.27, 0.34 | 0.31, 0.19, 0.28 |
//!
//! The first two were in sight when the features were chosen. After the last three were first looked at no constant changed, but
//! one step did: the mean over 3x3 pixels of what is guessed.
//!
//! So where texture leads, the map says well which pixels exceed an error. Where hidden background leads it is right about
//! where and in the mean about how much, but what is hidden is known too little to say it of each pixel.

use optics::Camera;
use rayon::prelude::*;
use rgbd::{PixelWindow, Plane};

use crate::{FrameView, Sides, apply::coc_radius_px, surface::finite};

/// Error at a straight edge over the difference that tells how it lies, by blur radius in pixels; linear between, constant
/// beyond.
const EDGE: [[f32; 2]; 17] = [
    [0.0, 0.0],
    [0.15, 0.0025],
    [0.3, 0.0075],
    [0.45, 0.013],
    [0.6, 0.0177],
    [0.7, 0.0198],
    [0.8, 0.0208],
    [0.9, 0.0204],
    [1.0, 0.0187],
    [1.1, 0.0163],
    [1.2, 0.0143],
    [1.3, 0.0115],
    [1.5, 0.006],
    [1.75, 0.0055],
    [2.0, 0.0065],
    [2.5, 0.004],
    [4.0, 0.003],
];

/// Error of all other texture, and of the noise of the frame's own colours, over the Laplacian.
const OTHER: [[f32; 2]; 7] =
    [[0.0, 0.012], [0.5, 0.018], [1.0, 0.018], [1.5, 0.012], [2.0, 0.0084], [3.0, 0.0048], [4.0, 0.0036]];

/// The part of the doubt that is seen, by the largest blur radius beside the pixel.
const SEEN: [[f32; 2]; 2] = [[0.75, 0.33], [2.0, 1.0]];

/// The part of the open iris that counts, by the same: the weights of a disc of a pixel need not fill it.
const OPEN: [[f32; 2]; 2] = [[0.75, 0.0], [1.25, 1.0]];

/// Pixels between the places at which a neighbourhood is looked at, and how many there are on each side.
const STEP: i32 = 4;
const STEPS: i32 = 2;

/// An iris that is open by less than this is full but for rounding.
const LEAST_OPEN: f32 = 0.01;

/// Why a filtered pixel may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorCause {
    /// Detail under a blur of about a pixel.
    Texture,
    /// Colours that are guesses: silhouettes taken apart, background filled in.
    Guess,
    /// Too little picture beyond the border.
    Border,
    /// No depth at the pixel.
    UnknownDepth,
}

impl ErrorCause {
    /// All causes, in the order of [`PredictedError::causes`].
    pub const EVERY: [Self; 4] = [Self::Texture, Self::Guess, Self::Border, Self::UnknownDepth];
}

/// The predicted error of each pixel: root mean square over R, G and B, in the units of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedError {
    /// From all causes.
    pub total: Plane,
    /// From each cause alone, in the order of [`ErrorCause::EVERY`]; their squares add up to that of the total.
    pub causes: [Plane; 4],
}

impl PredictedError {
    /// The cause that weighs most at a pixel of the window; `None` where no error is predicted.
    #[must_use]
    pub fn largest_cause(&self, x: i32, y: i32) -> Option<ErrorCause> {
        let errors = ErrorCause::EVERY.into_iter().zip(self.causes.each_ref().map(|plane| plane.at(x, y)));
        errors.filter(|&(_, error)| error > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(cause, _)| cause)
    }
}

/// What a method knows of its own guesses, up to a pixel beyond the window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Doubt {
    /// Mean of how far the colours that a pixel took may be off.
    pub(crate) mean: Plane,
    /// What stayed open of its iris.
    pub(crate) open: Plane,
}

/// Predicts from the frame and from a method's own doubt.
pub(crate) fn predicted_error(
    view: &FrameView,
    camera: &Camera,
    sides: Sides,
    window: PixelWindow,
    Doubt { mean, open }: &Doubt,
) -> PredictedError {
    let beyond = window.grown(1, 1);
    let radius = coc_radius_px(view, camera);
    // NaN where the depth is unknown, `None` where there is nothing
    let radius = |x: i32, y: i32| radius.get(x, y).map(|radius| sides.limited(radius, 0.0).abs());
    let widest = by_rows(beyond, |x, y| around(x, y).filter_map(|(x, y)| radius(x, y)).fold(0.0, f32::max));

    // Look at the colours around each pixel
    let edge = by_rows(beyond, |x, y| square(view, x, y, &EDGE_STENCIL));
    let laplacian = by_rows(beyond, |x, y| square(view, x, y, &LAPLACIAN));
    let texture = by_rows(window, |x, y| match radius(x, y) {
        Some(radius) if !radius.is_nan() => {
            let part = |share: &[[f32; 2]], squares: &Plane| share_at(share, radius).powi(2) * mean_3x3(squares, x, y);
            (part(&EDGE, &edge) + part(&OTHER, &laplacian)).sqrt()
        }
        _ => 0.0,
    });
    let guess = by_rows(beyond, |x, y| (share_at(&SEEN, widest.at(x, y)) * mean.at(x, y)).powi(2));
    let guess = by_rows(window, |x, y| mean_3x3(&guess, x, y).sqrt());
    let border = by_rows(window, |x, y| {
        let open = open.at(x, y) * share_at(&OPEN, widest.at(x, y));
        if open > LEAST_OPEN { open * contrast(view, x, y) } else { 0.0 }
    });
    let unknown = by_rows(window, |x, y| match radius(x, y) {
        Some(radius) if radius.is_nan() => contrast(view, x, y),
        _ => 0.0,
    });
    let causes = [texture, guess, border, unknown];
    let total = by_rows(window, |x, y| causes.each_ref().map(|c| c.at(x, y)).into_iter().fold(0.0, f32::hypot));
    PredictedError { total, causes }
}

/// A plane of what `value` tells for each pixel.
fn by_rows(window: PixelWindow, value: impl Fn(i32, i32) -> f32 + Sync) -> Plane {
    let mut plane = Plane::filled(window, 0.0);
    plane.values_mut().par_chunks_mut((window.width as usize).max(1)).enumerate().for_each(|(row, values)| {
        let y = window.y + row as i32;
        values.iter_mut().zip(window.x..).for_each(|(to, x)| *to = value(x, y));
    });
    plane
}

/// A table of shares at a radius.
fn share_at(table: &[[f32; 2]], radius: f32) -> f32 {
    if radius <= table[0][0] {
        return table[0][1];
    }
    let last = table[table.len() - 1];
    let span = table.windows(2).find(|span| radius < span[1][0]);
    span.map_or(last[1], |span| {
        let ([r0, s0], [r1, s1]) = (span[0], span[1]);
        s0 + (s1 - s0) * (radius - r0) / (r1 - r0)
    })
}

/// The first layer's colour at the pixel of the view that is nearest.
fn color(view: &FrameView, x: i32, y: i32) -> [f32; 3] {
    let window = view.window();
    let [r, g, b, _] =
        view.frame().layers()[0].color.at(x.clamp(window.x, window.x_end() - 1), y.clamp(window.y, window.y_end() - 1));
    [r, g, b].map(finite)
}

/// Weights of a pixel, of its neighbours beside and aslant, and of the pixels two steps away along the axes.
type Stencil = [f32; 4];

/// Fourth difference along x and y, less 5/4 of the mixed one: 0 where an edge runs along a diagonal, largest where it runs
/// along the border of two pixels.
const EDGE_STENCIL: Stencil = [7.0, -1.5, -1.25, 1.0];
const LAPLACIAN: Stencil = [-4.0, 1.0, 0.0, 0.0];

/// Square of a stencil's value, mean over R, G and B.
fn square(view: &FrameView, x: i32, y: i32, stencil: &Stencil) -> f32 {
    let beside = [(-1, 0), (1, 0), (0, -1), (0, 1)];
    let rings = [beside, [(-1, -1), (1, -1), (-1, 1), (1, 1)], beside.map(|(dx, dy)| (2 * dx, 2 * dy))];
    let mut sum = color(view, x, y).map(|c| stencil[0] * c);
    for (ring, &weight) in rings.iter().zip(&stencil[1..]).filter(|(_, weight)| **weight != 0.0) {
        for (dx, dy) in ring {
            sum.iter_mut().zip(color(view, x + dx, y + dy)).for_each(|(sum, c)| *sum += weight * c);
        }
    }
    sum.iter().map(|value| value * value).sum::<f32>() / 3.0
}

/// A pixel and its neighbours, row by row.
fn around(x: i32, y: i32) -> impl Iterator<Item = (i32, i32)> {
    (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
}

/// Mean over a pixel, which must not lie on the plane's rim, and its neighbours.
fn mean_3x3(plane: &Plane, x: i32, y: i32) -> f32 {
    around(x, y).map(|(x, y)| plane.at(x, y)).sum::<f32>() / 9.0
}

/// Standard deviation of the frame's colour around a pixel, root mean square over R, G and B.
fn contrast(view: &FrameView, x: i32, y: i32) -> f32 {
    let (mut count, mut sum, mut squares) = (0.0, [0.0; 3], 0.0);
    for v in (-STEPS..=STEPS).map(|k| y + k * STEP) {
        for u in (-STEPS..=STEPS).map(|k| x + k * STEP).filter(|&u| view.window().contains(u, v)) {
            count += 1.0;
            for (sum, c) in sum.iter_mut().zip(color(view, u, v)) {
                *sum += c;
                squares += c * c;
            }
        }
    }
    if count == 0.0 {
        return 0.0;
    }
    let mean = sum.iter().map(|s| (s / count) * (s / count)).sum::<f32>();
    ((squares / count - mean).max(0.0) / 3.0).sqrt()
}

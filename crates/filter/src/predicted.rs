//! How far a filtered pixel may be from the truth, and why.
//!
//! The causes are predicted one by one, each as a root mean square over R, G and B in the units of the picture, and are
//! taken for independent: their squares add up.
//!
//! - *Texture*: the weights of a disc of about a pixel stand for an integral over its outline. What they miss grows with
//!   the curvature of the colour, here the root mean square of its Laplacian over 3x3 pixels, times a share that depends on
//!   the blur radius: greatest at 0.9 pixels.
//! - *Guess*: the mean of what the gathered colours may be off, at silhouettes taken apart and in filled-in background.
//! - *Border*: the part of the iris that found nothing, times the contrast around.
//! - *Unknown depth*: where the pixel's own depth is a guess, so is its blur: the contrast around.
//!
//! The shares were fitted on `simple/tilt`, `simple/double`, `simple/reverse` and `simple/tilt_swing_shift` (2026-11-25).
//! The Laplacian was chosen among other features with a look at `landscape/double` too. On other shots, of one layer and of
//! two, it was measured to reach (2026-11-25, 320x180, 512 samples,
//! `cargo test --test predicted_error -- --nocapture`; precision and recall of errors above 0.02):
//!
//! | shot | rank correlation | precision | recall |
//! | --- | --- | --- | --- |
//! | `simple/swing_shift` | 0.75, 0.74 | 0.41, 0.38 | 0.56, 0.55 |
//! | `simple/tilt_shift` | 0.90, 0.90 | 0.53, 0.52 | 0.59, 0.58 |
//! | `landscape/double` | 0.81, 0.80 | 0.21, 0.11 | 0.37, 0.35 |
//!
//! So it orders the pixels well, but says less well which of them exceed a given error: the guess is not calibrated, and
//! counts hidden colours as if all of them were off in the same way.

use optics::Camera;
use rgbd::{PixelWindow, Plane};

use crate::{FrameView, apply::coc_radius_px, surface::finite};

/// Error of texture over its Laplacian, by blur radius in pixels; linear between, constant beyond.
const TEXTURE: [[f32; 2]; 9] = [
    [0.0, 0.01],
    [0.2, 0.018],
    [0.45, 0.04],
    [0.75, 0.052],
    [1.1, 0.048],
    [1.5, 0.025],
    [2.0, 0.014],
    [3.0, 0.009],
    [8.0, 0.006],
];

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

/// Predicts from the frame, and from the gather's mean `doubt` of colours and the part of the iris that stayed `open`.
pub(crate) fn predicted_error(view: &FrameView, camera: &Camera, doubt: Plane, open: &Plane) -> PredictedError {
    let window = doubt.window();
    let radius = coc_radius_px(view, camera);
    let laplacian = laplacian(view, window.grown(1, 1));
    let texture = Plane::from_fn(window, |x, y| match radius.get(x, y) {
        Some(radius) if !radius.is_nan() => texture_share(radius.abs()) * mean_3x3(&laplacian, x, y).sqrt(),
        _ => 0.0,
    });
    let border = Plane::from_fn(window, |x, y| {
        let open = open.at(x, y);
        if open > LEAST_OPEN { open * contrast(view, x, y) } else { 0.0 }
    });
    let unknown = Plane::from_fn(window, |x, y| match radius.get(x, y) {
        Some(radius) if radius.is_nan() => contrast(view, x, y),
        _ => 0.0,
    });
    let causes = [texture, doubt, border, unknown];
    let total = Plane::from_fn(window, |x, y| causes.each_ref().map(|c| c.at(x, y)).into_iter().fold(0.0, f32::hypot));
    PredictedError { total, causes }
}

/// [`TEXTURE`] at a radius.
fn texture_share(radius: f32) -> f32 {
    let last = TEXTURE[TEXTURE.len() - 1];
    let span = TEXTURE.windows(2).find(|span| radius < span[1][0]);
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

/// Square of the Laplacian of the colour, mean over R, G and B.
fn laplacian(view: &FrameView, window: PixelWindow) -> Plane {
    Plane::from_fn(window, |x, y| {
        let here = color(view, x, y);
        let around = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| color(view, x + dx, y + dy));
        let square = |c: usize| (around.iter().map(|color| color[c]).sum::<f32>() - 4.0 * here[c]).powi(2);
        (square(0) + square(1) + square(2)) / 3.0
    })
}

/// Mean over a pixel, which must not lie on the plane's rim, and its neighbours.
fn mean_3x3(plane: &Plane, x: i32, y: i32) -> f32 {
    (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).map(|(dx, dy)| plane.at(x + dx, y + dy)).sum::<f32>() / 9.0
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

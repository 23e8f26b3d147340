//! A layer made ready to be gathered: inverse depth, slope and finite colour per pixel.

use glam::DVec2;
use optics::Camera;
use rayon::prelude::*;
use rgbd::{Layer, PixelWindow, Rest};

use crate::FrameView;

/// How far, in pixels, the depth of a hole is looked for; holes farther from any depth stay as sharp as they came.
pub(crate) const HOLE_REACH: i32 = 32;

/// Largest inverse depth that is taken from a file, in 1 / scene units: squares and sums of what is nearer would overflow.
pub(crate) const NEAREST: f32 = 1e12;

/// A hidden surface that fills less of a pixel than this is not there; its colour as if it filled it would be a guess.
const LEAST_COVER: f32 = 1e-4;

/// Brightest value that is taken from a file: the largest half float. Infinities become it, NaN becomes 0.
const BRIGHTEST: f32 = 65504.0;

/// One layer of a view, pixel by pixel.
pub(crate) struct Surface {
    pub(crate) window: PixelWindow,
    /// 1/z in 1 / scene units; 0 for the sky.
    pub(crate) inverse_depth: Vec<f32>,
    /// Premultiplied colour.
    pub(crate) rgba: Vec<[f32; 4]>,
    /// How much of the pixel it fills: 1 in the first layer, alpha in hidden ones; 0 where there is nothing.
    pub(crate) cover: Vec<f32>,
    /// How far the colour may be off, root mean square over R, G and B; empty where all of it is known.
    pub(crate) doubt: Vec<f32>,
    /// Change of inverse depth per pixel in x and y; empty in the first layer, where it is the one of the pixels around.
    pub(crate) slopes: Vec<[f32; 2]>,
    /// What its colours spare those who read them in the layer itself.
    pub(crate) tame: Tame,
}

/// What a layer's colours spare those who read them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tame {
    /// Whether all alpha is 1.
    pub(crate) is_opaque: bool,
    /// Whether no colour has to be made finite.
    pub(crate) is_finite: bool,
}

impl Surface {
    /// Layer `index` of the view.
    pub(crate) fn new(view: &FrameView, camera: &Camera, index: usize) -> Self {
        let layer = &view.frame().layers()[index];
        let window = view.window();
        let width = window.width as usize;
        let data = layer.window();
        let [r, g, b, a] = layer.color.planes();
        let mut surface = Self {
            window,
            inverse_depth: vec![0.0; window.area()],
            rgba: vec![[0.0; 4]; window.area()],
            cover: vec![1.0; window.area()],
            doubt: Vec::new(),
            slopes: Vec::new(),
            tame: Tame::default(),
        };
        let rows = surface.rgba.par_chunks_mut(width).zip(surface.cover.par_chunks_mut(width));
        let rows = rows.zip(surface.inverse_depth.par_chunks_mut(width)).enumerate();
        let tame = rows.map(|(row, ((rgba, cover), inverse))| {
            let y = window.y + row as i32;
            let start = data.index(window.x, y);
            let part = start..start + width;
            let [r, g, b, a] = [r, g, b, a].map(|plane| &plane.values()[part.clone()]);
            let all = |plane: &[f32], is_good: fn(f32) -> bool| plane.iter().fold(true, |all, &c| all & is_good(c));
            let is_finite = [r, g, b, a].into_iter().all(|plane| all(plane, |c| c.abs() <= BRIGHTEST));
            for ((((rgba, &r), &g), &b), &a) in rgba.iter_mut().zip(r).zip(g).zip(b).zip(a) {
                *rgba = [r, g, b, a];
            }
            if !is_finite {
                rgba.iter_mut().for_each(|rgba| *rgba = rgba.map(finite));
            }
            let tame = Tame { is_opaque: all(a, |alpha| alpha == 1.0), is_finite };
            // The first layer always fills its pixel: its alpha is part of the colour. A hidden one fills what alpha says
            let known = &layer.known.bits()[part.clone()];
            if index > 0 {
                for ((cover, &known), rgba) in cover.iter_mut().zip(known).zip(rgba.iter()) {
                    *cover = if known && rgba[3] >= LEAST_COVER { rgba[3].min(1.0) } else { 0.0 };
                }
            }
            for (inverse, &depth) in inverse.iter_mut().zip(&layer.depth.values()[part]) {
                *inverse = (1.0 / depth).min(NEAREST);
            }
            for x in (0..width).filter(|&x| !known[x]) {
                let guess = cover[x] > 0.0;
                inverse[x] = if guess { inverse_depth(view, camera, layer, window.x + x as i32, y) } else { 0.0 };
            }
            tame
        });
        surface.tame = tame.reduce(
            || Tame { is_opaque: true, is_finite: true },
            |a, b| Tame { is_opaque: a.is_opaque & b.is_opaque, is_finite: a.is_finite & b.is_finite },
        );

        // Pixels of hidden layers will be dropped, so that their slopes are taken now
        if index > 0 {
            let slope = |i: usize| surface.slope_of_neighbours(i, i % width);
            surface.slopes = (0..window.area()).into_par_iter().map(slope).collect();
        }
        surface
    }

    /// Change of inverse depth per pixel in x and y on the surface itself, at a pixel of the window's `column`.
    #[inline(always)]
    pub(crate) fn slope(&self, i: usize, column: usize) -> [f32; 2] {
        if self.slopes.is_empty() { self.slope_of_neighbours(i, column) } else { self.slopes[i] }
    }

    /// The flatter of the two one-sided slopes on each axis: exact on a plane, and at an edge that of the side the pixel
    /// lies on.
    #[inline(always)]
    fn slope_of_neighbours(&self, i: usize, column: usize) -> [f32; 2] {
        let (width, count) = (self.window.width as usize, self.cover.len());
        if self.cover[i] <= 0.0 {
            return [0.0; 2];
        }
        let here = self.inverse_depth[i];
        let axis = |step: usize, is_inside: bool| {
            if is_inside && self.cover[i - step] > 0.0 && self.cover[i + step] > 0.0 {
                flatter(here - self.inverse_depth[i - step], self.inverse_depth[i + step] - here)
            } else {
                0.0
            }
        };
        [axis(1, column > 0 && column + 1 < width), axis(width, i >= width && i + width < count)]
    }
}

/// The one of smaller size, or 0 where they disagree in sign.
fn flatter(a: f32, b: f32) -> f32 {
    if a * b <= 0.0 {
        0.0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

/// A colour of a file, made finite.
#[inline(always)]
pub(crate) fn finite(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(-BRIGHTEST, BRIGHTEST) }
}

/// What the rest of a pixel is: 1/z and premultiplied colour, both made finite.
#[inline(always)]
pub(crate) fn rest_at(rest: Rest, x: i32, y: i32) -> Option<(f32, [f32; 4])> {
    rest.at(x, y).map(|rest| ((1.0 / rest.depth).min(NEAREST), rest.rgba.map(finite)))
}

/// The guess for a hole: 1/z of the nearest known pixel (the farther one of equals), and where none is
/// within reach the depth that keeps the pixel sharp.
fn inverse_depth(view: &FrameView, camera: &Camera, layer: &Layer, x: i32, y: i32) -> f32 {
    let window = view.window();
    let mut nearest: Option<(i32, f32)> = None;
    for ring in 1..=HOLE_REACH {
        if nearest.is_some_and(|(squared, _)| squared <= ring * ring) {
            break;
        }
        let mut look = |dx: i32, dy: i32| {
            let (u, v) = (x + dx, y + dy);
            if !window.contains(u, v) || !layer.known.at(u, v) {
                return;
            }
            let found = (dx * dx + dy * dy, (1.0 / layer.depth.at(u, v)).min(NEAREST));
            if nearest.is_none_or(|best| found.0 < best.0 || (found.0 == best.0 && found.1 < best.1)) {
                nearest = Some(found);
            }
        };
        for k in -ring..=ring {
            look(k, -ring);
            look(k, ring);
            look(-ring, k);
            look(ring, k);
        }
    }
    match nearest {
        Some((_, inverse_depth)) => inverse_depth,
        None => camera.focus.inverse_depth(pixel_q(view, camera, x, y)) as f32,
    }
}

/// Chief-ray direction of a pixel's centre.
pub(crate) fn pixel_q(view: &FrameView, camera: &Camera, x: i32, y: i32) -> DVec2 {
    let display = view.frame().display;
    let center = DVec2::new(f64::from(x) - f64::from(display.x) + 0.5, f64::from(y) - f64::from(display.y) + 0.5);
    camera.film.q_from_pixel(center)
}

//! A map brought to the pixels of its picture, without ever averaging depth across an edge.
//!
//! Around each pixel of the picture the 4x4 nearest pixels of the map are sorted by inverse depth. Where one gap holds more
//! than half of their range there is an edge (on a plane sixteen inverse depths have gaps of a third at most): the pixel
//! belongs to the side whose pixels look like it in the picture (joint bilateral weights; Kopf et al. 2007), and takes what
//! the plane through that side's inverse depths has there. Elsewhere inverse depth is interpolated, which is exact on planes.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::MapMeaning;
use crate::{Picture, PixelWindow, Plane};

/// How different two colours are that are no more alike, in square roots of light.
const COLOR_SIGMA: f32 = 0.08;

/// The least likeness, so that where no colour is like the pixel's the nearest side wins.
const LEAST_LIKENESS: f32 = 1e-4;

/// How far a map's pixel has a say, in its pixels.
const SPACE_SIGMA: f64 = 1.0;

/// Planar depths of a map, in its own pixels and NaN where they are not known, brought to the pixels of `guide`.
///
/// `largest`, the largest whole number of the map, and `meaning` tell how coarse its numbers are: what lies less than two of
/// their steps apart is no edge. A pixel of the picture that lies in an unknown pixel of the map stays unknown. A map that is no smaller than the picture is taken
/// pixel by pixel.
#[must_use]
pub fn fit_to_picture(planar: Plane, guide: &Picture, largest: Option<f32>, meaning: &MapMeaning) -> Plane {
    let (from, to) = (planar.window(), guide.window());
    if from.width == to.width && from.height == to.height {
        return Plane::from_values(to, planar.into_values()).expect("the same pixels");
    }
    let scale = DVec2::new(f64::from(from.width) / f64::from(to.width), f64::from(from.height) / f64::from(to.height));
    let likeness = (scale.x < 1.0 || scale.y < 1.0).then(|| roots_in(guide, from));
    let mut fitted = vec![0.0; to.area()];
    fitted.par_chunks_exact_mut(to.width as usize).enumerate().for_each(|(row, depths)| {
        for (column, depth) in depths.iter_mut().enumerate() {
            let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * scale;
            let (x, y) = (from.x + at.x as i32, from.y + at.y as i32);
            let nearest = planar.at(x.min(from.x_end() - 1), y.min(from.y_end() - 1));
            *depth = match &likeness {
                Some(roots) if !nearest.is_nan() => {
                    let own = roots_of(guide, row * to.width as usize + column);
                    Around::new(&planar, roots, at, own).depth(|inverse| meaning.step(largest, inverse))
                }
                _ => nearest,
            };
        }
    });
    let fitted = Plane::from_values(to, fitted).expect("a depth for each pixel");
    if likeness.is_some() { without_specks(&fitted) } else { fitted }
}

/// The median of the 3x3 pixels around each, which is a depth that there is: a single pixel whose colour is like the other side's
/// is no part of it. On a plane it is the pixel itself.
fn without_specks(depth: &Plane) -> Plane {
    let window = depth.window();
    let mut calm = depth.clone();
    calm.values_mut().par_chunks_exact_mut(window.width as usize).enumerate().for_each(|(row, depths)| {
        let y = window.y + row as i32;
        for (x, calm) in (window.x..).zip(depths.iter_mut()) {
            if x == window.x || x + 1 == window.x_end() || y == window.y || y + 1 == window.y_end() {
                continue;
            }
            let mut around: [f32; 9] = std::array::from_fn(|k| depth.at(x - 1 + k as i32 % 3, y - 1 + k as i32 / 3));
            if around.iter().all(|depth| !depth.is_nan()) {
                *calm = *around.select_nth_unstable_by(4, f32::total_cmp).1;
            }
        }
    });
    calm
}

/// Square roots of red, green and blue: about what an eye tells apart.
fn roots_of(picture: &Picture, i: usize) -> [f32; 3] {
    [0, 1, 2].map(|c| {
        let value = picture.planes()[c].values()[i];
        if value > 0.0 { value.min(16.0).sqrt() } else { 0.0 }
    })
}

/// The mean roots of the guide over each pixel of the map.
fn roots_in(guide: &Picture, map: PixelWindow) -> Vec<[f32; 3]> {
    let (width, height) = (guide.window().width as usize, guide.window().height as usize);
    let (columns, rows) = (map.width as usize, map.height as usize);
    // From the first to before the last pixel of the guide whose centre lies in a pixel of the map, one at least
    let span = |i: usize, count: usize, size: usize| {
        let border = |i: usize| (i * size).div_ceil(count).min(size);
        let start = border(i).min(size - 1);
        start..border(i + 1).max(start + 1)
    };
    let mean = |i: usize| {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for y in span(i / columns, rows, height) {
            for x in span(i % columns, columns, width) {
                let roots = roots_of(guide, y * width + x);
                sum.iter_mut().zip(roots).for_each(|(sum, root)| *sum += root);
                count += 1.0;
            }
        }
        sum.map(|sum| sum / count)
    };
    (0..columns * rows).into_par_iter().map(mean).collect()
}

/// One pixel of the map near a pixel of the picture.
#[derive(Clone, Copy, Default)]
struct Near {
    inverse: f32,
    /// How much it has to say by where it is.
    space: f64,
    /// And by its colour too.
    vote: f64,
    /// Its centre from the picture's pixel, in pixels of the map.
    from: DVec2,
}

/// The known pixels of the map around a pixel of the picture, by inverse depth.
struct Around {
    near: [Near; 16],
    count: usize,
}

impl Around {
    fn new(planar: &Plane, roots: &[[f32; 3]], at: DVec2, own: [f32; 3]) -> Self {
        let window = planar.window();
        let corner = (at - 0.5).floor();
        let mut around = Self { near: [Near::default(); 16], count: 0 };
        for k in 0..16 {
            let place = corner + DVec2::new(f64::from(k % 4 - 1), f64::from(k / 4 - 1));
            let (x, y) = (window.x + place.x as i32, window.y + place.y as i32);
            let Some(depth) = planar.get(x, y).filter(|depth| !depth.is_nan()) else { continue };
            let color = roots[window.index(x, y)];
            let difference: f32 = color.iter().zip(own).map(|(a, b)| (a - b) * (a - b)).sum();
            let likeness = (-0.5 * difference / (COLOR_SIGMA * COLOR_SIGMA)).exp() + LEAST_LIKENESS;
            let from = place + 0.5 - at;
            let space = (-0.5 * from.length_squared() / (SPACE_SIGMA * SPACE_SIGMA)).exp();
            around.near[around.count] = Near { inverse: depth.recip(), space, vote: space * f64::from(likeness), from };
            around.count += 1;
        }
        around.near[..around.count].sort_by(|a, b| a.inverse.total_cmp(&b.inverse));
        around
    }

    fn depth(&self, step: impl Fn(f32) -> f32) -> f32 {
        let near = &self.near[..self.count];
        let (Some(first), Some(last)) = (near.first(), near.last()) else { return f32::NAN };

        // Find the widest gap
        let gap = |i: usize| near[i + 1].inverse - near[i].inverse;
        let widest = (0..near.len() - 1).reduce(|a, b| if gap(b) > gap(a) { b } else { a });
        let Some(widest) = widest else { return first.inverse.recip() };
        let noise = (2.1 * step(near[widest + 1].inverse)).max(1e-3 * last.inverse);
        let is_edge = gap(widest) > 0.5 * (last.inverse - first.inverse) && gap(widest) > noise;

        // Take the side that looks like the pixel
        let side = if is_edge {
            let (far, near) = near.split_at(widest + 1);
            let vote = |side: &[Near]| side.iter().map(|near| near.vote).sum::<f64>();
            if vote(near) > vote(far) { near } else { far }
        } else {
            near
        };
        let inverse = if is_edge { plane(side) } else { bilinear(side).unwrap_or_else(|| plane(side)) };
        (inverse.max(0.0) as f32).recip()
    }
}

/// Between the four nearest, where all are known.
fn bilinear(side: &[Near]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for near in side.iter().filter(|near| near.from.x.abs() < 1.0 && near.from.y.abs() < 1.0) {
        sum += f64::from(near.inverse) * (1.0 - near.from.x.abs()) * (1.0 - near.from.y.abs());
        count += 1;
    }
    (count == 4).then_some(sum)
}

/// What the plane of least squares through the inverse depths of a side has at the pixel, within their range.
fn plane(side: &[Near]) -> f64 {
    let mean = |value: &dyn Fn(&Near) -> f64| {
        let total: f64 = side.iter().map(|near| near.space).sum();
        side.iter().map(|near| near.space * value(near)).sum::<f64>() / total
    };
    let inverse = |near: &Near| f64::from(near.inverse);
    let at = |near: &Near| near.from.extend(1.0);
    let mut normal = DMat3::ZERO;
    let mut right = DVec3::ZERO;
    for near in side {
        let p = at(near);
        normal += DMat3::from_cols(p * p.x, p * p.y, p * p.z) * near.space;
        right += p * (near.space * inverse(near));
    }
    // Pixels on one line determine no plane
    const FLAT: f64 = 1e-3;
    let total = normal.z_axis.z;
    let value = if normal.determinant() > FLAT * total.powi(3) { (normal.inverse() * right).z } else { mean(&inverse) };
    let ends = [side[0].inverse, side[side.len() - 1].inverse].map(f64::from);
    value.clamp(ends[0], ends[1])
}

//! From the centres of cells to pixels: Catmull-Rom, kept within the cells around, so that no lamp leaves a dark ring.

use rgbd::PixelWindow;

use crate::{row::LANES, tiles::TILE};

/// Cells beyond a window from which its pixels are interpolated, on each side.
pub(crate) const MARGIN: i32 = 2;

/// Interpolates the pixels of `window`, whose corners are corners of cells of 2^level pixels and of blocks of 8 and whose
/// sides are at most a tile's.
///
/// `planes` hold the cells row by row, `width` to a row, [`MARGIN`] of them before the window. Eight pixels of a row are
/// put at a time, if they are wanted.
#[inline(always)]
pub(crate) fn upsample<const N: usize>(
    window: PixelWindow,
    level: u32,
    planes: &[Vec<f32>; N],
    width: usize,
    is_wanted: impl Fn(i32, i32) -> bool,
    mut put: impl FnMut(i32, i32, &[[f32; LANES]; N]),
) {
    let side = 1_usize << level;
    // Where a pixel lies among the cells: the second of the four around it, and their weights
    let place = |k: usize| {
        let at = (k as f32 + 0.5) / side as f32 - 0.5 + MARGIN as f32;
        (at as usize, catmull_rom(at.fract()))
    };
    let columns: [(usize, [f32; 4]); TILE as usize] = std::array::from_fn(place);
    let columns = &columns[..window.width as usize];
    let mut line = [0.0; TILE as usize];
    let line = &mut line[..width];
    let mut blocks = [[[0.0; LANES]; N]; TILE as usize / LANES];
    for (j, y) in (window.y..window.y_end()).enumerate() {
        let starts = || (window.x..window.x_end()).step_by(LANES);
        if !starts().any(|x| is_wanted(x, y)) {
            continue;
        }
        let (row, weights) = place(j);
        for (c, plane) in planes.iter().enumerate() {
            let rows = [0, 1, 2, 3].map(|k| &plane[(row + k - 1) * width..(row + k) * width]);
            for (i, line) in line.iter_mut().enumerate() {
                *line = between(rows.map(|row| row[i]), weights);
            }
            for (block, columns) in blocks.iter_mut().zip(columns.chunks(LANES)) {
                for (out, &(column, weights)) in block[c].iter_mut().zip(columns) {
                    *out = between([0, 1, 2, 3].map(|k| line[column + k - 1]), weights);
                }
            }
        }
        for (x, block) in starts().zip(&blocks) {
            if is_wanted(x, y) {
                put(x, y, block);
            }
        }
    }
}

/// Weights of four values around a place between the middle ones.
fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]
}

/// The value between four, and within them.
#[inline(always)]
fn between([a, b, c, d]: [f32; 4], weights: [f32; 4]) -> f32 {
    let value = weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d;
    value.max(a.min(b).min(c.min(d))).min(a.max(b).max(c.max(d)))
}

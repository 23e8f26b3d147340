//! From the centres of cells to pixels: Catmull-Rom, kept within the cells around, so that no lamp leaves a dark ring.

use rgbd::PixelWindow;

use crate::{row::LANES, tiles::TILE};

/// Cells beyond a window from which its pixels are interpolated, on each side.
pub(crate) const MARGIN: i32 = 2;

/// Rows of cells in a tile and its margins at most.
const MOST_LINES: usize = TILE as usize / 2 + 2 * MARGIN as usize;

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

    // Along the rows of cells first: there are fewer of them
    let lines = (window.height as usize >> level) + 2 * MARGIN as usize;
    let mut wide = [[[0.0; TILE as usize]; MOST_LINES]; N];
    for (wide, plane) in wide.iter_mut().zip(planes) {
        for (wide, cells) in wide[..lines].iter_mut().zip(plane.chunks_exact(width)) {
            for (out, &(column, weights)) in wide.iter_mut().zip(columns) {
                let [a, b, c, d] = *cells[column - 1..].first_chunk().expect("cells beyond the window on each side");
                *out = between([a, b, c, d], weights);
            }
        }
    }
    for (j, y) in (window.y..window.y_end()).enumerate() {
        let (row, weights) = place(j);
        for (i, x) in (window.x..window.x_end()).step_by(LANES).enumerate() {
            if !is_wanted(x, y) {
                continue;
            }
            let mut block = [[0.0; LANES]; N];
            for (block, wide) in block.iter_mut().zip(&wide) {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| &wide[row + k - 1][i * LANES..(i + 1) * LANES]);
                for ((((out, &a), &b), &c), &d) in block.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                    *out = between([a, b, c, d], weights);
                }
            }
            put(x, y, &block);
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
    larger(smaller(value, larger(larger(a, b), larger(c, d))), smaller(smaller(a, b), smaller(c, d)))
}

/// The smaller of two numbers that are no NaN; one instruction, as that of `std` is not.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

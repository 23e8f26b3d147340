//! Work cut into tiles, on all cores.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rgbd::{Cancelled, Picture, PixelWindow, Progress};

/// Side of a tile in pixels: a work item, it never changes a result.
const TILE: u32 = 32;

/// The picture of `window` whose pixels `work` makes, tile by tile, each row by row.
pub(crate) fn by_tiles(
    window: PixelWindow,
    progress: &dyn Progress,
    work: impl Fn(PixelWindow) -> Vec<[f32; 4]> + Sync,
) -> Result<Picture, Cancelled> {
    let tiles = tiles(window);
    let done = AtomicU64::new(0);
    let finished: Vec<Vec<[f32; 4]>> = tiles
        .par_iter()
        .map(|&tile| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            let pixels = work(tile);
            progress.report(done.fetch_add(1, Ordering::Relaxed) + 1, tiles.len() as u64);
            Ok(pixels)
        })
        .collect::<Result<_, _>>()?;

    let mut picture = Picture::filled(window, [0.0; 4]);
    for (tile, pixels) in tiles.iter().zip(&finished) {
        for ((x, y), &rgba) in tile.pixels().zip(pixels) {
            picture.set(x, y, rgba);
        }
    }
    Ok(picture)
}

/// `window` cut into tiles.
fn tiles(window: PixelWindow) -> Vec<PixelWindow> {
    let starts = |from: i32, end: i32| (from..end).step_by(TILE as usize);
    starts(window.y, window.y_end())
        .flat_map(|y| starts(window.x, window.x_end()).map(move |x| (x, y)))
        .map(|(x, y)| PixelWindow { x, y, width: TILE, height: TILE }.intersection(&window))
        .collect()
}

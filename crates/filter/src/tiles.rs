//! Work cut into tiles, on all cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rgbd::{Cancelled, PixelWindow, Plane, Progress};

/// Side of a tile in pixels. Tiles are cut at multiples of it, whatever the window.
pub(crate) const TILE: u32 = 64;

/// Side of the parts of a tile over which a lens whose focus changes is taken as one, and over which edges are gathered.
pub(crate) const PART: u32 = 32;

/// The parts of a tile.
pub(crate) fn parts(tile: PixelWindow) -> impl Iterator<Item = PixelWindow> {
    let starts = |from: i32, end: i32| (from..end).step_by(PART as usize);
    let corners = starts(tile.y, tile.y_end()).flat_map(move |y| starts(tile.x, tile.x_end()).map(move |x| (x, y)));
    corners.map(|(x, y)| PixelWindow { x, y, width: PART, height: PART })
}

/// `channels` planes of `window` that `work` makes tile by tile: it receives a tile and its channels, row by row, full of
/// zeros.
pub(crate) fn by_tiles(
    window: PixelWindow,
    channels: usize,
    progress: &dyn Progress,
    work: impl Fn(PixelWindow, &mut [Vec<f32>]) + Sync,
) -> Result<Vec<Plane>, Cancelled> {
    let tiles = tiles(window);
    let done = AtomicU64::new(0);
    let planes = Mutex::new(vec![Plane::filled(window, 0.0); channels]);
    tiles.par_iter().try_for_each_init(
        || vec![Vec::new(); channels],
        |out, &tile| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            for channel in out.iter_mut() {
                channel.clear();
                channel.resize(tile.area(), 0.0);
            }
            work(tile, out);

            // Copying takes a hundredth of the work, so that a lock is cheap
            let mut planes = planes.lock().expect("no thread panics while it holds the lock");
            for (plane, channel) in planes.iter_mut().zip(out.iter()) {
                for (row, values) in channel.chunks(tile.width as usize).enumerate() {
                    let to = window.index(tile.x, tile.y + row as i32);
                    plane.values_mut()[to..to + values.len()].copy_from_slice(values);
                }
            }
            drop(planes);
            progress.report(done.fetch_add(1, Ordering::Relaxed) + 1, tiles.len() as u64);
            Ok(())
        },
    )?;
    Ok(planes.into_inner().expect("no thread panicked"))
}

/// `window` cut at multiples of the tile's side.
fn tiles(window: PixelWindow) -> Vec<PixelWindow> {
    let side = TILE as i32;
    let starts = |from: i32, end: i32| (from.div_euclid(side) * side..end).step_by(TILE as usize);
    starts(window.y, window.y_end())
        .flat_map(|y| starts(window.x, window.x_end()).map(move |x| (x, y)))
        .map(|(x, y)| PixelWindow { x, y, width: TILE, height: TILE }.intersection(&window))
        .collect()
}

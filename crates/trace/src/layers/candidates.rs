//! Where it is worth looking behind the first surface.

use optics::Camera;
use rgbd::{Mask, Plane};

/// A jump that moves by less than this over the whole lens hides nothing that could be seen.
const LEAST_PARALLAX_PX: f64 = 0.05;

/// The pixels behind whose first surface some lens point might see another one.
///
/// A line of sight from a lens point to a hidden point starts in front of the first surface, as the pinhole sees it,
/// and ends behind it. It does not meet that surface, so it changes sides at a jump of depth. Seen from the pinhole,
/// that jump lies within the lens radius over its nearer depth (in units of q) of the hidden point. So all pixels are
/// marked that lie so near to a pixel where the inverse depth is not affine: planes have affine inverse depths.
pub(super) fn near_edges(depth: &Plane, camera: &Camera) -> Mask {
    let window = depth.window();
    let lens_px = camera.pixels_per_defocus().max_element();
    let inverse = |x: i32, y: i32| depth.get(x, y).map(|z| 1.0 / f64::from(z));

    // Stamp a square of the reach of each jump, as sums of rows and columns of differences
    let (width, height) = (window.width as usize + 1, window.height as usize + 1);
    let mut marks = vec![0_i32; width * height];
    for (x, y) in window.pixels() {
        let Some(middle) = inverse(x, y) else { continue };
        let mut nearest = middle;
        let mut bend: f64 = 0.0;
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
            if let (Some(before), Some(after)) = (inverse(x - dx, y - dy), inverse(x + dx, y + dy)) {
                bend = bend.max((before - 2.0 * middle + after).abs());
                nearest = nearest.max(before).max(after);
            }
        }
        if lens_px * bend > LEAST_PARALLAX_PX {
            let reach = (lens_px * nearest).min(1e6).ceil() as i32 + 2;
            let column = |x: i32| (x.clamp(window.x, window.x_end()) - window.x) as usize;
            let row = |y: i32| (y.clamp(window.y, window.y_end()) - window.y) as usize;
            let (x0, x1) = (column(x.saturating_sub(reach)), column(x.saturating_add(reach + 1)));
            let (y0, y1) = (row(y.saturating_sub(reach)), row(y.saturating_add(reach + 1)));
            marks[y0 * width + x0] += 1;
            marks[y0 * width + x1] -= 1;
            marks[y1 * width + x0] -= 1;
            marks[y1 * width + x1] += 1;
        }
    }
    for y in 0..height {
        for x in 0..width {
            let left = if x > 0 { marks[y * width + x - 1] } else { 0 };
            let above = if y > 0 { marks[(y - 1) * width + x] } else { 0 };
            let both = if x > 0 && y > 0 { marks[(y - 1) * width + x - 1] } else { 0 };
            marks[y * width + x] += left + above - both;
        }
    }
    Mask::from_fn(window, |x, y| marks[(y - window.y) as usize * width + (x - window.x) as usize] > 0)
}

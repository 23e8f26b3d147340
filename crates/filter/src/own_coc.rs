//! Rung 1: every pixel averages its own circle of confusion.
//!
//! What most real-time filters start from, and the measure of what occlusion is worth: a blurred background bleeds onto a
//! sharp foreground, and a blurred foreground keeps a hard silhouette. Hidden layers are not looked at.

use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, PixelWindow, Plane, Progress};

use crate::{
    FrameView,
    cat_eye::Eye,
    kernel::KernelTable,
    lens_map::PixelLens,
    surface::{Surface, pixel_q},
    tiles::by_tiles,
};

/// Averages `window`; `max_radius` in pixels.
pub(crate) fn own_coc(
    view: &FrameView,
    camera: &Camera,
    model: KernelModel,
    max_radius: f32,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Picture, Cancelled> {
    let surface = Surface::new(view, camera, 0);
    let table = KernelTable::of(camera);

    // Average around one pixel
    let pixel = |x: i32, y: i32| -> [f32; 4] {
        if !surface.window.contains(x, y) {
            return [0.0; 4];
        }
        let here = surface.window.index(x, y);
        let q = pixel_q(view, camera, x, y);
        let (lens, eye) = (PixelLens::new(camera, model, q), Eye::of(camera, q));
        let defocus = lens.scale * (surface.inverse_depth[here] - lens.focus);
        let radius = defocus.abs().min(max_radius);
        let (kernel, _) = table.with_slope(radius);
        let reach = (radius * lens.stretch() + 1.5) as u32;
        let around = PixelWindow { x, y, width: 1, height: 1 }.grown(reach, reach).intersection(&surface.window);
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        for (u, v) in around.pixels() {
            let offset = lens.iris_offset((u - x) as f32, (v - y) as f32, defocus, radius);
            let weight = match &eye {
                Some(eye) => eye.weight(&table, offset, radius, &kernel),
                None => table.weight(offset, radius, &kernel),
            };
            if weight > 0.0 {
                total += weight;
                let rgba = surface.rgba[surface.window.index(u, v)];
                sum.iter_mut().zip(rgba).for_each(|(sum, c)| *sum += weight * c);
            }
        }
        if total > 0.0 { sum.map(|c| c / total) } else { surface.rgba[here] }
    };

    let planes = by_tiles(window, 4, progress, |tile, out| {
        for (i, (x, y)) in tile.pixels().enumerate() {
            let rgba = pixel(x, y);
            (0..4).for_each(|c| out[c][i] = rgba[c]);
        }
    })?;
    let planes = <[Plane; 4]>::try_from(planes).expect("four planes");
    Ok(Picture::from_planes(planes).expect("planes of one window"))
}

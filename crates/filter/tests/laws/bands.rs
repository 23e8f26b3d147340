//! A picture made whole, in bands, on any number of threads: always the same bits.

use filter::{FrameView, GatherSettings, Method, apply, reach_px};
use glam::DVec3;
use optics::{ApertureShape, Camera};
use rgbd::{Frame, Picture, PixelWindow, Silent};

use crate::scenes::{DISPLAY, all_methods, camera, filtered, layer, lenses, noise, over, rough_frame};

/// The rows of `band` from a view that ends where the method's reach does are those of the `whole` picture; returns how many
/// rows the view has.
fn check_band(frame: &Frame, camera: &Camera, method: &Method, whole: &Picture, band: PixelWindow) -> u32 {
    let whole = whole.cropped(band);
    let reach = reach_px(&FrameView::whole(frame), camera, method);
    let view = FrameView::part(frame, band.grown(reach, reach));
    let part = apply(&view, camera, method, band, &Silent).unwrap().picture;
    let off = band.pixels().filter(|&(x, y)| part.at(x, y) != whole.at(x, y)).collect::<Vec<_>>();
    assert!(part == whole, "{method:?} through {camera:?}, reach {reach}: {band} differs at {off:?}");
    view.window().height
}

#[test]
fn bands_and_threads_never_change_bits() {
    let frame = rough_frame(DISPLAY, DISPLAY.grown(6, 6), noise);
    let lenses = [&lenses()[1..4], &lenses()[5..]].concat();
    for (camera, method) in lenses.iter().flat_map(|lens| all_methods().into_iter().map(move |m| (lens, m))) {
        let whole = filtered(&frame, camera, &method);
        for (start, end) in [(0, 24), (24, 48), (0, 11), (11, 12), (12, 37), (37, 48)] {
            check_band(&frame, camera, &method, &whole, PixelWindow::from_corners(0, start, DISPLAY.x_end(), end));
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| filtered(&frame, camera, &method)) == whole, "{method:?} on {threads} threads");
        }
    }
}

#[test]
fn a_band_needs_no_more_of_the_frame_than_the_reach() {
    // Far taller than any reach, its windows at odd and negative places: trees, tiles and fills must not care
    for (x, y) in [(0, 0), (-37, -533), (1001, 77)] {
        let display = PixelWindow { x, y, width: 40, height: 600 };
        let data = PixelWindow { x: x - 3, y: y - 11, width: 45, height: 617 };
        // Wide steps without holes, so that fills and their mirrored samples go as far as they may; and a rough one
        let step = |_, y: i32| [6.0, 9.0, 1.2, 5.0, 2.0][((y - display.y).div_euclid(41)).rem_euclid(5) as usize];
        let steps = Frame::new(display, vec![layer(data, |x, y| noise(x, y, 7), step)]).unwrap();
        let frames = [rough_frame(display, data, noise), steps];
        let between = camera(DVec3::new(0.02, -0.05, 0.35), DVec3::Z, 0.3, ApertureShape::Disc);
        let cases = frames.iter().flat_map(|frame| [between, lenses()[3], lenses()[5]].map(|lens| (frame, lens)));
        for (frame, camera) in cases.map(|(frame, lens)| (frame, over(display, &lens))) {
            let settings = GatherSettings { max_radius_px: Some(10.5), ..GatherSettings::default() };
            for method in [Method::OwnCoc(settings), Method::Gather(settings), Method::Merged(settings)] {
                let whole = filtered(frame, &camera, &method);
                for (start, end) in [(290, 301), (311, 312)] {
                    let band = PixelWindow::from_corners(x, y + start, display.x_end(), y + end);
                    let height = check_band(frame, &camera, &method, &whole, band);
                    assert!(height < 550, "{height} rows read: the band is no test");
                }
            }
        }
    }
}

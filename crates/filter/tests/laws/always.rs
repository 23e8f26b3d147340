//! What holds for every method, lens and frame.

use filter::{FrameView, GatherSettings, Method, apply};
use optics::Camera;
use rgbd::{Frame, PixelWindow, Plane, Silent};

use crate::scenes::{DISPLAY, all_methods, filtered, layer, lenses, noise, rough_frame};

#[test]
fn a_furnace_stays_one_for_every_lens_and_method_up_to_the_border() {
    const ROUNDING: f32 = 1e-6; // sums of some thousand f32 weights
    for data in [DISPLAY, DISPLAY.grown(9, 4)] {
        let frame = rough_frame(DISPLAY, data, |_, _, _| 1.0);
        for (camera, method) in lenses().iter().flat_map(|lens| all_methods().into_iter().map(move |m| (lens, m))) {
            let picture = filtered(&frame, camera, &method);
            let worst = picture.planes().iter().flat_map(Plane::values).map(|v| (v - 1.0).abs()).fold(0.0, f32::max);
            assert!(worst <= ROUNDING, "{method:?} through {camera:?}: off by {worst}");
        }
    }
}

#[test]
fn a_pinhole_changes_nothing() {
    let frame = rough_frame(DISPLAY, DISPLAY, noise);
    let closed = &lenses()[0];
    let original = &frame.layers()[0].color;
    for method in all_methods() {
        let picture = filtered(&frame, closed, &method);
        let worst =
            DISPLAY.pixels().map(|(x, y)| (picture.at(x, y)[0] - original.at(x, y)[0]).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-6, "{method:?}: {worst}"); // a weight of 1, divided by itself
    }
}

#[test]
fn bad_pixels_come_out_finite() {
    let color = |x: i32, y: i32| match (x + y).rem_euclid(5) {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => f32::NEG_INFINITY,
        _ => 0.5,
    };
    let depth = |x: i32, y: i32| {
        [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, f32::MIN_POSITIVE, 1e30, 2.0][((x * 3 + y) & 7) as usize]
    };
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, color, depth)]).unwrap();
    for (camera, method) in
        lenses()[1..].iter().flat_map(|lens| all_methods().into_iter().skip(1).map(move |m| (lens, m)))
    {
        let picture = filtered(&frame, camera, &method);
        assert!(picture.planes().iter().flat_map(Plane::values).all(|v| v.is_finite()), "{method:?} {camera:?}");
    }
}

#[test]
fn what_cannot_be_filtered_is_said() {
    let frame = rough_frame(DISPLAY, DISPLAY, noise);
    let view = FrameView::whole(&frame);
    let lens = &lenses()[1];
    let far_away = PixelWindow { x: 1000, ..DISPLAY };
    let error = apply(&view, lens, &Method::default(), far_away, &Silent).unwrap_err().to_string();
    assert!(error.contains("64x48 at (1000, 0)"), "{error}");
    let other_film = Camera { film: lens.film.resized(10, 10).unwrap(), ..*lens };
    let error = apply(&view, &other_film, &Method::default(), DISPLAY, &Silent).unwrap_err().to_string();
    assert!(error.contains("10x10"), "{error}");
    let negative = Method::Gather(GatherSettings { max_radius_px: Some(-1.0), ..GatherSettings::default() });
    assert!(apply(&view, lens, &negative, DISPLAY, &Silent).is_err());
}

//! The predicted error: nothing where nothing can be wrong, and always a number.

use filter::{FrameView, GatherSettings, LensRaysSettings, Method, PredictedError, apply, reach_px};
use optics::Camera;
use rgbd::{Frame, PixelWindow, Plane, Silent};

use crate::scenes::{DISPLAY, layer, lenses, noise, rough_frame};

/// Every method that knows its own error.
fn methods() -> [Method; 3] {
    let settings = GatherSettings { predict_error: true, ..GatherSettings::default() };
    let rays = LensRaysSettings { samples: 16, predict_error: true, ..LensRaysSettings::default() };
    [Method::Gather(settings), Method::Merged(settings), Method::LensRays(rays)]
}

fn predicted(frame: &Frame, camera: &Camera, method: &Method) -> PredictedError {
    let filtered = apply(&FrameView::whole(frame), camera, method, DISPLAY, &Silent);
    filtered.expect("a frame of the camera's size").predicted_error.expect("a map was asked for")
}

/// Every lens with every method.
fn runs() -> impl Iterator<Item = (Camera, Method)> {
    lenses().into_iter().flat_map(|camera| methods().map(|method| (camera, method)))
}

#[test]
fn a_furnace_predicts_no_error() {
    const ROUNDING: f32 = 2e-3; // the root of what is left of a difference of squares in f32
    let frame = rough_frame(DISPLAY, DISPLAY.grown(9, 4), |_, _, _| 1.0);
    for (camera, method) in runs() {
        let worst = predicted(&frame, &camera, &method).total.values().iter().copied().fold(0.0, f32::max);
        assert!(worst <= ROUNDING, "{camera:?}: {worst}");
    }
}

#[test]
fn bad_pixels_have_finite_predictions() {
    let color = |x: i32, y: i32| [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5][((x + y) & 3) as usize];
    let depth = |x: i32, y: i32| [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 2.0][(x * 3 + y).rem_euclid(6) as usize];
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, color, depth)]).expect("one window");
    for (camera, method) in runs() {
        let PredictedError { total, causes } = predicted(&frame, &camera, &method);
        let values = || causes.iter().chain([&total]).flat_map(Plane::values);
        assert!(values().all(|v| v.is_finite() && *v >= 0.0), "{camera:?}");
    }
}

#[test]
fn the_total_is_made_of_the_causes() {
    let frame = rough_frame(DISPLAY, DISPLAY, noise);
    for (camera, method) in runs() {
        let predicted = predicted(&frame, &camera, &method);
        for (x, y) in DISPLAY.pixels() {
            let (total, causes) = (predicted.total.at(x, y), predicted.causes.each_ref().map(|c| c.at(x, y)));
            let sum = causes.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!((total - sum).abs() <= 1e-5 * total, "({x}, {y}): {total}, {causes:?}");
            assert_eq!(predicted.largest_cause(x, y).is_some(), total > 0.0);
        }
    }
}

#[test]
fn asking_for_the_error_changes_no_picture_and_cutting_changes_no_error() {
    let frame = rough_frame(DISPLAY, DISPLAY.grown(9, 4), noise);
    for (camera, method) in runs() {
        let whole = FrameView::whole(&frame);
        let filtered = apply(&whole, &camera, &method, DISPLAY, &Silent).expect("a frame of the camera's size");
        let silent = match method {
            Method::LensRays(rays) => Method::LensRays(LensRaysSettings { predict_error: false, ..rays }),
            Method::Gather(_) => Method::Gather(GatherSettings::default()),
            _ => Method::default(),
        };
        let alone = apply(&whole, &camera, &silent, DISPLAY, &Silent).expect("a frame of the camera's size");
        assert_eq!(filtered.picture, alone.picture, "{camera:?}, {}", method.name());

        let band = PixelWindow { y: DISPLAY.y + 5, height: 7, ..DISPLAY };
        let reach = reach_px(&whole, &camera, &method);
        let part = FrameView::part(&frame, band.grown(reach, reach));
        let cut = apply(&part, &camera, &method, band, &Silent).expect("a frame of the camera's size");
        let cut = cut.predicted_error.expect("a map was asked for").total;
        let total = filtered.predicted_error.expect("a map was asked for").total;
        assert_eq!(total.cropped(band), cut, "{camera:?}, {}", method.name());
    }
}

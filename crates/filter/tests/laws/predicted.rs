//! The predicted error: nothing where nothing can be wrong, and always a number.

use filter::{FrameView, GatherSettings, Method, PredictedError, apply};
use optics::Camera;
use rgbd::{Frame, Plane, Silent};

use crate::scenes::{DISPLAY, layer, lenses, noise, rough_frame};

fn predicted(frame: &Frame, camera: &Camera) -> PredictedError {
    let settings = GatherSettings { predict_error: true, ..GatherSettings::default() };
    let filtered = apply(&FrameView::whole(frame), camera, &Method::Merged(settings), DISPLAY, &Silent);
    filtered.expect("a frame of the camera's size").predicted_error.expect("a map was asked for")
}

#[test]
fn a_furnace_predicts_no_error() {
    const ROUNDING: f32 = 2e-3; // the root of what is left of a difference of squares in f32
    let frame = rough_frame(DISPLAY, DISPLAY.grown(9, 4), |_, _, _| 1.0);
    for camera in lenses() {
        let worst = predicted(&frame, &camera).total.values().iter().copied().fold(0.0, f32::max);
        assert!(worst <= ROUNDING, "{camera:?}: {worst}");
    }
}

#[test]
fn bad_pixels_have_finite_predictions() {
    let color = |x: i32, y: i32| [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5][((x + y) & 3) as usize];
    let depth = |x: i32, y: i32| [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 2.0][(x * 3 + y).rem_euclid(6) as usize];
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, color, depth)]).expect("one window");
    for camera in lenses() {
        let PredictedError { total, causes } = predicted(&frame, &camera);
        let values = || causes.iter().chain([&total]).flat_map(Plane::values);
        assert!(values().all(|v| v.is_finite() && *v >= 0.0), "{camera:?}");
    }
}

#[test]
fn the_total_is_made_of_the_causes() {
    let frame = rough_frame(DISPLAY, DISPLAY, noise);
    for camera in lenses() {
        let predicted = predicted(&frame, &camera);
        for (x, y) in DISPLAY.pixels() {
            let (total, causes) = (predicted.total.at(x, y), predicted.causes.each_ref().map(|c| c.at(x, y)));
            let sum = causes.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!((total - sum).abs() <= 1e-5 * total, "({x}, {y}): {total}, {causes:?}");
            assert_eq!(predicted.largest_cause(x, y).is_some(), total > 0.0);
        }
    }
}

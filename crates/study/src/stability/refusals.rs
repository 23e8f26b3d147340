//! Requests that have no meaning, each with the error that is documented for it.

use filter::{FilterError, FrameView, GatherSettings, Method};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, OpticsError, Pose, ThinLens};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, Silent};
use serde::Serialize;

/// A request without meaning, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refusal {
    /// What was asked for.
    pub request: &'static str,
    /// What was said; `None` where the request was accepted.
    pub said: Option<String>,
    /// Whether that is the documented error.
    pub is_documented: bool,
}

/// Makes every such request once.
#[must_use]
pub fn refusals() -> Vec<Refusal> {
    let lens = ThinLens::new(0.05, 2.8, 0.0515).expect("a 50 mm lens");
    let through_centre = Focus::from_world_plane(&Pose::IDENTITY, DVec3::ZERO, DVec3::Y);
    let behind = Focus::new(DVec3::new(0.0, 0.0, -30.0)).expect("a finite plane");
    let near_hinge = Focus::new(DVec3::new(0.0, -25.0, 0.5)).expect("a finite plane");
    let near_plane = Focus::new(DVec3::new(0.0, 0.0, 25.0)).expect("a finite plane");
    let picks = [0.0, 0.1, 0.2].map(|x| (DVec2::new(x, 0.0), 2.0));
    let steep = || {
        let tilted = lens.tilted(1.4, 0.0)?;
        tilted.camera(Pose::IDENTITY, Film::from_fov(1.0, 16, 9)?, tilted.iris(ApertureShape::Disc))
    };
    use OpticsError as E;
    vec![
        optics("a plane of focus through the lens centre", through_centre, |e| matches!(e, E::OutOfRange { .. })),
        optics("focus that is no number", Focus::new(DVec3::splat(f64::NAN)), |e| matches!(e, E::OutOfRange { .. })),
        optics("focus at depth 0", Focus::at_depth(0.0), |e| matches!(e, E::OutOfRange { .. })),
        optics("focus within the focal length", lens.focused_at(DVec2::ZERO, 0.04), |e| {
            matches!(e, E::DepthTooNear { .. })
        }),
        optics(
            "a plane of focus behind the camera, nearer than the sensor",
            ThinLens::at_image_distance(&behind, 0.05, 2.8),
            |e| matches!(e, E::FacesAway { .. }),
        ),
        optics("a hinge within the focal length", ThinLens::of_focal_length(&near_hinge, 0.05, 2.8), |e| {
            matches!(e, E::HingeTooNear { .. })
        }),
        optics("a plane of focus within the focal length", ThinLens::of_focal_length(&near_plane, 0.05, 2.8), |e| {
            matches!(e, E::PlaneTooNear { .. })
        }),
        optics("a lens seen from its edge", steep(), |e| matches!(e, E::EdgeOn { .. })),
        optics("a plane through three pixels of one line", Focus::through_pixels(picks), |e| {
            matches!(e, E::CollinearPixels)
        }),
        optics("an aperture of negative radius", lens.with_aperture_radius(-0.01), |e| {
            matches!(e, E::OutOfRange { .. })
        }),
        filter("a largest blur that is no number", f32::NAN, 16, |e| matches!(e, FilterError::BadSetting { .. })),
        filter("a film of another size than the picture", 4.0, 15, |e| matches!(e, FilterError::FilmMismatch { .. })),
    ]
}

fn optics<T>(
    request: &'static str,
    answer: Result<T, OpticsError>,
    is_documented: impl Fn(&OpticsError) -> bool,
) -> Refusal {
    let error = answer.err();
    Refusal { request, is_documented: error.as_ref().is_some_and(is_documented), said: error.map(|e| e.to_string()) }
}

/// A grey picture of 16 x 9 pixels, filtered with a largest radius and a film of a width.
fn filter(
    request: &'static str,
    max_radius_px: f32,
    width: u32,
    is_documented: impl Fn(&FilterError) -> bool,
) -> Refusal {
    let window = PixelWindow::of_size(16, 9);
    let layer = Layer::from_raw_depth(Picture::filled(window, [0.5; 4]), Plane::filled(window, 2.0));
    let frame = Frame::new(window, vec![layer]).expect("a layer of one window");
    let camera = Camera {
        pose: Pose::IDENTITY,
        film: Film::from_fov(1.0, width, 9).expect("a film"),
        focus: Focus::at_depth(1.0).expect("a depth"),
        iris: Iris::upright(0.1, ApertureShape::Disc).expect("a radius"),
    };
    let settings = GatherSettings { max_radius_px: Some(max_radius_px), ..GatherSettings::default() };
    let answer = filter::apply(&FrameView::whole(&frame), &camera, &Method::Merged(settings), window, &Silent);
    let error = answer.err();
    Refusal { request, is_documented: error.as_ref().is_some_and(is_documented), said: error.map(|e| e.to_string()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_meaning_is_refused_with_the_documented_error() {
        for refusal in refusals() {
            assert!(refusal.is_documented, "{}: {:?}", refusal.request, refusal.said);
        }
    }
}

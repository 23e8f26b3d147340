//! Hidden layers show only where some lens point sees past what hides them.

use filter::{GatherSettings, Method};
use glam::DVec3;
use optics::{ApertureShape, Camera};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane};

use crate::scenes::{camera, filtered, noise, over};

const DISPLAY: PixelWindow = PixelWindow { x: -7, y: 3, width: 210, height: 150 };
const CARD: PixelWindow = PixelWindow { x: 50, y: 40, width: 85, height: 70 };
const CARD_DEPTH: f32 = 2.0;
const WALL_DEPTH: f32 = 5.0;
const BEHIND_THE_WALL: f32 = 7.0;

/// A near card before a far wall; the hidden layer holds the wall under the whole card, and another wall behind the wall
/// everywhere else.
fn card_and_wall(hidden_radiance: f32) -> Frame {
    let data = DISPLAY.grown(5, 5);
    let visible = Picture::from_fn(data, |x, y| [noise(x, y, 1), noise(x, y, 2), noise(x, y, 3), 1.0]);
    let depth = |x, y| if CARD.contains(x, y) { CARD_DEPTH } else { WALL_DEPTH };
    let hidden = Picture::from_fn(data, |_, _| [hidden_radiance, hidden_radiance, hidden_radiance, 1.0]);
    let hidden_depth = |x, y| if CARD.contains(x, y) { WALL_DEPTH } else { BEHIND_THE_WALL };
    let layers = vec![
        Layer::from_raw_depth(visible, Plane::from_fn(data, depth)),
        Layer::from_raw_depth(hidden, Plane::from_fn(data, hidden_depth)),
    ];
    Frame::new(DISPLAY, layers).unwrap()
}

/// Distance of a pixel from the card's outline, in pixels.
fn from_outline(x: i32, y: i32) -> f32 {
    let beyond = |at: i32, start: i32, end: i32| (start - at).max(at - (end - 1));
    let (dx, dy) = (beyond(x, CARD.x, CARD.x_end()), beyond(y, CARD.y, CARD.y_end()));
    if dx <= 0 && dy <= 0 { -dx.max(dy) as f32 } else { (dx.max(0) as f32).hypot(dy.max(0) as f32) }
}

/// How far from the outline hidden light may fall: as far as a lens point sees past it, and the footprint of the wall from
/// there; or the footprint of the card's outline, whose pixels are taken apart. What is behind the wall is never seen.
fn allowed(camera: &Camera) -> f32 {
    // The pixel on the outline is taken apart, and one more is filled
    const SLACK: f32 = 2.0;
    let px = (camera.iris.radius() * camera.film.pixels_per_q().max_element()) as f32;
    let seen = px * (1.0 / CARD_DEPTH - 1.0 / WALL_DEPTH);
    let [low, high] = camera.focus.inverse_depth_range(&camera.film).map(|w| w as f32);
    let radius = |z: f32| px * (1.0 / z - low).abs().max((1.0 / z - high).abs());
    (seen + radius(WALL_DEPTH)).max(radius(CARD_DEPTH)) + SLACK
}

#[test]
fn hidden_light_falls_only_where_some_lens_point_sees_past_the_first_layer() {
    let tilted = DVec3::new(0.05, -0.1, 1.0);
    let lenses = [
        camera(DVec3::new(0.0, 0.0, 0.5), DVec3::Z, 0.2, ApertureShape::Disc),
        camera(DVec3::new(0.0, 0.0, 0.2), DVec3::Z, 0.2, ApertureShape::Disc),
        camera(DVec3::new(0.0, 0.0, 0.35), DVec3::Z, 0.3, ApertureShape::polygon(5, 0.3).unwrap()),
        camera(DVec3::new(0.0, 0.0, 0.7), DVec3::Z, 0.15, ApertureShape::Disc),
        camera(DVec3::new(0.0, 0.0, 0.1), DVec3::Z, 0.15, ApertureShape::Disc),
        camera(DVec3::new(0.02, -0.1, 0.3), DVec3::Z, 0.2, ApertureShape::Disc),
        camera(DVec3::new(0.02, -0.1, 0.3), tilted, 0.2, ApertureShape::Disc),
    ];
    let (dark, bright) = (card_and_wall(0.0), card_and_wall(1e4));
    for lens in lenses.map(|lens| over(DISPLAY, &lens)) {
        let settings = GatherSettings::default();
        for method in [Method::OwnCoc(settings), Method::Gather(settings), Method::Merged(settings)] {
            let [dark, bright] = [&dark, &bright].map(|frame| filtered(frame, &lens, &method));
            let far = allowed(&lens);
            let differs = |&(x, y): &(i32, i32)| dark.at(x, y) != bright.at(x, y);
            let farthest = DISPLAY.pixels().filter(differs).map(|(x, y)| from_outline(x, y)).fold(0.0, f32::max);
            assert!(farthest <= far, "{} w {:?}: light at {farthest} px, allowed {far}", method.name(), lens.focus);

            // It is a test: pixels far from the outline are there on both sides, and hidden light falls somewhere
            let beyond = |inside: bool| {
                DISPLAY.pixels().filter(|&(x, y)| CARD.contains(x, y) == inside && from_outline(x, y) > far).count()
            };
            assert!(beyond(true) > 20 && beyond(false) > 20, "{} {} {far}", beyond(true), beyond(false));
            assert!(matches!(method, Method::OwnCoc(_)) || farthest > 1.0, "{}: no hidden light at all", method.name());
        }
    }
}

//! Where the edges are.

use compare::{CompareError, GivenNoise, MaskKind, Masks, Reference};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane};

const DISPLAY: PixelWindow = PixelWindow { x: 10, y: 20, width: 60, height: 40 };

/// A camera of 100 px per unit of q and aperture radius 1 that focuses at infinity: the blur radius is 100 / z px.
fn camera() -> Camera {
    let half = DVec2::new(0.3, 0.2);
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(-half, half, DISPLAY.width, DISPLAY.height).unwrap(),
        focus: Focus::at_depth(f64::INFINITY).unwrap(),
        iris: Iris::upright(1.0, ApertureShape::Disc).unwrap(),
    }
}

fn frame(data: PixelWindow, depth: impl FnMut(i32, i32) -> f32) -> Frame {
    let color = Picture::filled(data, [0.5; 4]);
    Frame::new(DISPLAY, vec![Layer::from_raw_depth(color, Plane::from_fn(data, depth))]).unwrap()
}

#[test]
fn edges_lie_within_the_reach_of_a_jump_and_no_farther() {
    // Blur radius 4 px left of column 40, 1 px from there on: a jump of 6 px in diameter
    let masks =
        Masks::from_frame(&frame(DISPLAY, |x, _| if x < 40 { 25.0 } else { 100.0 }), &camera(), Some(5.0)).unwrap();
    for (x, y) in DISPLAY.pixels() {
        let is_edge = (39 - 5..=40 + 5).contains(&x);
        assert_eq!(masks.edges().at(x, y), is_edge, "({x}, {y})");
    }
    assert_eq!(masks.share(MaskKind::Edges), 12.0 / 60.0);
    assert_eq!(masks.count(MaskKind::Interior) + masks.count(MaskKind::Edges), DISPLAY.area());
}

#[test]
fn the_reach_is_euclidean() {
    // One near pixel: the jumps are the 3x3 pixels around it
    let masks =
        Masks::from_frame(&frame(DISPLAY, |x, y| if (x, y) == (40, 40) { 10.0 } else { 100.0 }), &camera(), Some(6.5))
            .unwrap();
    for (x, y) in DISPLAY.pixels() {
        let beyond = |d: i32| f64::from((d.abs() - 1).max(0));
        let is_edge = beyond(x - 40).hypot(beyond(y - 40)) <= 6.5;
        assert_eq!(masks.edges().at(x, y), is_edge, "({x}, {y})");
    }
}

#[test]
fn a_jump_of_three_pixels_is_none_and_one_of_more_is() {
    let masks_of = |diameter: f32| {
        Masks::from_frame(
            &frame(DISPLAY, |x, _| if x < 40 { 200.0 / diameter } else { f32::INFINITY }),
            &camera(),
            None,
        )
        .unwrap()
    };
    assert_eq!(masks_of(2.99).count(MaskKind::Edges), 0);
    assert!(masks_of(3.01).count(MaskKind::Edges) > 0);
    let kinds = [MaskKind::All, MaskKind::Interior, MaskKind::Near, MaskKind::InFocus];
    assert_eq!(masks_of(2.99).kinds(), kinds, "no figure of no pixel");
}

#[test]
fn the_reach_follows_the_largest_blur_of_the_display_window_and_is_eight_at_least() {
    // Only the overscan is nearer than 10
    let data = DISPLAY.grown(7, 7);
    let reach = |z: f32| {
        let frame = frame(data, |x, y| if DISPLAY.contains(x, y) { z } else { 1.0 });
        Masks::from_frame(&frame, &camera(), None).unwrap().reach_px()
    };
    assert_eq!(reach(50.0), Some(8.0), "2 px of blur");
    assert_eq!(reach(8.0), Some(13.0), "12.5 px of blur");
}

#[test]
fn a_jump_in_the_overscan_counts_where_it_reaches_into_the_picture() {
    let data = DISPLAY.grown(20, 0);
    let depth = |x: i32, _: i32| if x < DISPLAY.x - 4 { 25.0 } else { 100.0 };
    let with = Masks::from_frame(&frame(data, depth), &camera(), Some(8.0)).unwrap();
    let without = Masks::from_frame(&frame(DISPLAY, depth), &camera(), Some(8.0)).unwrap();
    assert_eq!(with.count(MaskKind::Edges), 5 * DISPLAY.height as usize, "columns 10 to 14");
    assert_eq!(without.count(MaskKind::Edges), 0);
}

#[test]
fn a_tilted_plane_of_focus_has_no_edges_on_itself_and_unknown_depth_is_none() {
    // A plane at the depth where the tilted lens is sharp, with a hole in it
    let tilted = Camera { focus: Focus::new(DVec3::new(0.1, -0.3, 0.4)).unwrap(), ..camera() };
    let depth = |x: i32, y: i32| {
        let q = tilted.film.q_from_pixel(DVec2::new(f64::from(x - 10) + 0.5, f64::from(y - 20) + 0.5));
        let is_hole = (30..35).contains(&x) && (30..35).contains(&y);
        if is_hole { f32::NAN } else { (1.0 / tilted.focus.inverse_depth(q)) as f32 }
    };
    let masks = Masks::from_frame(&frame(DISPLAY, depth), &tilted, None).unwrap();
    assert_eq!(masks.count(MaskKind::Edges), 0);
    assert!(masks.largest_coc_radius_px().unwrap() < 1e-4, "what is in focus is sharp within the digits of f32");
}

#[test]
fn a_film_of_another_size_and_a_reach_that_is_none_are_refused() {
    let other = Camera { film: camera().film.resized(61, 40).unwrap(), ..camera() };
    let error = Masks::from_frame(&frame(DISPLAY, |_, _| 5.0), &other, None).unwrap_err();
    assert_eq!(error.to_string(), "the camera's film is 61x40 pixels, the display window is 60x40 at (10, 20)");
    let error = Masks::from_frame(&frame(DISPLAY, |_, _| 5.0), &camera(), Some(f64::NAN)).unwrap_err();
    assert!(matches!(error, CompareError::BadReach(_)));
}

#[test]
fn the_zones_lie_before_in_and_behind_the_plane_of_focus_and_holes_in_none() {
    // Focused at 50: the blur radius is 100 / z - 2 px
    let focused = Camera { focus: Focus::at_depth(50.0).unwrap(), ..camera() };
    let depth = |x: i32, y: i32| match x {
        _ if y == 30 => f32::NAN,
        ..30 => 25.0,       // 2 px near
        30..50 => 40.0,     // 0.5 px near
        _ => f32::INFINITY, // 2 px far
    };
    let masks = Masks::from_frame(&frame(DISPLAY, depth), &focused, None).unwrap();
    let rows = DISPLAY.height as usize - 1;
    for (kind, columns) in [(MaskKind::Near, 20), (MaskKind::InFocus, 20), (MaskKind::Far, 20)] {
        assert_eq!(masks.count(kind), columns * rows, "{kind:?}");
    }
    assert!(masks.holds(MaskKind::Near, 0) && !masks.holds(MaskKind::Near, 10 * DISPLAY.width as usize));
}

#[test]
fn highlights_are_what_is_brighter_than_white() {
    let picture = Picture::from_fn(DISPLAY, |x, y| [0.5, if (x, y) == (12, 21) { 1.5 } else { 1.0 }, 0.0, 1.0]);
    let reference = Reference::from_picture(&picture, DISPLAY, GivenNoise::default()).unwrap();
    let masks = Masks::without_depth(DISPLAY).with_highlights(&reference);
    assert_eq!(masks.kinds(), [MaskKind::All, MaskKind::Highlights]);
    assert!(masks.count(MaskKind::Highlights) == 1 && masks.holds(MaskKind::Highlights, DISPLAY.index(12, 21)));
    assert!(!Masks::without_depth(DISPLAY).kinds().contains(&MaskKind::Highlights), "unless asked for");
}

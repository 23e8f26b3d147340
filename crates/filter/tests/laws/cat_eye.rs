//! A lens that a second rim covers towards the corners.

use filter::{GatherSettings, LensRaysSettings, Method};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera};
use rgbd::{Frame, Picture};

use crate::scenes::{DISPLAY, all_methods, camera, filtered, layer, lenses, noise, rough_frame};

/// Where the light is: so near to the corner that its spot, towards the centre, still lies in the picture.
const LIGHT: (i32, i32) = (50, 37);

/// A lens of `radius_px` pixels of blur for what is at `depth`, focused at 4.
fn eyed(radius_px: f64, depth: f64, shape: ApertureShape, strength: f64) -> Camera {
    let radius = radius_px / 100.0 / (1.0 / depth - 0.25_f64).abs();
    camera(DVec3::new(0.0, 0.0, 0.25), DVec3::Z, radius, shape).with_cat_eye(strength).unwrap()
}

fn blurring() -> [Method; 4] {
    let settings = GatherSettings::default();
    let rays = LensRaysSettings { samples: 2048, ..LensRaysSettings::default() };
    [Method::OwnCoc(settings), Method::Gather(settings), Method::Merged(settings), Method::LensRays(rays)]
}

fn q_of(camera: &Camera, x: i32, y: i32) -> DVec2 {
    camera.film.q_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
}

/// The spot of one white pixel by the law: each pixel takes the mean over its open lens; each is averaged over its box.
fn spot(camera: &Camera, depth: f64, radius_px: f64) -> Picture {
    const STEPS: i32 = 8;
    let defocus = 1.0 / depth - 0.25;
    Picture::from_fn(DISPLAY, |x, y| {
        let opening = camera.iris.opening(q_of(camera, x, y));
        let open = (0..STEPS * STEPS).filter(|i| {
            let part = (DVec2::new(f64::from(i % STEPS), f64::from(i / STEPS)) + 0.5) / f64::from(STEPS) - 0.5;
            let offset = DVec2::new(f64::from(LIGHT.0 - x), f64::from(LIGHT.1 - y)) - part;
            // p - q in iris coordinates, y up
            opening.contains(DVec2::new(offset.x, -offset.y) / radius_px * defocus.signum())
        });
        let share = open.count() as f64 / f64::from(STEPS * STEPS);
        [(share / (opening.area() * radius_px * radius_px)) as f32; 4]
    })
}

/// Sum, centroid, and sum of absolute differences to another spot.
fn compared(found: &Picture, wanted: &Picture) -> (f64, DVec2, f64) {
    let (mut sum, mut centroid, mut off) = (0.0, DVec2::ZERO, 0.0);
    for (x, y) in DISPLAY.pixels() {
        let light = f64::from(found.at(x, y)[0]);
        sum += light;
        centroid += light * DVec2::new(f64::from(x), f64::from(y));
        off += (light - f64::from(wanted.at(x, y)[0])).abs();
    }
    (sum, centroid / sum, off)
}

#[test]
fn a_point_of_light_near_a_corner_blurs_to_the_open_part_of_the_lens() {
    // Pixels of the outline by a quarter each; gathers miss by a sixth of that, rays by their noise
    const OUTLINE: f64 = 0.12;
    let pentagon = ApertureShape::polygon(5, 0.4).unwrap();
    for (depth, strength, shape) in [
        (2.0, 1.0, ApertureShape::Disc),
        (2.0, 0.5, ApertureShape::Disc),
        (8.0, 1.0, ApertureShape::Disc),
        (2.0, 0.7, pentagon),
        (8.0, 0.7, pentagon),
    ] {
        let light = |x: i32, y: i32| f32::from((x, y) == LIGHT);
        let frame = Frame::new(DISPLAY, vec![layer(DISPLAY.grown(12, 12), light, |_, _| depth as f32)]).unwrap();
        let camera = eyed(9.0, depth, shape, strength);
        let wanted = spot(&camera, depth, 9.0);
        let (sum, centroid, _) = compared(&wanted, &wanted);
        let whole = spot(&eyed(9.0, depth, shape, 0.0), depth, 9.0);
        let missed = compared(&whole, &wanted).2 / sum;
        for method in blurring() {
            let (found, at, off) = compared(&filtered(&frame, &camera, &method), &wanted);
            let what = format!("{} {shape:?} at {depth} m, strength {strength}", method.name());
            assert!((found / sum - 1.0).abs() < 0.02, "{what}: sum {found}, wanted {sum}");
            assert!((at - centroid).length() < 0.15, "{what}: at {at}, wanted {centroid}");
            assert!(off < OUTLINE * sum, "{what}: off by {off} of {sum}");
        }
        // Without the eye it would not pass
        assert!(missed > 2.0 * OUTLINE, "{missed}");
    }
}

#[test]
fn no_strength_is_no_cat_eye_to_the_bit() {
    let frame = rough_frame(DISPLAY, DISPLAY.grown(6, 6), noise);
    for (camera, method) in lenses()[..6].iter().flat_map(|lens| all_methods().into_iter().map(move |m| (lens, m))) {
        let without = camera.with_cat_eye(0.0).unwrap();
        assert!(filtered(&frame, camera, &method) == filtered(&frame, &without, &method), "{method:?}");
    }
}

#[test]
fn an_even_surface_stays_even_and_the_exposure_is_kept() {
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, |_, _| 0.7, |_, _| 2.0)]).unwrap();
    for radius in [0.4, 1.0, 2.5, 9.0, 20.0] {
        for method in blurring() {
            let picture = filtered(&frame, &eyed(radius, 2.0, ApertureShape::Disc, 1.0), &method);
            let worst = DISPLAY.pixels().map(|(x, y)| (picture.at(x, y)[0] - 0.7).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-5, "{} {radius}: {worst}", method.name());
        }
    }
}

#[test]
fn what_is_in_focus_stays_as_sharp_as_it_came() {
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, |x, y| noise(x, y, 5), |_, _| 4.0)]).unwrap();
    for method in blurring() {
        let picture = filtered(&frame, &eyed(20.0, 2.0, ApertureShape::Disc, 1.0), &method);
        let color = &frame.layers()[0].color;
        let worst = DISPLAY.pixels().map(|(x, y)| (picture.at(x, y)[0] - color.at(x, y)[0]).abs());
        let worst = worst.fold(0.0, f32::max);
        assert!(worst < 1e-4, "{}: {worst}", method.name());
    }
}

//! An iris that an anamorphic lens squeezes.

use filter::{FrameView, GatherSettings, LensRaysSettings, Method, apply};
use glam::DVec2;
use optics::{ApertureShape, Camera, Film, Iris, KernelModel};
use rgbd::{Frame, Picture, Silent};

use crate::scenes::{DISPLAY, filtered, layer, noise, untilted};

/// A lens of `radius_px` pixels of blur, along the longer axis, for what is at 2 m.
fn squeezed(radius_px: f64, squeeze: f64) -> Camera {
    let camera = untilted(4.0, radius_px / 100.0 / 0.25);
    Camera { iris: camera.iris.squeezed(squeeze).unwrap(), ..camera }
}

/// One white pixel at (32, 24), all at 2 m.
fn point_of_light() -> Frame {
    Frame::new(DISPLAY, vec![layer(DISPLAY, |x, y| f32::from((x, y) == (32, 24)), |_, _| 2.0)]).unwrap()
}

fn blurring(max_radius_px: Option<f32>) -> [Method; 4] {
    let settings = GatherSettings { max_radius_px, ..GatherSettings::default() };
    let rays = LensRaysSettings { samples: 1024, max_radius_px, ..LensRaysSettings::default() };
    [Method::OwnCoc(settings), Method::Gather(settings), Method::Merged(settings), Method::LensRays(rays)]
}

/// Half width and half height of an ellipse that is spread as a spot around (32, 24): twice its standard deviation.
fn half_sizes(spot: &Picture) -> DVec2 {
    let (mut sum, mut second) = (0.0, DVec2::ZERO);
    for (x, y) in DISPLAY.pixels() {
        let light = f64::from(spot.at(x, y)[0]);
        sum += light;
        second += light * DVec2::new(f64::from(x - 32), f64::from(y - 24)).powf(2.0);
    }
    2.0 * (second / sum).map(f64::sqrt)
}

#[test]
fn a_point_of_light_blurs_to_the_width_and_height_that_were_asked() {
    // What one edge of the kernel leaves to the shorter axis of the narrowest oval; rays miss by 0.02, their noise
    const FOURTH_OF_A_PIXEL: f64 = 0.25;
    for (radius, squeeze) in [(4.0, 0.25), (4.0, 2.0), (9.0, 0.5), (9.0, 4.0), (14.0, 1.33), (14.0, 2.0)] {
        let wanted = radius * DVec2::new(1.0 / squeeze, squeeze).min(DVec2::ONE);
        for method in blurring(None) {
            let found = half_sizes(&filtered(&point_of_light(), &squeezed(radius, squeeze), &method));
            let off = (found - wanted).abs().max_element();
            assert!(off < FOURTH_OF_A_PIXEL, "{} squeeze {squeeze}: {found}, wanted {wanted}", method.name());
        }
    }
}

#[test]
fn what_is_in_focus_stays_as_sharp_as_it_came() {
    let frame = Frame::new(DISPLAY, vec![layer(DISPLAY, |x, y| noise(x, y, 5), |_, _| 4.0)]).unwrap();
    for squeeze in [0.25, 0.6, 2.0, 4.0] {
        for shape in [ApertureShape::Disc, ApertureShape::polygon(3, 0.4).unwrap()] {
            let iris = Iris::upright(0.5, shape).unwrap().squeezed(squeeze).unwrap();
            let camera = Camera { iris, ..untilted(4.0, 0.5) };
            for method in blurring(None) {
                let picture = filtered(&frame, &camera, &method);
                let color = &frame.layers()[0].color;
                let worst = DISPLAY.pixels().map(|(x, y)| (picture.at(x, y)[0] - color.at(x, y)[0]).abs());
                let worst = worst.fold(0.0, f32::max);
                assert!(worst < 1e-4, "{} {shape:?} squeeze {squeeze}: {worst}", method.name());
            }
        }
    }
}

#[test]
fn the_limit_of_the_blur_is_that_of_the_longer_axis() {
    for method in blurring(Some(6.0)) {
        let found = half_sizes(&filtered(&point_of_light(), &squeezed(18.0, 2.0), &method));
        assert!((found - DVec2::new(3.0, 6.0)).abs().max_element() < 0.25, "{}: {found}", method.name());
    }
    // What is said of it is too
    let (frame, limit) = (point_of_light(), GatherSettings { max_radius_px: Some(6.0), ..GatherSettings::default() });
    let result = |radius| {
        let camera = squeezed(radius, 0.5);
        apply(&FrameView::whole(&frame), &camera, &Method::Merged(limit), DISPLAY, &Silent).unwrap()
    };
    assert!((result(18.0).largest_radius_px - 18.0).abs() < 1e-4);
    assert_eq!((result(18.0).cut_to_px, result(5.9).cut_to_px), (Some(6.0), None));
    assert_eq!((result(5.9).kernel, result(5.9).kernel_choice), (KernelModel::Ellipse, None));
}

#[test]
fn a_squeeze_that_the_pixels_undo_leaves_a_disc() {
    // Pixels half as wide as high, and an iris half as wide as high
    let camera = squeezed(8.0, 0.5);
    let film = Film::new(camera.film.min() * DVec2::new(1.0, 0.5), camera.film.max() * DVec2::new(1.0, 0.5), 64, 48);
    let camera = Camera { film: film.unwrap(), ..camera };
    let frame = point_of_light();
    let result = apply(&FrameView::whole(&frame), &camera, &Method::default(), DISPLAY, &Silent).unwrap();
    assert_eq!(result.kernel, KernelModel::Disc);
    assert!((half_sizes(&result.picture) - 8.0).abs().max_element() < 0.05, "{}", half_sizes(&result.picture));
}

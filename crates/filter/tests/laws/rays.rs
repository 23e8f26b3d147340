//! Known answers for lens rays.

use filter::{FrameView, LensRaysSettings, Method, apply};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Footprint, Reading};
use rgbd::{Frame, Layer, Picture, Plane, Silent};

use crate::scenes::{DISPLAY, camera, filtered, layer, lenses, noise, rays, rough_frame, untilted};

#[test]
fn rays_spread_as_equation_5_says() {
    // Walls whose colours are x, y, x^2, x y and y^2: the blurred colours are the moments of what a pixel sees. (Of one
    // bright pixel as many rays are seen in all as each pixel has: far too few to tell where it lands.)
    let tilt = DVec3::new(0.12, -0.2, 1.0);
    let pentagon = ApertureShape::polygon(5, 0.3).unwrap();
    let cases = [
        (DVec3::new(0.0, 0.0, 0.25), DVec3::Z, 0.5, ApertureShape::Disc),
        (DVec3::new(0.0, -0.5, 0.3), DVec3::Z, 0.08, pentagon),
        (DVec3::new(0.2, -0.5, 0.3), tilt, 0.5, ApertureShape::Disc),
        (DVec3::new(0.2, 0.8, -0.2), tilt, 0.2, pentagon),
    ];
    let at = (40, 18);
    let data = DISPLAY.grown(40, 40);
    for (w, normal, radius, shape) in cases {
        let camera = camera(w, normal, radius, shape);
        let mean = |value: &dyn Fn(f64, f64) -> f64| {
            let color = |x: i32, y: i32| value(f64::from(x - at.0), f64::from(y - at.1)) as f32;
            let frame = Frame::new(DISPLAY, vec![layer(data, color, |_, _| 2.0)]).unwrap();
            f64::from(filtered(&frame, &camera, &rays(256)).at(at.0, at.1)[0])
        };
        let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
        let found = [mean(&|x, _| x * x) - x * x, mean(&|x, y| x * y) - x * y, mean(&|_, y| y * y) - y * y];

        let q = camera.film.q_from_pixel(DVec2::new(f64::from(at.0) + 0.5, f64::from(at.1) + 0.5));
        let wanted = Footprint::new(&camera, Reading::Gather, q, 0.5).in_pixels(&camera.film).moments().unwrap();
        let covariance = [wanted.covariance.x_axis.x, wanted.covariance.x_axis.y, wanted.covariance.y_axis.y];
        let spread = covariance[0].max(covariance[2]);
        // A twentieth of a pixel moves nothing that is seen; 2 % of the variance is 1 % of the radius
        let centroid = DVec2::new(x, y);
        assert!(centroid.distance(wanted.centroid) < 0.05, "centroid {centroid}, wanted {}", wanted.centroid);
        for (found, wanted) in found.into_iter().zip(covariance) {
            assert!((found - wanted).abs() < 0.02 * spread, "second moment {found}, wanted {wanted} of {spread}");
        }
    }
}

#[test]
fn what_hides_behind_a_near_thing_is_seen_past_its_rim_and_only_there() {
    // A near bar, blurred by 6 px, over a sharp floor; the hidden floor behind it is of another colour
    let camera = untilted(4.0, 0.24);
    let data = DISPLAY.grown(8, 8);
    let is_bar = |x: i32| (24..44).contains(&x);
    let front = layer(data, |x, _| if is_bar(x) { 1.0 } else { 0.0 }, |x, _| if is_bar(x) { 2.0 } else { 4.0 });
    let hidden = Layer::from_raw_depth(
        Picture::from_fn(data, |x, _| if is_bar(x) { [0.0, 1.0, 0.0, 1.0] } else { [0.0; 4] }),
        Plane::from_fn(data, |x, _| if is_bar(x) { 4.0 } else { f32::NAN }),
    );
    let picture = filtered(&Frame::new(DISPLAY, vec![front, hidden]).unwrap(), &camera, &rays(64));
    let hidden_share = |x: i32| picture.at(x, 24)[1] - picture.at(x, 24)[0];
    // Green without red is the hidden floor: outside the bar none of it, in the middle neither, at the rim nearly half
    for x in (14..24).chain(30..38).chain(44..54) {
        assert!(hidden_share(x).abs() < 1e-6, "x {x}: {}", hidden_share(x));
    }
    assert!((24..26).chain(42..44).all(|x| hidden_share(x) > 0.25));
}

#[test]
fn the_limit_of_the_blur_holds_for_rays() {
    // A light at 2 m, 12 px of blur cut to 3
    let camera = untilted(4.0, 0.48);
    let wall = layer(DISPLAY, |x, y| f32::from((x, y) == (32, 24)), |_, _| 2.0);
    let frame = Frame::new(DISPLAY, vec![wall]).unwrap();
    let cut = LensRaysSettings { samples: 256, max_radius_px: Some(3.0), ..LensRaysSettings::default() };
    let picture = filtered(&frame, &camera, &Method::LensRays(cut));
    let far = |(x, y): &(i32, i32)| f64::from((x - 32).pow(2) + (y - 24).pow(2)).sqrt() > 4.5;
    assert!(DISPLAY.pixels().filter(far).all(|(x, y)| picture.at(x, y)[0] == 0.0));
    let energy: f32 = DISPLAY.pixels().map(|(x, y)| picture.at(x, y)[0]).sum();
    assert!((energy - 1.0).abs() < 0.05, "{energy}"); // some 7,000 rays hit the light: 1.2 % of noise
}

#[test]
fn a_pixel_needs_a_ray() {
    let frame = rough_frame(DISPLAY, DISPLAY, noise);
    let error = apply(&FrameView::whole(&frame), &lenses()[1], &rays(0), DISPLAY, &Silent).unwrap_err().to_string();
    assert!(error.contains("1 to 65536"), "{error}");
}

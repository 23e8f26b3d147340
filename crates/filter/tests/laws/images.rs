//! What mirrors show is blurred by its optical depth, in front of and behind what their surface is.

use filter::{FrameView, Method, apply, apply_in_bands, reach_px};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, Silent};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 96, height: 64 };

/// Columns that are a mirror.
const MIRROR: std::ops::Range<i32> = 30..66;

/// Focus at 2; what lies at 6 has a radius of 100 x 0.2 x 1/3 = 6.7 pixels.
fn camera(focus: f64) -> Camera {
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::new(-0.48, -0.32), DVec2::new(0.48, 0.32), WINDOW.width, WINDOW.height).unwrap(),
        focus: Focus::new(DVec3::new(0.0, 0.0, 1.0 / focus)).unwrap(),
        iris: Iris::upright(0.2, ApertureShape::Disc).unwrap(),
    }
}

fn checker(x: i32, y: i32) -> [f32; 4] {
    let c = if (x.div_euclid(5) + y.div_euclid(7)) % 2 == 0 { 0.9 } else { 0.1 };
    [c, 0.5 * c, 0.2, 1.0]
}

/// A wall at 2 with a mirror in it.
fn frame(color: impl Fn(i32, i32) -> [f32; 4], optical: f32) -> Frame {
    let layer = Layer::from_raw_depth(Picture::from_fn(WINDOW, color), Plane::filled(WINDOW, 2.0));
    let depth = Plane::from_fn(WINDOW, |x, _| if MIRROR.contains(&x) { optical } else { 2.0 });
    Frame::new(WINDOW, vec![layer]).unwrap().with_optical_depth(depth)
}

fn methods() -> [Method; 4] {
    [
        Method::OwnCoc(Default::default()),
        Method::Gather(Default::default()),
        Method::default(),
        Method::LensRays(Default::default()),
    ]
}

fn filtered(frame: &Frame, camera: &Camera, method: &Method) -> Picture {
    apply(&FrameView::whole(frame), camera, method, WINDOW, &Silent).unwrap().picture
}

fn difference(a: [f32; 4], b: [f32; 4]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_mirror_in_focus_shows_its_image_blurred_and_leaks_nothing() {
    let wall = [0.3, 0.2, 0.1, 1.0];
    let mirrored = frame(|x, y| if MIRROR.contains(&x) { checker(x, y) } else { wall }, 6.0);
    let far = Layer::from_raw_depth(Picture::from_fn(WINDOW, checker), Plane::filled(WINDOW, 6.0));
    let far = Frame::new(WINDOW, vec![far]).unwrap();
    for method in methods() {
        let [picture, twin] = [&mirrored, &far].map(|frame| filtered(frame, &camera(2.0), &method));
        for (x, y) in WINDOW.pixels() {
            // Beyond the blur from the rim (7 px, and the sides of squares) it is as if the mirror were a hole; sums differ
            // in rounding, squares by what they merge
            if (MIRROR.start + 12..MIRROR.end - 12).contains(&x) {
                let off = difference(picture.at(x, y), twin.at(x, y));
                assert!(off < 0.01, "{}: {off} at ({x}, {y})", method.name());
            }
            // The wall beside it is in focus
            if !MIRROR.contains(&(x - 1)) && !MIRROR.contains(&(x + 1)) && !MIRROR.contains(&x) {
                assert!(difference(picture.at(x, y), wall) < 1e-5, "{} at ({x}, {y})", method.name());
            }
        }
    }
}

#[test]
fn an_image_in_focus_stays_sharp_in_a_blurred_mirror() {
    let mirrored = frame(checker, 6.0);
    for method in methods() {
        let picture = filtered(&mirrored, &camera(6.0), &method);
        for (x, y) in WINDOW.pixels().filter(|(x, _)| (MIRROR.start + 9..MIRROR.end - 9).contains(x)) {
            let off = difference(picture.at(x, y), checker(x, y));
            assert!(off < 1e-4, "{}: {off} at ({x}, {y})", method.name());
        }
    }
}

#[test]
fn a_furnace_stays_one_whatever_mirrors_show() {
    // What is transparent shows no image, and its alpha tells nothing of what mirrors fill
    for alpha in [1.0, 0.6] {
        let white = |x: i32, y: i32| [1.0, 1.0, 1.0, if (x + y) % 9 == 0 { alpha } else { 1.0 }];
        let depth = Plane::from_fn(WINDOW, |x, y| 0.5 + ((x * 7 + y * 13) % 11) as f32);
        let odd = frame(white, 6.0).with_optical_depth(depth);
        for method in methods() {
            let picture = filtered(&odd, &camera(2.0), &method);
            let off = |(x, y)| (0..3).map(|c| (picture.at(x, y)[c] - 1.0_f32).abs()).fold(0.0, f32::max);
            // Shares and normalised images, each within 1e-5
            let off = WINDOW.pixels().map(off).fold(0.0, f32::max);
            assert!(off < 3e-5, "{}: {off}", method.name());
        }
    }
}

#[test]
fn bands_of_a_picture_with_mirrors_have_the_bits_of_the_whole() {
    let mirrored = frame(checker, 6.0);
    let (view, camera) = (FrameView::whole(&mirrored), camera(2.5));
    for method in methods() {
        let whole = apply(&view, &camera, &method, WINDOW, &Silent).unwrap();
        let bands = apply_in_bands(&view, &camera, &method, WINDOW, 1, &Silent).unwrap();
        assert_eq!(whole, bands, "{}", method.name());
        assert!((whole.image_share - 36.0 / 96.0).abs() < 1e-6);
        // A band by itself needs no more than its reach
        let band = PixelWindow { x: 0, y: 20, width: WINDOW.width, height: 8 };
        let reach = reach_px(&view, &camera, &method);
        let part = FrameView::part(&mirrored, band.grown(reach, reach));
        let alone = apply(&part, &camera, &method, band, &Silent).unwrap().picture;
        assert_eq!(alone, whole.picture.cropped(band), "{}", method.name());
    }
}

#[test]
fn what_is_no_optical_depth_changes_nothing() {
    let plain = frame(checker, 6.0).without_optical_depth();
    for nothing in [0.0, -3.0, f32::NAN, 2.0] {
        let odd = frame(checker, nothing);
        for method in methods() {
            assert_eq!(filtered(&odd, &camera(2.5), &method), filtered(&plain, &camera(2.5), &method));
        }
    }
    // Infinitely far is a depth
    let sky =
        apply(&FrameView::whole(&frame(checker, f32::INFINITY)), &camera(2.5), &Method::default(), WINDOW, &Silent);
    assert!(sky.unwrap().image_share > 0.0);
}

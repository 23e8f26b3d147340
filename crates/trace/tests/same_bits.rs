//! The same picture, to the bit, however the work is cut.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DAffine3, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Mask, PixelWindow, Progress, Silent};
use trace::{Accumulation, Light, Material, Pigment, Pixels, RenderError, Scene, SceneBuilder, Shape};

const WINDOW: PixelWindow = PixelWindow { x: -3, y: -2, width: 40, height: 30 };

fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let colors = [Vec3::new(0.7, 0.6, 0.5), Vec3::splat(0.1)];
    let floor = Material { pigment: Pigment::Checker { colors, side: 0.3, axes: [0, 2] }, emission: Vec3::ZERO };
    let floor = builder.material(floor);
    let red = builder.material(Material::matte(Vec3::new(0.8, 0.1, 0.1)));
    builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
    builder.shape(Shape::Sphere, DAffine3::from_translation(DVec3::Y), red).unwrap();
    builder.light(Light::Ambient { strength: Vec3::splat(0.3) });
    builder.light(Light::sun(DVec3::new(1.0, 2.0, 0.5), Vec3::splat(0.7)).unwrap());
    builder.sky(Vec3::new(0.5, 0.6, 0.9));
    builder.build().unwrap()
}

fn camera() -> Camera {
    Camera {
        pose: Pose::look_at(DVec3::new(0.0, 3.0, 6.0), DVec3::Y, DVec3::Y).unwrap(),
        film: Film::from_fov(0.7, 34, 26).unwrap(),
        focus: Focus::new(DVec3::new(0.05, -0.1, 0.16)).unwrap(),
        iris: Iris::new(DVec3::new(0.05, -0.1, 1.0), 0.3, ApertureShape::Disc).unwrap(),
    }
}

fn part(pixels: impl Into<Pixels>, samples: std::ops::Range<u32>) -> Accumulation {
    trace::render(&scene(), &camera(), &pixels.into(), samples, 9, &Silent).unwrap()
}

fn whole() -> Accumulation {
    part(WINDOW, 0..13)
}

#[test]
fn any_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(whole).to_truth().unwrap()
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}

#[test]
fn resumed_in_any_order() {
    let truth = whole().to_truth().unwrap();
    for ranges in [[0..5, 5..6, 6..13], [6..13, 0..5, 5..6]] {
        let sums = Accumulation::join(ranges.map(|samples| part(WINDOW, samples))).unwrap();
        assert_eq!(sums.to_truth().unwrap(), truth);
    }
}

#[test]
fn cropped_and_joined() {
    let truth = whole().to_truth().unwrap();
    let left = PixelWindow { width: 17, ..WINDOW };
    let right = PixelWindow { x: WINDOW.x + 17, width: WINDOW.width - 17, ..WINDOW };
    let mut sums = part(right, 0..13);
    sums.merge(&part(left, 0..13)).unwrap();
    assert_eq!(sums.to_truth().unwrap(), truth);
    // A crop alone is that part of the whole
    assert_eq!(part(left, 0..13).picture(), whole().picture().cropped(left));
}

#[test]
fn masked_and_joined() {
    let truth = whole().to_truth().unwrap();
    let odd = Mask::from_fn(WINDOW, |x, y| (x + 3 * y).rem_euclid(5) < 2);
    let even = Mask::from_fn(WINDOW, |x, y| !odd.at(x, y));
    let mut sums = part(odd, 0..13);
    assert!(matches!(sums.to_truth(), Err(RenderError::NoSamples(_))));
    sums.merge(&part(even, 0..13)).unwrap();
    assert_eq!(sums.to_truth().unwrap(), truth);
}

#[test]
fn another_seed_is_another_picture_of_the_same_thing() {
    let other = trace::truth(&scene(), &camera(), WINDOW, 26, 10, &Silent).unwrap();
    let truth = whole().to_truth().unwrap();
    assert_ne!(other, truth);
    let mean = |truth: &rgbd::Truth| {
        let picture = truth.picture();
        picture.planes()[..3].iter().flat_map(rgbd::Plane::values).map(|&x| f64::from(x)).sum::<f64>() / 3600.0
    };
    // Standard error of the mean: noise of about 0.02 over 1200 pixels and 3 dependent channels
    assert!((mean(&truth) - mean(&other)).abs() < 5.0 * 0.02 / 1200_f64.sqrt());
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let mut sums = whole();
    let before = sums.clone();
    let overlap = part(PixelWindow { x: 0, y: 0, width: 1, height: 1 }, 12..14);
    assert_eq!(sums.merge(&overlap), Err(RenderError::Overlap { first: 12, end: 13 }));
    assert_eq!(sums.merge(&part(WINDOW, 15..16)), Err(RenderError::Gap { first: 13, end: 15 }));
    assert_eq!(Accumulation::join([]), Err(RenderError::NoParts));
    let seed = trace::render(&scene(), &camera(), &WINDOW.into(), 13..14, 8, &Silent).unwrap();
    assert_eq!(sums.merge(&seed), Err(RenderError::SeedMismatch(9, 8)));
    let other = trace::render(&scene(), &camera().pinhole(), &WINDOW.into(), 13..14, 9, &Silent).unwrap();
    assert_eq!(sums.merge(&other), Err(RenderError::CameraMismatch));
    assert_eq!(sums, before);
    let range = |samples| trace::render(&scene(), &camera(), &WINDOW.into(), samples, 9, &Silent);
    assert!(matches!(range(3..3), Err(RenderError::SampleRange { .. })));
    assert!(matches!(range(0..trace::MAX_SAMPLES + 1), Err(RenderError::SampleRange { .. })));
    assert!(range(trace::MAX_SAMPLES - 1..trace::MAX_SAMPLES).is_ok());
    assert!(trace::render(&scene(), &camera(), &PixelWindow::of_size(0, 5).into(), 0..1, 9, &Silent).is_err());
}

/// Counts reports, and stops the work at the third.
struct Third(AtomicU64);

impl Progress for Third {
    fn report(&self, done: u64, total: u64) {
        assert!(done <= total);
        self.0.fetch_add(1, Ordering::SeqCst);
    }

    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) >= 3
    }
}

#[test]
fn a_cancelled_render_stops() {
    let progress = Third(AtomicU64::new(0));
    let result = trace::render(&scene(), &camera(), &WINDOW.into(), 0..1, 9, &progress);
    assert_eq!(result, Err(RenderError::Cancelled(rgbd::Cancelled)));
    assert!(progress.0.load(Ordering::SeqCst) < 19);
}

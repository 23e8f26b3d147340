//! Random lenses and cameras within what is built and sold, and somewhat beyond; metres.
#![allow(dead_code, unreachable_pub)] // each test binary takes what it needs

use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose, ThinLens};
use proptest::prelude::*;

/// Full-frame sensor, metres.
pub const SENSOR: [f64; 2] = [0.036, 0.024];

/// Disc or polygon.
pub fn shape() -> impl Strategy<Value = ApertureShape> {
    prop_oneof![
        Just(ApertureShape::Disc),
        (3u32..=32, -4.0..4.0f64).prop_map(|(blades, turn)| ApertureShape::polygon(blades, turn).unwrap()),
    ]
}

/// Spherical and anamorphic.
pub fn squeeze() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), 0.25..4.0f64]
}

/// 15-200 mm, f/1-f/22, focused on the axis from 0.5 m to 50 m, tilt and swing up to 12 degrees, shift up to 12 mm.
pub fn lens() -> impl Strategy<Value = ThinLens> {
    let movements = (-0.21..0.21f64, -0.21..0.21f64, -0.012..0.012f64, -0.012..0.012f64);
    (0.015..0.2f64, 1.0..22.0f64, 0.5..50.0f64, movements).prop_map(|(f, n, depth, (tilt, swing, right, rise))| {
        let lens = ThinLens::new(f, n, f).unwrap().tilted(tilt, swing).unwrap();
        lens.focused_at(DVec2::ZERO, depth).unwrap().shifted(DVec2::new(right, rise)).unwrap()
    })
}

/// The same with a tilt of at least 0.001 degrees.
pub fn tilted_lens() -> impl Strategy<Value = ThinLens> {
    lens().prop_filter("tilted", |lens| lens.total_tilt() > 1.7e-5)
}

/// A lens on a camera, its iris tilted with it.
pub fn lens_camera() -> impl Strategy<Value = (ThinLens, Camera)> {
    (lens(), shape(), squeeze()).prop_map(|(lens, shape, squeeze)| {
        let film = lens.film(SENSOR, 640, 427).unwrap();
        (lens, lens.camera(Pose::IDENTITY, film, lens.iris(shape).squeezed(squeeze).unwrap()).unwrap())
    })
}

/// Any plane of focus, in front, behind or through the picture, and any iris up to 20 mm leaning up to 35 degrees.
pub fn raw_camera() -> impl Strategy<Value = Camera> {
    let w = [-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64];
    (w, [-0.5..0.5f64, -0.5..0.5f64], 1e-3..0.02f64, shape(), squeeze()).prop_map(|(w, m, radius, shape, squeeze)| {
        Camera {
            pose: Pose::IDENTITY,
            film: Film::from_fov(0.9, 640, 360).unwrap(),
            focus: Focus::new(DVec3::from_array(w)).unwrap(),
            iris: Iris::new(DVec3::new(m[0], m[1], 1.0), radius, shape).unwrap().squeezed(squeeze).unwrap(),
        }
    })
}

/// A place in a window, from (0, 0) to (1, 1), in q.
pub fn q_at(film: &Film, place: [f64; 2]) -> DVec2 {
    film.min() + (film.max() - film.min()) * DVec2::from_array(place)
}

/// A point of the unit square.
pub fn unit_square() -> impl Strategy<Value = [f64; 2]> {
    [0.0..1.0f64, 0.0..1.0f64]
}

//! A lens that is a tube: what it leaves open at an angle.

mod random_lens;

use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Opening, Pose};
use proptest::prelude::*;
use random_lens::{q_at, raw_camera, shape, unit_square};

/// An upright lens over a film of 0.8 x 0.6 in q: half its diagonal is 0.5.
fn camera(shape: ApertureShape) -> Camera {
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::new(-0.4, -0.3), DVec2::new(0.4, 0.3), 80, 60).unwrap(),
        focus: Focus::at_depth(3.0).unwrap(),
        iris: Iris::upright(0.02, shape).unwrap(),
    }
}

#[test]
fn the_rim_moves_towards_the_centre_by_the_strength_at_a_corner() {
    for strength in [0.0, 0.3, 1.0] {
        let camera = camera(ApertureShape::Disc).with_cat_eye(strength).unwrap();
        let rim = |q: DVec2| camera.iris.opening(q).rim();
        for corner in camera.film.corners() {
            assert!((rim(corner) + strength * corner / 0.5).length() < 1e-12);
            assert!((rim(0.5 * corner) - 0.5 * rim(corner)).length() < 1e-12);
        }
        assert_eq!(camera.iris.opening(DVec2::ZERO).share(), 1.0);
        // It never closes, however far the film is shifted
        assert!(rim(DVec2::new(40.0, 3.0)).length() <= Opening::LARGEST_SHIFT + 1e-12);
    }
    for strength in [-0.1, 1.1, f64::NAN] {
        assert!(camera(ApertureShape::Disc).with_cat_eye(strength).is_err());
    }
}

#[test]
fn two_discs_share_what_the_closed_form_says() {
    // 2 acos(s / 2) - (s / 2) sqrt(4 - s^2)
    for (strength, area) in [(1.0, 1.228_369_698_608_757), (0.5, 2.152_109_225_029_709)] {
        let camera = camera(ApertureShape::Disc).with_cat_eye(strength).unwrap();
        let opening = camera.iris.opening(camera.film.max());
        assert!((opening.area() - area).abs() < 1e-12, "{}", opening.area());
    }
}

proptest! {
    #[test]
    fn without_a_cat_eye_every_ray_is_what_it_was(camera in raw_camera(), place in unit_square(), u in unit_square()) {
        let (q, u) = (q_at(&camera.film, place), DVec2::from_array(u));
        let none = camera.with_cat_eye(0.0).unwrap();
        prop_assert_eq!(none, camera);
        prop_assert_eq!(camera.iris.open_point(q, u), Some(camera.iris.point(u)));
        let (text, rim) = (serde_json::to_string(&camera).unwrap(), camera.iris.opening(q).rim());
        prop_assert!(!text.contains("cat_eye") && rim == DVec2::ZERO);
        prop_assert!((camera.iris.opening(q).area() - camera.iris.shape().area()).abs() < 1e-12);
    }

    #[test]
    fn rays_leave_through_the_open_part_alone(
        camera in raw_camera(), place in unit_square(), u in unit_square(), strength in 0.0..1.0f64,
    ) {
        let (q, u) = (q_at(&camera.film, place), DVec2::from_array(u));
        let cut = camera.with_cat_eye(strength).unwrap();
        let opening = cut.iris.opening(q);
        let p = camera.iris.shape().sample(u);
        match cut.ray(q, u, 0.0) {
            Some(ray) => prop_assert!(opening.is_within_rim(p) && Some(ray) == camera.ray(q, u, 0.0)),
            None => prop_assert!(!opening.is_within_rim(p) || camera.ray(q, u, 0.0).is_none()),
        }
        // It comes back from a file to the bit
        let text = serde_json::to_string(&cut).unwrap();
        prop_assert_eq!(serde_json::from_str::<Camera>(&text).unwrap(), cut);
    }

    #[test]
    fn a_cat_eye_is_a_ring_before_the_lens(
        m in [-0.4..0.4f64, -0.4..0.4f64], place in unit_square(), u in unit_square(), length in 0.0..3.0f64,
    ) {
        // Focused at infinity all rays of a pixel are parallel, so that the ring covers exactly a moved disc
        let mut camera = camera(ApertureShape::Disc);
        camera.focus = Focus::new(DVec3::ZERO).unwrap();
        camera.iris = Iris::new(DVec3::new(m[0], m[1], 1.0), 0.02, ApertureShape::Disc).unwrap();
        let (q, u) = (q_at(&camera.film, place), DVec2::from_array(u));
        let ray = camera.ray(q, u, 0.0).unwrap();
        let iris = camera.iris.with_cat_eye(length).unwrap();
        prop_assume!(iris.opening(q).rim().length() < Opening::LARGEST_SHIFT - 1e-9);
        let axis = iris.normal();
        let at_ring = ray.origin + ray.direction * (0.02 * length / ray.direction.dot(axis));
        let off_axis = (at_ring - axis * at_ring.dot(axis)).length() / 0.02;
        prop_assume!((off_axis - 1.0).abs() > 1e-9);
        prop_assert_eq!(iris.open_point(q, u).is_some(), off_axis < 1.0);
    }

    #[test]
    fn the_area_is_that_of_the_points_inside(shape in shape(), turn in 0.0..std::f64::consts::TAU, shift in 0.0..1.25f64) {
        const STEPS: u32 = 256;
        let iris = Iris::upright(1.0, shape).unwrap().with_cat_eye(shift).unwrap();
        let opening = iris.opening(DVec2::from_angle(turn));
        let cells = (0..STEPS * STEPS)
            .map(|i| (DVec2::new(f64::from(i % STEPS), f64::from(i / STEPS)) + 0.5) / f64::from(STEPS));
        let open = cells.filter(|&u| opening.contains(shape.sample(u) * (1.0 - 1e-12))).count();
        // A cell at the border counts whole or not at all. Of the outermost 4 x 256 half may be wrong by half a cell to the same
        // side, where a small shift misses all their middles: 0.0039
        let found = open as f64 / f64::from(STEPS * STEPS);
        prop_assert!((found - opening.share()).abs() < 4e-3, "{found} {}", opening.share());
        prop_assert!(opening.share() > 0.05);
    }
}

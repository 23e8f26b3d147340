//! What goes in comes out: lens and plane, lens and camera, picks, planes of the world, Nakane's angles, and JSON.

mod random_lens;

use glam::{DVec2, DVec3};
use optics::{Camera, Focus, Iris, Nakane, Pose, ThinLens};
use proptest::prelude::*;
use random_lens::{lens, lens_camera, q_at, raw_camera, shape, tilted_lens, unit_square};

/// Relative rounding of an image distance computed from w: v/F times the rounding of f64, with a margin.
const ROUNDING: f64 = 1e-9;

fn assert_same_lens(found: &ThinLens, wanted: &ThinLens) -> Result<(), TestCaseError> {
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= ROUNDING * size || a == b;
    let (f, v) = (wanted.focal_length(), wanted.image_distance());
    prop_assert!(near(found.focal_length(), f, f), "{found:?} {wanted:?}");
    prop_assert!(near(found.image_distance(), v, v), "{found:?} {wanted:?}");
    prop_assert!(near(found.f_number(), wanted.f_number(), wanted.f_number()), "{found:?} {wanted:?}");
    prop_assert!(near(found.tilt(), wanted.tilt(), 1.0), "{found:?} {wanted:?}");
    prop_assert!(near(found.swing(), wanted.swing(), 1.0), "{found:?} {wanted:?}");
    prop_assert!((found.shift() - wanted.shift()).length() <= ROUNDING * v, "{found:?} {wanted:?}");
    Ok(())
}

proptest! {
    #[test]
    fn plane_and_image_distance_give_the_lens_back(lens in lens()) {
        let back = ThinLens::at_image_distance(&lens.focus(), lens.image_distance(), lens.f_number()).unwrap();
        assert_same_lens(&back, &lens.shifted(DVec2::ZERO).unwrap())?;
    }

    #[test]
    fn plane_and_focal_length_give_the_lens_back(lens in lens()) {
        let back = ThinLens::of_focal_length(&lens.focus(), lens.focal_length(), lens.f_number()).unwrap();
        assert_same_lens(&back, &lens.shifted(DVec2::ZERO).unwrap())?;
    }

    #[test]
    fn the_camera_gives_the_lens_back((lens, camera) in lens_camera()) {
        assert_same_lens(&camera.thin_lens(lens.image_distance()).unwrap(), &lens)?;
        let [width, height] = camera.sensor_size(lens.image_distance());
        prop_assert!((width - random_lens::SENSOR[0]).abs() + (height - random_lens::SENSOR[1]).abs() < 1e-12);
    }

    #[test]
    fn a_tilted_iris_tells_the_image_distance(lens in tilted_lens(), shape in shape(), turn in 0.01..0.1f64) {
        let film = lens.film(random_lens::SENSOR, 640, 427).unwrap();
        let camera = lens.camera(Pose::IDENTITY, film, lens.iris(shape)).unwrap();
        // Near 0 the tilt's own rounding is magnified
        let tolerance = 1e-12 / lens.total_tilt() + ROUNDING;
        let v = camera.image_distance().unwrap();
        prop_assert!((v / lens.image_distance() - 1.0).abs() < tolerance, "{v} {lens:?}");
        // An upright iris does not, nor one that leans to another side
        prop_assert_eq!(Camera { iris: lens.upright_iris(shape), ..camera }.image_distance(), None);
        let aside = lens.axis() + turn * DVec3::new(-lens.axis().y, lens.axis().x, 0.0);
        let iris = Iris::new(aside, 0.01, shape).unwrap();
        prop_assert_eq!(Camera { iris, ..camera }.image_distance(), None);
    }

    #[test]
    fn an_untilted_lens_leaves_the_image_distance_open(f in 0.02..0.2f64, depth in 0.5..50.0f64) {
        let lens = ThinLens::new(f, 2.0, f).unwrap().focused_at(DVec2::ZERO, depth).unwrap();
        let film = lens.film(random_lens::SENSOR, 640, 427).unwrap();
        let camera = lens.camera(Pose::IDENTITY, film, lens.iris(Default::default())).unwrap();
        prop_assert_eq!(camera.image_distance(), None);
        // Any v will do: the same rays come from each of these lenses
        for v in [0.01, 0.05, 3.0] {
            let other = camera.thin_lens(v).unwrap();
            prop_assert!((other.focus().w() - camera.focus.w()).length() < ROUNDING / v);
            prop_assert!((other.aperture_radius() / camera.iris.radius() - 1.0).abs() < ROUNDING);
        }
    }

    #[test]
    fn focusing_at_a_pixel_makes_it_sharp(lens in lens(), place in unit_square(), depth in 0.5..100.0f64) {
        let film = lens.film(random_lens::SENSOR, 640, 427).unwrap();
        let q = q_at(&film, place);
        let nearest = lens.focal_length() / lens.axis().dot(q.extend(1.0));
        prop_assume!(depth > 1.01 * nearest);
        let focus = lens.focused_at(q, depth).unwrap().focus();
        prop_assert!((focus.inverse_depth(q) - 1.0 / depth).abs() < ROUNDING / lens.focal_length());
        let at_infinity = lens.focused_at(q, f64::INFINITY).unwrap().focus();
        prop_assert!(at_infinity.inverse_depth(q).abs() < ROUNDING / lens.focal_length());
    }

    #[test]
    fn focusing_at_a_sensor_point_lets_the_window_breathe(
        lens in lens(), x in -0.018..0.018f64, y in -0.012..0.012f64, depth in 0.5..100.0f64,
    ) {
        let point = DVec2::new(x, y);
        prop_assume!(depth > 1.01 * lens.focal_length() / lens.axis().z);
        let Ok(focused) = lens.focused_at_sensor_point(point, depth) else { return Ok(()) };
        let q = (point + lens.shift()) / focused.image_distance();
        prop_assert!((focused.focus().inverse_depth(q) - 1.0 / depth).abs() < ROUNDING / lens.focal_length());
    }

    #[test]
    fn three_picked_pixels_determine_the_plane(
        w in [-2.0..2.0f64, -2.0..2.0f64, 0.0..2.0f64], places in [unit_square(), unit_square(), unit_square()],
    ) {
        let wanted = Focus::new(DVec3::from_array(w)).unwrap();
        let q = places.map(|[x, y]| DVec2::new(x - 0.5, y - 0.5));
        let area = (q[1] - q[0]).perp_dot(q[2] - q[0]).abs();
        prop_assume!(area > 1e-3 && q.iter().all(|&q| wanted.inverse_depth(q) > 0.0));
        let found = Focus::through_pixels(q.map(|q| (q, wanted.depth(q).unwrap()))).unwrap();
        prop_assert!((found.w() - wanted.w()).length() < 1e-12 / area);
    }

    #[test]
    fn a_plane_of_the_world_comes_back(
        camera in raw_camera(), position in [-5.0..5.0f64, -5.0..5.0f64, -5.0..5.0f64], target in [-1.0..1.0f64, -1.0..1.0f64],
    ) {
        let position = DVec3::from_array(position);
        let pose = Pose::look_at(position, position + DVec3::new(target[0], target[1], -1.0), DVec3::Y).unwrap();
        let (point, normal) = camera.focus.to_world_plane(&pose).unwrap();
        prop_assert!((normal.length() - 1.0).abs() < 1e-12);
        prop_assert!(((point - position).length() / camera.focus.distance() - 1.0).abs() < ROUNDING);
        let back = Focus::from_world_plane(&pose, point, normal).unwrap();
        // The position is subtracted again, which costs digits where the plane is near
        let tolerance = 1e-13 * (1.0 + position.length() * camera.focus.w().length()) * camera.focus.w().length();
        prop_assert!((back.w() - camera.focus.w()).length() < tolerance);
    }

    #[test]
    fn nakanes_angles_come_back(theta in -1.57..1.57f64, distance in 0.1..100.0f64, v in 0.01..0.2f64) {
        prop_assume!(theta.abs() > 0.01);
        let plane = Nakane::new(theta, distance).unwrap();
        let of_focus = Nakane::of(&plane.focus().unwrap()).unwrap();
        let of_lens = Nakane::from_lens_tilt(theta, plane.lens_tilt(v), v).unwrap();
        prop_assert!((of_focus.theta() - theta).abs() < 1e-12);
        prop_assert!((of_focus.distance() / distance - 1.0).abs() < 1e-12);
        // Near a right angle the tilt is nearly 0, and U hangs on its last digits
        prop_assert!((of_lens.distance() / distance - 1.0).abs() < 1e-12 / plane.lens_tilt(v).abs());
    }

    #[test]
    fn json_keeps_every_bit((lens, camera) in lens_camera(), raw in raw_camera()) {
        let text = serde_json::to_string(&lens).unwrap();
        prop_assert_eq!(serde_json::from_str::<ThinLens>(&text).unwrap(), lens);
        for camera in [camera, raw, raw.pinhole()] {
            let text = serde_json::to_string(&camera).unwrap();
            prop_assert_eq!(serde_json::from_str::<Camera>(&text).unwrap(), camera);
        }
    }

    #[test]
    fn another_unit_is_the_same_lens(lens in lens()) {
        let millimetres = lens.scaled(1000.0).unwrap();
        prop_assert!((millimetres.focus().w() * 1000.0 - lens.focus().w()).length() < ROUNDING / lens.focal_length());
        prop_assert_eq!(millimetres.f_number(), lens.f_number());
        assert_same_lens(&millimetres.scaled(1e-3).unwrap(), &lens)?;
    }
}

#[test]
fn a_plane_at_infinity_has_no_place_in_the_world() {
    let focus = Focus::at_depth(f64::INFINITY).unwrap();
    assert_eq!(focus.to_world_plane(&Pose::IDENTITY), None);
    assert_eq!((focus.hinge(), focus.vanishing_line(), Nakane::of(&focus)), (None, None, None));
    assert_eq!((focus.hinge_distance(), focus.distance()), (f64::INFINITY, f64::INFINITY));
    assert_eq!(focus.depth(DVec2::ONE), Some(f64::INFINITY));
}

#[test]
fn three_picks_in_the_sky_focus_at_infinity() {
    let picks = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|q| (q, f64::INFINITY));
    assert_eq!(Focus::through_pixels(picks).unwrap().w(), DVec3::ZERO);
}

#[test]
fn a_pinhole_survives_json() {
    let lens = ThinLens::new(0.05, f64::INFINITY, 0.05).unwrap();
    assert_eq!(lens.aperture_radius(), 0.0);
    let text = serde_json::to_string(&lens).unwrap();
    assert_eq!(serde_json::from_str::<ThinLens>(&text).unwrap(), lens);
    assert_eq!(lens.with_aperture_radius(0.0).unwrap(), lens);
}

#[test]
fn a_swung_plane_has_no_nakane_angle() {
    let swung = ThinLens::new(0.05, 2.0, 0.052).unwrap().tilted(0.1, 0.02).unwrap().focus();
    assert_eq!(Nakane::of(&swung), None);
    let behind = Focus::new(DVec3::new(0.0, -1.0, -0.5)).unwrap();
    assert_eq!(Nakane::of(&behind), None);
}

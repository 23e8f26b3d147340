//! Known answers: a worked example, a published hinge chart, Merklinger's table, and Nakane et al.'s two scenes.

use glam::DVec2;
use optics::{Focus, Nakane, OpticsError, ThinLens};

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted} +- {tolerance}");
}

#[test]
fn worked_example_50_mm_tilted_5_degrees() -> Result<(), OpticsError> {
    // The printed digits
    const HALF_DIGIT: f64 = 0.5e-5;
    let focus = ThinLens::new(50.0, 2.8, 51.5)?.tilted(5f64.to_radians(), 0.0)?.focus();
    assert_near(focus.depth(DVec2::ZERO).unwrap(), 1974.65244, HALF_DIGIT);
    assert_near(focus.angle_from_sensor().to_degrees(), 73.80010, HALF_DIGIT);
    assert_near(focus.hinge_distance(), 573.68566, HALF_DIGIT);
    Ok(())
}

#[test]
fn hinge_chart_of_a_24_mm_lens() -> Result<(), OpticsError> {
    // The chart prints two or three digits
    const PRINTED: f64 = 0.008;
    let chart = [(2.0, 0.69), (3.0, 0.46), (4.0, 0.345), (5.0, 0.275), (6.0, 0.23), (8.0, 0.172)];
    for (tilt, hinge) in chart {
        let lens = ThinLens::new(0.024, 4.0, 0.0242)?.tilted(f64::to_radians(tilt), 0.0)?;
        assert_near(lens.focus().hinge_distance(), hinge, PRINTED * hinge);
    }
    Ok(())
}

#[test]
fn merklingers_tilts_for_150_mm() -> Result<(), OpticsError> {
    const FOOT: f64 = 304.8;
    // He rounds to whole degrees where he says "near enough"
    for (feet, printed, computed) in [(7.0, 4.0, 4.03), (4.2, 7.0, 6.73), (2.0, 14.24, 14.24)] {
        let tilt = ThinLens::tilt_for_hinge(150.0, feet * FOOT)?.to_degrees();
        assert_near(tilt, printed, 0.3);
        assert_near(tilt, computed, 0.005);
        // And back: that tilt has its hinge there, wherever the lens is focused
        let lens = ThinLens::new(150.0, 5.6, 160.0)?.tilted(tilt.to_radians(), 0.0)?;
        assert_near(lens.focus().hinge_distance(), feet * FOOT, 1e-9 * feet * FOOT);
    }
    Ok(())
}

/// (theta, printed tilt, U/v, what the printed digits allow)
const NAKANE: [(f64, f64, f64, [f64; 2]); 4] = [
    (41.2, 7.62, 7.538, [7.518, 7.559]),
    (-48.8, -5.09, 8.828, [8.801, 8.855]),
    (45.0, 2.58, 21.19, [21.11, 21.27]),
    (-45.0, -2.58, 21.19, [21.11, 21.27]),
];

#[test]
fn nakanes_scenes_lie_where_their_tilt_says() -> Result<(), OpticsError> {
    for (theta, tilt, u_over_v, [least, most]) in NAKANE {
        let v = 0.05;
        let plane = Nakane::from_lens_tilt(theta.to_radians(), tilt.to_radians(), v)?;
        let found = plane.distance() / v;
        assert!((least..=most).contains(&found), "U/v = {found} at {theta} degrees");
        // Three or four digits are printed
        assert_near(found, u_over_v, 1e-3 * u_over_v);
    }
    Ok(())
}

#[test]
fn nakanes_two_angles_of_one_lens_are_both_reproduced() -> Result<(), OpticsError> {
    for (theta, printed_tilt, u_over_v, _) in NAKANE {
        let v = 0.05;
        let plane = Nakane::new(theta.to_radians(), u_over_v * v)?;
        // The tilt they print, to its last digit
        let tilt = plane.lens_tilt(v).to_degrees();
        assert_near(tilt, printed_tilt, 0.01);
        // Their eq. 3 gives the lens plane's angle from the axis, of which the tilt is the complement
        let eq_3 = ((u_over_v + 1.0) * theta.to_radians().tan()).atan().to_degrees();
        assert_near(plane.lens_plane_angle(v).to_degrees(), eq_3, 1e-9);
        assert_near(90f64.copysign(theta) - eq_3, tilt, 1e-9);
        // A real lens with that tilt has that plane of focus
        let lens = ThinLens::at_image_distance(&plane.focus()?, v, 2.8)?;
        assert_near(lens.tilt().to_degrees(), tilt, 1e-9);
        assert_near(lens.swing(), 0.0, 1e-12);
    }
    Ok(())
}

#[test]
fn hyperfocal_distance_of_the_textbook() -> Result<(), OpticsError> {
    // 50 mm f/8, circle of confusion 0.03 mm: 50 + 2500 / 0.24 mm
    let lens = ThinLens::new(50.0, 8.0, 50.0)?;
    assert_near(lens.hyperfocal_distance(0.03), 10_466.667, 1e-3);
    // Focused there, the camera's own wedge reaches infinity on its edge: |0 - w| = delta for a radius of c/2
    let focused = lens.focused_at(DVec2::ZERO, lens.hyperfocal_distance(0.03))?;
    let film = focused.film([36.0, 24.0], 3600, 2400)?;
    let camera = focused.camera(optics::Pose::IDENTITY, film, focused.iris(Default::default()))?;
    let wedge = camera.wedge(0.5 * 0.03 * 100.0)?; // 100 pixels per mm
    assert_near(wedge.hyperfocal_depth(), 10_466.667, 1e-3);
    let (near, _) = wedge.limits(DVec2::ZERO).unwrap();
    assert_near(near, 0.5 * 10_466.667, 1e-3);
    Ok(())
}

#[test]
fn positive_tilt_lays_the_plane_of_focus_along_the_floor() -> Result<(), OpticsError> {
    let lens = ThinLens::new(0.05, 2.8, 0.051)?;
    let tilted = lens.tilted(0.1, 0.0)?;
    let hinge = tilted.focus().hinge().unwrap();
    assert!(hinge.point.y < 0.0 && hinge.direction.x > 0.0, "the hinge is below: {hinge:?}");
    // The upper half of the picture, where a floor is far, is focused farther than the lower half
    let depth = |focus: Focus, x: f64, y: f64| focus.depth(DVec2::new(x, y)).unwrap();
    assert!(depth(tilted.focus(), 0.0, 0.05) > depth(tilted.focus(), 0.0, -0.05));
    // Positive swing puts the hinge to the right, and focuses the left farther
    let swung = lens.tilted(0.0, 0.1)?.focus();
    assert!(swung.hinge().unwrap().point.x > 0.0);
    assert!(depth(swung, -0.05, 0.0) > depth(swung, 0.05, 0.0));
    // Rise shows more of what is above
    let film = lens.shifted(DVec2::new(0.0, 0.01))?.film([0.036, 0.024], 360, 240)?;
    assert!(film.max().y > -film.min().y);
    Ok(())
}

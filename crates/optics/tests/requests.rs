//! Each impossible request fails, with its own error and a sentence that says why and what would do.

use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, DepthRange, Film, Focus, Iris, Nakane, OpticsError, Pose, ThinLens, Wedge};

/// The error is of this kind, and its sentence names these words.
macro_rules! assert_refused {
    ($request:expr, $pattern:pat, $($words:literal),+) => {
        let error = $request.unwrap_err();
        assert!(matches!(error, $pattern), "{error:?}");
        let sentence = error.to_string();
        $(assert!(sentence.contains($words), "{:?} is not in {sentence:?}", $words);)+
    };
}

fn lens() -> ThinLens {
    ThinLens::new(0.05, 2.8, 0.052).unwrap()
}

#[test]
fn a_plane_that_only_a_lens_facing_away_could_hold_sharp() {
    // On the axis w_z = -25 is below -1/0.05
    let behind = Focus::new(DVec3::new(0.0, 0.0, -25.0)).unwrap();
    assert_refused!(
        ThinLens::at_image_distance(&behind, 0.05, 2.8),
        OpticsError::FacesAway { .. },
        "-25",
        "0.05 in front of the sensor",
        "smaller image distance"
    );
    // On the border itself too; a shorter image distance does
    let border = Focus::new(DVec3::new(0.0, 1.0, -20.0)).unwrap();
    assert!(matches!(ThinLens::at_image_distance(&border, 0.05, 2.8), Err(OpticsError::FacesAway { .. })));
    assert!(ThinLens::at_image_distance(&behind, 0.03, 2.8).is_ok());
    let film = Film::from_fov(0.5, 64, 64).unwrap();
    let camera = Camera { pose: Pose::IDENTITY, film, focus: behind, iris: Iris::pinhole() };
    assert!(matches!(camera.thin_lens(0.05), Err(OpticsError::FacesAway { .. })));
}

#[test]
fn a_pixel_that_looks_at_the_lens_edge_on() {
    let tilted = lens().tilted(1.2, 0.0).unwrap();
    let film = Film::from_fov(1.5, 100, 100).unwrap();
    assert_refused!(
        tilted.camera(Pose::IDENTITY, film, tilted.upright_iris(ApertureShape::Disc)),
        OpticsError::EdgeOn { .. },
        "68.75 degrees",
        "less tilt"
    );
    assert!(matches!(tilted.focused_at(DVec2::new(0.0, 1.0), 5.0), Err(OpticsError::EdgeOn { .. })));
    assert!(lens().camera(Pose::IDENTITY, film, Iris::pinhole()).is_ok());
    // The camera blocks such rays as well
    let iris = tilted.iris(ApertureShape::Disc);
    let camera = Camera { pose: Pose::IDENTITY, film, focus: tilted.focus(), iris };
    assert_eq!(camera.ray(DVec2::new(0.0, 1.0), DVec2::splat(0.5), 0.0), None);
    assert_eq!(camera.seen_through(DVec2::new(0.0, 1.0), 0.1, DVec3::ZERO), None);
    assert_eq!(camera.lands_at(DVec2::new(0.0, 1.0), 0.1, DVec3::ZERO), None);
}

#[test]
fn a_sensor_point_that_sees_the_lens_edge_on_or_never_gets_sharp() {
    // Low in the picture the lens that looks down is nearly behind itself
    let tilted = ThinLens::new(0.05, 2.8, 0.05).unwrap().tilted(1.4, 0.0).unwrap();
    let high = tilted.focused_at_sensor_point(DVec2::new(0.0, 0.04), f64::INFINITY);
    assert!(high.is_ok(), "{high:?}");
    let low = tilted.focused_at_sensor_point(DVec2::new(0.0, -0.06), 1.0);
    assert_refused!(low, OpticsError::OutOfRange { .. }, "along the tilted axis", "less than 1");
    let near = tilted.focused_at_sensor_point(DVec2::ZERO, 0.1);
    assert_refused!(near, OpticsError::DepthTooNear { .. }, "depth 0.1", "more than 0.29");
}

#[test]
fn a_hinge_nearer_than_the_focal_length() {
    // w_y = -25: J = 0.04 < 0.05
    let focus = Focus::new(DVec3::new(0.0, -25.0, 0.5)).unwrap();
    let words = OpticsError::HingeTooNear { hinge_distance: 0.04, focal_length: 0.05 }.to_string();
    assert!(words.contains("shorter than 0.04"), "{words}");
    assert_refused!(ThinLens::of_focal_length(&focus, 0.05, 2.8), OpticsError::HingeTooNear { .. }, "0.04", "0.05");
    assert_refused!(ThinLens::tilt_for_hinge(0.05, 0.05), OpticsError::HingeTooNear { .. }, "hinge farther away");
    assert!(ThinLens::of_focal_length(&focus, 0.039, 2.8).is_ok());
}

#[test]
fn a_plane_of_focus_nearer_than_the_focal_length() {
    let focus = Focus::at_depth(0.04).unwrap();
    assert_refused!(ThinLens::of_focal_length(&focus, 0.05, 2.8), OpticsError::PlaneTooNear { .. }, "0.04", "0.05");
    assert!(ThinLens::of_focal_length(&focus, 0.039, 2.8).is_ok());
    // At the focal length the image would be at infinity
    let at_focal_length = ThinLens::of_focal_length(&Focus::at_depth(0.0625).unwrap(), 0.0625, 2.8);
    assert!(matches!(at_focal_length, Err(OpticsError::PlaneTooNear { .. })));
    // Behind the camera any lens can focus, whose hinge is not too near
    assert!(ThinLens::of_focal_length(&Focus::new(DVec3::new(0.0, 0.0, -40.0)).unwrap(), 0.05, 2.8).is_ok());
}

#[test]
fn a_depth_nearer_than_the_focal_length() {
    assert_refused!(
        lens().focused_at(DVec2::ZERO, 0.05),
        OpticsError::DepthTooNear { .. },
        "depth 0.05",
        "more than 0.05"
    );
    assert!(lens().focused_at(DVec2::ZERO, 0.0501).is_ok());
}

#[test]
fn three_pixels_on_one_line() {
    let on_line = [0.0, 0.25, 1.0].map(|t| (DVec2::new(0.1 + t, 0.2 - 3.0 * t), 2.0));
    assert_refused!(Focus::through_pixels(on_line), OpticsError::CollinearPixels, "one line", "move one");
    let same = [(DVec2::ZERO, 1.0), (DVec2::ZERO, 2.0), (DVec2::X, 3.0)];
    assert_eq!(Focus::through_pixels(same), Err(OpticsError::CollinearPixels));
    // A thousandth of a pixel off the line is a plane
    let nearly = [(DVec2::ZERO, 1.0), (DVec2::X, 1.0), (DVec2::new(0.5, 1e-6), 1.0)];
    assert!(Focus::through_pixels(nearly).is_ok());
    let [a, b, _] = nearly;
    for bad in [(DVec2::Y, 0.0), (DVec2::Y, -1.0), (DVec2::Y, f64::NAN), (DVec2::NAN, 1.0), (DVec2::INFINITY, 1.0)] {
        assert!(matches!(Focus::through_pixels([a, b, bad]), Err(OpticsError::OutOfRange { .. })), "{bad:?}");
    }
}

#[test]
fn numbers_outside_their_range() {
    const BAD: [f64; 4] = [0.0, -1.0, f64::NAN, f64::NEG_INFINITY];
    let out_of_range = |what: &str, result: Result<(), OpticsError>| match result {
        Err(OpticsError::OutOfRange { .. }) => (),
        other => panic!("{what}: {other:?}"),
    };
    for x in BAD {
        out_of_range("focal length", ThinLens::new(x, 2.8, 0.05).map(drop));
        out_of_range("f-number", ThinLens::new(0.05, x, 0.05).map(drop));
        out_of_range("image distance", ThinLens::new(0.05, 2.8, x).map(drop));
        out_of_range("sensor", lens().film([x, 0.024], 10, 10).map(drop));
        out_of_range("depth of focus", lens().focused_at(DVec2::ZERO, x).map(drop));
        out_of_range("depth of focus", lens().focused_at_sensor_point(DVec2::ZERO, x).map(drop));
        out_of_range("depth of focus", Focus::at_depth(x).map(drop));
        out_of_range("nearest depth", DepthRange::new(x, 1.0).map(drop));
        out_of_range("farthest depth", DepthRange::new(1.0, x).map(drop));
        out_of_range("hinge", ThinLens::tilt_for_hinge(0.05, x).map(drop));
        out_of_range("scale", lens().scaled(x).map(drop));
        out_of_range("U", Nakane::new(1.0, x).map(drop));
        out_of_range("v", Nakane::from_lens_tilt(1.0, 0.1, x).map(drop));
        out_of_range("w", Focus::new(DVec3::new(0.0, x / 0.0, 1.0)).map(drop));
    }
    for x in [-1.0, f64::NAN] {
        out_of_range("radius", lens().with_aperture_radius(x).map(drop));
        out_of_range("delta", Wedge::new(lens().focus(), x).map(drop));
        let film = Film::from_fov(0.5, 64, 64).unwrap();
        let iris = lens().iris(ApertureShape::Disc);
        let camera = lens().camera(Pose::IDENTITY, film, iris).unwrap();
        out_of_range("circle of confusion", camera.wedge(x).map(drop));
    }
    for x in [1.6, -1.6, f64::NAN, f64::INFINITY] {
        out_of_range("tilt", lens().tilted(x, 0.0).map(drop));
        out_of_range("swing", lens().tilted(0.0, x).map(drop));
        out_of_range("theta", Nakane::new(x, 1.0).map(drop));
    }
    out_of_range("shift", lens().shifted(DVec2::new(f64::NAN, 0.0)).map(drop));
    out_of_range("blades", ApertureShape::polygon(2, 0.0).map(drop));
    for squeeze in [0.0, 0.2, 4.1, -1.0, f64::NAN, f64::INFINITY] {
        out_of_range("squeeze", Iris::pinhole().squeezed(squeeze).map(drop));
    }
    out_of_range("iris", Iris::new(DVec3::NEG_Z, 1.0, ApertureShape::Disc).map(drop));
    // Tilts that would put U behind the lens: theta and tilt of different signs, or a plane behind
    out_of_range("Nakane", Nakane::from_lens_tilt(0.7, -0.1, 0.05).map(drop));
    out_of_range("Nakane", Nakane::from_lens_tilt(1.5, 1.0, 0.05).map(drop));
    out_of_range("Nakane", Nakane::new(0.0, 1.0).map(drop));
    // A plane through the lens centre has no w
    let through = Focus::from_world_plane(&Pose::IDENTITY, DVec3::new(1.0, 0.0, 0.0), DVec3::Y);
    assert_refused!(through, OpticsError::OutOfRange { .. }, "distance of the plane of focus from the lens centre");
}

#[test]
fn files_are_checked_as_calls_are() {
    let lens = |text: &str| serde_json::from_str::<ThinLens>(text).map_err(|error| error.to_string());
    assert!(lens(r#"{"focal_length": 0.05, "f_number": 2.8, "image_distance": 0.05}"#).is_ok());
    let negative = lens(r#"{"focal_length": -0.05, "f_number": 2.8, "image_distance": 0.05}"#).unwrap_err();
    assert!(negative.contains("focal length is -0.05"), "{negative}");
    let unknown = lens(r#"{"focal_length": 0.05, "f_number": 2.8, "image_distance": 0.05, "tild": 1}"#).unwrap_err();
    assert!(unknown.contains("tild"), "{unknown}");

    // Each part of a camera too
    let film = Film::from_fov(0.5, 64, 48).unwrap();
    let iris = Iris::upright(0.01, ApertureShape::polygon(5, 0.0).unwrap()).unwrap();
    let camera = Camera { pose: Pose::IDENTITY, film, focus: Focus::at_depth(2.0).unwrap(), iris };
    let text = serde_json::to_string(&camera).unwrap();
    let read = |text: &str| serde_json::from_str::<Camera>(text).map_err(|error| error.to_string());
    assert_eq!(read(&text), Ok(camera));
    let anamorphic = Camera { iris: iris.squeezed(1.33).unwrap(), ..camera };
    let squeezed = serde_json::to_string(&anamorphic).unwrap();
    assert_eq!(read(&squeezed), Ok(anamorphic));
    let error = read(&squeezed.replace("1.33", "133")).unwrap_err();
    assert!(error.contains("squeeze (height of the iris over its width) is 133"), "{error}");
    for (good, bad, words) in [
        (r#""width":64"#, r#""width":0"#, "picture width in pixels is 0"),
        (r#""radius":0.01"#, r#""radius":-1"#, "aperture radius is -1"),
        (r#""blades":5"#, r#""blades":0"#, "number of aperture blades is 0"),
        (r#""m":[0.0,0.0,1.0]"#, r#""m":[0.0,0.0,-1.0]"#, "the iris must face the scene"),
        (r#""e2":[-0.0,1.0,0.0]"#, r#""e2":[0.0,-1.0,0.0]"#, "no right-handed frame"),
        (r#""up":[0.0,1.0,0.0]"#, r#""up":[0.0,2.0,0.0]"#, "not of length 1"),
    ] {
        assert!(text.contains(good), "{good} is not in {text}");
        let error = read(&text.replace(good, bad)).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

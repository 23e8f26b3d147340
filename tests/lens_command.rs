//! `tiltshift lens`, run as a user runs it: known answers, requests that come back, and errors in one line.

use assert_cmd::cargo::cargo_bin_cmd;
use serde_json::Value;

/// A full-frame 50 mm lens, all but its focus.
const FIFTY: &str = "--focal-length 50 --sensor-width 36 --f-number 2.8";

/// Standard output of `tiltshift lens` with these arguments, which must succeed and be silent on stderr.
fn words(arguments: &str) -> String {
    let output = cargo_bin_cmd!("tiltshift").arg("lens").args(arguments.split_whitespace()).output().unwrap();
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success() && err.is_empty(), "lens {arguments}: {err}");
    out
}

/// The same as JSON.
fn json(arguments: &str) -> Value {
    serde_json::from_str(&words(&format!("{arguments} --json"))).unwrap()
}

/// The number at a path such as `/lens/tilt_deg`.
fn number(report: &Value, path: &str) -> f64 {
    report.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path} in {report:#}"))
}

/// The line of words that begins with `label`, without it.
fn line<'a>(words: &'a str, label: &str) -> &'a str {
    let found = words.lines().find_map(|line| line.trim_start().strip_prefix(label));
    found.unwrap_or_else(|| panic!("no line {label:?} in\n{words}")).trim()
}

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted} +- {tolerance}");
}

#[test]
fn worked_example_50_mm_tilted_5_degrees() {
    const HALF_DIGIT: f64 = 0.5e-5; // of what is printed, in mm and degrees
    let setting = format!("{FIFTY} --tilt 5 --image-distance 51.5");
    let report = json(&setting);
    assert_near(1e3 * number(&report, "/plane_of_focus/depth_on_axis_m"), 1974.65244, HALF_DIGIT);
    assert_near(number(&report, "/plane_of_focus/angle_from_sensor_deg"), 73.80010, HALF_DIGIT);
    assert_near(1e3 * number(&report, "/plane_of_focus/hinge/distance_m"), 573.68566, HALF_DIGIT);
    assert_near(number(&report, "/lens/effective_f_number"), 2.8 * 51.5 / 50.0, 1e-12);

    // And in words, signs included
    let text = words(&setting);
    assert_eq!(line(&text, "on the axis"), "sharp at 1.975 m");
    assert_eq!(line(&text, "angle"), "73.80 degrees from the sensor");
    assert_eq!(line(&text, "hinge"), "0.5737 m below the lens");
    assert_eq!(line(&text, "lens axis"), "tilt 5.00 degrees down");
}

#[test]
fn focusing_where_the_image_distance_puts_it_gives_that_image_distance_back() {
    let by_image = json(&format!("{FIFTY} --tilt 5 --swing -3 --image-distance 51.5"));
    let depth = number(&by_image, "/plane_of_focus/depth_on_axis_m");
    let by_depth = json(&format!("{FIFTY} --tilt 5 --swing -3 --focus-distance {depth:e}"));
    assert_near(number(&by_depth, "/lens/image_distance_mm"), 51.5, 1e-9);
    // A point at the centre of the axis' pixel is as good, here with an odd size so that there is one
    let by_point = json(&format!("{FIFTY} --tilt 5 --swing -3 --size 1281x721 --point 640,360,{depth:e}"));
    assert_near(number(&by_point, "/lens/image_distance_mm"), 51.5, 1e-9);
}

#[test]
fn hinge_chart_of_a_24_mm_lens_in_both_directions() {
    const PRINTED: f64 = 0.008; // the chart has two or three digits
    for (tilt, hinge) in [(2.0, 0.69), (3.0, 0.46), (4.0, 0.345), (5.0, 0.275), (6.0, 0.23), (8.0, 0.172)] {
        let lens = "--focal-length 24 --sensor-width 36 --f-number 4 --focus-distance 3";
        let by_tilt = json(&format!("{lens} --tilt {tilt}"));
        let found = number(&by_tilt, "/plane_of_focus/hinge/distance_m");
        assert_near(found, hinge, PRINTED * hinge);
        // The tilt that puts it there, above and below
        for sign in [1.0, -1.0] {
            let by_hinge = json(&format!("{lens} --hinge-distance {}", sign * found));
            assert_near(number(&by_hinge, "/lens/tilt_deg"), sign * tilt, 1e-9);
            assert_near(number(&by_hinge, "/plane_of_focus/hinge/nearest_point_m/1"), -sign * found, 1e-9);
        }
    }
}

#[test]
fn nakanes_plane_and_lens_tilt() {
    // U/v = 7.538 for 41.2 degrees and 7.62 (printed digits): U = 0.4 m, v = 0.4/7.538 m, F from the tilt
    let v = 400.0 / 7.538;
    let focal_length = v * 7.62f64.to_radians().cos() / (1.0 + v / 400.0);
    let plane = format!("--focal-length {focal_length} --sensor-width 36 -N 8 --focus-plane 41.2,0.4");
    let report = json(&plane);
    assert_near(number(&report, "/lens/tilt_deg"), 7.62, 0.01);
    assert_near(number(&report, "/plane_of_focus/nakane/theta_deg"), 41.2, 1e-9);
    assert_near(number(&report, "/plane_of_focus/nakane/distance_m"), 0.4, 1e-12);
    assert!(line(&words(&plane), "lens axis").ends_with("(to suit the plane of focus)"));
}

#[test]
fn three_points_of_a_plane_give_back_the_lens_that_made_it() {
    let made = json(&format!("{FIFTY} --tilt 4 --swing -2.5 --focus-distance 2"));
    let w: Vec<f64> = (0..3).map(|i| number(&made, &format!("/plane_of_focus/w_per_m/{i}"))).collect();
    // Depth of that plane at a pixel, by hand: q from the window, then 1/w(q)
    let point = |x: f64, y: f64| {
        let q = 36.0 / 50.0 / 1280.0;
        let (qx, qy) = ((x + 0.5 - 640.0) * q, (360.0 - y - 0.5) * q);
        format!("--point {x},{y},{:e}", 1.0 / (w[0] * qx + w[1] * qy + w[2]))
    };
    let points = format!("{FIFTY} {} {} {}", point(100.0, 700.0), point(1200.0, 650.0), point(600.0, 20.0));
    let found = json(&points);
    assert_near(number(&found, "/lens/tilt_deg"), 4.0, 1e-9);
    assert_near(number(&found, "/lens/swing_deg"), -2.5, 1e-9);
    assert_near(number(&found, "/plane_of_focus/depth_on_axis_m"), 2.0, 1e-9);
    let image_distance = number(&made, "/lens/image_distance_mm");
    assert_near(number(&found, "/lens/image_distance_mm"), image_distance, 1e-9);

    // Both lean in words, and the hinge lies on their side
    let text = words(&points);
    let axis = line(&text, "lens axis");
    assert_eq!(
        axis,
        "tilt 4.00 degrees down, swing 2.50 degrees left; 4.72 degrees in total (to suit the three points)"
    );
    let hinge = line(&text, "hinge");
    assert!(hinge.contains(" below and ") && hinge.contains(" left of it"), "{hinge}");
}

#[test]
fn limits_of_sharpness_blur_to_the_stated_circle() {
    let report = json(&format!("{FIFTY} --tilt 2 --focus-distance 3 --coc 1.5"));
    // |1/z - w(q)| R s is the radius in pixels, for R = F/(2N) and s pixels per unit of q
    let (radius, scale) = (0.025 / 2.8, 1280.0 / (36.0 / 50.0));
    for place in ["on_axis", "top", "bottom", "left", "right"] {
        let at = |what: &str| number(&report, &format!("/depth_of_field/{place}/{what}_m"));
        for limit in [at("near"), at("far")] {
            assert_near((limit.recip() - at("sharp").recip()).abs() * radius * scale, 1.5, 1e-9);
        }
        assert!(at("near") < at("sharp") && at("sharp") < at("far"));
    }
    // The wedge: where it is z J delta wide, its planes are z J delta away from the plane of focus, up and down
    let (hinge, delta) = (number(&report, "/plane_of_focus/hinge/distance_m"), 1.5 / (radius * scale));
    assert_near(number(&report, "/depth_of_field/wedge_half_width_m"), 3.0 * hinge * delta, 1e-12);
}

#[test]
fn focus_at_infinity_is_said_as_infinity() {
    for focus in ["--focus-distance inf", "--image-distance 50", "--point 640,360,inf"] {
        let report = json(&format!("{FIFTY} {focus}"));
        assert_eq!(report["plane_of_focus"]["depth_on_axis_m"], "inf", "{focus}");
        assert_eq!(report["depth_of_field"]["on_axis"]["far_m"], "inf");
        assert_near(number(&report, "/blur/largest_of_sky_diameter_px"), 0.0, 1e-9);
        assert!(report["plane_of_focus"]["hinge"].is_null() && report["blur"]["scene"].is_null());
        assert_eq!(line(&words(&format!("{FIFTY} {focus}")), "on the axis"), "sharp at infinity");
        assert_eq!(line(&words(&format!("{FIFTY} {focus}")), "sky"), "sharp");
    }
}

#[test]
fn the_sky_blurs_to_the_textbook_diameter() {
    // Untilted: F v / (N z0) on the sensor at distance v; the window is held, so pixels per q are 1280 / 0.72
    let report = json(&format!("{FIFTY} --focus-distance 2"));
    let wanted = 0.05 / 2.8 / 2.0 * 1280.0 / 0.72;
    assert_near(number(&report, "/blur/largest_of_sky_diameter_px"), wanted, 1e-9);
    // Half the focus distance blurs as much as infinity does
    assert_near(number(&report, "/blur/scene/nearest_m"), 1.0, 1e-12);
    assert_near(number(&report, "/blur/scene/largest_diameter_px"), wanted, 1e-9);
    assert_eq!(report["blur"]["scene"]["kernel"], "disc");
    // A fast lens with much tilt needs more than a disc, an upright iris does not
    let fast = "--focal-length 50 --sensor-width 36 -N 1.4 --focus-distance 2 --tilt 8";
    assert_ne!(json(fast)["blur"]["scene"]["kernel"], "disc");
    assert_eq!(json(&format!("{fast} --upright-iris"))["blur"]["scene"]["kernel"], "disc");
}

#[test]
fn a_vanishing_line_in_the_picture_is_said_with_its_far_side() {
    let floor = format!("{FIFTY} --tilt 8 --focus-distance 6");
    let report = json(&floor);
    // w(q) = 0 at q_y = w_z/|w_y|, a row of the picture
    let w = |i: usize| number(&report, &format!("/plane_of_focus/w_per_m/{i}"));
    let row = 360.0 - w(2) / w(1).abs() * 1280.0 / 0.72;
    assert_near(number(&report, "/plane_of_focus/vanishing_line_px/0/1"), row, 1e-6);
    assert!(report["depth_of_field"]["top"]["sharp_m"].is_null());
    let text = words(&floor);
    assert!(text.contains("above it the plane of focus is behind the camera"), "{text}");
    assert!(line(&text, "top").starts_with("nothing"), "{text}");
    // Turned the other way the far side is below
    assert!(words(&format!("{FIFTY} --tilt -8 --focus-distance 6")).contains("below it the plane of focus is behind"));
    assert!(
        words(&format!("{FIFTY} --swing 8 --focus-distance 6")).contains("left of it the plane of focus is behind")
    );
}

#[test]
fn a_pinhole_is_sharp_everywhere() {
    let pinhole = "--focal-length 50 --sensor-width 36 --aperture-radius 0 --tilt 3 --focus-distance 2";
    assert_eq!(line(&words(pinhole), "pinhole"), "everything is sharp");
    let report = json(pinhole);
    assert_eq!(report["lens"]["f_number"], "inf");
    assert_eq!(report["depth_of_field"]["on_axis"]["far_m"], "inf");
    assert_near(number(&report, "/depth_of_field/on_axis/near_m"), 0.0, 0.0);
}

#[test]
fn words_and_json_agree() {
    let setting = format!("{FIFTY} --tilt -3 --swing 2 --shift -1.5,4 --focus-distance 2.5 --nearest 0.8");
    let (text, report) = (words(&setting), json(&setting));
    // Each figure of the words, found in its line
    let figures = [
        ("lens axis", "/lens/total_tilt_deg", 1.0, 2),
        ("image distance", "/lens/image_distance_mm", 1.0, 3),
        ("angle", "/plane_of_focus/angle_from_sensor_deg", 1.0, 2),
        ("hinge", "/plane_of_focus/hinge/distance_m", 1.0, 4),
        ("sky", "/blur/largest_of_sky_diameter_px", 1.0, 1),
        ("scene", "/blur/scene/largest_diameter_px", 1.0, 1),
    ];
    for (label, path, unit, decimals) in figures {
        let figure = format!("{:.decimals$}", unit * number(&report, path));
        let figure = figure.trim_end_matches('0');
        assert!(line(&text, label).contains(figure), "{label}: {figure} in\n{text}");
    }
    assert_eq!(line(&text, "shift"), "4 mm up and 1.5 mm left");
    assert!(line(&text, "lens axis").starts_with("tilt 3.00 degrees up, swing 2.00 degrees right"));
}

#[test]
fn impossible_requests_end_with_code_2_and_one_line() {
    let requests = [
        ("--focal-length 50", "--sensor-width"),
        ("--focal-length 50 --fov 40 --focus-distance 2", "--f-number"),
        ("--focal-length 50 --fov 40 -N 2", "--focus-distance"),
        ("--focal-length 50 --fov 190 -N 2 --focus-distance 2", "--fov is 190"),
        ("--focal-length=-50 --sensor-width 36 -N 2 --focus-distance 2", "--focal-length is -50 mm"),
        ("--focal-length 50 --fov 40 -N 0 --focus-distance 2", "f-number"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 0.04", "cannot focus at depth 0.04"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --hinge-distance 0.04", "the hinge is 0.04"),
        ("--focal-length 50 --fov 40 -N 2 --focus-plane 60,0.04", "focal length"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --tilt 95", "--tilt is 95 degrees"),
        ("--focal-length 50 --fov 100 -N 2 --focus-distance 2 --swing 80", "edge-on"),
        ("--focal-length 50 --fov 40 -N 2 --image-distance 0", "--image-distance is 0 mm"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --nearest 0", "nearest depth"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --coc=-1", "--coc is -1 px"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --coc inf", "--coc is inf px"),
        ("--focal-length 50 --fov 40 -N 2 --focus-plane 120,2", "120 degrees"),
        ("--focal-length 50 --fov 40 -N 2 --focus-distance 2 --blades 2", "blades"),
        ("--focal-length 50 --fov 40 -N 2 --focus-pixel 4,5", "--point X,Y,M"),
        ("--focal-length 50 --fov 40 -N 2 --point 4,5,2 --point 40,5,2", "same height"),
        ("--focal-length 50 --fov 40 -N 2 --point 4,5,2 --point 4,6,2 --point 5,5,2 --point 5,6,2", "given 4 times"),
        ("--lens-preset canon-ts-e-24 --focal-length 50 --sensor full-frame --focus-distance 2", "24 mm"),
        ("--focal-length 50 --fov 40 -N 2 --focus ground", "--point X,Y,M"),
        ("--focal-length 50 --fov 40 -N 2 --point 1,1,1 --point 2,2,2 --point 3,3,3", "on one line"),
        ("--focal-length 50 --fov 40 -N 2 --point 1,1,1 --point 2,9,2 --point 3,3,3 --tilt 2", "leave out --tilt"),
        ("--focal-length 50 --fov 40 -N 2 --point 1280,1,1", "outside the picture"),
        ("--focal-length 50 --fov 40 -N 2 --point 1,1,-1", "depth"),
    ];
    for (arguments, sentence) in requests {
        let output = cargo_bin_cmd!("tiltshift").arg("lens").args(arguments.split_whitespace()).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "lens {arguments}: {err}");
        assert!(output.stdout.is_empty() && err.contains(sentence), "lens {arguments}: {err}");
        // What was mistyped is clap's to explain, with its usage; the rest is one sentence
        let is_usage = err.starts_with("error:");
        assert!(is_usage || err.trim_end().lines().count() == 1, "lens {arguments}: {err}");
    }
}

#[test]
fn help_names_the_unit_of_every_option() {
    let help = words("--help");
    let units =
        ["mm", "metres", "degrees", "pixels", "f-number", "aperture blades", "aperture radii", "times as tall as wide"];
    // An option is a line that begins with a dash and what follows it; a switch takes no value and has no unit
    let options = help.split("\n      --").chain(help.split("\n  -N, --")).skip(1);
    let mut number_of_options = 0;
    // Names of lenses and sensors have none either
    let is_measure =
        |text: &&str| text.lines().next().is_some_and(|line| line.contains('<') && !line.contains("<NAME>"));
    for option in options.filter(is_measure) {
        let end = option.find("\n  -").or_else(|| option.find("\n\n")).unwrap_or(option.len());
        let text = option[..end].to_lowercase().split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(units.iter().any(|unit| text.contains(unit)), "no unit: {text}");
        number_of_options += 1;
    }
    assert!(number_of_options >= 15, "{help}");
    for hidden in ["--focus-pixel", "--focus-points", "--focus-band", "--focus <", "--metres-per-unit"] {
        assert!(!help.contains(hidden), "{hidden} has no use without a picture");
    }
}

#[test]
fn a_preset_brings_its_focal_length_and_aperture_and_warns_of_its_limits() {
    let run = |more: &str| {
        let start = "lens --lens-preset canon-ts-e-24-ii --sensor full-frame --focus-distance 2 --json";
        let arguments = start.split(' ').chain(more.split_whitespace());
        let output = cargo_bin_cmd!("tiltshift").args(arguments).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{err}");
        (serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap(), err)
    };
    let (report, warnings) = run("--tilt 8");
    assert_eq!(report["lens"]["focal_length_mm"].as_f64().map(f64::round), Some(24.0));
    assert_eq!(report["lens"]["f_number"].as_f64(), Some(3.5));
    assert!(warnings.is_empty(), "{warnings}");
    let (report, warnings) = run("--tilt 10 -N 1.4 --shift 0,13");
    assert_eq!(report["lens"]["f_number"].as_f64(), Some(1.4), "what is typed is done");
    for limit in ["f/3.5", "8.5°", "12 mm"] {
        assert!(warnings.contains(limit), "{limit}: {warnings}");
    }
    let list = cargo_bin_cmd!("tiltshift").args(["lens", "--list-presets"]).output().unwrap();
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(list.contains("canon-ts-e-24-ii") && list.contains("full-frame"), "{list}");
}

#[test]
fn two_points_make_a_lens_without_swing_that_is_sharp_at_both() {
    // A floor 1.5 m below a level camera of 24 mm: 4 m and 20 m away, seen at rows of their own
    let (f, width, height) = (24.0, 1280.0, 720.0);
    let row = |z: f64| (0.5 * height + 1.5 / z * f / 36.0 * width - 0.5_f64).round();
    let depth = |row: f64| 1.5 * f / 36.0 * width / (row + 0.5 - 0.5 * height);
    let points: Vec<String> =
        [4.0, 20.0].iter().map(|&z| format!("--point 640,{},{}", row(z), depth(row(z)))).collect();
    let arguments = format!("--focal-length 24 --sensor-width 36 -N 4 {} --json", points.join(" "));
    let output = cargo_bin_cmd!("tiltshift").arg("lens").args(arguments.split_whitespace()).output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The plane of focus is that floor: its hinge 1.5 m below the lens, no swing
    assert!(report["lens"]["swing_deg"].as_f64().unwrap().abs() < 1e-9);
    let hinge = report["plane_of_focus"]["hinge"]["distance_m"].as_f64().unwrap();
    assert!((hinge - 1.5).abs() < 1e-6, "{hinge}");
}

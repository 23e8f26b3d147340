//! `tiltshift chart`, `tiltshift hybrid` and `tiltshift causes` as a user types them.

use std::path::Path;
use std::process::{Command, Output};

use rgbd::{ReadOptions, read_frame, read_picture};
use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs a command that must succeed.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let output = tiltshift(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    output
}

fn scene() -> String {
    format!("{}/data/scenes/simple.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_chart_leaves_figures_for_machines_and_drawings_for_eyes() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    let shot = ["--shot", "tilt", "--size", "80x45", "--rgbd-spp", "64"];
    run(folder.path(), &[&["hybrid", &scene, "-o", "other.exr", "--samples", "16"], &shot[..]].concat());
    let quick = ["--truth-samples", "256", "--samples", "3,16", "--hybrid", "0.02", "--runs", "2"];
    let candidate = ["--candidate", "other program,other.exr,12.5"];
    let output = run(folder.path(), &[&["chart", &scene, "--out", "c"], &shot[..], &quick, &candidate].concat());

    let json = std::fs::read_to_string(folder.path().join("c/chart.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["format"], 1);
    assert_eq!(json["conditions"]["truth_samples"], 256);
    assert!(json["conditions"]["truth_noise_rmse"].as_f64().unwrap() > 0.0);
    let points = json["points"].as_array().unwrap();
    let names: Vec<&str> = points.iter().map(|point| point["name"].as_str().unwrap()).collect();
    // The tracer takes samples in pairs, so that 3 are 4
    assert_eq!(names[8..], ["hybrid 0.02", "trace 4", "trace 16", "other program"]);
    let other = points.last().unwrap();
    assert_eq!(other["kernel"]["median"], 12.5);
    assert!(
        other["command_dominated_by"].is_string(),
        "the hybrid makes about this picture in less than 12 s: {other}"
    );
    let stdout = String::from_utf8(output.stdout).unwrap();
    for name in names {
        assert!(stdout.contains(name), "{stdout}");
    }
    for file in ["chart.svg", "chart_command.svg"] {
        let svg = std::fs::read_to_string(folder.path().join("c").join(file)).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("other program"));
    }
}

#[test]
fn a_series_shows_how_cost_grows() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    let quick = ["--size", "64x36", "--rgbd-spp", "16", "--samples", "2", "--hybrid", "0.1", "--runs", "1"];
    run(folder.path(), &[&["chart", &scene, "--shot", "tilt", "--series", "blur", "--out", "s"], &quick[..]].concat());
    let json = std::fs::read_to_string(folder.path().join("s/series_blur.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let at = |i: usize| json["methods"][0]["places"][i]["at"].as_f64().unwrap();
    const SHARE: f64 = 0.01;
    assert!((at(3) / at(1) - 4.0).abs() < SHARE, "four times the iris is four times the blur: {json}");
    assert!(folder.path().join("s/series_blur.svg").is_file() && folder.path().join("s/series_blur.csv").is_file());
    assert!(!folder.path().join("s/truth.exr").exists());
}

#[test]
fn causes_leave_shares_that_add_up_a_page_and_maps() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    let quick = ["--size", "48x27", "--truth-samples", "128", "--rgbd-spp", "16", "--fine", "2", "--lens-rays", "8"];
    let output = run(folder.path(), &[&["causes", &scene, "--shot", "tilt", "--out", "c"], &quick[..]].concat());
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert!(stdout.contains("small discs") && stdout.contains("rest"), "{stdout}");

    let file = |name: &str| folder.path().join("c").join(name);
    let json = std::fs::read_to_string(file("simple_tilt.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["format"], 1);
    for (filter, causes) in json["filters"].as_array().unwrap().iter().zip([8, 7]) {
        let shares = filter["shares"]["causes"].as_array().unwrap();
        assert_eq!(shares.len(), causes, "hidden background is no cause where it is given");
        for order in ["forward", "reversed"] {
            let sum: f64 = shares.iter().map(|share| share[order].as_f64().unwrap()).sum();
            let whole = sum + filter["shares"]["rest"].as_f64().unwrap();
            assert!((whole - 1.0).abs() < 1e-6, "{order}: {whole}");
        }
    }
    let page = std::fs::read_to_string(file("simple_tilt.html")).unwrap();
    assert!(page.contains("mixed colour at silhouettes") && !page.contains("src=\"http"));
    assert_eq!(std::fs::read_to_string(file("causes.csv")).unwrap().lines().count(), 1 + 2);
    assert!(file("simple_tilt_1_map.png").is_file() && file("simple_tilt_2_map.png").is_file());
}

#[test]
fn a_hybrid_says_in_its_file_what_was_traced() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    let render =
        ["render", &scene, "--shot", "tilt", "--size", "80x45", "--spp", "16", "-o", "t.exr", "--rgbd", "d.exr"];
    run(folder.path(), &render);
    let hybrid = |tolerance: &str, output: &str| {
        let arguments = ["hybrid", &scene, "--shot", "tilt", "--rgbd", "d.exr", "--samples", "16", "-o", output];
        stderr(&run(folder.path(), &[&arguments[..], &["--tolerance", tolerance]].concat()))
    };
    assert!(hybrid("0", "all.exr").contains("traced 100.0 %"));
    assert!(hybrid("inf", "none.exr").contains("traced 0.0 %"));
    hybrid("0.005", "some.exr");

    let read = |name: &str| read_picture(&folder.path().join(name), &ReadOptions::default()).unwrap().value;
    let [truth, all] = ["t.exr", "all.exr"].map(read);
    const ROUNDING: f32 = 1e-6; // a truth is the mean of its halves, each of them rounded
    let differ = truth.planes()[1].values().iter().zip(all.planes()[1].values()).any(|(a, b)| (a - b).abs() > ROUNDING);
    assert!(!differ, "without tolerance it is the trace");
    // Read as a depth, which is unknown where it is 0
    let traced = ReadOptions { depth: Some("traced".to_owned()), ..ReadOptions::default() };
    let frame = read_frame(&folder.path().join("some.exr"), &traced).unwrap().value;
    let layer = &frame.layers()[0];
    assert!(layer.known.bits().contains(&false), "some pixels are filtered");
    assert!(layer.depth.values().contains(&1.0), "some are traced");
    assert!(layer.depth.values().iter().any(|&weight| weight > 0.0 && weight < 1.0), "some are mixed");
}

#[test]
fn bad_requests_exit_with_2_and_say_what_would_do() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    run(folder.path(), &["hybrid", &scene, "--size", "32x18", "--samples", "2", "--rgbd-spp", "4", "-o", "small.exr"]);
    run(folder.path(), &["render", &scene, "--size", "32x18", "--spp", "2", "--rgbd-spp", "4", "--rgbd", "d.exr"]);
    let cases: &[(&[&str], &str)] = &[
        (&["chart", &scene, "--shot", "none"], "none"),
        (&["chart", "missing.toml"], "missing.toml"),
        (&["chart", &scene, "--candidate", "name,file.exr"], "commas between"),
        (&["chart", &scene, "--candidate", "name,file.exr,0"], "above 0"),
        (&["chart", &scene, "--candidate", "name,missing.exr,1"], "missing.exr"),
        (&["chart", &scene, "--candidate", "name,small.exr,1"], "must be of one size"),
        (&["chart", &scene, "--samples", "1"], "2..=131072"),
        (&["chart", &scene, "--runs", "0"], "1..=1000"),
        (
            &["chart", &scene, "--shot", "pinhole", "--size", "32x18", "--rgbd-spp", "4", "--series", "blur"],
            "nothing is blurred",
        ),
        (&["causes", &scene, "--shot", "pinhole"], "nothing is blurred"),
        (&["causes", &scene, "--shot", "tilt,none"], "none"),
        (&["causes", &scene, "--size", "4000x4000"], "at most"),
        (&["causes", &scene, "--fine", "1"], "2..=8"),
        (&["hybrid", &scene, "--tolerance", "-0.1"], "tolerance"),
        (&["hybrid", &scene, "--tolerance", "nan"], "tolerance"),
        (&["hybrid", &scene, "-o", "h.png"], "--png"),
        (&["hybrid", &scene, "--shot", "tilt", "--rgbd", "d.exr", "-o", "h.exr"], "this shot's camera"),
        (&["hybrid", &scene, "--rgbd", "d.exr", "-o", "d.exr"], "is the input"),
    ];
    for (arguments, said) in cases {
        let output = tiltshift(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
}

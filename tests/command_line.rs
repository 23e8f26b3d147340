//! The commands as a user types them: the whole road, exit codes, and what happens to files.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn scene(name: &str) -> String {
    format!("{}/data/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// Renders a small shot into `folder`: t.exr (truth), d.exr (RGB-D).
fn rendered(folder: &Path) {
    let scene = scene("simple");
    let small = ["--size", "160x90", "--spp", "64", "--rgbd-spp", "64"];
    let arguments =
        [&["render", &scene, "--shot", "tilt_swing_shift", "-o", "t.exr", "--rgbd", "d.exr"], &small[..]].concat();
    let output = tiltshift(folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

#[test]
fn render_filter_and_compare_make_one_road() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path());

    // The frame brings its camera along
    let output = tiltshift(folder.path(), &["filter", "d.exr", "-o", "f.exr", "--png", "f.png"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(output.stdout.is_empty(), "only results go to stdout");
    assert!(folder.path().join("f.png").is_file());

    let compare = ["compare", "t.exr", "f.exr", "--rgbd", "d.exr", "--report", "r", "--json"];
    let output = tiltshift(folder.path(), &compare);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mse = |entry: &serde_json::Value| {
        assert_eq!(entry["figures"][0]["mask"], "all");
        entry["figures"][0]["mse"].as_f64().unwrap()
    };
    assert!(mse(&json["candidates"][0]) < 0.25 * mse(&json["unfiltered"]), "half the RMS error at least: {json:#}");
    let figures = &json["candidates"][0]["figures"][0];
    let [low, high] = ["low", "high"].map(|end| figures["intervals"]["mae"][end].as_f64());
    let mae = figures["mae"].as_f64();
    assert!(low <= mae && mae <= high, "every figure comes with its interval: {figures:#}");
    let page = std::fs::read_to_string(folder.path().join("r/report.html")).unwrap();
    assert!(page.contains("<html") && !page.contains("src=\"http"), "one page, nothing from elsewhere");

    // Thresholds are exit codes
    assert_eq!(code(&tiltshift(folder.path(), &["compare", "t.exr", "f.exr", "--min-psnr", "20"])), 0);
    let output = tiltshift(folder.path(), &["compare", "t.exr", "f.exr", "--min-psnr", "90"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("below 90 dB"), "{}", stderr(&output));
    assert_eq!(code(&tiltshift(folder.path(), &["compare", "t.exr", "f.exr", "--max-rmse", "1e-9"])), 1);
    let limited = |limits: &str| tiltshift(folder.path(), &["compare", "t.exr", "f.exr", "--fail-above", limits]);
    assert_eq!(code(&limited("psnr=20dB,ssim=0.5,hdr-flip=0.9")), 0);
    let output = limited("psnr=20dB,flip=1e-6,ssim=0.99999");
    assert_eq!(code(&output), 1);
    let said = stderr(&output);
    assert!(said.contains("FLIP") && said.contains("SSIM") && !said.contains("PSNR"), "{said}");
    assert_eq!(code(&limited("flop=1")), 2);
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let [one, two] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    for folder in [&one, &two] {
        rendered(folder.path());
        assert_eq!(code(&tiltshift(folder.path(), &["filter", "d.exr", "-o", "f.exr"])), 0);
    }
    for name in ["t.exr", "d.exr", "f.exr"] {
        let [a, b] = [&one, &two].map(|folder| std::fs::read(folder.path().join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn a_lens_from_options_replaces_the_frames_own() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path());
    let run = |lens: &[&str], output: &str| {
        let arguments = [&["filter", "d.exr", "-o", output], lens].concat();
        let output = tiltshift(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stderr(&output)
    };
    // Three points on the floor lay the plane of focus along it: the lens tilts down
    let text = run(&["-N", "2", "--focal-length", "50", "--focus-points", "10,85", "150,85", "150,5"], "p.exr");
    let tilt: f64 = text.split("tilt ").nth(1).and_then(|rest| rest.split('°').next()).unwrap().parse().unwrap();
    assert!(tilt > 1.0, "{text}");
    let swung = ["-N", "2", "--focal-length", "50", "--focus-pixel", "80,45", "--swing", "-3"];
    run(&swung, "s.exr");
    run(&[&swung[..], &["--anamorphic", "2"]].concat(), "a.exr");
    let [points, swung, squeezed] =
        ["p.exr", "s.exr", "a.exr"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert!(points != swung && swung != squeezed);
    // The result tells the lens that it was made with
    let read = rgbd::read_picture(&folder.path().join("a.exr"), &rgbd::ReadOptions::default()).unwrap();
    assert_eq!(read.head.camera.unwrap().iris.squeeze(), 2.0);
}

#[test]
fn raised_highlights_are_not_clipped_again() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path());
    let raise = ["filter", "d.exr", "-o", "r.exr", "--highlight-gain", "50", "--highlight-threshold", "0.5"];
    let output = tiltshift(folder.path(), &raise);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("highlights raised in "), "{}", stderr(&output));
    let picture = rgbd::read_picture(&folder.path().join("r.exr"), &rgbd::ReadOptions::default()).unwrap().value;
    let brightest = picture.planes()[..3].iter().flat_map(rgbd::Plane::values).copied().fold(0.0, f32::max);
    assert!(brightest > 1.0, "{brightest}");
}

#[test]
fn bad_requests_exit_with_2_and_say_in_one_line_what_would_do() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path());
    std::fs::write(folder.path().join("text.exr"), "this is no picture").unwrap();
    std::fs::write(folder.path().join("bad.toml"), "format = 1\nshoots = 3\n").unwrap();
    let scene = scene("simple");
    std::fs::copy(&scene, folder.path().join("good.toml")).unwrap();
    std::fs::write(folder.path().join("ball.toml"), "format = 1\n[shapes]\nball = { sphere = { radius = -1.0 } }\n")
        .unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["filter", "missing.exr", "-o", "o.exr"], "missing.exr"),
        (&["filter", "text.exr", "-o", "o.exr"], "text.exr"),
        (&["filter", "d.exr", "-o", "d.exr"], "is the input"),
        (&["filter", "d.exr", "-o", "o.exr", "--png", "d.exr"], "is the input"),
        (&["filter", "d.exr", "-o", "o.exr", "--png", "o.exr"], "two results"),
        (
            &[
                "filter",
                "d.exr",
                "-o",
                "o.exr",
                "-N",
                "2",
                "--focal-length",
                "50",
                "--focus-distance",
                "1",
                "--fov",
                "40",
            ],
            "--fov",
        ),
        (&["render", "good.toml", "-o", "good.toml"], "is the input"),
        (&["render", &scene, "--shot", "tilt", "-o", "o.exr", "--rgbd", "./o.exr"], "two results"),
        (&["render", &scene, "--shot", "tilt", "--size", "65536x65536", "-o", "o.exr"], "pixels"),
        (&["render", &scene, "--shot", "tilt", "--overscan", "65536", "-o", "o.exr"], "pixels"),
        (&["render", "ball.toml", "-o", "o.exr"], "[shapes.ball]"),
        (&["render", ".", "-o", "o.exr"], "regular file"),
        (&["compare", "t.exr", "d.exr", "--max-rmse", "nan"], "--max-rmse"),
        (&["demo", "--shot", "nosuch"], "nosuch"),
        (&["filter", "d.exr", "-o", "o.exr", "-N", "2", "--focal-length", "50"], "--focus-distance"),
        (&["filter", "d.exr", "-o", "o.exr", "-N", "0", "--focal-length", "50", "--focus-distance", "2"], "f-number"),
        (&["filter", "d.exr", "-o", "o.exr", "-N", "2", "--focal-length", "50", "--focus-pixel", "500,5"], "outside"),
        (
            &[
                "filter",
                "d.exr",
                "-o",
                "o.exr",
                "-N",
                "2",
                "--focal-length",
                "50",
                "--focus-points",
                "1,1",
                "2,2",
                "3,3",
            ],
            "line",
        ),
        (&["filter", "t.exr", "-o", "o.exr", "-N", "2", "--focal-length", "50", "--focus-distance", "1"], "depth"),
        (&["filter", "d.exr", "-o", "o.exr", "--max-radius", "-1"], "largest blur radius"),
        (&["filter", "d.exr", "-o", "o.exr", "--tilt", "90"], "degrees"),
        (
            &[
                "filter",
                "d.exr",
                "-o",
                "o.exr",
                "-N",
                "2",
                "--focal-length",
                "50",
                "--focus-distance",
                "2",
                "--anamorphic",
                "8",
            ],
            "anamorphic squeeze (height of the iris over its width) is 8; it must be 0.25 to 4",
        ),
        (&["filter", "d.exr", "-o", "o.exr", "--memory-limit", "4GB"], "no size of memory"),
        (
            &[
                "filter",
                "d.exr",
                "-o",
                "o.exr",
                "-N",
                "2",
                "--focal-length",
                "50",
                "--focus-distance",
                "2",
                "--cat-eye",
                "3",
            ],
            "cat's eye",
        ),
        (&["filter", "d.exr", "-o", "o.exr", "--highlight-gain", "0.5"], "gain of highlights is 0.5; it must be 1 to"),
        (
            &["filter", "d.exr", "-o", "o.exr", "--highlight-gain", "2", "--highlight-threshold", "1"],
            "threshold of highlights is 1; it must be 0 or more",
        ),
        (&["filter", "d.exr", "-o", "o.exr", "--highlight-threshold", "0.5"], "--highlight-gain"),
        (&["filter", "d.exr", "-o", "o.png", "--coc"], "name it .exr for --coc"),
        (&["compare", "t.exr", "missing.exr"], "missing.exr"),
        (&["render", &scene, "--shot", "nosuch"], "nosuch"),
        (&["render", &scene, "--shot", "tilt", "--noise", "-1"], "--noise"),
        (&["render", "bad.toml"], "shoots"),
    ];
    for (arguments, word) in cases {
        let output = tiltshift(folder.path(), arguments);
        let text = stderr(&output);
        assert_eq!(code(&output), 2, "{arguments:?}: {text}");
        assert!(text.contains(word), "{arguments:?}: {text}");
        assert!(!text.contains("panicked"), "{text}");
        assert_eq!(
            text.matches("No such file").count().min(2),
            usize::from(text.contains("No such file")),
            "said twice: {text}"
        );
        assert!(!folder.path().join("o.exr").exists(), "{arguments:?} wrote a file");
    }
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path());
    std::fs::create_dir(folder.path().join("taken.exr")).unwrap();
    let output = tiltshift(folder.path(), &["filter", "d.exr", "-o", "taken.exr"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("taken.exr"), "{}", stderr(&output));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().contains(".tmp-")), "{left:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_cleanly_with_130() {
    let folder = TempDir::new().unwrap();
    let scene = scene("simple");
    // Far more samples than anybody waits for
    let arguments = ["render", &scene, "--shot", "tilt", "--spp", "100000", "-o", "t.exr", "--rgbd", "d.exr"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_tiltshift"))
        .args(arguments)
        .current_dir(folder.path())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["t.part.exr"], "what there is so far, whole, and nothing else");
}

//! Completions, manual pages, and options from a file.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn every_shell_gets_completions_and_every_command_a_page() {
    let folder = TempDir::new().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = tiltshift(folder.path(), &["completions", shell]);
        assert!(output.status.success());
        assert!(text(&output.stdout).contains("focus-pixel"), "{shell}");
    }
    assert!(tiltshift(folder.path(), &["man", "pages"]).status.success());
    for command in ["", "-filter", "-render", "-compare", "-lens"] {
        let page = std::fs::read_to_string(folder.path().join(format!("pages/tiltshift{command}.1"))).unwrap();
        assert!(
            page.contains(".SH NAME") && page.contains(&format!("tiltshift{}", command.replace('-', "\\-"))),
            "{page}"
        );
    }
}

/// A lens report as JSON, with a file of options.
fn lens(folder: &Path, file: &str, more: &[&str]) -> Result<serde_json::Value, String> {
    std::fs::write(folder.join("c.toml"), file).unwrap();
    let output = tiltshift(folder, &[&["lens", "--config", "c.toml", "--json"], more].concat());
    if output.status.success() {
        Ok(serde_json::from_slice(&output.stdout).unwrap())
    } else {
        assert_eq!(output.status.code(), Some(2));
        Err(text(&output.stderr))
    }
}

const FILE: &str = "focal-length = 50\nsensor-width = 36.0\nf_number = 2.8\nfocus-distance = 3\ntilt = -4\n";

#[test]
fn a_file_gives_options_and_the_line_comes_first() {
    let folder = TempDir::new().unwrap();
    let typed = ["--focal-length", "50", "--sensor-width", "36", "-N", "2.8", "--focus-distance", "3", "--tilt", "-4"];
    let typed = tiltshift(folder.path(), &[&["lens", "--json"], &typed[..]].concat());
    let typed: serde_json::Value = serde_json::from_slice(&typed.stdout).unwrap();
    assert_eq!(lens(folder.path(), FILE, &[]).unwrap(), typed);

    // What is typed wins, also where it excludes what the file says
    let tilt = |report: &serde_json::Value| report["lens"]["tilt_deg"].as_f64().unwrap();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(tilt(&lens(folder.path(), FILE, &["--tilt", "2"]).unwrap()), 2.0));
    let report = lens(folder.path(), FILE, &["--hinge-distance", "1"]).unwrap();
    assert!(near(tilt(&report), (0.05_f64).asin().to_degrees()));
    let report = lens(folder.path(), FILE, &["-N", "8"]).unwrap();
    assert_eq!(report["lens"]["f_number"].as_f64(), Some(8.0));
    assert!(lens(folder.path(), FILE, &["--image-distance", "51"]).is_ok(), "another focus replaces the file's");

    // Lists, tables of a command, and tables of others
    let points = "point = [\"100,700,1.6\", [1200, 700, 1.6], \"640,400,12\"]\n";
    let file =
        format!("sensor = \"full-frame\"\n{points}[lens]\nfocal-length = 24\nf-number = 4\n[filter]\ncoc = true\n");
    let report = lens(folder.path(), &file, &[]).unwrap();
    assert_eq!(report["lens"]["tilt_follows_from"], "three points");
}

#[test]
fn wrong_files_name_what_is_wrong() {
    let folder = TempDir::new().unwrap();
    for (file, words) in [
        ("tlit = 3\n", ["c.toml", "\"tlit\""]),
        ("[fliter]\ntilt = 3\n", ["[fliter]", "filter"]),
        ("tilt = \n", ["c.toml", "TOML"]),
        ("list-presets = 3\n", ["list-presets", "switch"]),
        ("tilt = true\n", ["tilt", "number"]),
        ("config = \"d.toml\"\n", ["\"config\"", "no option"]),
    ] {
        let said = lens(folder.path(), file, &[]).unwrap_err();
        assert!(words.iter().all(|word| said.contains(word)), "{file}: {said}");
    }
    let absent = tiltshift(folder.path(), &["lens", "--config", "absent.toml"]);
    assert_eq!(absent.status.code(), Some(2));
    assert!(text(&absent.stderr).contains("absent.toml"));
}

#[test]
fn what_cannot_be_written_is_found_out_before_any_work() {
    let folder = TempDir::new().unwrap();
    let frame = rgbd::Frame::new(
        rgbd::PixelWindow::of_size(16, 9),
        vec![rgbd::Layer::from_raw_depth(
            rgbd::Picture::filled(rgbd::PixelWindow::of_size(16, 9), [0.5; 4]),
            rgbd::Plane::filled(rgbd::PixelWindow::of_size(16, 9), 2.0),
        )],
    );
    rgbd::write_frame(&folder.path().join("in.exr"), &frame.unwrap(), &rgbd::WriteOptions::default()).unwrap();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    let lens = ["--focal-length", "50", "--sensor-width", "36", "-N", "2", "--focus-distance", "2"];
    for (arguments, words) in [
        (&["in.exr", "-o", "out"][..], &["cannot write \"out\"", "it is a folder; name a file in it"][..]),
        (&["in.exr", "-o", "in.exr/a.exr"], &["cannot make the folder"]),
        (&[".", "-o", "a.exr"], &["is a folder; name the frames in it", "shot.####.exr"]),
        (&["in.exr", "-o", "a.exr", "--focus-distance", "-2"], &["--focus-distance is -2 m; it must be positive"]),
    ] {
        let lens = if arguments.contains(&"--focus-distance") { &lens[..6] } else { &lens[..] };
        let output = tiltshift(folder.path(), &[&["filter"], arguments, lens].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(words.iter().all(|word| said.contains(word)) && !said.contains("method"), "{arguments:?}: {said}");
    }
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "nothing was left behind: {names:?}");
}

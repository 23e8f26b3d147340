//! Sequences as a user types them: the same bits as one at a time, missing and damaged frames named, what is complete kept.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::process::{Command, Output};

use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, ReadOptions, WriteOptions, read_frame, write_frame};
use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A frame whose card moves to the right.
fn frame(number: i32) -> Frame {
    let window = PixelWindow::of_size(64, 40);
    let is_card = |x: i32, y: i32| (10 + number..30 + number).contains(&x) && (8..32).contains(&y);
    let color = Picture::from_fn(window, |x, y| {
        let stripes = if (x + y) % 6 < 3 { 0.8 } else { 0.2 };
        if is_card(x, y) { [stripes, 0.3, 0.1, 1.0] } else { [0.1, 0.3, stripes, 1.0] }
    });
    let depth = Plane::from_fn(window, |x, y| if is_card(x, y) { 2.0 } else { 6.0 });
    Frame::new(window, vec![Layer::from_raw_depth(color, depth)]).unwrap()
}

/// Frames 8 to 13, without 11.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    for number in [8, 9, 10, 12, 13] {
        let path = folder.path().join(format!("shot.{number:04}.exr"));
        write_frame(&path, &frame(number), &WriteOptions::default()).unwrap();
    }
    folder
}

const LENS: [&str; 6] = ["--focal-length", "50", "--sensor", "full-frame", "-N", "0.7"];
const FOCUS: [&str; 2] = ["--focus-distance", "2"];

fn filter(folder: &Path, more: &[&str]) -> Output {
    tiltshift(folder, &[&["filter"], more, &LENS, &FOCUS].concat())
}

/// What a result holds but its notes, of which the command line is one.
fn pixels(path: &Path) -> Vec<Vec<f32>> {
    let picture = rgbd::read_picture(path, &ReadOptions::default()).unwrap().value;
    picture.planes().iter().map(|plane| plane.values().to_vec()).collect()
}

#[test]
fn frames_together_are_the_frames_one_by_one() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (pattern, out) in [("shot.####.exr", "a.####.exr"), ("shot.%04d.exr", "b_%04d.exr"), ("shot.*.exr", "c.exr")] {
        let output = filter(folder.path(), &[pattern, "-o", out]);
        assert!(output.status.success(), "a gap that nobody asked to be filled is only named: {}", stderr(&output));
        assert!(stderr(&output).contains("missing: frames 11\n"), "{}", stderr(&output));
        assert!(stderr(&output).contains("5 frames written"), "{}", stderr(&output));
    }
    for number in [8, 9, 10, 12, 13] {
        let input = format!("shot.{number:04}.exr");
        assert!(filter(folder.path(), &[&input, "-o", "one.exr"]).status.success());
        let wanted = pixels(&path("one.exr"));
        for name in [format!("a.{number:04}.exr"), format!("b_{number:04}.exr"), format!("c_{number:04}.exr")] {
            assert_eq!(pixels(&path(&name)), wanted, "{name}");
        }
    }
    // As a shell hands them over
    let files = ["shot.0008.exr", "shot.0012.exr"];
    let output = filter(folder.path(), &[&files[..], &["-o", "d.exr", "--png", "d.##.png"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(path("d_0012.exr").is_file() && path("d.12.png").is_file());
}

#[test]
fn a_damaged_and_a_missing_frame_are_named_and_do_not_stop_the_others() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let whole = std::fs::read(path("shot.0010.exr")).unwrap();
    std::fs::write(path("shot.0010.exr"), &whole[..whole.len() / 2]).unwrap();
    let output = filter(folder.path(), &["shot.####.exr", "-o", "out/####.exr", "--frames", "9..13", "--json"]);
    let said = stderr(&output);
    let lines: Vec<serde_json::Value> =
        output.stdout.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice(line).ok()).collect();
    let fates: Vec<_> = lines.iter().map(|line| (line["frame"].as_i64(), line["status"].as_str())).collect();
    let written = Some("written");
    assert_eq!(fates, [(Some(9), written), (Some(10), Some("failed")), (Some(12), written), (Some(13), written)]);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("frame 10: \"shot.0010.exr\" is damaged"), "{said}");
    let last = said.lines().last().unwrap();
    assert!(
        last.contains("3 frames written")
            && last.contains("1 failed: frames 10")
            && last.contains("1 missing: frames 11"),
        "{said}"
    );
    let names: Vec<String> =
        std::fs::read_dir(path("out")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(names.len(), 3, "whole files only: {names:?}");

    // Mended and resumed: what is complete is not touched
    std::fs::write(path("shot.0010.exr"), &whole).unwrap();
    let before = std::fs::metadata(path("out/0012.exr")).unwrap().modified().unwrap();
    std::fs::write(path("out/.0010.exr.tmp-1"), b"killed").unwrap();
    let output = filter(folder.path(), &["shot.####.exr", "-o", "out/####.exr", "--resume"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("2 frames written") && stderr(&output).contains("3 kept"), "{}", stderr(&output));
    assert_eq!(std::fs::metadata(path("out/0012.exr")).unwrap().modified().unwrap(), before);
    assert!(!path("out/.0010.exr.tmp-1").exists(), "what a killed run left is gone");
}

#[test]
fn keys_move_the_focus_from_frame_to_frame() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("keys.csv"), "frame,focus-distance,f-number\n8,2,0.7\n12,6,1.4\n").unwrap();
    let lens = ["--focal-length", "50", "--sensor", "full-frame"];
    let keys = ["shot.####.exr", "-o", "k.####.exr", "--focus-keys", "keys.csv"];
    let output = tiltshift(folder.path(), &[&["filter"], &keys[..], &lens].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    for (frame, distance, n) in [("0008", "2", "0.7"), ("0012", "6", "1.4"), ("0013", "6", "1.4")] {
        let still = [&format!("shot.{frame}.exr"), "-o", "one.exr", "--focus-distance", distance, "-N", n];
        assert!(tiltshift(folder.path(), &[&["filter"], &still[..], &lens].concat()).status.success());
        assert_eq!(pixels(&path("one.exr")), pixels(&path(&format!("k.{frame}.exr"))), "frame {frame}");
    }
    let twice = tiltshift(folder.path(), &[&["filter"], &keys[..], &lens, &["-N", "2"]].concat());
    assert_eq!(twice.status.code(), Some(2));
    assert!(stderr(&twice).contains("f-number is in the table"), "{}", stderr(&twice));
}

#[test]
fn wrong_sequences_end_in_one_sentence() {
    let folder = folder();
    let cases: [(&[&str], &str); 5] = [
        (&["shoot.####.exr", "-o", "o.exr"], "no file fits \"shoot.####.exr\""),
        (&["shot.0008.exr", "-o", "o.exr", "--frames", "1..2"], "is one file"),
        (&["shot.####.exr", "-o", "o.exr", "--frames", "100..200"], "is of frames 100..200"),
        (&["shot.####.exr", "-o", "shot.####.exr"], "is a frame of the input"),
        (&["shot.0008.exr", "-o", "o.exr", "--focus-keys", "absent.csv"], "absent.csv"),
    ];
    for (arguments, word) in cases {
        let output = filter(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(word), "{arguments:?}: {}", stderr(&output));
    }
    assert_eq!(read_frame(&folder.path().join("shot.0008.exr"), &ReadOptions::default()).unwrap().value, frame(8));
}

/// Ctrl-C in the middle ends with 130 and leaves whole files only; the rest follows with --resume.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_whole_frames_and_resume_goes_on() {
    let folder = TempDir::new().unwrap();
    // Large enough to be met while it runs
    let window = PixelWindow::of_size(640, 400);
    for number in 1..=12 {
        let color = Picture::from_fn(window, |x, y| [((x * y + number) % 7) as f32 * 0.1, 0.3, 0.2, 1.0]);
        let depth = Plane::from_fn(window, |x, y| 2.0 + ((x / 40 + y / 40) % 5) as f32);
        let frame = Frame::new(window, vec![Layer::from_raw_depth(color, depth)]).unwrap();
        write_frame(&folder.path().join(format!("s{number:02}.exr")), &frame, &WriteOptions::default()).unwrap();
    }
    let arguments = [&["filter", "s##.exr", "-o", "o##.exr", "--max-radius", "60"], &LENS[..], &FOCUS].concat();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tiltshift"))
        .args(&arguments)
        .current_dir(folder.path())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // Press it once the first frame stands
    let is_there = |number: i32| folder.path().join(format!("o{number:02}.exr")).is_file();
    while !is_there(1) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    let stands: Vec<i32> = (1..=12).filter(|&number| is_there(number)).collect();
    println!("{} of 12 frames stood when it was stopped", stands.len());
    assert!(status.code() == Some(130) || stands.len() == 12, "{status}");
    for number in &stands {
        pixels(&folder.path().join(format!("o{number:02}.exr")));
    }
    let output = tiltshift(folder.path(), &[&arguments[..], &["--resume"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!((1..=12).all(is_there));
    let hidden = std::fs::read_dir(folder.path())
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().starts_with('.'));
    assert_eq!(hidden.count(), 0, "nothing unfinished is left");
}

/// Writes 240 frames of 1280x720 into the folder `TILTSHIFT_FRAMES`, made of one RGB-D frame `TILTSHIFT_FRAME`: each a little
/// brighter and a little farther away. For measuring; run with `--ignored`.
#[test]
#[ignore = "writes 4 GB; for measuring"]
fn frames_to_measure() {
    let variable = |name: &str| std::path::PathBuf::from(std::env::var_os(name).expect("a path"));
    let one = read_frame(&variable("TILTSHIFT_FRAME"), &ReadOptions::default()).unwrap().value;
    for number in 0..240 {
        let part = 1.0 + number as f32 / 2400.0;
        let layers = one.clone().with_layers(1).into_layers();
        let layers = layers.into_iter().map(|layer| {
            let color = layer.color.map(|[r, g, b, a]| [part * r, part * g, part * b, a]);
            let depth = Plane::from_fn(layer.window(), |x, y| part * layer.depth.at(x, y));
            Layer::from_raw_depth(color, depth)
        });
        let mut frame = Frame::new(one.display, layers.collect()).unwrap();
        frame.camera = one.camera;
        frame.metres_per_unit = one.metres_per_unit;
        let path = variable("TILTSHIFT_FRAMES").join(format!("shot.{number:04}.exr"));
        write_frame(&path, &frame, &WriteOptions::default()).unwrap();
    }
}

/// A rough floor with a ball that rolls over it, another roughness in each frame.
fn rough_floor(number: i32) -> Frame {
    let window = PixelWindow::of_size(96, 64);
    let noise = |x: i32, y: i32| {
        let state = (x * 7919 + y * 104_729 + number * 1_299_709) as u32;
        let state = state.wrapping_mul(2_654_435_761) ^ (state >> 13);
        f32::from((state.wrapping_mul(2_246_822_519) >> 16) as u16) / 65535.0 - 0.5
    };
    let depth = Plane::from_fn(window, |x, y| {
        let inverse = (0.05 + 0.01 * (y as f32)) * (1.0 + 0.04 * noise(x, y));
        if (x - 3 * number).pow(2) + (y - 32).pow(2) < 64 { 1.5 } else { 1.0 / inverse }
    });
    let color = Picture::from_fn(window, |x, y| [0.2 + 0.1 * ((x / 5 + y / 5) % 2) as f32; 4].map(|v| v.min(1.0)));
    let color = color.map(|[r, g, b, _]| [r, g, b, 1.0]);
    Frame::new(window, vec![Layer::from_raw_depth(color, depth)]).unwrap()
}

/// The lens of each frame, as --json tells it: tilt and focus.
fn lenses(folder: &Path, more: &[&str]) -> Vec<[f64; 2]> {
    let lens = ["filter", "floor.####.exr", "--fov", "50", "--sensor-width", "36", "-N", "1", "--json"];
    let output = tiltshift(folder, &[&lens[..], more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let lines = output.stdout.split(|&byte| byte == b'\n').filter(|line| !line.is_empty());
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let of_line = |line: &[u8]| {
        let value: serde_json::Value = serde_json::from_slice(line).unwrap();
        [number(&value["report"]["tilt_deg"]), number(&value["report"]["focus_m"])]
    };
    lines.map(of_line).collect()
}

#[test]
fn the_ground_of_a_sequence_stands_still_in_any_order() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    for number in 5..30 {
        write_frame(&path(&format!("floor.{number:04}.exr")), &rough_floor(number), &WriteOptions::default()).unwrap();
    }
    let same = |lenses: &[[f64; 2]]| lenses.windows(2).all(|pair| pair[0] == pair[1]);
    for wish in ["ground", "miniature"] {
        let steady = lenses(folder.path(), &["-o", "a.####.exr", "--focus", wish]);
        assert!(steady.len() == 25 && same(&steady), "{wish}: {steady:?}");
    }
    let each = lenses(folder.path(), &["-o", "b.####.exr", "--focus", "ground", "--ground", "each"]);
    assert!(!same(&each), "found anew it trembles, else there is nothing to hold still: {each:?}");

    // One thread, and what is missing made later: the same bits
    let arguments = ["filter", "floor.####.exr", "--fov", "50", "--sensor-width", "36", "-N", "1", "--focus", "ground"];
    let run = |threads: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tiltshift"));
        command.args([&arguments[..], more].concat()).current_dir(folder.path()).env("RAYON_NUM_THREADS", threads);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let said = run("2", &["-o", "c.####.exr"]);
    assert!(said.contains("one ground for all frames, from 5 of them"), "{said}");
    let wanted = pixels(&path("c.0017.exr"));
    for number in [6, 17, 29] {
        std::fs::remove_file(path(&format!("c.{number:04}.exr"))).unwrap();
    }
    assert!(run("1", &["-o", "c.####.exr", "--resume"]).contains("22 kept"));
    assert_eq!(pixels(&path("c.0017.exr")), wanted);
}

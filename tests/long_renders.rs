//! Renders through the command line that are killed, resumed, cut into parts and joined: the same bits as one run.
#![allow(clippy::print_stdout)] // tests say what they measured

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rgbd::{Truth, read_truth};

const KILLS: u32 = 20;

/// `tiltshift render` of a small picture.
fn render(folder: &Path, output: &str, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tiltshift"));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/simple.toml");
    command.current_dir(folder).arg("render").arg(scene).args(["--shot", "tilt", "--size", "96x54", "--layers", "1"]);
    command
        .env("RAYON_NUM_THREADS", "2")
        .args(["--rgbd-spp", "1", "-o", output])
        .args(more)
        .stderr(Stdio::piped())
        .stdout(Stdio::null());
    command
}

/// Runs a command to its end; what it says.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

fn truth(path: &Path) -> Truth {
    read_truth(path, 1 << 20).unwrap().value
}

/// The next of some numbers that look random.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

/// Starts a command again and again and kills each run after a random time; how many were killed, and how many of them
/// had left something to go on with.
fn kill(start: impl Fn() -> Child, part: &Path, done: &Path) -> [u32; 2] {
    let (mut state, mut kills, mut left) = (7, 0, 0);
    while kills < KILLS && !done.exists() {
        let mut child = start();
        // From before the first file is written to well after it
        std::thread::sleep(Duration::from_millis(20 + next(&mut state) % 130));
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        left += u32::from(part.exists());
    }
    [kills, left]
}

#[test]
fn a_render_that_is_killed_twenty_times_ends_with_the_same_bits() {
    for goal in [&["--spp", "3000"][..], &["--noise", "0.0005", "--max-spp", "131072"]] {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let goal = [goal, &["--save-every", "0.05", "--resume"]].concat();
        let start = || render(folder.path(), "killed.exr", &goal).spawn().unwrap();
        let [kills, left] = kill(start, &path("killed.part.exr"), &path("killed.exr"));
        println!("{goal:?}: {left} of {kills} kills left a part");
        assert!(kills >= 5 && left > 0, "{goal:?}: {left} of {kills} kills left a part");
        run(&mut render(folder.path(), "killed.exr", &goal));
        run(&mut render(folder.path(), "whole.exr", &goal));
        assert!(truth(&path("killed.exr")) == truth(&path("whole.exr")), "{goal:?}");
        assert!(!path("killed.part.exr").exists(), "what is done leaves nothing behind");
    }
}

#[test]
fn parts_of_samples_and_pixels_join_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [
        ("a.exr", ["--samples", "0..20", "--crop", "0,0,40x54"]),
        ("b.exr", ["--samples", "20..64", "--crop", "0,0,40x54"]),
        ("c.exr", ["--samples", "0..64", "--crop", "40,0,56x54"]),
    ];
    for (output, options) in parts {
        run(&mut render(folder.path(), output, &options));
    }
    let merge = |parts: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tiltshift"));
        command.current_dir(folder.path()).arg("merge").args(parts).args(["-o", "joined.exr"]);
        command
    };
    run(&mut merge(&["c.exr", "b.exr", "a.exr"]));
    run(&mut render(folder.path(), "whole.exr", &["--spp", "64"]));
    assert!(truth(&folder.path().join("joined.exr")) == truth(&folder.path().join("whole.exr")));

    // What does not join says why
    for (parts, why) in [
        (&["a.exr", "c.exr", "a.exr"][..], "samples 0 to 10 of some pixels are in both"),
        (&["a.exr", "b.exr"], "3024 of the picture's 5184 pixels have no samples, the first at (40, 0)"),
        (&["whole.exr"], "is no part of a render"),
    ] {
        let output = merge(parts).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(why) && said.lines().count() == 1, "{said}");
    }
}

#[test]
fn a_part_of_another_render_is_not_gone_on_with_nor_lost() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("x.part.exr");
    run(&mut render(folder.path(), "x.exr", &["--spp", "64", "--keep-part"]));
    let before = std::fs::read(&part).unwrap();
    for (options, why) in [
        (&["--spp", "128"][..], "--resume"),
        (&["--spp", "128", "--resume", "--seed", "2"], "another seed"),
        (&["--noise", "0.1", "--resume"], "begun otherwise"),
    ] {
        let output = render(folder.path(), "x.exr", options).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(why), "{said}");
    }
    assert_eq!(std::fs::read(&part).unwrap(), before);
    // More samples go on from there
    run(&mut render(folder.path(), "x.exr", &["--spp", "128", "--resume"]));
    run(&mut render(folder.path(), "whole.exr", &["--spp", "128"]));
    assert!(truth(&folder.path().join("x.exr")) == truth(&folder.path().join("whole.exr")));
}

#[test]
fn frames_of_a_moving_shot_are_numbered_and_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/simple.toml");
    let keys = "[shots.rack]\n[[shots.rack.keys]]\nframe = 1\nlens.focus = { distance = 8 }\n\
        [[shots.rack.keys]]\nframe = 3\nlens.focus = { distance = 14 }\n";
    let text = std::fs::read_to_string(scene).unwrap() + keys;
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let frames = |range: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tiltshift"));
        command.current_dir(folder.path()).args(["render", "s.toml", "--shot", "rack", "--frames", range]).args(more);
        command.args(["--size", "48x27", "--spp", "8", "--rgbd-spp", "2", "--rgbd", "d.##.exr"]);
        command
    };
    run(&mut frames("1..2", &[]));
    assert!(folder.path().join("out/s_rack_0002.exr").exists() && folder.path().join("d.02.exr").exists());
    let said = run(&mut frames("1..3", &["--resume"]));
    assert!(said.contains("frame 2 is there already") && said.contains("out/s_rack_0003.exr"), "{said}");
    let picture = |name: &str| truth(&folder.path().join(name)).picture();
    assert!(picture("out/s_rack_0001.exr") != picture("out/s_rack_0003.exr"), "the focus moves");
}

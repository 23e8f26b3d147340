//! `tiltshift advise`, `tiltshift filter --tolerance` and `tiltshift benchmark` as a user types them.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

fn tiltshift(folder: &Path, arguments: &[&str], code: i32) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(arguments).current_dir(folder).output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    output
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn scene() -> String {
    format!("{}/data/scenes/simple.toml", env!("CARGO_MANIFEST_DIR"))
}

const SIZE: [&str; 4] = ["--size", "64x36", "--rgbd-spp", "32"];

#[test]
fn advice_names_a_method_and_the_command_that_runs_it() {
    let folder = TempDir::new().unwrap();
    let scene = scene();
    let asked = |tolerance: &str, code: i32| {
        let options = ["advise", &scene, "--shot", "tilt", "--json", "--tolerance", tolerance];
        let json = stdout(&tiltshift(folder.path(), &[&options[..], &SIZE].concat(), code));
        serde_json::from_str::<serde_json::Value>(&json).unwrap()
    };
    let loose = asked("psnr=20", 0);
    assert_eq!(loose["chosen"]["method"], "pinhole", "a slight blur may be left away at 20 dB: {loose}");
    let tight = asked("psnr=45dB", 0);
    let command = tight["chosen"]["command"].as_str().unwrap();
    assert!(command.starts_with("tiltshift render ") || command.starts_with("tiltshift hybrid "), "{command}");
    assert!(tight["chosen"]["seconds"].as_f64().unwrap() >= loose["chosen"]["seconds"].as_f64().unwrap());
    assert!(tight["methods"].as_array().unwrap().len() > 10);
    assert_eq!(asked("psnr=120", 1)["is_within"], false);

    // The command that it names runs as it stands
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    tiltshift(folder.path(), &words, 0);
    assert!(folder.path().join("OUT.exr").exists());
}

#[test]
fn a_filtered_picture_is_held_against_its_tolerance() {
    let folder = TempDir::new().unwrap();
    let (scene, at) = (scene(), folder.path());
    let made = ["render", &scene, "--shot", "tilt", "--spp", "2", "-o", "t.exr", "--rgbd", "f.exr"];
    tiltshift(at, &[&made[..], &SIZE].concat(), 0);
    let filter = |tolerance, more: &[&str], code| {
        let options = ["filter", "f.exr", "-o", "o.exr", "--json", "--tolerance", tolerance];
        tiltshift(at, &[&options[..], more].concat(), code)
    };
    let kept = stdout(&filter("psnr=20dB", &[], 0));
    let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
    assert_eq!(kept["method"], "merged");
    assert_eq!(kept["promise"]["is_within"], true);
    let missed = filter("rmse=0.0001", &[], 1);
    assert!(stderr(&missed).contains("trying lens rays"), "{}", stderr(&missed));
    assert!(at.join("o.exr").exists(), "the best there is, is written");
    assert!(stderr(&filter("psnr=20dB", &["--method", "pinhole"], 2)).contains("--tolerance"));

    // Advice on a file that knows its camera
    let advice = stdout(&tiltshift(at, &["advise", "f.exr", "--tolerance", "psnr=20"], 0));
    assert!(advice.contains("merged") && !advice.contains("trace"), "{advice}");
    let words = ["advise", "f.exr", "--tolerance", "flip=1"];
    assert!(stderr(&tiltshift(at, &words, 2)).contains("hdr-flip=VALUE"));
    let words = ["advise", &scene, "--shot", "tilt", "--tilt", "3"];
    assert!(stderr(&tiltshift(at, &words, 2)).contains("is a scene"));
}

#[test]
fn a_benchmark_scores_pictures_and_knows_its_truths() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let case = |name: &str, shot: &str| {
        format!(
            "[[case]]\nname = {name:?}\nscene = {:?}\nshot = {shot:?}\nsize = [160, 90]\nsamples = 64\nnoise = 0.01\n\
             checksum = \"00000000\"\n",
            scene()
        )
    };
    let text = format!("format = 1\ndescription = \"two\"\n{}{}", case("one", "tilt"), case("two", "blur"));
    std::fs::write(at.join("b.toml"), &text).unwrap();
    let first = tiltshift(at, &["benchmark", "b.toml", "--out", "made", "--json", "s.json"], 0);
    assert!(stderr(&first).contains("not the recorded bits"));
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(at.join("s.json")).unwrap()).unwrap();
    let of = |candidate: usize, case: usize| {
        json["candidates"][candidate]["scores"][case]["error"]["all"]["rmse"].as_f64().unwrap()
    };
    assert!(of(1, 0) < of(0, 0) && of(1, 1) < 0.5 * of(0, 1), "the filter is nearer than no filter: {json}");

    // What was recorded is recognised, and what is there is not traced again
    let sum = stderr(&first).split("one: truth ").nth(1).unwrap()[..8].to_owned();
    std::fs::write(at.join("b.toml"), text.replacen("00000000", &sum, 1)).unwrap();
    let written = std::fs::metadata(at.join("made/one/truth.exr")).unwrap().modified().unwrap();
    let second = tiltshift(at, &["benchmark", "b.toml", "--out", "made", "--case", "one"], 0);
    assert!(stderr(&second).contains("as recorded"), "{}", stderr(&second));
    assert_eq!(std::fs::metadata(at.join("made/one/truth.exr")).unwrap().modified().unwrap(), written);

    // Another program's pictures, one of them missing
    std::fs::create_dir(at.join("theirs")).unwrap();
    std::fs::copy(at.join("made/one/truth.exr"), at.join("theirs/one.exr")).unwrap();
    let theirs = tiltshift(at, &["benchmark", "b.toml", "--out", "made", "--candidate", "They,theirs"], 1);
    assert!(stderr(&theirs).contains("They has no picture of two"), "{}", stderr(&theirs));
    assert!(stdout(&theirs).contains("They") && !stdout(&theirs).contains("tiltshift filter"));

    tiltshift(at, &["benchmark", "b.toml", "--case", "three"], 2);
    tiltshift(at, &["benchmark", "nothing.toml"], 2);
    std::fs::write(at.join("bad.toml"), "format = 1\n").unwrap();
    let bad = tiltshift(at, &["benchmark", "bad.toml"], 2);
    assert!(stderr(&bad).contains("bad.toml"), "{}", stderr(&bad));
}

//! `tiltshift render` of a model without a scene file.

use assert_cmd::Command;

/// A square of two colours on the floor and a block on it, 2 m wide.
const OBJ: &str = "mtllib m.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -.2 0 0\nv .2 0 0\nv .2 .6 0\nv -.2 .6 0\n\
    usemtl floor\nf 4 3 2 1\nusemtl card\nf 5 6 7 8\n";
const MTL: &str = "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl card\nKd 0.8 0.2 0.1\nmap_Kd none.png\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), OBJ).unwrap();
    std::fs::write(folder.path().join("m.mtl"), MTL).unwrap();
    folder
}

fn render(folder: &tempfile::TempDir, options: &[&str]) -> std::process::Output {
    let mut command = Command::cargo_bin("tiltshift").unwrap();
    command.current_dir(folder.path()).args(["render", "m.obj", "--size", "48x27", "--spp", "8", "--rgbd-spp", "8"]);
    command.args(options).output().unwrap()
}

#[test]
fn a_model_is_seen_through_the_lens_that_is_named() {
    let folder = folder();
    let output =
        render(&folder, &["--tilt", "8", "--f-number", "2.8", "--png", "m.png", "--optical-depth", "optical.exr"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    // What is missing is named once, and what the scene asks for is said
    assert_eq!(said.matches("none.png").count(), 1, "{said}");
    for file in ["out/m.exr", "out/m_rgbd.exr", "m.png", "optical.exr"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    // The lens stands in the files: tilted down by 8 degrees, focused on the middle
    let frame = rgbd::read_frame(&folder.path().join("out/m_rgbd.exr"), &rgbd::ReadOptions::default()).unwrap().value;
    let camera = frame.camera.unwrap();
    let normal = camera.iris.normal();
    assert!((normal.z.acos().to_degrees() - 8.0).abs() < 1e-6 && normal.y < 0.0, "{normal}");
    assert!(camera.iris.radius() > 0.0);
}

#[test]
fn bounces_can_be_asked_for_and_a_camera_that_is_not_there_cannot() {
    let folder = folder();
    let output = render(&folder, &["--bounces", "2"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("path tracing to 2 bounces: bounces asked for"), "{said}");
    let output = render(&folder, &["--camera", "3"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.trim_end().lines().last().unwrap().contains("camera3"), "{said}");
}

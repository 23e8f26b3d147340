//! What a scene file says is what is built, and what is wrong is said with its place.

use std::path::Path;

use glam::{DVec2, DVec3};
use trace::{FileError, SceneFile};

const CAMERA: &str =
    "[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\n[film]\nsize = [64, 32]\nwindow = { fov_deg = 90 }\n";

fn parse(text: &str) -> Result<SceneFile, FileError> {
    SceneFile::parse(text, "test.toml")
}

/// A file of this lens and nothing to see.
fn lens(lines: &str) -> Result<SceneFile, FileError> {
    parse(&format!("format = 1\nmetres_per_unit = 0.5\n{CAMERA}[lens]\n{lines}\n"))
}

#[track_caller]
fn fails(result: Result<SceneFile, FileError>, parts: &[&str]) {
    let message = result.expect_err("this should be refused").to_string();
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

#[test]
fn the_documented_example_is_a_scene() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/FORMAT.md");
    let page = std::fs::read_to_string(page).unwrap();
    let example = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let file = parse(example).unwrap();
    assert_eq!(file.description(), "What a reader wants to know");
    assert_eq!(file.scene().metres_per_unit(), Some(0.01));
    assert_eq!(file.shots().keys().collect::<Vec<_>>(), ["blur", "large", "pinhole", "rack", "tilt"]);
    // Half a frame about frame 12, and a pillar that rolls from 1 to 25
    let blur = file.shot(Some("blur")).unwrap();
    assert_eq!((blur.exposure.times(), file.scene().frames()), ([11.75, 12.25], Some([1.0, 25.0])));
    assert_eq!((file.frames("blur"), file.frames("rack")), (Some(1..=25), Some(1..=48)));
    assert_eq!(file.scene_of(blur).moving_things(), 1);
    // 12 mm f/2.8 at 10 mm a unit: R = 1.2 / 5.6 units
    let base = file.shot(None).unwrap();
    assert!((base.camera.iris.radius() - 1.2 / 5.6).abs() < 1e-12);
    assert!((base.camera.focus.w() - DVec3::new(0.0, 0.0, 1.0 / 11.0)).length() < 1e-12);
    assert_eq!(file.shot(Some("pinhole")).unwrap().camera.iris.radius(), 0.0);
    // The tilted plane goes through what was asked for, and the lens follows by the focal length
    let tilt = file.shot(Some("tilt")).unwrap();
    let p = tilt.camera.pose.point_to_camera(DVec3::new(3.0, 0.3, -2.0));
    assert!((tilt.camera.focus.w().dot(p) - 1.0).abs() < 1e-12);
    assert!((tilt.lens.unwrap().focal_length() - 1.2).abs() < 1e-9);
    let large = file.shot(Some("large")).unwrap();
    assert_eq!((large.camera.film.width(), large.camera.focus), (1280, tilt.camera.focus));
}

#[test]
fn a_shot_moves_from_key_to_key() {
    let keys = "[lens]\nfocal_length = 0.2\nfocus = { distance = 9 }\n[shots.a]\n\
        [[shots.a.keys]]\nframe = 0\nlens.tilt_deg = 0\nlens.focus = { distance = 4 }\ncamera.position = [0, 0, 0]\n\
        [[shots.a.keys]]\nframe = 10\nlens.tilt_deg = 5\n\
        [[shots.a.keys]]\nframe = 20\nlens.focus = { distance = 8.0 }\n\
        [shots.b]\nfrom = \"a\"\nfilm.size = [32, 16]\n[shots.still]\nlens.focus = { distance = 9 }\n";
    let file = parse(&format!("format = 1\n{CAMERA}{keys}")).unwrap();
    assert_eq!((file.frames("a"), file.frames("still")), (Some(0..=20), None));
    let focus = |frame| {
        let shot = file.shot_at("a", frame).unwrap();
        1.0 / shot.camera.focus.inverse_depth(DVec2::ZERO)
    };
    let tilt = |frame| file.shot_at("a", frame).unwrap().lens.unwrap().axis().y.asin().to_degrees();
    for (frame, z, degrees) in [(-5, 4.0, 0.0), (0, 4.0, 0.0), (5, 5.0, 2.5), (15, 7.0, 5.0), (20, 8.0, 5.0)] {
        assert!((focus(frame) - z).abs() < 1e-9, "{frame}: {}", focus(frame));
        assert!((tilt(frame) + degrees).abs() < 1e-9, "{frame}: {}", tilt(frame));
    }
    // One that builds on it moves in the same way, and the list shows where it starts
    let small = file.shot_at("b", 15).unwrap().camera;
    assert_eq!((small.focus, small.film.width()), (file.shot_at("a", 15).unwrap().camera.focus, 32));
    assert_eq!(file.shots()["a"], file.shot_at("a", 0).unwrap());
    assert_eq!(file.shot_at("still", 7).unwrap().camera, file.shot(Some("still")).unwrap().camera);
}

#[test]
fn keys_that_cannot_be_are_refused_with_their_frame() {
    let keys = |keys: &str| {
        let shot = "[lens]\nfocus = { distance = 9 }\nfocal_length = 0.2\n[shots.a]\n";
        parse(&format!("format = 1\n{CAMERA}{shot}{keys}"))
    };
    let key = |frame: i64, line: &str| format!("[[shots.a.keys]]\nframe = {frame}\n{line}\n");
    fails(keys(&(key(2, "") + &key(2, ""))), &["[shots.a]", "in the order of their frames"]);
    fails(keys(&(key(0, "film.size = [8, 8]"))), &["[shots.a]", "size of the film"]);
    let kinds = key(0, "lens.focus = \"infinity\"") + &key(9, "lens.focus = { distance = 8 }");
    fails(keys(&kinds), &["[shots.a], frame 0", "focus is not of one kind"]);
    fails(keys(&key(3, "lens.tild_deg = 3")), &["[shots.a], frame 3", "tild_deg"]);
    // In the middle the camera would stand on what it looks at
    let through = key(0, "camera.position = [0, 0, 1]") + &key(4, "camera.position = [0, 0, -3]");
    fails(keys(&through), &["[shots.a], frame 2"]);
    fails(keys(&key(9_999_999, "")), &["[shots.a]", "1000000"]);
    fails(keys("[[shots.a.keys]]\nlens.tilt_deg = 1\n"), &["missing field `frame`"]);
}

#[test]
fn every_way_to_focus_says_the_same() {
    // F = 0.2 units (100 mm) focused at 4 units: 1/v = 5 - 0.25
    let v = 1.0 / 4.75;
    let same = [
        "focal_length_mm = 100\nfocus = { distance = 4 }".to_owned(),
        "focal_length = 0.2\nfocus = { w = [0, 0, 0.25] }".to_owned(),
        format!("image_distance = {v:?}\nfocus = {{ distance = 4 }}"),
        format!(
            "image_distance_mm = {:?}\nfocus = {{ plane = {{ point = [1, 1, -4], normal = [0, 0, -2] }} }}",
            v * 500.0
        ),
        format!("focal_length = 0.2\nimage_distance = {v:?}"),
    ];
    for text in same {
        let file = lens(&format!("{text}\naperture = {{ f_number = 2 }}")).unwrap();
        let shot = file.shot(None).unwrap();
        assert!((shot.camera.focus.w() - DVec3::new(0.0, 0.0, 0.25)).length() < 1e-12, "{text}");
        assert!((shot.camera.iris.radius() - 0.05).abs() < 1e-12, "{text}");
        assert!((shot.lens.unwrap().image_distance() - v).abs() < 1e-12, "{text}");
    }
    let infinity = lens("focus = \"infinity\"").unwrap();
    assert_eq!(infinity.shot(None).unwrap().camera.focus.w(), DVec3::ZERO);
}

#[test]
fn tilt_and_swing_turn_the_iris_unless_it_is_upright() {
    let text =
        "focal_length = 0.2\nfocus = { distance = 4 }\ntilt_deg = 5\nswing_deg = -3\naperture = { radius = 0.1 }\n";
    let tilted = lens(text).unwrap().shot(None).unwrap().clone();
    let (t, s) = (5_f64.to_radians(), (-3_f64).to_radians());
    let n = DVec3::new(s.sin() * t.cos(), -t.sin(), s.cos() * t.cos());
    assert!((tilted.camera.iris.normal() - n).length() < 1e-12);
    let w = n / 0.2 - DVec3::Z * (n.z / 0.2 - 0.25);
    assert!((tilted.camera.focus.w() - w).length() < 1e-12);
    let upright = lens(&format!("{text}iris = \"upright\"")).unwrap().shot(None).unwrap().clone();
    assert_eq!(upright.camera.iris.normal(), DVec3::Z);
    assert_eq!(upright.camera.focus, tilted.camera.focus);
    let own = lens(&format!("{text}iris = {{ normal = [0, 0.6, 0.8] }}")).unwrap().shot(None).unwrap().clone();
    assert!((own.camera.iris.normal() - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-12);
}

#[test]
fn shift_moves_the_window_by_its_share_of_the_image_distance() {
    let v = 1.0 / 4.75;
    for shift in ["{ mm = [5, -10] }".to_owned(), format!("{{ q = [{:?}, {:?}] }}", 0.01 / v, -0.02 / v)] {
        let text = format!("focal_length = 0.2\nfocus = {{ distance = 4 }}\nshift = {shift}");
        let film = lens(&text).unwrap().shot(None).unwrap().camera.film;
        let middle = 0.5 * (film.min() + film.max());
        assert!((middle - DVec2::new(0.01, -0.02) / v).length() < 1e-12);
    }
}

#[test]
fn unknown_keys_are_shown_with_line_and_caret() {
    fails(parse("format = 1\n[materials.red]\ncolour = 0.5\n"), &["test.toml", "line 3", "^^^", "colour", "checker"]);
    fails(
        parse("format = 1\n[shapes]\nball = { sphere = { radius = 1, colour = 2 } }\n"),
        &["line 3", "^", "colour", "radius"],
    );
    fails(lens("focus = { distanse = 3 }"), &["line 10", "^", "distanse", "distance"]);
    fails(
        parse("format = 1\n[lights]\na = { ambient = { strength = \"much\" } }\n"),
        &["line 3", "a number or three numbers"],
    );
    fails(parse("format = \n"), &["line 1", "^"]);
}

#[test]
fn what_cannot_be_is_said_with_its_place() {
    let object = |line: &str| {
        parse(&format!(
            "format = 1\n[materials.red]\ncolor = 0.5\n[shapes]\nball = {{ sphere = {{ radius = 1 }} }}\n[[objects]]\n{line}\n"
        ))
    };
    fails(object("shape = \"bal\"\nmaterial = \"red\""), &["line 7", "no shape \"bal\"", "ball"]);
    fails(object("shape = \"ball\"\nmaterial = \"rot\""), &["line 8", "no material \"rot\"", "red"]);
    fails(object("shape = \"ball\""), &["line 7", "needs a material"]);
    fails(object("material = \"red\""), &["[[objects]]", "a shape or a mesh"]);
    fails(
        object("shape = \"ball\"\nmaterial = \"red\"\nplacements = [\n{},\n{ scale = [1, 0, 1] }]"),
        &["line 11", "no volume"],
    );
    fails(parse("format = 2\n"), &["format 2", "format 1"]);
    fails(parse("format = 1\n[meshes.a]\nfile = \"none.obj\"\n"), &["none.obj"]);
    fails(parse("format = 1\n[meshes.a]\nfile = \"none.fbx\"\n"), &["none.fbx", ".gltf"]);
    fails(parse("format = 1\n[meshes.a]\nvertices = []\n"), &["[meshes.a]", "vertices and triangles"]);
    fails(parse("format = 1\nsky = -1\n"), &["radiance of the sky", "-1"]);
    fails(SceneFile::open("/nowhere/at/all.toml"), &["cannot read", "all.toml"]);
}

#[test]
fn lenses_that_say_too_much_or_too_little_are_refused() {
    let shot = "[camera], [lens], [film]";
    fails(lens(""), &[shot, "needs a focus"]);
    fails(lens("focus = { w = [0, 0.1, 0.2] }\ntilt_deg = 3"), &[shot, "leave one out"]);
    fails(lens("focus = { distance = 3 }\nfocal_length = 0.1\nimage_distance = 0.2"), &[shot, "leave one out"]);
    fails(lens("focus = { distance = 3 }\nfocal_length = 0.1\nfocal_length_mm = 50"), &[shot, "given twice"]);
    fails(lens("focus = { distance = 3 }\naperture = { f_number = 2 }"), &[shot, "f-number needs"]);
    fails(lens("focus = { distance = 3 }\ntilt_deg = 3"), &[shot, "tilted lens needs"]);
    fails(lens("focus = { distance = 0.1 }\nfocal_length = 0.2"), &[shot]);
    fails(lens("focus = { distance = 3 }\naperture = { radius = -1 }"), &[shot, "aperture radius"]);
    fails(lens("focus = { distance = 3 }\nblades = { count = 2 }"), &[shot, "3 to 32"]);
    fails(lens("focus = { distance = 3 }\nanamorphic = 9"), &[shot, "0.25 to 4"]);
    fails(
        lens("focus = { distance = 3 }\niris = { normal = [0, 1, 0.1] }\naperture = { radius = 1 }"),
        &[shot, "edge-on"],
    );
    fails(parse(&format!("format = 1\n{CAMERA}[lens]\nfocal_length_mm = 50\n")), &[shot, "metres_per_unit"]);
}

#[test]
fn shots_build_on_each_other_but_not_in_a_circle() {
    let base = format!("format = 1\n{CAMERA}[lens]\nfocus = {{ distance = 3 }}\n");
    let chain = format!(
        "{base}[shots.a]\nlens.aperture = {{ radius = 0.5 }}\n[shots.b]\nfrom = \"a\"\nlens.focus = {{ distance = 7 }}\n[shots.c]\nfrom = \"b\"\nfilm.size = [8, 4]\n"
    );
    let camera = parse(&chain).unwrap().shot(Some("c")).unwrap().camera;
    assert_eq!((camera.iris.radius(), camera.film.width()), (0.5, 8));
    assert!((camera.focus.w().z - 1.0 / 7.0).abs() < 1e-15);
    fails(parse(&format!("{base}[shots.a]\nfrom = \"b\"\n[shots.b]\nfrom = \"a\"\n")), &["circle", "line"]);
    fails(parse(&format!("{base}[shots.a]\nfrom = \"a\"\n")), &["circle"]);
    fails(parse(&format!("{base}[shots.a]\nfrom = \"z\"\n")), &["no shot \"z\""]);
    fails(parse(&format!("{base}[shots.a]\nlens.focus = {{ distance = -1 }}\n")), &["[shots.a]", "depth of focus"]);
    let error = parse(&base).unwrap().shot(Some("d")).unwrap_err().to_string();
    assert!(error.contains("no shot \"d\"") && error.contains("none"), "{error}");
}

#[test]
fn meshes_beside_the_file_are_placed_and_coloured() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl red\nKd 1 0.5 0.25\n").unwrap();
    let obj = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl red\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("square.obj"), obj).unwrap();
    let text = "format = 1\n[meshes.square]\nfile = \"square.obj\"\n[materials.blue]\ncolor = [0, 0, 1]\n[lights]\na = { ambient = { strength = 1 } }\n\
        [[objects]]\nmesh = \"square\"\nplacements = [{ translate = [0, 0, -5] }]\n[[objects]]\nmesh = \"square\"\nmaterial = \"blue\"\nplacements = [{ translate = [10, 0, -5], rotate_deg = [0, 90, 0] }]\n";
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let scene = SceneFile::open(&path).unwrap().scene().clone();
    let look = |origin: [f64; 3], direction: [f64; 3]| {
        scene.radiance(&trace::Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))).to_array()
    };
    assert_eq!(look([0.5, 0.5, 0.0], [0.0, 0.0, -1.0]), [1.0, 0.5, 0.25]);
    // Turned by 90 degrees about y it is seen from the side only
    assert_eq!(look([12.0, 0.0, -5.5], [-1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
    assert_eq!(look([10.5, 0.0, 0.0], [0.0, 0.0, -1.0]), [0.0, 0.0, 0.0]);
}

//! What moves while the shutter is open: known pictures, and the same picture told in two ways.

use rgbd::{Picture, PixelWindow, Silent, Truth};
use trace::{Accumulation, Exposure, FileError, Goal, Job, LayerSettings, Margin, Scene, SceneFile, Shot};

/// A camera 10 before the plane z = 0, of which a pixel shows 0.1.
const VIEW: &str = r#"
format = 1
[materials.white]
emission = 1.0
[materials.red]
color = [0.8, 0.3, 0.2]
[materials.tiles]
checker = { colors = [0.9, [0.1, 0.3, 0.5]], side = 0.35 }
[materials.brass]
color = [0.9, 0.7, 0.3]
metallic = 1.0
roughness = 0.3
[camera]
position = [0, 0, 10]
look_at = [0, 0, 0]
[lens]
focus = { distance = 10 }
aperture = { radius = 0.2 }
[film]
size = [40, 20]
window = { q = [-0.2, -0.1, 0.2, 0.1] }
[shapes]
card = { box = { size = [2, 4, 0.01] } }
bar = { box = { size = [1.8, 0.3, 0.2] } }
ball = { sphere = { radius = 0.5 } }
floor = { plane = { size = [30, 30] } }
ground = { plane = {} }
[lights]
fill = { ambient = { strength = 0.2 } }
sun = { sun = { toward = [-0.4, 1.0, 0.6], strength = 0.8 } }
"#;

fn file(rest: &str) -> SceneFile {
    SceneFile::parse(&format!("{VIEW}\n{rest}"), "motion.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(rest: &str) -> String {
    let error: FileError = SceneFile::parse(&format!("{VIEW}\n{rest}"), "motion.toml").expect_err(rest);
    error.to_string()
}

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 40, height: 20 };

fn taken(file: &SceneFile, shot: &Shot, spp: u32) -> Truth {
    trace::truth(&file.scene_of(shot), &shot.camera, WINDOW, spp, 3, &Silent).unwrap()
}

fn picture(file: &SceneFile, shot: Option<&str>, spp: u32) -> Picture {
    taken(file, file.shot(shot).unwrap(), spp).picture()
}

/// RMS difference of R, G and B.
fn rms(a: &Picture, b: &Picture) -> f64 {
    let of = |c: usize, (x, y): (i32, i32)| f64::from(a.at(x, y)[c] - b.at(x, y)[c]).powi(2);
    let squares: f64 = WINDOW.pixels().flat_map(|place| (0..3).map(|c| of(c, place)).collect::<Vec<_>>()).sum();
    (squares / (3 * WINDOW.area()) as f64).sqrt()
}

/// A card whose right edge goes from `from` to `to` while the shutter is open.
fn moving_card(from: f64, to: f64) -> SceneFile {
    file(&format!(
        "[shots.open]\ncamera.shutter = 1\nlens.aperture = \"pinhole\"\n[[objects]]\nshape = \"card\"\nmaterial = \"white\"\n\
         placements = [{{ translate = [-1, 0, -0.005] }}]\n\
         moves = [{{ frame = -0.5, translate = [{from}, 0, 0] }}, {{ frame = 0.5, translate = [{to}, 0, 0] }}]"
    ))
}

#[test]
fn a_moving_edge_is_as_soft_as_its_way_is_long() {
    // Eight pixels, far less than one, and none
    for (from, to) in [(-0.1, 0.72), (0.31, 0.34), (0.2, 0.2)] {
        let found = picture(&moving_card(from, to), Some("open"), 1024);
        for x in 14..34 {
            // A point is covered while the edge is beyond it: a ramp, over which a pixel is the mean
            let covered = |at: f64| {
                if to > from { ((to - at) / (to - from)).clamp(0.0, 1.0) } else { f64::from(u8::from(at < to)) }
            };
            let at = |i: i32| -2.0 + 0.1 * (f64::from(x) + (f64::from(i) + 0.5) / 1000.0);
            let expected = (0..1000).map(|i| covered(at(i))).sum::<f64>() / 1000.0;
            for y in [0, 7, 19] {
                let value = f64::from(found.at(x, y)[0]);
                // 1024 well-spread samples of an edge through pixel and time: 1024^-3/4 = 0.0055, three times that
                assert!(
                    (value - expected).abs() < 0.017,
                    "{from} to {to}, pixel {x}, {y}: {value} instead of {expected}"
                );
            }
        }
    }
}

#[test]
fn a_thing_that_crosses_the_picture_keeps_its_light() {
    let ball = |moves: &str| {
        let text = format!(
            "[shots.open]\ncamera.shutter = [0, 1]\n[[objects]]\nshape = \"card\"\nmaterial = \"white\"\n\
             placements = [{{ scale = [0.2, 0.2, 1] }}]\n{moves}"
        );
        let found = picture(&file(&text), Some("open"), 1024);
        WINDOW.pixels().map(|(x, y)| f64::from(found.at(x, y)[0])).sum::<f64>()
    };
    let still = ball("");
    let moving = ball("moves = [{ frame = 0, translate = [-1.2, 0.1, 0] }, { frame = 1, translate = [1.3, -0.2, 0] }]");
    // Its front stands 0.005 before z = 0 and shows 4 x 8 pixels; their sums of 1024 samples each are surely true to 1 %
    assert!((still / 32.0 - 1.0).abs() < 0.01 && (moving / still - 1.0).abs() < 0.01, "{still} {moving}");
}

const SPINNING: &str = r#"
[[objects]]
shape = "floor"
material = "tiles"
placements = [{ translate = [0, -0.9, 0], rotate_deg = [8, 0, 0] }]
[[objects]]
shape = "bar"
material = "red"
placements = [{ translate = [0.2, 0, 0.3], rotate_deg = [0, 20, 0] }]
moves = [{ frame = 10, rotate_deg = [0, 0, -60] }, { frame = 11, rotate_deg = [30, 0, 90], translate = [0.2, 0, 0.1] }]
"#;

#[test]
fn a_spinning_thing_is_the_mean_of_what_it_is_at_many_times() {
    const STILLS: u32 = 64;
    // Lit plainly, and by paths of light
    for shine in ["", "[render]\nbounces = 2"] {
        let file = file(&format!("{SPINNING}\n{shine}\n[shots.open]\ncamera.frame = 10\ncamera.shutter = [0, 1]"));
        let shot = file.shot(Some("open")).unwrap();
        let moving = taken(&file, shot, 1024);
        // The mean of the stills up to a time, and its squared noise
        let mean_to = |end: f64| {
            let (mut sum, mut noise) = (vec![[0.0; 4]; WINDOW.area()], 0.0);
            for i in 0..STILLS {
                let time = 10.0 + end * (f64::from(i) + 0.5) / f64::from(STILLS);
                let scene = file.scene().exposed(&Exposure::new(time, time).unwrap());
                let still = trace::truth(&scene, &shot.camera, WINDOW, 16, 100 + u64::from(i), &Silent).unwrap();
                noise += squared_noise(&still) / f64::from(STILLS * STILLS);
                let still = still.picture();
                for (sum, (x, y)) in sum.iter_mut().zip(WINDOW.pixels()) {
                    (0..4).for_each(|c| sum[c] += still.at(x, y)[c] / STILLS as f32);
                }
            }
            (Picture::from_fn(WINDOW, |x, y| sum[WINDOW.index(x, y)]), noise)
        };
        let (mean, noise) = mean_to(1.0);
        let expected = (noise + squared_noise(&moving)).sqrt();
        let difference = rms(&moving.picture(), &mean);
        // No more than both noises, which 2400 values tell to some per cent
        assert!((0.85..1.15).contains(&(difference / expected)), "{shine}: {difference} instead of {expected}");
        // Half of the way is another picture
        let other = rms(&moving.picture(), &mean_to(0.5).0);
        assert!(other > 3.0 * difference, "{shine}: {other} {difference}: the test would say little");
    }
}

/// Of the mean of both halves.
fn squared_noise(truth: &Truth) -> f64 {
    (0.5 * rms(&truth.halves[0], &truth.halves[1])).powi(2)
}

#[test]
fn a_moving_camera_sees_what_a_still_one_sees_of_a_world_that_moves_the_other_way() {
    let objects = |moves: &str| {
        format!(
            "[[objects]]\nshape = \"floor\"\nmaterial = \"tiles\"\nplacements = [{{ translate = [0, -0.9, 0] }}]\n{moves}\n\
             [[objects]]\nshape = \"bar\"\nmaterial = \"red\"\nplacements = [{{ translate = [0.2, 0.1, 0] }}]\n{moves}\n"
        )
    };
    let camera = r#"
        [shots.move]
        camera = { position = [0, 0, 10], right = [1, 0, 0], up = [0, 1, 0], forward = [0, 0, -1], shutter = [0, 1] }
    "#;
    // The tables of the file have a look_at, which a shot cannot take away: leave it out here
    let view = VIEW.replace("look_at = [0, 0, 0]\n", "right = [1, 0, 0]\nup = [0, 1, 0]\nforward = [0, 0, -1]\n");
    let parse = |text: &str| SceneFile::parse(&format!("{view}\n{text}"), "motion.toml").unwrap();
    let keys = "[[shots.move.keys]]\nframe = 0\ncamera.position = [0, 0, 10]\n\
                [[shots.move.keys]]\nframe = 1\ncamera.position = [0.8, 0.2, 9]\n";
    let one = parse(&format!("{camera}\n{keys}\n{}", objects("")));
    let moves = "moves = [{ frame = 0, translate = [0.4, 0.1, -0.5] }, { frame = 1, translate = [-0.4, -0.1, 0.5] }]";
    let still = "[shots.move]\ncamera.position = [0.4, 0.1, 9.5]\ncamera.shutter = [0, 1]\n";
    let other = parse(&format!("{still}\n{}", objects(moves)));
    let [a, b] = [&one, &other].map(|file| picture(file, Some("move"), 256));
    assert_eq!(one.shot(Some("move")).unwrap().camera, other.shot(Some("move")).unwrap().camera);
    // The very same samples; a few meet an edge on its other side, by rounding
    assert!(rms(&a, &b) < 1e-3, "{}", rms(&a, &b));
    let stopped = trace::truth(
        &one.scene_of(one.shot(Some("move")).unwrap()).stopped(),
        &one.shot(Some("move")).unwrap().camera,
        WINDOW,
        256,
        3,
        &Silent,
    );
    let other = rms(&a, &stopped.unwrap().picture());
    assert!(other > 0.01, "{other}: the test would say little");
}

#[test]
fn where_nothing_moves_an_open_shutter_changes_no_bit() {
    // Before the first key of the thing, and with a camera whose keys are equal
    let text = format!(
        "{SPINNING}\n[shots.closed]\n[shots.open]\ncamera.shutter = [-5, 3]\n[shots.keyed]\ncamera.shutter = 2\n\
         [[shots.keyed.keys]]\nframe = 0\ncamera.position = [0, 0, 10]\n[[shots.keyed.keys]]\nframe = 5\ncamera.position = [0, 0, 10]"
    );
    let file = file(&text);
    let closed = picture(&file, Some("closed"), 32);
    for name in ["open", "keyed"] {
        let shot = file.shot(Some(name)).unwrap();
        assert!(!file.scene_of(shot).is_timed());
        assert_eq!(picture(&file, Some(name), 32), closed, "{name}");
    }
    // While it moves, time counts
    let scene = file.scene().exposed(&Exposure::new(9.5, 10.5).unwrap());
    assert_eq!((scene.is_timed(), scene.moving_things(), file.scene().frames()), (true, 1, Some([10.0, 11.0])));
}

/// The same things as ones that stand still and as ones that could move.
#[test]
fn what_could_move_looks_as_what_cannot() {
    let objects = |moves: &str| {
        format!(
            r#"
            [meshes.roof]
            vertices = [[-0.6, 0, 0], [0.6, 0, 0], [0, 0.8, 0.1], [0, 0, -0.7]]
            triangles = [[0, 1, 2], [1, 3, 2], [3, 0, 2], [0, 3, 1]]
            [groups]
            pair = [
              {{ shape = "ball", material = "brass", place = {{ translate = [0, 0.3, 0], scale = [1, 0.7, 1] }} }},
              {{ mesh = "roof", place = {{ translate = [0.7, 0, 0.2] {inner} }} }},
              {{ shape = "bar", material = "tiles", place = {{ translate = [0, -0.4, 0] }} }},
            ]
            [[objects]]
            shape = "floor"
            material = "tiles"
            placements = [{{ translate = [0, -0.9, 0] }}]
            [[objects]]
            group = "pair"
            placements = [
              {{ translate = [-1, 0, 0], rotate_deg = [0, 30, 0] }},
              {{ translate = [0.7, 0.2, -0.5], rotate_deg = [10, 0, 20], scale = [-0.8, 0.8, 0.8] {placed} }},
            ]
            {whole}
            "#,
            inner = if moves.contains("inner") { ", moves = [{ frame = 0 }]" } else { "" },
            placed = if moves.contains("placed") { ", moves = [{ frame = 0 }]" } else { "" },
            whole = if moves.contains("whole") { "moves = [{ frame = 0 }]" } else { "" },
        )
    };
    let still = picture(&file(&objects("")), None, 64);
    for moves in ["inner", "placed", "whole", "inner placed whole"] {
        let found = picture(&file(&objects(moves)), None, 64);
        // Some samples at edges fall on the other side by rounding, and change what path light takes
        let is_off = |&(x, y): &(i32, i32)| (still.at(x, y)[0] - found.at(x, y)[0]).abs() > 0.02;
        let off = WINDOW.pixels().filter(is_off).count();
        assert!(off < 8 && rms(&still, &found) < 0.004, "{moves}: {off} pixels, {}", rms(&still, &found));
    }
}

#[test]
fn layers_show_the_middle_of_the_exposure() {
    let file = file(&format!("{SPINNING}\n[shots.open]\ncamera.frame = 10\ncamera.shutter = [0, 1]"));
    let shot = file.shot(Some("open")).unwrap();
    let settings = LayerSettings { color_samples: 16, margin: Margin::Pixels(2), ..LayerSettings::default() };
    let of = |scene: &Scene| trace::layers(scene, &shot.camera, &settings, &Silent).unwrap().frame;
    let moving = of(&file.scene_of(shot));
    let middle = of(&file.scene().exposed(&Exposure::new(10.5, 10.5).unwrap()));
    assert!(moving == middle);
    // Behind the bar lies what hidden layers hold: the floor, farther away than the first surface
    let hidden = &moving.layers()[1];
    let known: Vec<_> = moving.data().pixels().filter(|&(x, y)| hidden.known.at(x, y)).collect();
    assert!(known.len() > 20, "{}", known.len());
    assert!(known.iter().all(|&(x, y)| hidden.depth.at(x, y) > moving.layers()[0].depth.at(x, y)));
    let start = of(&file.scene().exposed(&Exposure::new(10.0, 10.0).unwrap()));
    assert!(moving != start, "the test would say little");
    let optical = |scene: &Scene| trace::optical_depth(scene, &shot.camera, WINDOW);
    assert!(optical(&file.scene_of(shot)) == optical(&file.scene().exposed(&Exposure::new(10.5, 10.5).unwrap())));
}

#[test]
fn renders_in_motion_are_cut_and_joined_to_the_same_bits() {
    // Things that move alone, and a camera that moves too, with a cat's eye that closes parts of the lens
    let keys = "[[shots.open.keys]]\nframe = 10\ncamera.position = [0, 0, 10]\n[[shots.open.keys]]\nframe = 11\ncamera.position = [0.3, 0, 10]";
    for keys in ["camera.frame = 10", keys] {
        let (own, keyed) = if keys.starts_with("camera") { (keys, "") } else { ("lens.cat_eye = 1", keys) };
        let file = file(&format!("{SPINNING}\n[shots.open]\ncamera.shutter = [0, 1]\n{own}\n{keyed}"));
        let shot = file.shot(Some("open")).unwrap();
        let scene = file.scene_of(shot);
        assert_eq!(scene.exposure().moves_camera(), !keyed.is_empty());
        let render = |samples| trace::render(&scene, &shot.camera, &WINDOW.into(), samples, 3, &Silent).unwrap();
        let whole = render(0..24);
        assert!(Accumulation::join([render(8..24), render(0..8)]).unwrap() == whole);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert!(one_thread.install(|| render(0..24)) == whole);
        // Towards a noise, stopped after every second chunk
        let goal = Goal::Noise { rmse: 0.03, most: 128 };
        let mut at_once = Job::new(shot.camera, WINDOW, 3);
        at_once.run(&scene, &goal, &Silent).unwrap();
        let mut job = Job::new(shot.camera, WINDOW, 3);
        let mut stops = 0;
        while job.run(&scene, &goal, &Stop(std::sync::atomic::AtomicU32::new(2))).is_err() {
            stops += 1;
        }
        assert!(stops > 3 && job == at_once, "{stops}");
        // Another shutter is another scene
        let stopped = Shot { exposure: shot.exposure.stopped(), ..shot.clone() };
        assert_ne!(file.fingerprint_of(shot), file.fingerprint_of(&stopped));
    }
}

/// Stops after some chunks of pixels.
struct Stop(std::sync::atomic::AtomicU32);

impl rgbd::Progress for Stop {
    fn report(&self, _: u64, _: u64) {}

    fn is_cancelled(&self) -> bool {
        use std::sync::atomic::Ordering::SeqCst;
        self.0.fetch_update(SeqCst, SeqCst, |left| left.checked_sub(1)).is_err()
    }
}

#[test]
fn what_cannot_move_so_is_refused_in_a_sentence() {
    let moves = |moves: &str| refusal(&format!("[[objects]]\nshape = \"ball\"\nmaterial = \"red\"\nmoves = {moves}"));
    assert!(moves("[]").contains("number of moves"));
    assert!(moves("[{ frame = nan }]").contains("frame of a move is NaN"));
    assert!(moves("[{ frame = 2 }, { frame = 1 }]").contains("later than that of the move before"));
    assert!(moves("[{ frame = 1, translate = [nan, 0, 0] }]").contains("translate of a move is NaN"));
    assert!(moves("[{ frame = 1, translate = [0, 1e300, 0] }]").contains("at most 1e12"));
    assert!(moves("[{ frame = 1, rotate_deg = [0, 1e300, 0] }]").contains("at most 1e7"));
    assert!(moves("[{ frame = 1, scale = 1 }, { frame = 2, scale = -1 }]").contains("scale of a move"));
    assert!(moves("[{ translate = [0, 0, 0] }]").contains("missing field `frame`"));
    assert!(moves("[{ frame = 1, jump = 2 }]").contains("unknown field `jump`"));
    let far = "[[objects]]\nshape = \"ball\"\nmaterial = \"red\"\nplacements = [{ scale = 1e9 }]\n\
               moves = [{ frame = 0, translate = [1e9, 0, 0] }]";
    assert!(refusal(far).contains("distance that a moving thing goes"));
    let endless = "[[objects]]\nshape = \"ground\"\nmaterial = \"red\"\nmoves = [{ frame = 0 }]";
    assert!(refusal(endless).contains("an endless plane cannot move"));
    for shutter in ["-1", "nan", "[1, 0]", "[0, inf]", "1e9"] {
        assert!(
            refusal(&format!("[shots.s]\ncamera.shutter = {shutter}")).contains("a shutter opens before it closes")
        );
    }
    assert!(refusal("[shots.s]\ncamera.shutter = \"long\"").contains("a number of frames, or [open, close]"));
    assert!(refusal("[shots.s]\ncamera.shutter = [0, 1, 2]").contains("invalid length 3"));
    assert!(refusal("[shots.s]\n[[shots.s.keys]]\nframe = 1\ncamera.frame = 2").contains("for shots without keys"));
    assert!(refusal("[shots.s]\ncamera.frame = inf").contains("must be finite"));
}

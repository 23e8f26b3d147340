//! The filter against what the tracer sees through the same lens, on the project's own scenes.
//!
//! Every rung of the ladder has floors; a filter that took tilt, swing or defocus with the wrong sign would fall through
//! them, and that is shown.

mod support {
    pub(crate) mod score;
    pub(crate) mod shots;
    pub(crate) mod table;
    pub(crate) mod traced;
}

use compare::MaskKind;
use filter::{LensRaysSettings, Method};
use glam::DVec3;
use optics::{ApertureShape, Camera, Focus};
use support::score::Score;
use support::shots::{Filtered, RUNGS, filtered, rung};
use support::table::Table;
use support::traced::{Traced, mirrored, scene, with_iris, with_shape};

/// How far below its floor a filter with a wrong sign must fall, dB: ten times the error.
const WIDE_DB: f64 = 10.0;

#[test]
fn every_rung_reaches_its_floors() {
    let mut table = Table::new("Filter against the tracer at 320x180, PSNR in dB without the truth's noise");
    let mut failures = Vec::new();
    for Filtered { shot, traced, scores } in filtered() {
        let radius = traced.masks.largest_coc_radius_px().expect("a depth");
        let share = 100.0 * traced.masks.share(MaskKind::Edges);
        let noise = traced.noise_db();
        table.note(&format!("largest radius {radius:.1} px, edges {share:.1} % of the pixels, noise {noise:.1} dB"));
        for (i, (how, score)) in RUNGS.into_iter().zip(scores).enumerate() {
            let floor = shot.floor(i);
            table.row(shot.name, how, *score, Some(floor));
            failures.extend(score.shortfalls(&format!("{}, {how}", shot.name), floor));
        }
    }
    table.print();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The figures have the noise taken off by two halves; at a quarter of the error what is left of it moves them by 0.1 dB.
#[test]
fn the_noise_of_every_truth_lies_6_db_below_the_error_of_the_truest_rung() {
    for Filtered { shot, traced, scores } in filtered() {
        let (noise, error) = (traced.noise_db(), scores.iter().map(Score::all).fold(0.0, f64::max));
        assert!(noise >= error + 6.0, "{}: noise {noise:.2} dB, error {error:.2} dB", shot.name);
    }
}

#[test]
fn a_truer_rung_is_nearer_to_the_truth() {
    for Filtered { shot, scores, .. } in filtered() {
        for i in 1..RUNGS.len() {
            let (before, after) = (scores[i - 1].all(), scores[i].all());
            assert!(after > before, "{}: {} {after:.2} dB, {} {before:.2} dB", shot.name, RUNGS[i], RUNGS[i - 1]);
        }
    }
}

/// Knowing what pixels are made of beats taking them apart by guesses.
#[test]
fn the_rest_of_pixels_makes_edges_truer() {
    /// Half of what was measured, or more: 0.4 and 0.7 on the landscape, 1.1 to 4.1 on the simple scene. dB.
    const GAIN_DB: [f64; 2] = [0.2, 0.8];
    let mut table = Table::new("Two layers, with and without the rest of pixels");
    for Filtered { shot, traced, scores } in filtered() {
        let without = traced.score_of(&traced.frame.clone().without_rest(), &traced.camera, rung(3));
        table.row(shot.name, "rest unknown", without, None);
        table.row(shot.name, RUNGS[3], scores[3], None);
        let (gain, least) =
            (scores[3].edges() - without.edges(), GAIN_DB[usize::from(shot.name.starts_with("simple"))]);
        assert!(gain >= least, "{}: {gain:.2} dB", shot.name);
    }
    table.print();
}

/// What is left of the truest rung where a plane of focus has other signs than the truth's.
fn check_flipped(sign: DVec3, is_turned: impl Fn(DVec3) -> bool, least_shots: usize) {
    let turned: Vec<_> = filtered().iter().filter(|shot| is_turned(shot.traced.camera.focus.w())).collect();
    assert!(turned.len() >= least_shots, "{} shots have something to flip", turned.len());
    let mut table = Table::new(&format!("Plane of focus w times {sign}"));
    for Filtered { shot, traced, .. } in &turned {
        let mut camera = traced.camera;
        camera.focus = Focus::new(camera.focus.w() * sign).expect("a plane of focus");
        let (score, floor) = (traced.score_of(&traced.frame, &camera, rung(3)), shot.floor(3));
        table.row(shot.name, RUNGS[3], score, Some(floor));
        assert!(score.all() < floor.all() - WIDE_DB, "{}: {:.2} dB with a wrong sign", shot.name, score.all());
    }
    table.print();
}

#[test]
fn a_tilt_of_the_wrong_sign_falls_through_the_floor() {
    check_flipped(DVec3::new(1.0, -1.0, 1.0), |w| w.y != 0.0, 5);
}

#[test]
fn a_swing_of_the_wrong_sign_falls_through_the_floor() {
    check_flipped(DVec3::new(-1.0, 1.0, 1.0), |w| w.x.abs() > 1e-6, 1);
}

/// Mirrored about the plane of focus every pixel has the blur it had, of the other sign: what stood before the plane is
/// behind it. The interior cannot tell, since a disc is the same upside down; edges can, since what hid is hidden.
#[test]
fn a_defocus_of_the_wrong_sign_falls_through_the_floor_at_edges() {
    /// How far below its floor, dB: twice the error. Measured: 4.5 on simple/tilt, 7.8 and more on the others.
    const WIDE_AT_EDGES_DB: f64 = 4.0;
    let mut table = Table::new("Depth mirrored about the plane of focus: defocus of the wrong sign");
    let mut mirrors = 0;
    for Filtered { shot, traced, .. } in filtered() {
        // On the miniature some of the mirrored ground would be behind the camera
        let Some(frame) = mirrored(&traced.frame, &traced.camera) else { continue };
        let (score, floor) = (traced.score_of(&frame, &traced.camera, rung(3)), shot.floor(3));
        table.row(shot.name, RUNGS[3], score, Some(floor));
        mirrors += 1;
        let edges = score.edges();
        assert!(edges < floor.edges() - WIDE_AT_EDGES_DB, "{}: {edges:.2} dB with a wrong sign", shot.name);
    }
    table.print();
    assert_eq!(mirrors, 6);
}

/// A three-bladed iris is not the same upside down, and so the interior too can tell the sign of D.
#[test]
fn a_defocus_of_the_wrong_sign_turns_a_three_bladed_iris_upside_down() {
    /// Measured less the slack of the shots' floors.
    const FLOOR: Score = Score([48.6, 47.0, 52.2]);
    /// How far below its floor, dB: four times the error. Measured: 7.9.
    const WIDE_DB: f64 = 6.0;
    let blades = |rotation| ApertureShape::polygon(3, rotation).expect("three blades");
    let traced = Traced::new(&scene("landscape"), "miniature", 128, |camera| with_shape(camera, blades(0.3)));
    let upside_down = with_shape(&traced.camera, blades(0.3 + std::f64::consts::PI));
    let right = traced.score(rung(3));
    let wrong = traced.score_of(&traced.frame, &upside_down, rung(3));
    let mut table = Table::new("Three blades");
    table.row("landscape/miniature", "as traced", right, Some(FLOOR));
    table.row("landscape/miniature", "upside down", wrong, None);
    table.print();
    let short = right.shortfalls("three blades", FLOOR);
    assert!(short.is_empty(), "{}", short.join("\n"));
    assert!(wrong.all() < FLOOR.all() - WIDE_DB, "{:.2} dB with a wrong sign", wrong.all());
}

/// The truth can tell how an anamorphic lens squeezes its iris, and every method follows.
#[test]
fn the_wrong_squeeze_of_an_anamorphic_lens_falls_through_the_floor() {
    /// Measured less the slack of the shots' floors: merged, lens rays.
    const FLOORS: [Score; 2] = [Score([52.1, 50.6, 55.5]), Score([52.2, 51.1, 54.1])];
    let squeezed = |camera: &Camera, squeeze| with_iris(camera, camera.iris.squeezed(squeeze).expect("a squeeze"));
    let traced = Traced::new(&scene("landscape"), "miniature", 128, |camera| squeezed(camera, 2.0));
    let mut table = Table::new("A 2x anamorphic lens");
    for (method, floor) in [rung(3), Method::LensRays(LensRaysSettings::default())].into_iter().zip(FLOORS) {
        let right = traced.score(method);
        table.row("landscape/miniature", method.name(), right, Some(floor));
        let short = right.shortfalls(method.name(), floor);
        assert!(short.is_empty(), "{}", short.join("\n"));
        for squeeze in [1.0, 0.5] {
            let wrong = traced.score_of(&traced.frame, &squeezed(&traced.camera, squeeze), method);
            table.row("landscape/miniature", &format!("{}, squeeze {squeeze}", method.name()), wrong, None);
            assert!(wrong.all() < floor.all() - WIDE_DB, "{:.2} dB with a squeeze of {squeeze}", wrong.all());
        }
    }
    table.print();
}

//! What moves do, and that boxes hold what moves.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::*;

fn at(frame: f64, translate: [f64; 3], turn: f64) -> MoveKey {
    let rotate = Some(DVec3::new(0.0, turn, 0.0));
    MoveKey { frame, translate: Some(DVec3::from_array(translate)), rotate, scale: None }
}

#[test]
fn a_turn_is_a_turn_at_every_time_and_no_mixture_of_matrices() {
    let moves = Moves::new(&[at(0.0, [0.0; 3], 0.0), at(4.0, [0.0; 3], TAU)], false).unwrap();
    for i in 0..=40 {
        let frame = 0.1 * f64::from(i);
        let found = moves.at(frame).transform_point3(DVec3::X);
        let (sine, cosine) = (frame * FRAC_PI_2).sin_cos();
        assert!(found.distance(DVec3::new(cosine, 0.0, -sine)) < 1e-12, "{frame}: {found}");
    }
    assert!(!moves.is_still([3.9, 4.1]) && moves.is_still([4.0, 9.0]) && moves.is_still([-2.0, 0.0]));
}

#[test]
fn a_key_that_says_nothing_of_a_number_lets_it_go_on() {
    let scaled = MoveKey { frame: 5.0, scale: Some(DVec3::splat(2.0)), ..MoveKey::default() };
    let moves = Moves::new(&[at(0.0, [0.0; 3], 0.0), scaled, at(10.0, [10.0, 0.0, 0.0], 0.0)], false).unwrap();
    assert_eq!(moves.at(5.0).translation, DVec3::new(5.0, 0.0, 0.0));
    // And the first stands for rest
    assert_eq!([0.0, 2.5, 9.0].map(|frame| moves.at(frame).matrix3.x_axis.x), [1.0, 1.5, 2.0]);
    assert_eq!(moves.frames(), [0.0, 10.0]);
}

#[test]
fn a_wheel_rolls_on_a_car_on_a_turntable() {
    // Maps apply from the innermost: turned about its axle, then at the car's end, then driven, then turned
    let wheel = Moves::new(&[at(0.0, [0.0; 3], 0.0), at(1.0, [0.0; 3], FRAC_PI_2)], false).unwrap();
    let drive = Moves::new(&[at(0.0, [0.0; 3], 0.0), at(1.0, [3.0, 0.0, 0.0], 0.0)], false).unwrap();
    let motion = Motion::new()
        .placed(DAffine3::from_rotation_y(FRAC_PI_2))
        .moved(&Arc::new(drive))
        .placed(DAffine3::from_translation(DVec3::Z))
        .moved(&Arc::new(wheel));
    // X, turned to -Z, at the car's end to 0, driven to 3 X, turned to -3 Z
    let found = motion.at(1.0).transform_point3(DVec3::X);
    assert!(found.distance(DVec3::new(0.0, 0.0, -3.0)) < 1e-12, "{found}");
    let rest = motion.rest().transform_point3(DVec3::ZERO);
    assert!(rest.distance(DVec3::X) < 1e-12, "{rest}");
    assert_eq!((motion.frames(), motion.moves()), (Some([0.0, 1.0]), true));
}

#[test]
fn a_box_holds_what_moves_in_it_at_every_time() {
    let mut state = 9_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) / (1_u64 << 52) as f64 - 1.0
    };
    for case in 0..60 {
        let mut vector = |size: f64| DVec3::new(size * random(), size * random(), size * random());
        // Up to several turns between keys: no sample of the times would do by itself
        let keys: Vec<_> = (0..4)
            .map(|i| MoveKey {
                frame: f64::from(i),
                translate: Some(vector(3.0)),
                rotate: Some(vector(9.0)),
                scale: Some(DVec3::ONE + vector(0.5)),
            })
            .collect();
        let moves = Arc::new(Moves::new(&keys, case % 2 == 0).unwrap());
        let inner = Arc::new(Moves::new(&keys[1..3], case % 3 == 0).unwrap());
        let motion = Motion::new().moved(&moves).placed(DAffine3::from_translation(vector(2.0))).moved(&inner);
        let sides = [-DVec3::ONE - vector(0.5), DVec3::ONE + vector(0.5)];
        let [open, close] = [0.3, 2.6];
        let bounds = motion.bounds(sides, [open, close]);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..=4000 {
            let map = motion.at(open + (close - open) * f64::from(i) / 4000.0);
            for corner in 0..8 {
                let pick = |axis: usize| sides[corner >> axis & 1][axis];
                let point = map.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
                (low, high) = (low.min(point), high.max(point));
            }
        }
        let [least, most] = [bounds.low, bounds.high].map(|side| glam::Vec3::from(side).as_dvec3());
        assert!(low.cmpge(least).all() && high.cmple(most).all(), "case {case}: {low} {high} beyond {bounds:?}");
        // And not much more, though things turn many times as fast as anything does
        assert!((most - least).max_element() < 2.0 * (high - low).max_element(), "case {case}: {bounds:?}");
    }
}

#[test]
fn moves_that_cannot_be_are_refused_in_a_sentence() {
    let says = |keys: &[MoveKey]| Moves::new(keys, false).unwrap_err().to_string();
    let key = at(0.0, [0.0; 3], 0.0);
    assert!(says(&[]).contains("number of moves"));
    assert!(says(&[MoveKey { frame: f64::NAN, ..key }]).contains("frame of a move is NaN"));
    assert!(says(&[key, MoveKey { frame: -1.0, ..key }]).contains("later than that of the move before"));
    assert!(says(&[key, key]).contains("later"));
    assert!(says(&[at(0.0, [f64::NAN, 0.0, 0.0], 0.0)]).contains("translate of a move is NaN"));
    assert!(says(&[at(0.0, [0.0, -1e13, 0.0], 0.0)]).contains("at most 1e12"));
    assert!(says(&[at(0.0, [0.0; 3], f64::INFINITY)]).contains("angle"));
    for bad in [0.0, -1.0, f64::NAN, 1e9] {
        let keys = [
            MoveKey { scale: Some(DVec3::ONE), ..key },
            MoveKey { frame: 1.0, scale: Some(DVec3::new(1.0, bad, 1.0)), ..key },
        ];
        assert!(says(&keys).contains("scale of a move"), "{bad}");
    }
    // A way may be possible by itself, but not where it is put
    let far = Arc::new(Moves::new(&[at(0.0, [1e12, 0.0, 0.0], 0.0)], false).unwrap());
    let put = Motion::new().placed(DAffine3::from_scale(DVec3::splat(1e6))).moved(&far);
    assert!(put.check(1.0).unwrap_err().to_string().contains("distance that a moving thing goes"));
    assert!(Motion::new().placed(DAffine3::from_scale(DVec3::ZERO)).moved(&far).check(1.0).is_err());
    assert!(Motion::new().moved(&far).check(1.0).is_ok());
}

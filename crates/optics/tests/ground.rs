//! The ground is found where there is one, among things that stand on it, noise and sky; and not where there is none.

use glam::{DVec2, DVec3};
use optics::{Film, Focus, Ground};

/// Uniform numbers in [0, 1), the same every time.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// What a camera sees that looks down by `pitch` from `height` above a floor: boxes on `share` of the pixels, sky above.
fn seen(pitch: f64, height: f64, boxes: f64, noise: f64) -> (DVec3, Vec<(DVec2, f64)>) {
    // The floor's normal, away from the lens, in camera space
    let down = DVec3::new(0.0, -pitch.cos(), pitch.sin());
    let w = down / height;
    let mut number = numbers();
    let mut samples = Vec::new();
    for i in 0..60 {
        for j in 0..80 {
            let q = DVec2::new(f64::from(j) / 79.0 - 0.5, 0.375 - f64::from(i) / 79.0);
            let floor = w.dot(q.extend(1.0)).max(0.0);
            let block = if number() < boxes { number() } else { 0.0 };
            let inverse = (floor * (1.0 + block)) * (1.0 + noise * (number() - 0.5));
            samples.push((q, inverse));
        }
    }
    (w, samples)
}

#[test]
fn the_ground_is_found_among_boxes_and_noise() {
    for (pitch_deg, boxes, noise, tolerance) in [
        (20.0, 0.0, 0.0, 1e-9),
        // What stands on the ground lower than the 1 % within which samples agree pulls it up by less than that
        (5.0, 0.3, 0.0, 6e-3),
        (30.0, 0.5, 0.01, 6e-3),
        (55.0, 0.6, 0.01, 6e-3),
        // A guessed depth, up to 5 % off: the plane is no worse than its samples, low boxes among them
        (25.0, 0.3, 0.1, 5e-2),
    ] {
        let (w, samples) = seen(f64::to_radians(pitch_deg), 1.6, boxes, noise);
        let ground = Ground::find(&samples).expect("a ground");
        let off = (ground.plane().w() - w).length() / w.length();
        assert!(off <= tolerance, "{pitch_deg} degrees: off by {off}");
        assert!((ground.height() / 1.6 - 1.0).abs() <= 2.0 * tolerance);
        assert_eq!(Some(ground), Ground::find(&samples), "the same samples give the same ground");
    }
}

#[test]
fn a_wall_a_ceiling_and_noise_are_no_ground() {
    let samples = |inverse: &mut dyn FnMut(DVec2) -> f64| -> Vec<(DVec2, f64)> {
        let grid = (0..2400).map(|i| DVec2::new(f64::from(i % 60) / 60.0 - 0.5, f64::from(i / 60) / 60.0 - 0.3));
        grid.map(|q| (q, inverse(q))).collect()
    };
    assert_eq!(Ground::find(&samples(&mut |q| 0.3 + 0.1 * q.x)), None, "a wall");
    assert_eq!(Ground::find(&samples(&mut |q| 0.1 + 0.4 * q.y)), None, "a ceiling");
    let mut number = numbers();
    assert_eq!(Ground::find(&samples(&mut |_| 0.05 + number())), None, "noise");
    assert_eq!(Ground::find(&samples(&mut |_| 0.0)), None, "sky");
    assert_eq!(Ground::find(&[]), None);
}

#[test]
fn a_plane_that_stands_on_the_ground_is_square_to_it_and_holds_its_point() {
    let (w, samples) = seen(0.4, 2.0, 0.0, 0.0);
    let ground = Ground::find(&samples).unwrap();
    let q = DVec2::new(0.1, -0.05);
    let depth = 1.0 / w.dot(q.extend(1.0));
    let standing = ground.standing_at(q, depth).unwrap();
    const ROUNDING: f64 = 1e-9;
    assert!(standing.w().normalize().dot(w.normalize()).abs() < ROUNDING, "square to the ground");
    assert!(standing.defocus(q, 1.0 / depth).abs() < ROUNDING, "through the point");
    assert!(standing.w().x.abs() < ROUNDING, "no swing for a level camera");
    assert!(ground.standing_at(q, f64::INFINITY).is_err());
}

#[test]
fn two_pixels_fix_tilt_and_focus_without_swing() {
    let picks = [(DVec2::new(0.2, -0.2), 1.5), (DVec2::new(-0.3, 0.1), f64::INFINITY)];
    let focus = Focus::through_two_pixels(picks).unwrap();
    assert_eq!(focus.w().x, 0.0);
    for (q, depth) in picks {
        assert!(focus.defocus(q, 1.0 / depth).abs() < 1e-12); // rounding of f64
    }
    let level = [(DVec2::new(0.2, 0.1), 1.5), (DVec2::new(-0.3, 0.1), 2.0)];
    let error = Focus::through_two_pixels(level).unwrap_err().to_string();
    assert!(error.contains("same height"), "{error}");
}

#[test]
fn the_median_of_grounds_is_not_moved_by_one_that_is_wrong() {
    let found =
        |pitch: f64, height: f64, noise: f64| Ground::find(&seen(pitch, height, 0.2, noise).1).expect("a ground");
    let good = [found(0.4, 1.6, 0.002), found(0.4, 1.6, 0.004), found(0.4, 1.6, 0.0), found(0.4, 1.6, 0.006)];
    let wrong = found(0.7, 1.1, 0.0);
    let median = Ground::median(&[good[0], wrong, good[1], good[2], good[3]]).expect("five grounds");
    let film = Film::new(DVec2::new(-0.5, -0.375), DVec2::new(0.5, 0.375), 80, 60).unwrap();
    // No farther from the truth than the worst of the good ones
    let truth = good[2];
    let worst = good.iter().map(|ground| truth.difference(ground, &film)).fold(0.0, f64::max);
    assert!(truth.difference(&median, &film) <= worst + 1e-12 && truth.difference(&wrong, &film) > 0.2);
    assert_eq!(Ground::median(&[]), None);
    // The ends of the way are the grounds, its middle is between them
    assert_eq!((truth.toward(&wrong, 0.0), truth.toward(&wrong, 1.0)), (truth, wrong));
    let half = truth.toward(&wrong, 0.5).plane().w();
    assert!((half - 0.5 * (truth.plane().w() + wrong.plane().w())).length() < 1e-12);
}

//! Sampling, density and share belong together.

use std::f32::consts::PI;

use super::*;
use crate::transport::albedo::Albedo;

/// Numbers that fill the unit square evenly (Roberts' R2 sequence), and a third.
fn numbers(i: u32) -> (f32, Vec2) {
    let of = |step: f64| ((0.5 + step * f64::from(i)).fract()) as f32;
    (of(0.819_172_513_396_164_4), Vec2::new(of(0.671_043_606_703_789_4), of(0.549_700_477_901_970_3)))
}

fn cases(coat: &Albedo) -> Vec<Bsdf<'_>> {
    let mut cases = vec![Bsdf::Matte(Vec3::new(0.8, 0.5, 0.2))];
    for (metallic, roughness) in [(0.0, 0.35), (0.0, 0.8), (1.0, 0.3), (1.0, 0.9), (0.4, 0.5)] {
        cases.push(Bsdf::Glossy(Glossy { color: Vec3::new(0.9, 0.6, 0.3), metallic, roughness, ior: 1.5, coat }));
    }
    cases
}

fn directions() -> [Vec3; 3] {
    [0.1_f32, 0.8, 1.3].map(|angle| Vec3::new(angle.sin() * 0.6, angle.sin() * 0.8, angle.cos()))
}

/// Cells of the hemisphere, equal in cosine and turn.
const CELLS: [usize; 2] = [10, 16];

fn cell(direction: Vec3) -> usize {
    let turn = direction.y.atan2(direction.x) / std::f32::consts::TAU + 0.5;
    let along = ((direction.z * CELLS[0] as f32) as usize).min(CELLS[0] - 1);
    along * CELLS[1] + ((turn * CELLS[1] as f32) as usize).min(CELLS[1] - 1)
}

/// Pearson's test at 1 % for all cases together (each at 1 % over the number of cases).
#[test]
fn samples_fall_as_often_as_their_density_says() {
    const COUNT: u32 = 40_000;
    let coat = Albedo::of_dielectric(1.5);
    for (case, o) in cases(&coat).into_iter().flat_map(|case| directions().map(|o| (case, o))) {
        // Independent numbers: chi-square knows nothing of even ones
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32) / (1 << 24) as f32
        };
        let mut counts = vec![0.0; CELLS[0] * CELLS[1]];
        let mut lost = 0.0;
        for _ in 0..COUNT {
            match case.sample(o, random(), Vec2::new(random(), random())) {
                Some(scattered) => counts[cell(scattered.direction)] += 1.0,
                None => lost += 1.0,
            }
        }
        // The density over each cell, by 16 x 16 midpoints
        let (mut chi, mut degrees, mut rest) = (0.0, -1.0, [lost, f64::from(COUNT)]);
        for (i, &found) in counts.iter().enumerate() {
            let mut mean = 0.0;
            for k in 0..1024 {
                let z = ((i / CELLS[1]) as f32 + ((k / 32) as f32 + 0.5) / 32.0) / CELLS[0] as f32;
                let turn = ((i % CELLS[1]) as f32 + ((k % 32) as f32 + 0.5) / 32.0) / CELLS[1] as f32;
                let (sine, cosine) = ((turn - 0.5) * std::f32::consts::TAU).sin_cos();
                let r = (1.0 - z * z).sqrt();
                mean += f64::from(case.pdf(o, Vec3::new(r * cosine, r * sine, z))) / 1024.0;
            }
            let expected = f64::from(COUNT) * mean * f64::from(2.0 * PI) / counts.len() as f64;
            rest[1] -= expected;
            if expected >= 10.0 {
                chi += (found - expected).powi(2) / expected;
                degrees += 1.0;
            } else {
                rest[0] += found;
                rest[1] += expected;
            }
        }
        // What is lost below the horizon, and cells that hardly any fall into, together
        if rest[1] >= 10.0 {
            chi += (rest[0] - rest[1]).powi(2) / rest[1];
            degrees += 1.0;
        }
        // Wilson and Hilferty: the quantile of 1 - 0.01 / 18 is 3.26 standard deviations of the cube root
        let d: f64 = degrees;
        let limit = d * (1.0 - 2.0 / (9.0 * d) + 3.26 * (2.0 / (9.0 * d)).sqrt()).powi(3);
        assert!(chi < limit, "{case:?} from {o}: chi-square {chi:.1} of {degrees} degrees, limit {limit:.1}");
    }
}

#[test]
fn weights_are_share_over_density() {
    let coat = Albedo::of_dielectric(1.5);
    for (case, o) in cases(&coat).into_iter().flat_map(|case| directions().map(|o| (case, o))) {
        for i in 0..500 {
            let (lobe, u) = numbers(i);
            let Some(scattered) = case.sample(o, lobe, u) else { continue };
            assert!((scattered.direction.length() - 1.0).abs() < 1e-4);
            let share = case.share(o, scattered.direction);
            let pdf = case.pdf(o, scattered.direction);
            let expected = share / pdf;
            assert!((scattered.pdf / pdf - 1.0).abs() < 1e-3, "{case:?}");
            assert!(
                (scattered.weight - expected).abs().max_element() < 1e-3 * (1.0 + expected.max_element()),
                "{case:?}"
            );
        }
    }
}

/// Lambert's part and each facet take as much of light from a to b as from b to a; only what makes up for the light that
/// facets of a metal reflect to each other does not, by design (Turquin).
#[test]
fn coats_are_reciprocal() {
    let coat = Albedo::of_dielectric(1.5);
    for case in cases(&coat).into_iter().filter(|case| !matches!(case, Bsdf::Glossy(Glossy { metallic: 0.1.., .. }))) {
        let [a, b, c] = directions();
        for (o, i) in [(a, b), (b, c), (a, c)] {
            let (one, other) = (case.share(o, i) / i.z, case.share(i, o) / o.z);
            assert!((one - other).abs().max_element() < 1e-4 * one.max_element(), "{case:?}: {one} {other}");
        }
    }
}

#[test]
fn a_mirror_goes_straight_back_and_glass_bends_by_snell() {
    let o = Vec3::new(0.6, 0.0, 0.8);
    let coat = Albedo::of_dielectric(1.5);
    let mirror = Glossy { color: Vec3::ONE, metallic: 1.0, roughness: 0.0, ior: 1.5, coat: &coat };
    let scattered = Bsdf::Glossy(mirror).sample(o, 0.3, Vec2::splat(0.5)).unwrap();
    assert_eq!((scattered.direction, scattered.weight, scattered.pdf), (Vec3::new(-0.6, 0.0, 0.8), Vec3::ONE, 0.0));
    let glass = Bsdf::Glass { tint: Vec3::ONE, eta: 1.5, thin: false };
    let through = glass.sample(o, 0.99, Vec2::splat(0.5)).unwrap();
    assert!((through.direction.x + 0.6 / 1.5).abs() < 1e-6 && through.direction.z < 0.0);
    // From inside beyond the critical angle everything is reflected
    let inside = Bsdf::Glass { tint: Vec3::ONE, eta: 1.0 / 1.5, thin: false };
    let steep = Vec3::new(0.8, 0.0, 0.6);
    assert_eq!(inside.sample(steep, 0.999_99, Vec2::ZERO).unwrap().direction, Vec3::new(-0.8, 0.0, 0.6));
}

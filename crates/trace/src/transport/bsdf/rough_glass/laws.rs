//! Sampling, density, share and energy of rough glass.

use std::f32::consts::{PI, TAU};

use super::*;
use crate::transport::albedo::PERFECT;
use crate::transport::bsdf::Bsdf;

/// Numbers that fill the unit square evenly (Roberts' R2 sequence), and a third.
fn numbers(i: u32) -> (f32, Vec2) {
    let of = |step: f64| ((0.5 + step * f64::from(i)).fract()) as f32;
    (of(0.819_172_513_396_164_4), Vec2::new(of(0.671_043_606_703_789_4), of(0.549_700_477_901_970_3)))
}

fn directions() -> [Vec3; 3] {
    [0.1_f32, 0.7, 1.3].map(|angle| Vec3::new(angle.sin() * 0.6, angle.sin() * 0.8, angle.cos()))
}

/// Tables of entering and leaving.
fn tables() -> [Albedo; 2] {
    [RoughGlass::kept(1.5), RoughGlass::kept(1.0 / 1.5)]
}

fn cases([entering, leaving]: &[Albedo; 2]) -> Vec<RoughGlass<'_>> {
    let tint = Vec3::ONE;
    let of = |roughness: f32| {
        let thin: &Albedo = &PERFECT;
        [
            RoughGlass { tint, eta: 1.5, thin: false, roughness, kept: entering },
            RoughGlass { tint, eta: 1.0 / 1.5, thin: false, roughness, kept: leaving },
            RoughGlass { tint, eta: 1.5, thin: true, roughness, kept: thin },
        ]
    };
    [0.5, 0.7, 0.9].into_iter().flat_map(of).collect()
}

/// Pearson's test at 1 % for all cases together.
#[test]
fn samples_fall_on_both_sides_as_often_as_their_density_says() {
    const COUNT: u32 = 40_000;
    const CELLS: [usize; 2] = [16, 12];
    let tables = tables();
    for (glass, o) in cases(&tables).into_iter().flat_map(|glass| directions().map(|o| (glass, o))) {
        // Independent numbers: chi-square knows nothing of even ones
        let mut state = 11_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32) / (1 << 24) as f32
        };
        let (mut counts, mut lost) = (vec![0.0; CELLS[0] * CELLS[1]], 0.0);
        for _ in 0..COUNT {
            match glass.sample(o, random(), Vec2::new(random(), random())) {
                Some(Scattered { direction, .. }) => {
                    let turn = direction.y.atan2(direction.x) / TAU + 0.5;
                    let along = ((0.5 * (direction.z + 1.0) * CELLS[0] as f32) as usize).min(CELLS[0] - 1);
                    counts[along * CELLS[1] + ((turn * CELLS[1] as f32) as usize).min(CELLS[1] - 1)] += 1.0;
                }
                None => lost += 1.0,
            }
        }
        // The density over each cell, equal in cosine and turn, by 64 x 64 midpoints
        const FINE: usize = 64;
        let (mut chi, mut degrees, mut rest) = (0.0, -1.0, [lost, f64::from(COUNT)]);
        for (cell, &found) in counts.iter().enumerate() {
            let mut mean = 0.0;
            for k in 0..FINE * FINE {
                let place = |k: usize| (k as f32 + 0.5) / FINE as f32;
                let z = 2.0 * ((cell / CELLS[1]) as f32 + place(k / FINE)) / CELLS[0] as f32 - 1.0;
                let turn = ((cell % CELLS[1]) as f32 + place(k % FINE)) / CELLS[1] as f32;
                let (sine, cosine) = ((turn - 0.5) * TAU).sin_cos();
                let r = (1.0 - z * z).sqrt();
                mean += f64::from(glass.pdf(o, Vec3::new(r * cosine, r * sine, z))) / (FINE * FINE) as f64;
            }
            let expected = f64::from(COUNT) * mean * f64::from(4.0 * PI) / counts.len() as f64;
            rest[1] -= expected;
            if expected >= 10.0 {
                chi += (found - expected).powi(2) / expected;
                degrees += 1.0;
            } else {
                rest[0] += found;
                rest[1] += expected;
            }
        }
        if rest[1] >= 10.0 {
            chi += (rest[0] - rest[1]).powi(2) / rest[1];
            degrees += 1.0;
        }
        // Wilson and Hilferty: the quantile of 1 - 0.01 / 27 is 3.37 standard deviations of the cube root
        let d: f64 = degrees;
        let limit = d * (1.0 - 2.0 / (9.0 * d) + 3.37 * (2.0 / (9.0 * d)).sqrt()).powi(3);
        assert!(chi < limit, "{glass:?} from {o}: chi-square {chi:.1} of {degrees} degrees, limit {limit:.1}");
    }
}

#[test]
fn weights_are_share_over_density() {
    let tables = tables();
    let mut through = 0;
    for (glass, o) in cases(&tables).into_iter().flat_map(|glass| directions().map(|o| (glass, o))) {
        for i in 0..400 {
            let (lobe, u) = numbers(i);
            let Some(scattered) = glass.sample(o, lobe, u) else { continue };
            let expected = glass.share(o, scattered.direction) / glass.pdf(o, scattered.direction);
            // A half vector of nearly opposite directions loses digits
            assert!(
                (scattered.weight - expected).abs().max_element() < 5e-3 * expected.max_element(),
                "{glass:?} {scattered:?}"
            );
            through += u32::from(scattered.direction.z < 0.0);
        }
    }
    assert!(through > 2000, "{through}");
}

/// As much of light goes from a to b as from b to a, times the square of the ratio of indices, once what makes up for lost light is
/// taken out.
#[test]
fn light_goes_both_ways_but_for_the_square_of_the_index() {
    let tables = tables();
    let plain = |glass: &RoughGlass<'_>, o: Vec3, i: Vec3| glass.share(o, i).x / (glass.gain(o) * i.z.abs());
    let [a, b, c] = directions();
    for glass in cases(&tables) {
        for (o, i) in [(a, b), (b, c), (a, c)] {
            let (one, other) = (plain(&glass, o, i), plain(&glass, i, o));
            assert!((one - other).abs() <= 1e-3 * one, "{glass:?}: {one} {other}");
            // From below: the frame of the other side has its z there
            let below = Vec3::new(-0.6 * i.x, -0.6 * i.y, -(1.0 - 0.36 * (i.x * i.x + i.y * i.y)).sqrt());
            let kept = if glass.eta > 1.0 { &tables[1] } else { &tables[0] };
            let back = RoughGlass {
                eta: if glass.thin { glass.eta } else { 1.0 / glass.eta },
                kept: if glass.thin { glass.kept } else { kept },
                ..glass
            };
            let index = if glass.thin { 1.0 } else { glass.eta * glass.eta };
            let (one, other) = (plain(&glass, o, below), plain(&back, mirrored(below), mirrored(o)));
            assert!((index * one - other).abs() <= 2e-3 * other, "{glass:?}: {one} {other}");
        }
    }
}

#[test]
fn nothing_is_lost_and_nothing_gained() {
    /// What the tables are wrong by.
    const TABLES: f32 = 0.005;
    let tables = tables();
    for (glass, o) in cases(&tables).into_iter().flat_map(|glass| directions().map(|o| (glass, o))) {
        let total = |i: u32| {
            let (lobe, u) = numbers(i);
            // Radiance that enters another index is compressed; energy is not
            glass.sample(o, lobe, u).map_or(0.0, |scattered| {
                let index = if scattered.direction.z < 0.0 && !glass.thin { glass.eta * glass.eta } else { 1.0 };
                scattered.weight.x * index
            })
        };
        let mean = (0..20_000).map(total).sum::<f32>() / 20_000.0;
        assert!((mean - 1.0).abs() < TABLES, "{glass:?} from {o}: {mean}");
    }
    // By itself single scattering at full roughness keeps nine tenths straight on and half of it aslant
    let [straight, _, aslant] = directions().map(|o| tables[0].share(1.0, o.z));
    assert!((0.85..0.93).contains(&straight) && (0.5..0.57).contains(&aslant), "{straight} {aslant}");
}

#[test]
fn the_smoother_the_nearer_to_polished_glass() {
    let o = Vec3::new(0.6, 0.0, 0.8);
    let kept = RoughGlass::kept(1.5);
    let polished = Bsdf::Glass { tint: Vec3::ONE, eta: 1.5, thin: false };
    let mut before = f32::INFINITY;
    for roughness in [0.3, 0.1, 0.04] {
        let glass = RoughGlass { tint: Vec3::ONE, eta: 1.5, thin: false, roughness, kept: &kept };
        let (mut off, mut share, mut count) = (0.0, 0.0, 0.0_f32);
        for i in 0..4000 {
            let (lobe, u) = numbers(i);
            let (Some(rough), Some(smooth)) = (glass.sample(o, lobe, u), polished.sample(o, lobe, u)) else { continue };
            share += f32::from(u8::from(rough.direction.z > 0.0)) - f32::from(u8::from(smooth.direction.z > 0.0));
            if rough.direction.z * smooth.direction.z > 0.0 {
                off += rough.direction.distance_squared(smooth.direction);
                count += 1.0;
                let energy = (rough.weight - smooth.weight).abs().max_element();
                assert!(energy < 0.6 * roughness + 0.004, "{roughness}: {rough:?} {smooth:?}");
            }
        }
        let spread = (off / count).sqrt();
        // A facet's normal is off by about alpha, a reflection by twice that
        assert!(spread < 4.0 * roughness * roughness && spread < before, "{roughness}: {spread}");
        assert!((share / 4000.0).abs() < 0.1 * roughness, "{roughness}: {share}");
        before = spread;
    }
}

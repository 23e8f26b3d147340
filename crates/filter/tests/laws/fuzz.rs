//! No depth and no colour makes a pixel that is not a number, or light from nothing.

use filter::Method;
use rgbd::{Frame, Layer, Picture, PixelRest, PixelWindow, Plane};

use crate::scenes::{all_methods, filtered, lenses, noise, over};

const DISPLAY: PixelWindow = PixelWindow { x: -3, y: 5, width: 45, height: 37 };
const SEEDS: u32 = 12;

/// Taking a silhouette apart gives each surface at most this much of the brightest colour: what is left over of a pixel of
/// colour 1 between a near guess of 1 and a far one of 0 with equal shares is 1/2, and each side takes it whole.
const OVERSHOOT: f32 = 1.5;

/// A depth that a file might hold: patches, steps, ramps and noise of any size, values that are no depth at all.
fn depth(x: i32, y: i32, seed: u32) -> f32 {
    let patch = 1 + (noise(0, 0, seed) * 9.0) as i32;
    let n = noise(x.div_euclid(patch), y.div_euclid(patch), seed + 1);
    let odd = [
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        0.0,
        -0.0,
        -1.0,
        1e-45,
        1e-38,
        1e-30,
        1e-12,
        1e-3,
        65504.0,
        1e10,
        1e38,
        f32::MAX,
    ];
    // How much of the picture is odd differs from seed to seed
    let share = noise(1, 0, seed);
    if n < share * share {
        return odd[(noise(x.div_euclid(patch), y.div_euclid(patch), seed + 2) * odd.len() as f32) as usize];
    }
    let ramp = 1.0 + 0.05 * (x as f32 * noise(2, 0, seed) + y as f32 * noise(3, 0, seed));
    ramp * (1.0 + 8.0 * n) * (1.0 + 0.02 * noise(x, y, seed + 3) * noise(4, 0, seed))
}

/// Colours from `least` to 65504, most of them small.
fn color(x: i32, y: i32, seed: u32, least: f32, alpha: bool) -> [f32; 4] {
    let lit =
        |c: u32| least + (65504.0 - least) * noise(x, y, seed + 10 + c).powi(1 + (40.0 * noise(5, 0, seed)) as i32);
    [lit(0), lit(1), lit(2), if alpha { noise(x, y, seed + 14).powi(20) } else { 1.0 }]
}

/// Two layers; alpha is 1 or anything.
fn frame(seed: u32, least: f32, alpha: bool) -> Frame {
    let layer = |salt: u32| {
        let color = Picture::from_fn(DISPLAY.grown(2, 7), |x, y| color(x, y, seed + salt, least, alpha));
        Layer::from_raw_depth(color, Plane::from_fn(DISPLAY.grown(2, 7), |x, y| depth(x, y, seed + salt)))
    };
    Frame::new(DISPLAY, vec![layer(0), layer(50)]).unwrap()
}

fn for_all(alpha: bool, least: f32, check: impl Fn(&Method, u32, &Frame, &Picture)) {
    for seed in (0..SEEDS).map(|seed| 1000 * seed) {
        let frame = frame(seed, least, alpha);
        for lens in &lenses()[1..5] {
            for method in all_methods() {
                check(&method, seed, &frame, &filtered(&frame, &over(DISPLAY, lens), &method));
            }
        }
    }
}

#[test]
fn no_depth_makes_a_pixel_that_is_not_finite() {
    for_all(true, 0.0, |method, seed, _, picture| {
        let bad = picture.planes().iter().flat_map(Plane::values).filter(|v| !v.is_finite() || **v < 0.0).count();
        assert!(bad == 0, "{method:?}, seed {seed}: {bad} values");
    });
}

#[test]
fn no_rest_of_pixels_makes_one_that_is_not_finite_or_brighter_than_a_share_of_it_may_be() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 0.5, 1.0, 65504.0, 1e38];
    let any = |x: i32, y: i32, salt: u32| odd[(noise(x, y, salt) * odd.len() as f32) as usize];
    for (seed, lens) in (0..SEEDS).zip(lenses().into_iter().cycle()) {
        let rest = |x, y| {
            let share = if noise(x, y, seed + 90) < 0.2 { any(x, y, seed + 91) } else { noise(x, y, seed + 92) };
            let rgba = [any(x, y, seed + 93), any(x, y, seed + 94), any(x, y, seed + 95), share];
            let depth = if noise(x, y, seed + 96) < 0.5 { any(x, y, seed + 97) } else { depth(x, y, seed + 98) };
            (noise(x, y, seed + 99) < 0.5).then_some(PixelRest { rgba, depth })
        };
        let frame = frame(seed, 0.0, false).with_rest(rest);
        for method in all_methods() {
            let picture = filtered(&frame, &over(DISPLAY, &lens), &method);
            // A share of 0.02 is the least that counts
            let is_good = |c: f32| (-1e-3..=51.0 * 65504.0).contains(&c);
            let bad = picture.planes().iter().flat_map(Plane::values).find(|&&c| !is_good(c));
            assert_eq!(bad, None, "{} on seed {seed}", method.name());
        }
    }
}

#[test]
fn no_pixel_is_brighter_or_darker_than_all_that_it_is_made_of() {
    const ROUNDING: f32 = 1e-5;
    for_all(false, 0.5, |method, seed, frame, picture| {
        let is_unmixed = matches!(method, Method::Gather(_) | Method::Merged(_) | Method::LensRays(_));
        let overshoot = if is_unmixed { OVERSHOOT } else { 1.0 };
        for c in 0..3 {
            let given = frame.layers().iter().flat_map(|layer| layer.color.planes()[c].values().iter());
            let (low, high) = given.fold((f32::INFINITY, 0.0_f32), |(low, high), &v| (low.min(v), high.max(v)));
            let found = picture.planes()[c].values();
            let (least, most) =
                found.iter().fold((f32::INFINITY, 0.0_f32), |(low, high), &v| (low.min(v), high.max(v)));
            assert!(
                least >= if overshoot > 1.0 { 0.0 } else { low * (1.0 - ROUNDING) },
                "{method:?}, seed {seed}: {least}, given {low}"
            );
            assert!(most <= high * (overshoot + ROUNDING), "{method:?}, seed {seed}: {most}, given {high}");
        }
        let opaque = picture.planes()[3].values().iter().map(|a| (a - 1.0).abs()).fold(0.0, f32::max);
        assert!(opaque < ROUNDING, "{method:?}, seed {seed}: alpha off by {opaque}");
    });
}

//! What the noise of a picture is said to be is what it is, and samples that are put where they count leave no bias.
#![allow(clippy::print_stdout)] // tests say what they measured

mod lit_spheres;

use std::sync::LazyLock;

use lit_spheres::{WINDOW, camera, scene};
use rgbd::{Picture, PixelWindow, Silent, Truth};
use trace::{Accumulation, Goal, Job};

const SEEDS: u64 = 64;
const NOISE: f64 = 0.05;

/// The picture with 32,768 samples per pixel, whose noise is a hundredth of that of the others.
static REFERENCE: LazyLock<Picture> =
    LazyLock::new(|| trace::truth(&scene(), &camera(), WINDOW, 1 << 15, 1000, &Silent).unwrap().picture());

/// One render by the way under test.
fn to_noise(seed: u64) -> Accumulation {
    let mut job = Job::new(camera(), WINDOW, seed);
    job.run(&scene(), &Goal::Noise { rmse: NOISE, most: 1 << 14 }, &Silent).unwrap();
    job.into_sums()
}

/// The classical way, in which each pixel goes on until its own halves agree.
fn until_own_halves_agree(seed: u64) -> Accumulation {
    let scene = scene();
    let mut sums = trace::render(&scene, &camera(), &WINDOW.into(), 0..4, seed, &Silent).unwrap();
    for _ in 0..7 {
        let [a, b] = sums.to_truth().unwrap().halves;
        let counts = sums.clone();
        let wanted = |x: i32, y: i32| {
            let agrees = (0..3).all(|c| (a.at(x, y)[c] - b.at(x, y)[c]).abs() < 0.05);
            let [count, _] = counts.samples_at(x, y);
            let end = if agrees { count } else { 2 * count };
            [0..end, 0..end]
        };
        sums.extend(&scene, &wanted, &Silent).unwrap();
    }
    sums
}

/// The picture in twelve squares of 64 pixels, whose errors are independent of each other.
fn squares() -> impl Iterator<Item = PixelWindow> {
    let place = |i: i32| PixelWindow { x: i % 4 * 8, y: i / 4 * 8, width: 8, height: 8 };
    (0..12).map(place)
}

/// Of each square, the sum of the errors of its pixels (R + G + B), and the variance that the halves state for it.
fn errors(truth: &Truth) -> Vec<[f64; 2]> {
    let picture = truth.picture();
    let sum = |p: [f32; 4]| p[..3].iter().map(|&v| f64::from(v)).sum::<f64>();
    let [a, b] = &truth.halves;
    let of = |square: PixelWindow| {
        let error: f64 = square.pixels().map(|(x, y)| sum(picture.at(x, y)) - sum(REFERENCE.at(x, y))).sum();
        let stated = square.pixels().map(|(x, y)| (0.5 * (sum(a.at(x, y)) - sum(b.at(x, y)))).powi(2)).sum();
        [error, stated]
    };
    squares().map(of).collect()
}

/// What 64 renders tell.
struct Statistics {
    /// Sum over seeds and squares of error^2 / stated variance: chi square of 64 * 12 = 768 degrees of freedom.
    chi_square: f64,
    /// |t| of the mean error of the whole picture.
    t: f64,
}

fn statistics(render: impl Fn(u64) -> Accumulation) -> Statistics {
    let all: Vec<_> = (1..=SEEDS).map(|seed| errors(&render(seed).to_truth().unwrap())).collect();
    let n = SEEDS as f64;
    let mut chi_square = 0.0;
    for square in 0..12 {
        let squares = all.iter().map(|errors| errors[square][0].powi(2)).sum::<f64>();
        let stated = all.iter().map(|errors| errors[square][1]).sum::<f64>() / n;
        chi_square += squares / stated;
    }
    let of_picture: Vec<f64> = all.iter().map(|errors| errors.iter().map(|[error, _]| error).sum()).collect();
    let mean = of_picture.iter().sum::<f64>() / n;
    let variance = of_picture.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Statistics { chi_square, t: mean.abs() / (variance / n).sqrt() }
}

/// Chi square of 768 degrees of freedom lies between these with 99 %: 768 +- 2.576 sqrt(2 * 768), skewness aside.
const CHI_SQUARE: [f64; 2] = [667.0, 869.0];

/// |t| of 63 degrees of freedom is below this with 99 %.
const T: f64 = 2.656;

#[test]
fn samples_where_they_count_leave_the_noise_honest_and_the_mean_unbiased() {
    let Statistics { chi_square, t } = statistics(to_noise);
    println!("chi square {chi_square:.0}, |t| {t:.2}");
    assert!((CHI_SQUARE[0]..CHI_SQUARE[1]).contains(&chi_square), "chi square {chi_square:.0}");
    assert!(t < T, "|t| {t:.2}");
}

#[test]
fn a_fixed_number_of_samples_is_honest_too() {
    let fixed = |seed| trace::render(&scene(), &camera(), &WINDOW.into(), 0..64, seed, &Silent).unwrap();
    let Statistics { chi_square, t } = statistics(fixed);
    println!("chi square {chi_square:.0}, |t| {t:.2}");
    assert!((CHI_SQUARE[0]..CHI_SQUARE[1]).contains(&chi_square), "chi square {chi_square:.0}");
    assert!(t < T, "|t| {t:.2}");
}

#[test]
fn the_test_finds_out_pixels_that_decide_over_themselves() {
    let Statistics { chi_square, t } = statistics(until_own_halves_agree);
    println!("chi square {chi_square:.0}, |t| {t:.2}");
    assert!(chi_square > CHI_SQUARE[1], "chi square {chi_square:.0}: the stated noise is far too low");
    assert!(t > T, "|t| {t:.2}: lights that were missed at first are too dark");
}

#[test]
fn the_noise_is_reached_with_fewer_samples_than_the_same_number_everywhere_takes() {
    let sums = to_noise(3);
    assert!(sums.noise() <= NOISE, "{}", sums.noise());
    assert!(sums.noise() > 0.6 * NOISE, "{}: far more samples than were needed", sums.noise());
    let of_all = sums.samples() as f64 / (2 * WINDOW.area()) as f64;
    let fixed = trace::render(&scene(), &camera(), &WINDOW.into(), 0..of_all.ceil() as u32, 3, &Silent).unwrap();
    assert!(fixed.noise() > 1.2 * sums.noise(), "{} against {} with {of_all:.0}", fixed.noise(), sums.noise());
}

#[test]
fn the_limit_of_samples_is_kept() {
    let mut job = Job::new(camera(), WINDOW, 3);
    job.run(&scene(), &Goal::Noise { rmse: 1e-6, most: 100 }, &Silent).unwrap();
    assert!(WINDOW.pixels().all(|(x, y)| job.sums().samples_at(x, y) == [100; 2]));
}

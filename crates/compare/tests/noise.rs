//! The reference's noise drops out of the corrected error; where it covers the error this is said.
//!
//! Each statistical test states how often it would fail for a correct implementation with a random seed.

use compare::{Comparison, CorrectedError, GivenNoise, MaskKind, Masks, Reference};
use rgbd::{Picture, PixelWindow, Truth};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 24, height: 24 };
const SIGMA: f64 = 0.05;

/// SplitMix64, and normal numbers from it by Box and Muller.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

fn clean() -> Picture {
    Picture::from_fn(WINDOW, |x, y| [0.2 + 0.01 * x as f32, 0.5, 0.1 + 0.02 * y as f32, 1.0])
}

/// The clean picture plus noise of standard deviation `SIGMA` for 16 samples, the same in R and G, own in B.
fn noisy(random: &mut Random, samples: u32) -> Picture {
    let clean = clean();
    let sigma = SIGMA * (16.0 / f64::from(samples)).sqrt();
    Picture::from_fn(WINDOW, |x, y| {
        let [r, g, b, a] = clean.at(x, y);
        let (rg, own) = ((sigma * random.normal()) as f32, (sigma * random.normal()) as f32);
        [r + rg, g + rg, b + own, a]
    })
}

fn truth(random: &mut Random, samples: [u32; 2]) -> Reference {
    let halves = samples.map(|n| noisy(random, n));
    Reference::from_truth(&Truth { display: WINDOW, camera: None, halves, samples }).unwrap()
}

/// A candidate that is wrong in a quarter of its columns; its mean square error against the clean picture.
fn wrong(by: f32) -> (Picture, f64) {
    let clean = clean();
    let picture = Picture::from_fn(WINDOW, |x, y| {
        let [r, g, b, a] = clean.at(x, y);
        if x % 4 == 0 { [r + by, g - by, b + 0.5 * by, a] } else { [r, g, b, a] }
    });
    (picture, f64::from(by).powi(2) * 2.25 / 3.0 / 4.0)
}

fn compare(reference: &Reference, candidate: &Picture) -> Comparison {
    Comparison::new(reference, candidate, &Masks::without_depth(WINDOW)).unwrap()
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

#[test]
fn the_corrected_error_is_free_of_bias_and_knows_its_own_scatter() {
    const TRIALS: usize = 300;
    for samples in [[16, 16], [24, 8]] {
        let mut random = Random(7);
        let (candidate, error) = wrong(0.2);
        let (mut corrected, mut stated, mut plain) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..TRIALS {
            let figures = compare(&truth(&mut random, samples), &candidate).all().clone();
            let CorrectedError::Above { mse, uncertainty } = figures.corrected else { panic!("an error of {error}") };
            corrected.push(mse);
            stated.push(uncertainty);
            plain.push(figures.mse);
        }

        // 4 standard errors of the mean: false alarm 6e-5
        let (mean, deviation) = spread(&corrected);
        let standard_error = deviation / (TRIALS as f64).sqrt();
        assert!((mean - error).abs() < 4.0 * standard_error, "{mean} instead of {error} +- {standard_error}");

        // The control: the plain error holds the noise, and the test sees it
        assert!(spread(&plain).0 - error > 10.0 * standard_error, "the plain error should be too large");

        // The standard deviation of n normal values is itself known to 1 / sqrt(2 n) = 4 %: 4 of those, false alarm 6e-5
        let ratio = spread(&stated).0 / deviation;
        assert!((ratio - 1.0).abs() < 4.0 * 0.041, "stated over seen scatter is {ratio} for {samples:?} samples");
    }
}

#[test]
fn the_noise_that_is_reported_is_that_of_the_mean() {
    // 2304 independent values in 2 trials know their mean square to sqrt(2 / 2304) = 3 %, with 2 equal channels 4 %:
    // 4 of those, false alarm 6e-5
    let masks = Masks::without_depth(WINDOW);
    for (samples, seed) in [([16, 16], 1), ([48, 16], 2)] {
        let total = samples.iter().sum::<u32>();
        let reference = truth(&mut Random(seed), samples);
        let expected = SIGMA * SIGMA * 16.0 / f64::from(total);
        let found = reference.noise_mse(&masks, MaskKind::All).unwrap();
        assert!((found / expected - 1.0).abs() < 0.23, "{found} instead of {expected}");
    }
}

#[test]
fn a_perfect_candidate_is_below_the_noise() {
    // A perfect candidate passes for wrong in 0.13 % of all cases: more than 4 of 300, false alarm 7e-5
    let mut random = Random(11);
    let candidate = clean();
    let seen: Vec<CorrectedError> =
        (0..300).map(|_| compare(&truth(&mut random, [16, 16]), &candidate).all().corrected).collect();
    let alarms = seen.iter().filter(|error| matches!(error, CorrectedError::Above { .. })).count();
    assert!(alarms <= 4, "{alarms} of 300");
    for error in seen {
        if let CorrectedError::BelowNoise { at_most } = error {
            assert!(at_most > 0.0 && at_most < SIGMA * SIGMA, "{at_most}");
            assert_eq!(error.psnr_db(), None, "no meaningless figure");
        }
    }
}

#[test]
fn a_given_noise_is_subtracted_and_hides_what_is_smaller() {
    let mut random = Random(5);
    let noise = GivenNoise { all: Some(SIGMA * SIGMA), ..GivenNoise::default() };
    let reference = Reference::from_picture(&noisy(&mut random, 16), WINDOW, noise).unwrap();
    let (far_off, error) = wrong(0.5);
    let figures = compare(&reference, &far_off).all().clone();
    let CorrectedError::Above { mse, .. } = figures.corrected else { panic!("{:?}", figures.corrected) };
    assert!((mse - (figures.mse - SIGMA * SIGMA)).abs() < 1e-12);
    // The product of error and noise scatters by 2 SIGMA sqrt(error 5/6 / pixels) (R and G go opposite ways): 4 of those
    assert!((mse - error).abs() < 4.0 * 2.0 * SIGMA * (error / WINDOW.area() as f64).sqrt(), "{mse} for {error}");
    assert!(matches!(compare(&reference, &clean()).all().corrected, CorrectedError::BelowNoise { .. }));
}

#[test]
fn an_unknown_noise_is_said_to_be_unknown() {
    let reference = Reference::from_picture(&clean(), WINDOW, GivenNoise::default()).unwrap();
    assert_eq!(compare(&reference, &wrong(0.1).0).all().corrected, CorrectedError::UnknownNoise);
    let bad = GivenNoise { edges: Some(-1.0), ..GivenNoise::default() };
    let error = Reference::from_picture(&clean(), WINDOW, bad).unwrap_err();
    assert_eq!(error.to_string(), "the noise MSE of edges is -1; it must be 0 or positive");
}

//! What must hold for any two pictures.

use compare::{CompareError, Comparison, CorrectedError, GivenNoise, MaskKind, Masks, Reference};
use rgbd::{Picture, PixelWindow, Truth};

const WINDOW: PixelWindow = PixelWindow { x: -3, y: 7, width: 40, height: 30 };

fn plasma(window: PixelWindow) -> Picture {
    Picture::from_fn(window, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let wave = |k: f32| 0.4 + 0.3 * (0.3 * x + k * y).sin();
        [wave(0.1), wave(0.5), wave(0.9), 1.0]
    })
}

fn compare(reference: &Picture, candidate: &Picture) -> Comparison {
    let reference = Reference::from_picture(reference, WINDOW, GivenNoise::default()).unwrap();
    Comparison::new(&reference, candidate, &Masks::without_depth(WINDOW)).unwrap()
}

fn offset(picture: &Picture, by: f32) -> Picture {
    Picture::from_fn(picture.window(), |x, y| picture.at(x, y).map(|value| value + by))
}

#[test]
fn a_picture_equals_itself_in_every_figure() {
    let picture = plasma(WINDOW);
    let all = compare(&picture, &picture).all().clone();
    assert_eq!([all.mse, all.mae, all.bias, all.rel_mse, all.flip_ldr, all.flip_hdr], [0.0; 6]);
    assert_eq!(all.ssim, 1.0);
    assert_eq!(all.psnr_db(), f64::INFINITY);
    assert_eq!((all.pixels, all.share), (WINDOW.area(), 1.0));
}

#[test]
fn a_constant_offset_has_the_error_of_its_size() {
    const BY: f32 = 0.125; // a power of two: sums with it lose at most the last digit of a pixel
    const ROUNDING: f64 = 1e-6;
    let picture = plasma(WINDOW);
    let all = compare(&picture, &offset(&picture, BY)).all().clone();
    assert!((all.mse - 1.0 / 64.0).abs() < ROUNDING && (all.rmse() - 0.125).abs() < ROUNDING);
    assert!((all.psnr_db() - 10.0 * 64.0_f64.log10()).abs() < 1e-4);
    assert!((all.mae - 0.125).abs() < ROUNDING && (all.bias - 0.125).abs() < ROUNDING);
    let darker = compare(&picture, &offset(&picture, -BY)).all().clone();
    assert!((darker.bias + 0.125).abs() < ROUNDING, "the sign of the bias is that of the candidate's excess");
}

#[test]
fn rel_mse_forgives_errors_in_the_light() {
    const FLOAT_INPUT: f64 = 1e-6;
    let of_level = |level: f32| {
        let flat = Picture::filled(WINDOW, [level, level, level, 1.0]);
        compare(&flat, &offset(&flat, 0.5)).all().rel_mse
    };
    assert!((of_level(0.0) - 25.0).abs() < FLOAT_INPUT, "0.25 / 0.01");
    assert!((of_level(2.0) - 0.25 / 4.01).abs() < FLOAT_INPUT, "0.25 / (4 + 0.01)");
}

#[test]
fn ldr_flip_ssim_and_mse_do_not_mind_which_picture_comes_first() {
    const F32_ROUNDING: f64 = 1e-6;
    let (a, b) = (plasma(WINDOW), offset(&plasma(WINDOW), 0.07));
    let (ab, ba) = (compare(&a, &b).all().clone(), compare(&b, &a).all().clone());
    assert!(ab.flip_ldr > 0.01 && (ab.flip_ldr - ba.flip_ldr).abs() < F32_ROUNDING);
    assert!(ab.ssim < 0.999 && (ab.ssim - ba.ssim).abs() < F32_ROUNDING);
    assert_eq!((ab.mse, ab.mae, ab.bias), (ba.mse, ba.mae, -ba.bias));
}

#[test]
fn flip_grows_with_the_error_and_stays_in_its_range() {
    let picture = plasma(WINDOW);
    let errors = [0.01, 0.03, 0.1, 0.3].map(|by| compare(&picture, &offset(&picture, by)).all().flip_ldr);
    assert!(errors.is_sorted() && errors[0] > 0.0, "{errors:?}");
    let black = Picture::filled(WINDOW, [0.0, 0.0, 0.0, 1.0]);
    let light = compare(&black, &Picture::filled(WINDOW, [1e30, 1e30, 1e30, 1.0]));
    assert!(light.all().flip_hdr <= 1.0 && light.all().flip_hdr > 0.5, "a black reference has exposures too");
}

#[test]
fn only_the_display_window_counts() {
    let overscan = WINDOW.grown(9, 4);
    let mut candidate = plasma(overscan);
    for (x, y) in overscan.pixels().filter(|&(x, y)| !WINDOW.contains(x, y)) {
        candidate.set(x, y, [1e6, f32::NAN, -3.0, 1.0]);
    }
    let comparison = compare(&plasma(WINDOW), &candidate);
    assert_eq!((comparison.all().mse, comparison.non_finite), (0.0, 0));
}

#[test]
fn pixels_that_are_no_numbers_are_counted_and_taken_as_black() {
    let reference = plasma(WINDOW);
    let mut candidate = reference.clone();
    candidate.set(0, 10, [f32::NAN, 0.3, 0.3, 1.0]);
    candidate.set(1, 10, [0.3, f32::INFINITY, f32::NEG_INFINITY, 1.0]);
    let comparison = compare(&reference, &candidate);
    assert_eq!(comparison.non_finite, 2);
    let lost = |x| reference.at(x, 10)[..3].iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
    let expected = (lost(0) + lost(1)) / (3.0 * WINDOW.area() as f64);
    assert!((comparison.all().mse - expected).abs() < 1e-12, "{}", comparison.all().mse);
    assert!(comparison.all().flip_hdr.is_finite() && comparison.all().ssim.is_finite());
}

#[test]
fn windows_that_do_not_match_are_refused_with_their_sizes() {
    let picture = plasma(PixelWindow { width: 39, ..WINDOW });
    let reference = Reference::from_picture(&plasma(WINDOW), WINDOW, GivenNoise::default()).unwrap();
    let error = Comparison::new(&reference, &picture, &Masks::without_depth(WINDOW)).unwrap_err();
    assert_eq!(error.to_string(), "the candidate covers 39x30 at (-3, 7); the comparison needs 40x30 at (-3, 7)");
    let masks = Masks::without_depth(PixelWindow::of_size(40, 30));
    let error = Comparison::new(&reference, &plasma(WINDOW), &masks).unwrap_err();
    assert!(matches!(error, CompareError::WindowMismatch { .. }), "{error}");
    let nothing = PixelWindow { width: 0, ..WINDOW };
    let error = Reference::from_picture(&plasma(WINDOW), nothing, GivenNoise::default()).unwrap_err();
    assert_eq!(error, CompareError::NoPixel(nothing));
}

#[test]
fn the_same_bits_on_one_thread_and_on_three() {
    let (reference, candidate) = (plasma(WINDOW), offset(&plasma(WINDOW), 0.02));
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compare(&reference, &candidate))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_truth_of_equal_halves_without_noise_gives_the_plain_error() {
    let (half, candidate) = (plasma(WINDOW), offset(&plasma(WINDOW), 0.25));
    let halves = [half.clone(), half];
    let truth = Truth { display: WINDOW, camera: None, halves, samples: [8, 8] };
    let reference = Reference::from_truth(&truth).unwrap();
    let comparison = Comparison::new(&reference, &candidate, &Masks::without_depth(WINDOW)).unwrap();
    let CorrectedError::Above { mse, uncertainty } = comparison.all().corrected else { panic!("an error of 0.25") };
    assert!((mse - comparison.all().mse).abs() < 1e-9 && uncertainty == 0.0);
    assert_eq!(reference.noise_mse(&Masks::without_depth(WINDOW), MaskKind::All), Some(0.0));
}

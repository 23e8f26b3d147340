//! Figures of two formulas, held to scikit-image 0.26 and to the reference implementation of FLIP (flip-evaluator 1.7).

use compare::{Comparison, GivenNoise, Masks, Reference};
use rgbd::{Picture, PixelWindow};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 64, height: 48 };

/// What FLIP must agree to: both work in f32, where a power of 0.7 or 0.5 magnifies the last digits of small errors.
const FLIP_TOLERANCE: f64 = 1e-4;
/// Single pixels of FLIP scatter a little more than their mean.
const FLIP_PIXEL_TOLERANCE: f32 = 5e-4;
/// SSIM is f64 in both, from f32 pictures; the map is stored as f32.
const SSIM_TOLERANCE: f64 = 1e-6;
/// Sums of f32 inputs in f64.
const SUM_TOLERANCE: f64 = 1e-6;

fn wave(x: f64, y: f64, c: f64) -> f64 {
    0.5 + 0.45 * (0.37 * x + 0.21 * y + 2.1 * c).sin()
}

fn picture(value: impl Fn(f64, f64, f64) -> f64) -> Picture {
    Picture::from_fn(WINDOW, |x, y| {
        let [r, g, b] = [0.0, 1.0, 2.0].map(|c| value(f64::from(x), f64::from(y), c) as f32);
        [r, g, b, 1.0]
    })
}

fn lit(x: f64, y: f64, c: f64) -> f64 {
    if (x, y) == (20.0, 10.0) { 100.0 } else { 8.0 * wave(x, y, c).powi(3) }
}

struct Expected {
    mse: f64,
    rel_mse: f64,
    mae: f64,
    /// Mean of the whole map, and without the five border pixels that scikit-image leaves out of its own mean.
    ssim: [f64; 2],
    flip: [f64; 2],
    /// LDR-FLIP, HDR-FLIP and SSIM at three pixels: the upper left, one beside the lights, the lower right corner.
    at: [(i32, i32, f32, f32, f32); 3],
    exposures: (f64, f64, u32),
}

fn assert_figures(reference: &Picture, candidate: &Picture, expected: &Expected) {
    let reference = Reference::from_picture(reference, WINDOW, GivenNoise::default()).unwrap();
    let comparison = Comparison::new(&reference, candidate, &Masks::without_depth(WINDOW)).unwrap();
    let all = comparison.all();

    // Means
    for (what, found, wanted, relative) in [
        ("MSE", all.mse, expected.mse, SUM_TOLERANCE),
        ("relMSE", all.rel_mse, expected.rel_mse, SUM_TOLERANCE),
        ("MAE", all.mae, expected.mae, SUM_TOLERANCE),
        ("SSIM", all.ssim, expected.ssim[0], SSIM_TOLERANCE),
        ("LDR-FLIP", all.flip_ldr, expected.flip[0], FLIP_TOLERANCE),
        ("HDR-FLIP", all.flip_hdr, expected.flip[1], FLIP_TOLERANCE),
    ] {
        let tolerance = if what.contains("FLIP") { relative } else { relative * wanted };
        assert!((found - wanted).abs() <= tolerance, "{what} is {found}, the reference says {wanted}");
    }
    let inner = PixelWindow { x: 5, y: 5, width: WINDOW.width - 10, height: WINDOW.height - 10 };
    let cropped: f64 = comparison.ssim.cropped(inner).values().iter().map(|&s| f64::from(s)).sum();
    assert!((cropped / inner.area() as f64 - expected.ssim[1]).abs() < SSIM_TOLERANCE);

    // Single pixels: a transposed or shifted map has the same mean
    for (x, y, ldr, hdr, ssim) in expected.at {
        for (found, wanted, tolerance) in [
            (comparison.flip_ldr.at(x, y), ldr, FLIP_PIXEL_TOLERANCE),
            (comparison.flip_hdr.at(x, y), hdr, FLIP_PIXEL_TOLERANCE),
            (comparison.ssim.at(x, y), ssim, 1e-5),
        ] {
            assert!((found - wanted).abs() < tolerance, "({x}, {y}): {found}, the reference says {wanted}");
        }
    }

    let (start, stop, count) = expected.exposures;
    assert!((comparison.exposures.start - start).abs() < 1e-5, "{:?}", comparison.exposures);
    assert!((comparison.exposures.stop - stop).abs() < 1e-5, "{:?}", comparison.exposures);
    assert_eq!(comparison.exposures.count, count);
}

#[test]
fn waves_in_the_range_of_a_display() {
    let expected = Expected {
        mse: 1.973_467_340e-2,
        rel_mse: 1.898_183_821e-1,
        mae: 1.263_272_274e-1,
        ssim: [0.829_315_133, 0.832_012_175],
        flip: [0.548_258_4, 0.457_830_8],
        at: [
            (7, 5, 0.666_581_5, 0.622_104_8, 0.840_035_2),
            (20, 10, 0.605_987_1, 0.656_093_8, 0.837_935_5),
            (63, 47, 0.703_125_2, 0.772_249_7, 0.819_131_3),
        ],
        exposures: (1.473_809_242, 2.088_364_363, 2),
    };
    let candidate = picture(|x, y, c| 0.97 * wave(x + 1.5, y - 0.5, c) + 0.01 * c);
    assert_figures(&picture(wave), &candidate, &expected);
}

#[test]
fn a_light_of_a_hundred_in_a_picture_of_high_range() {
    let expected = Expected {
        mse: 2.111_837_229e-1,
        rel_mse: 1.350_360_975e-2,
        mae: 2.729_051_924e-1,
        ssim: [0.995_371_406, 0.995_212_928],
        flip: [0.051_538_7, 0.059_944_0],
        at: [
            (7, 5, 0.187_264_62, 0.163_310_83, 0.995_180_7),
            (20, 10, 0.024_517_32, 0.024_804_51, 0.996_326),
            (63, 47, 0.123_023_79, 0.261_569_4, 0.994_477_9),
        ],
        exposures: (-5.560_559_273, 0.322_743_326, 6),
    };
    let candidate = picture(|x, y, c| lit(x, y, c) * (1.0 + 0.2 * (0.11 * x * y).sin()));
    assert_figures(&picture(lit), &candidate, &expected);
}

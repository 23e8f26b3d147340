//! Figures and masks of the shared reference pictures, held to other people's implementations.

mod shared;

use compare::{Comparison, GivenNoise, MaskKind, Masks, Reference};

/// FLIP and SSIM maps of the reference implementations, averaged in f64. (FLIP's own mean is a running f32 sum, off by
/// 2e-4 at 1280x720.)
const TOLERANCE: f64 = 1e-4;

fn compared(reference: &str, candidate: &str) -> Option<Comparison> {
    let (reference, candidate) = (shared::load(reference)?.0, shared::load(candidate)?.0);
    let display = reference.window();
    let reference = Reference::from_picture(&reference, display, GivenNoise::default()).unwrap();
    Some(Comparison::new(&reference, &candidate, &Masks::without_depth(display)).unwrap())
}

#[test]
fn a_pinhole_against_a_lens_on_three_scenes() {
    // MSE, SSIM, LDR-FLIP, HDR-FLIP
    for (lens, pinhole, expected) in [
        ("simple_untilted", "simple_pinhole", [7.628_740_36e-3, 0.817_450_26, 0.120_219_7, 0.125_203_7]),
        ("simple_tilt", "simple_pinhole", [2.500_782_54e-4, 0.989_920_99, 0.014_710_5, 0.020_488_2]),
        ("landscape_reverse", "landscape_pinhole", [2.698_029_60e-3, 0.818_630_32, 0.146_178_3, 0.157_884_5]),
    ] {
        let paths = [lens, pinhole].map(|name| format!("reference/{name}_ref.exr"));
        let Some(comparison) = compared(&paths[0], &paths[1]) else { return };
        let all = comparison.all();
        let [mse, ssim, ldr, hdr] = expected;
        assert!((all.mse / mse - 1.0).abs() < 1e-6, "{lens}: MSE {}", all.mse);
        assert!((all.ssim - ssim).abs() < 1e-5, "{lens}: SSIM {}", all.ssim);
        assert!((all.flip_ldr - ldr).abs() < TOLERANCE, "{lens}: LDR-FLIP {}", all.flip_ldr);
        assert!((all.flip_hdr - hdr).abs() < TOLERANCE, "{lens}: HDR-FLIP {}", all.flip_hdr);
    }
}

#[test]
fn the_edge_masks_of_the_blender_scenes() {
    const PRINTED_DIGITS: f64 = 5e-5;
    for (scene, focus, aperture, largest_diameter, share) in
        [("simple", 10.0, 0.61, 39.99, 0.1032), ("occluder", 6.0, 0.0776, 39.973, 0.4305)]
    {
        let Some((picture, depth)) =
            shared::load(&format!("reference/blender/{scene}_pinhole_1280x720_64spp_RGBZ.exr"))
        else {
            return;
        };
        let (frame, camera) = shared::blender_frame(picture, depth.expect("a depth channel"), focus, aperture);
        let masks = Masks::from_frame(&frame, &camera, Some(20.0)).unwrap();
        let found = masks.share(MaskKind::Edges);
        assert!((found - share).abs() < PRINTED_DIGITS, "{scene}: {found}");
        let radius = masks.largest_coc_radius_px().unwrap();
        assert!((2.0 * radius - largest_diameter).abs() < 2e-3, "{scene}: {radius}");
        let own_reach = Masks::from_frame(&frame, &camera, None).unwrap().reach_px();
        assert_eq!(own_reach, Some(20.0), "the largest radius, rounded up, is the 20 px that were given");
    }
}

#[test]
fn the_figures_within_the_edges_of_a_blender_scene() {
    let load = |name: &str| shared::load(&format!("reference/blender/{name}.exr"));
    let Some((lens, _)) = load("simple_dof40px_reference_192spp") else { return };
    let Some((pinhole, depth)) = load("simple_pinhole_1280x720_64spp_RGBZ") else { return };
    let (frame, camera) = shared::blender_frame(pinhole.clone(), depth.expect("a depth channel"), 10.0, 0.61);
    let masks = Masks::from_frame(&frame, &camera, None).unwrap();
    let noise = GivenNoise { all: Some(9.068e-6), edges: Some(9.667e-6), interior: None };
    let reference = Reference::from_picture(&lens, lens.window(), noise).unwrap();
    let comparison = Comparison::new(&reference, &pinhole, &masks).unwrap();

    // As printed: PSNR, the same corrected for noise, relMSE, HDR-FLIP, LDR-FLIP, SSIM
    for (mask, expected) in [
        (MaskKind::All, [21.73, 21.74, 0.0693, 0.1690, 0.1565, 0.7911]),
        (MaskKind::Edges, [21.88, 21.89, 0.0713, 0.1965, 0.1755, 0.7851]),
    ] {
        let f = comparison.within(mask).expect("figures");
        let corrected = f.corrected.psnr_db().expect("an error above the noise");
        let found = [f.psnr_db(), corrected, f.rel_mse, f.flip_hdr, f.flip_ldr, f.ssim];
        for (i, (found, wanted)) in found.into_iter().zip(expected).enumerate() {
            let printed_digits = if i < 2 { 0.0051 } else { 0.000_151 };
            assert!((found - wanted).abs() < printed_digits, "{mask:?}, figure {i}: {found} instead of {wanted}");
        }
    }

    // The noise of the interior follows from the other two
    let interior = reference.noise_mse(&masks, MaskKind::Interior).expect("noise of the interior");
    assert!((8.9e-6..9.068e-6).contains(&interior), "{interior}");
}

//! The choice of a kernel, and the margin around the picture.

mod random_lens;

use glam::DVec2;
use optics::{ApertureShape, Camera, DepthRange, Footprint, KernelModel, OpticsError, Pose, Reading, ThinLens};
use proptest::prelude::*;
use random_lens::{lens_camera, q_at, raw_camera, unit_square};

proptest! {
    #[test]
    fn the_margin_holds_every_traced_hit_and_is_not_too_wide(
        (_, camera) in lens_camera(), place in unit_square(), u in unit_square(), near in 0.6..5.0f64, t in 0.0..1.0f64,
    ) {
        let depths = DepthRange::new(near, f64::INFINITY).unwrap();
        let need = camera.overscan(&depths);
        let q = q_at(&camera.film, place);
        let ray = camera.ray(q, DVec2::from_array(u), 0.0).unwrap();
        let p = camera.seen_through(q, t / near, ray.origin).unwrap();
        let pixel = camera.film.pixel_from_q(p);
        let slack = 1.001;
        prop_assert!(pixel.x >= -slack * need.left - 1e-9 && pixel.y >= -slack * need.top - 1e-9);
        prop_assert!(pixel.x <= 640.0 + slack * need.right + 1e-9 && pixel.y <= 427.0 + slack * need.bottom + 1e-9);
        // No side needs more than the largest exact blur, nor all of them less than a tenth of it
        let largest = camera.largest_coc_radius_px(&depths);
        let most = need.left.max(need.right).max(need.top).max(need.bottom);
        prop_assert!(most <= 1.5 * largest, "{need:?} {largest}");
        prop_assert!(most >= 0.1 * largest, "{need:?} {largest}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_finer_grid_finds_the_same_margin_and_the_same_errors(
        camera in raw_camera(), near in 0.3..5.0f64, range in 1.0..20.0f64,
    ) {
        let depths = DepthRange::new(near, near * range).unwrap();
        let need = camera.overscan(&depths);
        let choice = KernelModel::choose(&camera, Reading::Scatter, &depths, 0.25);
        // Three times as fine, so that it holds the coarse grid
        let mut finer = [0.0f64; 6];
        for (x, y) in (0..=96).flat_map(|y| (0..=96).map(move |x| (x, y))) {
            let q = q_at(&camera.film, [f64::from(x) / 96.0, f64::from(y) / 96.0]);
            let pixel = camera.film.pixel_from_q(q);
            for inverse_depth in depths.inverse() {
                let gather = Footprint::new(&camera, Reading::Gather, q, inverse_depth).in_pixels(&camera.film);
                let scatter = Footprint::new(&camera, Reading::Scatter, q, inverse_depth).in_pixels(&camera.film);
                let found = [
                    gather.support(DVec2::NEG_X) - pixel.x,
                    gather.support(DVec2::X) - (640.0 - pixel.x),
                    gather.support(DVec2::NEG_Y) - pixel.y,
                    gather.support(DVec2::Y) - (360.0 - pixel.y),
                    scatter.skew(),
                    scatter.skew() + scatter.foreshortening(),
                ];
                finer.iter_mut().zip(found).for_each(|(most, x)| *most = most.max(x));
            }
        }
        let coarse = [need.left, need.right, need.top, need.bottom, choice.ellipse_error_px, choice.disc_error_px];
        for (fine, coarse) in finer.into_iter().zip(coarse) {
            // The stated accuracy of the coarse grid
            prop_assert!(fine <= 1.001 * coarse + 1e-9 && coarse <= fine + 1e-9, "{finer:?} {need:?} {choice:?}");
        }
    }
}

#[test]
fn the_margin_knows_which_way_a_triangle_points() -> Result<(), OpticsError> {
    // One corner up: what is nearer than the plane of focus is seen up to r above a pixel and down to r/2 below it
    let lens = ThinLens::new(0.05, 2.0, 0.05)?.focused_at(DVec2::ZERO, f64::INFINITY)?;
    let film = lens.film([0.036, 0.024], 720, 480)?;
    let corner_up = ApertureShape::polygon(3, std::f64::consts::FRAC_PI_2)?;
    let camera = lens.camera(Pose::IDENTITY, film, lens.iris(corner_up))?;
    let depths = DepthRange::new(2.0, 4.0)?;
    let need = camera.overscan(&depths);
    let r = camera.largest_coc_radius_px(&depths);
    assert!((need.top - r).abs() < 1e-9 && (need.bottom - 0.5 * r).abs() < 1e-9, "{need:?} {r}");
    assert!((need.left - 0.75f64.sqrt() * r).abs() < 1e-9 && (need.right - need.left).abs() < 1e-9, "{need:?}");
    Ok(())
}

#[test]
fn the_margin_of_an_untilted_lens_is_its_largest_blur() -> Result<(), OpticsError> {
    let lens = ThinLens::new(0.05, 2.0, 0.05)?.focused_at(DVec2::ZERO, 2.0)?;
    let film = lens.film([0.036, 0.024], 640, 427)?;
    let camera = lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::Disc))?;
    // The sky blurs to R s/2, a surface at 1.5 m to a third of that; rows are a little finer than columns
    let depths = DepthRange::new(1.5, 10.0)?.with_sky();
    let blur = 0.0125 * film.pixels_per_q() / 2.0;
    assert!((camera.largest_coc_radius_px(&depths) - blur.max_element()).abs() < 1e-9);
    let need = camera.overscan(&depths);
    assert!((need.left - blur.x).abs() < 1e-9 && (need.right - blur.x).abs() < 1e-9, "{need:?} {blur}");
    assert!((need.top - blur.y).abs() < 1e-9 && (need.bottom - blur.y).abs() < 1e-9, "{need:?} {blur}");
    assert_eq!(need.columns(1000), blur.x.ceil() as u32);
    // The cap holds, and a pinhole needs nothing
    assert_eq!((need.columns(3), need.rows(0)), (3, 0));
    let none = camera.pinhole().overscan(&depths);
    assert_eq!((none.columns(9), none.rows(9)), (0, 0));
    Ok(())
}

#[test]
fn the_cheapest_kernel_within_the_tolerance_is_chosen() -> Result<(), OpticsError> {
    let lens = ThinLens::new(0.05, 1.4, 0.05)?.tilted(8f64.to_radians(), 0.0)?.focused_at(DVec2::ZERO, 13.2)?;
    let film = lens.film([0.036, 0.024], 1280, 853)?;
    let tilted = lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::Disc))?;
    let upright = Camera { iris: lens.upright_iris(ApertureShape::Disc), ..tilted };
    let depths = DepthRange::new(0.6, f64::INFINITY)?;
    let choose = |camera, reading, tolerance| KernelModel::choose(camera, reading, &depths, tolerance);

    // Upright: a disc for nothing
    let choice = choose(&upright, Reading::Gather, KernelModel::DEFAULT_TOLERANCE_PX);
    assert_eq!((choice.model, choice.ellipse_error_px), (KernelModel::Disc, 0.0));
    assert!(choice.disc_error_px < 1e-12, "{choice:?}");
    assert!(choice.to_string().starts_with("disc kernel: its predicted error, 0.000 px, is within"), "{choice}");
    // Tilted: an ellipse when gathered, the exact form when scattered, a disc if one does not mind
    let choice = choose(&tilted, Reading::Gather, 0.5);
    assert_eq!(choice.model, KernelModel::Ellipse, "{choice}");
    assert!(choice.to_string().contains("a disc would be off by"), "{choice}");
    let choice = choose(&tilted, Reading::Scatter, 0.5);
    assert_eq!(choice.model, KernelModel::Exact, "{choice}");
    assert!(choice.to_string().contains("and an ellipse by"), "{choice}");
    assert_eq!(choose(&tilted, Reading::Gather, 30.0).model, KernelModel::Disc);
    assert!(KernelModel::Disc < KernelModel::Exact && KernelModel::Exact.to_string() == "exact");
    Ok(())
}

//! The footprint: exact moments and bounds, and predicted departures from a disc.

mod random_lens;

use glam::{DMat2, DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Footprint, Iris, OpticsError, Pose, Reading, ThinLens};
use proptest::prelude::*;
use random_lens::{lens_camera, q_at, raw_camera, unit_square};

/// A camera whose gather footprint at q = 0 has the lean `k` along e1, towards +x, and a spread of det cos(30 degrees).
fn leaning(k: f64, shape: ApertureShape) -> Camera {
    // e1 = (cos a, 0, sin a) with a = 30 degrees, so that R w(0) sin a = k
    let iris = Iris::new(DVec3::new(-0.5, 0.0, 0.75f64.sqrt()), 1.0, shape).unwrap();
    Camera {
        pose: Pose::IDENTITY,
        film: Film::from_fov(0.5, 100, 100).unwrap(),
        focus: Focus::new(DVec3::new(0.0, 0.0, 2.0 * k)).unwrap(),
        iris,
    }
}

/// Moments of u / (1 - lean . u), by undoing the spread.
fn unit_moments(footprint: &Footprint) -> (DVec2, DMat2) {
    let moments = footprint.moments().unwrap();
    let back = footprint.spread().inverse();
    (back * moments.centroid, back * moments.covariance * back.transpose())
}

#[test]
fn moments_of_a_square_opening_are_those_of_calculus() {
    for (k, tolerance) in [(0.05, 1e-12), (0.5, 1e-12), (0.9, 1e-5)] {
        // Sides along the lean: x uniform in +-a. E[1/(1-kx)] = atanh(ka)/(ka), E[1/(1-kx)^2] = 1/(1-k^2 a^2)
        let a = 0.5f64.sqrt();
        let square = ApertureShape::polygon(4, std::f64::consts::FRAC_PI_4).unwrap();
        let footprint = Footprint::new(&leaning(k, square), Reading::Gather, DVec2::ZERO, 0.0);
        let (mean, covariance) = unit_moments(&footprint);
        let (g, h) = ((k * a).atanh() / (k * a), 1.0 / (1.0 - k * k * a * a));
        check(mean, covariance, k, [g, h, a * a / 3.0 * h], tolerance);

        // A corner along the lean: x has the density 1 - |x|, and y given x is uniform in +-(1 - |x|)
        let diamond = ApertureShape::polygon(4, 0.0).unwrap();
        let footprint = Footprint::new(&leaning(k, diamond), Reading::Gather, DVec2::ZERO, 0.0);
        let (mean, covariance) = unit_moments(&footprint);
        let (g, h) = (2.0 / k * k.atanh() + (-k * k).ln_1p() / (k * k), -(-k * k).ln_1p() / (k * k));
        check(mean, covariance, k, [g, h, covariance.y_axis.y], tolerance);
    }

    /// From g = E[1/(1-kx)] and h = E[1/(1-kx)^2]: E[x/(1-kx)] = (g - 1)/k, E[(x/(1-kx))^2] = (h - 2g + 1)/k^2.
    fn check(mean: DVec2, covariance: DMat2, k: f64, [g, h, across]: [f64; 3], tolerance: f64) {
        let centroid = (g - 1.0) / k;
        let variance = (h - 2.0 * g + 1.0) / (k * k) - centroid * centroid;
        // What the calculus itself loses to cancellation at small k
        let tolerance = tolerance.max(1e-15 / (k * k * k));
        assert!((mean - DVec2::new(centroid, 0.0)).length() < tolerance, "k = {k}: {mean} {centroid}");
        let wanted = DMat2::from_diagonal(DVec2::new(variance, across));
        assert!(covariance.abs_diff_eq(wanted, tolerance * 10.0), "k = {k}: {covariance} {wanted}");
    }
}

#[test]
fn moments_agree_with_brute_sampling() {
    // Midpoints of n x n cells: 1/n^2, magnified by 1/(1 - k)^4 where the opening nearly meets the horizon
    const N: u32 = 700;
    for blades in [0, 3, 5, 9] {
        let shape = ApertureShape::polygon(blades, 0.4).unwrap_or_default();
        for k in [-0.6, 0.0, 0.3] {
            for reading in [Reading::Gather, Reading::Scatter] {
                let footprint = Footprint::new(&leaning(k, shape), reading, DVec2::new(0.1, -0.2), 0.7);
                let (mut mean, mut square) = (DVec2::ZERO, DMat2::ZERO);
                for i in 0..N * N {
                    let u = (DVec2::new(f64::from(i % N), f64::from(i / N)) + 0.5) / f64::from(N);
                    let offset = footprint.offset(shape.sample(u)).unwrap();
                    mean += offset / f64::from(N * N);
                    square += DMat2::from_cols(offset * offset.x, offset * offset.y) * f64::from(N * N).recip();
                }
                let moments = footprint.moments().unwrap();
                let covariance = square - DMat2::from_cols(mean * mean.x, mean * mean.y);
                let size = footprint.disc_radius();
                assert!((moments.centroid - mean).length() < 1e-4 * size, "{shape:?} {k} {reading:?}");
                assert!(moments.covariance.abs_diff_eq(covariance, 1e-4 * size * size), "{shape:?} {k} {reading:?}");
            }
        }
    }
}

#[test]
fn a_disc_footprint_without_lean_has_the_variance_of_a_disc() {
    let footprint = Footprint::new(&leaning(0.0, ApertureShape::Disc), Reading::Gather, DVec2::ZERO, 2.0);
    let (mean, covariance) = unit_moments(&footprint);
    assert_eq!(mean, DVec2::ZERO);
    assert!(covariance.abs_diff_eq(DMat2::IDENTITY * 0.25, 1e-15));
}

#[test]
fn an_opening_that_meets_the_horizon_has_no_bounds_and_no_moments() {
    for shape in [ApertureShape::Disc, ApertureShape::polygon(4, 0.0).unwrap()] {
        let footprint = Footprint::new(&leaning(1.01, shape), Reading::Gather, DVec2::ZERO, 0.0);
        assert_eq!(footprint.moments(), None);
        assert_eq!(footprint.offset(DVec2::X), None);
        assert_eq!((footprint.support(DVec2::NEG_X), footprint.skew()), (f64::INFINITY, f64::INFINITY));
    }
}

/// The largest value over the outline of an opening: over all corners, or 720 points of the circle.
fn farthest(shape: ApertureShape, between: impl Fn(DVec2) -> f64) -> f64 {
    let corners: Vec<DVec2> = match shape {
        ApertureShape::Disc => (0..720).map(|i| DVec2::from_angle(f64::from(i).to_radians() / 2.0)).collect(),
        ApertureShape::Polygon { .. } => shape.corners().collect(),
    };
    corners.into_iter().map(between).fold(0.0, f64::max)
}

#[test]
fn gathering_knows_a_hundredth_of_a_pixel_of_skew_where_scattering_knows_several() -> Result<(), OpticsError> {
    // 50 mm f/1.4 tilted by 8 degrees on a 36 mm sensor 1280 pixels wide, focused at 13 m on the axis; r = 58 px
    let lens = ThinLens::new(0.05, 1.4, 0.05)?.tilted(8f64.to_radians(), 0.0)?.focused_at(DVec2::ZERO, 13.2)?;
    let film = lens.film([0.036, 0.024], 1280, 853)?;
    let camera = lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::Disc))?;
    let inverse_depth = 1.0 / 13.2 + 58.0 / (lens.aperture_radius() * film.pixels_per_q().x);
    assert!((camera.coc_radius_px(DVec2::ZERO, inverse_depth) - 58.0).abs() < 0.01);

    // The skew as the text gives it, as predicted, and as it is between the exact footprint and the ellipse
    for (reading, printed, digit) in [(Reading::Gather, 0.011, 0.0005), (Reading::Scatter, 2.6, 0.05)] {
        let footprint = Footprint::new(&camera, reading, DVec2::ZERO, inverse_depth).in_pixels(&film);
        let to_first_order = 58.0 * footprint.lean().length();
        assert!((to_first_order - printed).abs() < digit, "{reading:?}: {to_first_order}");
        // Of the tilt's direction the ellipse is shorter by cos a, the prediction does not know that
        let found =
            farthest(ApertureShape::Disc, |u| (footprint.offset(u).unwrap() - footprint.ellipse_offset(u)).length());
        assert!(found <= footprint.skew() && footprint.skew() < 1.02 * found, "{reading:?}: {found}");
    }
    Ok(())
}

#[test]
fn a_squeezed_iris_blurs_to_an_oval_of_its_proportions() -> Result<(), OpticsError> {
    let lens = ThinLens::new(0.05, 2.0, 0.05)?.focused_at(DVec2::ZERO, 4.0)?;
    let film = lens.film([0.036, 0.024], 1500, 1000)?;
    for (squeeze, half_sizes) in [(2.0, DVec2::new(0.5, 1.0)), (0.5, DVec2::new(1.0, 0.5)), (1.0, DVec2::ONE)] {
        let camera = lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::Disc).squeezed(squeeze)?)?;
        assert_eq!(camera.iris.half_sizes(), 0.0125 * half_sizes);
        // R s |D| pixels along the longer axis, in both readings, and the bound says no less
        let radius = 0.0125 * film.pixels_per_q().x * 0.25;
        assert!((camera.coc_radius_px(DVec2::ZERO, 0.5) - radius).abs() < 1e-9);
        for reading in [Reading::Gather, Reading::Scatter] {
            let footprint = Footprint::new(&camera, reading, DVec2::ZERO, 0.5).in_pixels(&film);
            for (axis, half_size) in [(DVec2::X, half_sizes.x), (DVec2::Y, half_sizes.y)] {
                assert!((footprint.support(axis) - radius * half_size).abs() < 1e-9, "{reading:?} {squeeze}");
            }
            assert_eq!(footprint.foreshortening(), 0.0);
            let covariance = footprint.moments().unwrap().covariance;
            let wanted = DMat2::from_diagonal((0.5 * radius * half_sizes).powf(2.0));
            assert!(covariance.abs_diff_eq(wanted, 1e-9), "{covariance} {wanted}");
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn skew_and_foreshortening_follow_the_closed_forms(
        (lens, camera) in lens_camera(), place in unit_square(), inverse_depth in 0.0..3.0f64,
    ) {
        let camera = Camera { iris: camera.iris.squeezed(1.0).unwrap(), ..camera };
        let at = q_at(&camera.film, place);
        let (radius, sin) = (camera.iris.radius(), lens.total_tilt().sin());
        let w = camera.focus.inverse_depth(at);
        let gather = Footprint::new(&camera, Reading::Gather, at, inverse_depth);
        prop_assert!((gather.lean().length() - radius * sin * w.abs()).abs() < 1e-12);
        let scatter = Footprint::new(&camera, Reading::Scatter, at, inverse_depth);
        let beyond = 1.0 / lens.image_distance() - (inverse_depth - w);
        prop_assert!((scatter.lean().length() - radius * sin * beyond.abs()).abs() < 1e-12);
        // The upright iris scatters with R |w_xy|
        let upright = Camera { iris: lens.upright_iris(camera.iris.shape()), ..camera };
        let scatter = Footprint::new(&upright, Reading::Scatter, at, inverse_depth);
        prop_assert!((scatter.lean().length() - radius * camera.focus.w().truncate().length()).abs() < 1e-12);
        // det A(q) = m . (q, 1), and a disc departs by at most r (|q| sin a + 1 - cos a)
        let size = gather.disc_radius();
        let area = camera.iris.normal().dot(at.extend(1.0));
        prop_assert!((gather.spread().determinant() - size * size * area).abs() < 1e-12 * (1.0 + size * size));
        let disc = Camera { iris: lens.iris(ApertureShape::Disc), ..camera };
        let foreshortening = Footprint::new(&disc, Reading::Gather, at, inverse_depth).foreshortening();
        let bound = size * (at.length() * sin + 1.0 - lens.total_tilt().cos());
        prop_assert!(foreshortening <= bound + 1e-12, "{foreshortening} {bound}");
    }

    #[test]
    fn predicted_departures_bound_the_true_ones(
        camera in raw_camera(), place in unit_square(), inverse_depth in 0.0..3.0f64, scatter in any::<bool>(),
    ) {
        let reading = if scatter { Reading::Scatter } else { Reading::Gather };
        let at = q_at(&camera.film, place);
        let footprint = Footprint::new(&camera, reading, at, inverse_depth).in_pixels(&camera.film);
        let shape = camera.iris.shape();
        let (foreshortening, skew) = (footprint.foreshortening(), footprint.skew());
        let skewed = farthest(shape, |u| {
            (footprint.offset(u).unwrap() - footprint.ellipse_offset(u)).length()
        });
        prop_assert!(skewed <= skew * (1.0 + 1e-9));
        // For a disc the turn within the iris does not show: compare outlines by their reach in each direction
        let reach = |map: &dyn Fn(DVec2) -> DVec2, direction: DVec2| {
            (0..2880).map(|i| map(DVec2::from_angle(f64::from(i) / 2880.0 * std::f64::consts::TAU)).dot(direction)).fold(0.0, f64::max)
        };
        let departed = match shape {
            ApertureShape::Disc => (0..24).map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 24.0)).map(|direction| {
                let ellipse = reach(&|u| footprint.ellipse_offset(u), direction);
                (ellipse - reach(&|u| footprint.disc_offset(u), direction)).abs()
            }).fold(0.0, f64::max),
            ApertureShape::Polygon { .. } => farthest(shape, |u| {
                (footprint.ellipse_offset(u) - footprint.disc_offset(u)).length()
            }),
        };
        // 2880 directions find a reach to within 1e-6 of itself
        prop_assert!(departed <= foreshortening + 4e-6 * footprint.disc_radius(), "{departed} {foreshortening}");
        prop_assert!(departed >= 0.3 * foreshortening - 1e-6 * footprint.disc_radius(), "{departed} {foreshortening}");
    }

    #[test]
    fn support_is_the_farthest_offset(
        camera in raw_camera(), place in unit_square(), inverse_depth in 0.0..3.0f64, turn in 0.0..std::f64::consts::TAU,
    ) {
        let at = q_at(&camera.film, place);
        let footprint = Footprint::new(&camera, Reading::Gather, at, inverse_depth).in_pixels(&camera.film);
        let (shape, direction) = (camera.iris.shape(), DVec2::from_angle(turn));
        let support = footprint.support(direction);
        let found = farthest(shape, |u| footprint.offset(u).unwrap().dot(direction));
        // 720 points find the farthest of a disc's outline to within 1 - cos(0.25 degrees), 1e-5
        let size = footprint.disc_radius();
        prop_assert!(found <= support + 1e-9 * size && support <= found + 2e-5 * size, "{found} {support}");
    }
}

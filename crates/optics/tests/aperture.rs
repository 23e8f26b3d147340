//! Sampling the opening: inside it, uniform, without distortion, and of the moments it says.

mod random_lens;

use glam::{DMat2, DVec2};
use optics::{ApertureShape, Iris};
use proptest::prelude::*;
use random_lens::{shape, squeeze, unit_square};

fn shapes() -> Vec<ApertureShape> {
    let polygon = |blades, turn| ApertureShape::polygon(blades, turn).unwrap();
    vec![ApertureShape::Disc, polygon(3, 0.3), polygon(4, 0.0), polygon(5, -1.0), polygon(8, 2.0), polygon(32, 0.1)]
}

/// The centres of n x n equal cells of the unit square.
fn cells(n: u32) -> impl Iterator<Item = DVec2> {
    (0..n * n).map(move |i| (DVec2::new(f64::from(i % n), f64::from(i / n)) + 0.5) / f64::from(n))
}

proptest! {
    #[test]
    fn samples_lie_in_the_opening(shape in shape(), u in unit_square()) {
        // Within rounding: a point of the outline may fall to either side
        prop_assert!(shape.contains(shape.sample(DVec2::from_array(u)) * (1.0 - 1e-12)));
        prop_assert!(shape.contains(DVec2::ZERO) && !shape.contains(DVec2::new(0.8, 0.8)));
    }

    #[test]
    fn the_map_from_the_square_keeps_area_everywhere(shape in shape(), u in unit_square()) {
        const STEP: f64 = 1e-5;
        let u = DVec2::from_array(u);
        // Leave out the creases, where the concentric map or the outline turns a corner
        let s = 2.0 * u - 1.0;
        prop_assume!(u.min_element() > STEP && u.max_element() < 1.0 - STEP);
        prop_assume!((s.x.abs() - s.y.abs()).abs() > 0.01 && s.abs().max_element() > 0.01);
        let around = [DVec2::X, DVec2::Y].map(|axis| [u - STEP * axis, u + STEP * axis].map(|u| shape.sample(u)));
        if let ApertureShape::Polygon { blades, rotation } = shape {
            let wedge = std::f64::consts::TAU / f64::from(blades);
            let sector = |p: DVec2| ((p.to_angle() - rotation) / wedge).rem_euclid(f64::from(blades)).floor();
            let first = sector(around[0][0]);
            prop_assume!(around.iter().flatten().all(|&p| sector(p) == first));
        }
        // Central differences: an error of STEP^2 in the smooth parts, of rounding / STEP otherwise
        let [dx, dy] = around.map(|[low, high]| (high - low) / (2.0 * STEP));
        prop_assert!((dx.perp_dot(dy).abs() / shape.area() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_map_from_the_square_is_continuous(shape in shape(), u in unit_square(), turn in 0.0..std::f64::consts::TAU) {
        const STEP: f64 = 1e-6;
        let u = DVec2::from_array(u);
        let v = (u + STEP * DVec2::from_angle(turn)).clamp(DVec2::ZERO, DVec2::splat(1.0 - 1e-12));
        // The square is twice as wide as the opening's radius; the concentric map stretches by at most pi/2 more, and
        // pressing a triangle's corner out by 2/sqrt(3) and more along its side
        prop_assert!((shape.sample(u) - shape.sample(v)).length() < 8.0 * STEP);
    }

    #[test]
    fn iris_points_lie_on_the_iris(
        shape in shape(), m in [-0.5..0.5f64, -0.5..0.5f64], radius in 1e-4..0.1f64, squeeze in squeeze(),
        u in unit_square(),
    ) {
        let iris = Iris::new(glam::DVec3::new(m[0], m[1], 1.0), radius, shape).unwrap().squeezed(squeeze).unwrap();
        let u = DVec2::from_array(u);
        let p = iris.point(u);
        prop_assert!(p.dot(iris.normal()).abs() < 1e-15);
        let plane = DVec2::new(p.dot(iris.e1()), p.dot(iris.e2()));
        prop_assert!((plane / iris.half_sizes() - shape.sample(u)).length() < 1e-13);
        prop_assert_eq!(iris.half_sizes().max_element(), radius);
        prop_assert!((iris.half_sizes().y / iris.half_sizes().x - squeeze).abs() < 1e-15 * squeeze.max(1.0));
        // The frame is orthonormal and turns as x, y, z do
        prop_assert!((iris.e1().cross(iris.e2()) - iris.normal()).length() < 1e-15);
        prop_assert_eq!(iris.e1().y, 0.0);
    }
}

#[test]
fn every_part_of_the_opening_gets_its_share() {
    // A furnace for the iris: n x n samples, counted in squares of the plane, must fill all alike. Each sample stands
    // for a cell of its own, so that only cells on the border of a square are in doubt: with a random half of them
    // the deviation is below 1 % for squares of 5000 samples; 3 % leaves room for the outline that is not random.
    const SAMPLES: u32 = 1024;
    const SQUARES: i32 = 8;
    for shape in shapes() {
        let mut counts = vec![0u32; (4 * SQUARES * SQUARES) as usize];
        let index = |p: DVec2| {
            let cell = (p * f64::from(SQUARES)).floor().as_ivec2() + SQUARES;
            (cell.y * 2 * SQUARES + cell.x) as usize
        };
        for u in cells(SAMPLES) {
            counts[index(shape.sample(u))] += 1;
        }
        let expected = f64::from(SAMPLES * SAMPLES) / f64::from(SQUARES * SQUARES) / shape.area();
        let mut whole = 0;
        for (x, y) in (-SQUARES..SQUARES).flat_map(|y| (-SQUARES..SQUARES).map(move |x| (x, y))) {
            let corner = |dx, dy| DVec2::new(f64::from(x + dx), f64::from(y + dy)) / f64::from(SQUARES);
            // The opening is convex: a square is inside if its corners are
            if [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)].iter().all(|&p| shape.contains(p)) {
                let found = f64::from(counts[index(corner(0, 0) + 1e-9)]);
                assert!((found / expected - 1.0).abs() < 0.03, "{shape:?} at ({x}, {y}): {found} of {expected}");
                whole += 1;
            }
        }
        assert!(whole >= 40, "{shape:?}: only {whole} squares lie inside");
    }
}

#[test]
fn moments_of_the_samples_are_those_of_the_opening() {
    // Midpoints of n x n cells: an error of about 1/n^2 where the map is smooth, 1/n^2 a cell on the creases
    const TOLERANCE: f64 = 1e-4;
    for shape in shapes() {
        let n = 256;
        let (mut mean, mut square) = (DVec2::ZERO, DMat2::ZERO);
        for p in cells(n).map(|u| shape.sample(u)) {
            mean += p;
            square += DMat2::from_cols(p * p.x, p * p.y);
        }
        let count = f64::from(n * n);
        assert!((mean / count).length() < TOLERANCE, "{shape:?}");
        let covariance = square * count.recip();
        let wanted = DMat2::IDENTITY * shape.variance();
        assert!((covariance - wanted).abs_diff_eq(DMat2::ZERO, TOLERANCE), "{shape:?}: {covariance}");
    }
}

#[test]
fn areas_and_variances_of_known_shapes() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15 * 10.0, "{a} {b}");
    let polygon = |blades| ApertureShape::polygon(blades, 0.7).unwrap();
    near(ApertureShape::Disc.area(), std::f64::consts::PI);
    near(ApertureShape::Disc.variance(), 0.25);
    // A square of side sqrt 2 has area 2 and variance side^2/12; an equilateral triangle of side sqrt 3, side^2/24
    near(polygon(4).area(), 2.0);
    near(polygon(4).variance(), 2.0 / 12.0);
    near(polygon(3).area(), 0.75 * 3f64.sqrt());
    near(polygon(3).variance(), 3.0 / 24.0);
    near(polygon(6).variance(), 2.5 / 12.0);
}

#[test]
fn a_pinhole_has_one_point() {
    let pinhole = Iris::pinhole();
    assert_eq!(cells(4).map(|u| pinhole.point(u)).fold(0.0, |sum, p| sum + p.length()), 0.0);
}

//! How cost grows.

/// The power with which y grows with x, y ~ x^p: the slope of the straight line through the logarithms that misses them
/// least (least squares).
///
/// `None` unless there are two different x at least and all figures are above 0.
#[must_use]
pub fn growth_exponent(points: &[(f64, f64)]) -> Option<f64> {
    if points.iter().any(|&(x, y)| !(x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite())) {
        return None;
    }
    let count = points.len() as f64;
    let logs = || points.iter().map(|&(x, y)| (x.ln(), y.ln()));
    let (mean_x, mean_y) = logs().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x / count, sy + y / count));
    let (spread, common) = logs().fold((0.0, 0.0), |(spread, common), (x, y)| {
        (spread + (x - mean_x).powi(2), common + (x - mean_x) * (y - mean_y))
    });
    (spread > 0.0).then(|| common / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_is_found_whatever_its_factor() {
        const ROUNDING: f64 = 1e-12;
        for power in [-1.0, 0.0, 0.5, 2.0] {
            let points: Vec<_> = [1.0_f64, 3.0, 7.0, 20.0].map(|x| (x, 5.0 * x.powf(power))).to_vec();
            assert!((growth_exponent(&points).unwrap() - power).abs() < ROUNDING);
        }
        // In decades: (0, 0), (1, 1.30103), (2, 1.69897), (3, 3) lie about a line of slope 4.69897 / 5
        let about = growth_exponent(&[(1.0, 1.0), (10.0, 20.0), (100.0, 50.0), (1000.0, 1000.0)]).unwrap();
        assert!((about - 0.939_794).abs() < 1e-6, "{about}");
    }

    #[test]
    fn one_place_or_no_logarithm_is_no_growth() {
        assert_eq!(growth_exponent(&[]), None);
        assert_eq!(growth_exponent(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(growth_exponent(&[(0.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(growth_exponent(&[(1.0, f64::NAN), (2.0, 3.0)]), None);
    }
}

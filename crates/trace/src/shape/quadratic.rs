//! Roots of a quadratic, without cancellation.

/// The real roots of a t^2 + 2 b t + c, in no order; a root may be infinite or NaN where the equation degenerates.
pub(super) fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    // Add numbers of one sign only (Numerical Recipes, 5.6)
    let q = -(b + discriminant.sqrt().copysign(b));
    Some([q / a, c / q])
}

//! How much light a smooth boundary reflects.

use glam::Vec3;

/// Share that the boundary of a dielectric reflects of unpolarised light, met at a cosine (0 to 1) from the side whose index
/// is `eta` times smaller; 1 where it cannot get through.
pub(crate) fn dielectric(cosine: f32, eta: f32) -> f32 {
    let sine2 = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    if sine2 >= 1.0 {
        return 1.0;
    }
    let through = (1.0 - sine2).sqrt();
    let parallel = (eta * cosine - through) / (eta * cosine + through);
    let crossed = (cosine - eta * through) / (cosine + eta * through);
    (0.5 * (parallel * parallel + crossed * crossed)).min(1.0)
}

/// The same of a sheet, which reflects to and fro inside: R + T R T + T R^3 T + ...
pub(crate) fn sheet(cosine: f32, eta: f32) -> f32 {
    let once = dielectric(cosine, eta);
    if once < 1.0 { 2.0 * once / (1.0 + once) } else { once }
}

/// Schlick's approximation for a metal: F0 + (1 - F0) (1 - cos)^5.
pub(crate) fn schlick(f0: Vec3, cosine: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // ((n - 1) / (n + 1))^2 straight on, nothing of one polarisation at Brewster's angle, all at grazing
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        let brewster = 1.5_f32.atan();
        let crossed = (2.0 * brewster - std::f32::consts::FRAC_PI_2).sin().powi(2);
        assert!((dielectric(brewster.cos(), 1.5) - 0.5 * crossed).abs() < 1e-5);
        assert!((dielectric(0.0, 1.5) - 1.0).abs() < 1e-6);
        // Total reflection from arcsin(1 / 1.5) = 41.8 degrees on
        assert_eq!(dielectric(42_f32.to_radians().cos(), 1.0 / 1.5), 1.0);
        assert!(dielectric(41_f32.to_radians().cos(), 1.0 / 1.5) < 0.5);
        // The same from both sides, at angles that Snell joins
        for degrees in [10.0_f32, 40.0, 70.0, 85.0] {
            let outside = degrees.to_radians();
            let inside = (outside.sin() / 1.5).asin();
            let [a, b] = [dielectric(outside.cos(), 1.5), dielectric(inside.cos(), 1.0 / 1.5)];
            assert!((a - b).abs() < 1e-5, "{degrees}: {a} {b}");
        }
        assert_eq!(schlick(Vec3::splat(0.3), 1.0), Vec3::splat(0.3));
        assert_eq!(schlick(Vec3::splat(0.3), 0.0), Vec3::ONE);
    }
}

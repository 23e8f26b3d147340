//! Suns that have a size.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};

/// A disc infinitely far away, equally bright all over.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Disc {
    toward: DVec3,
    /// 1 - cos of its angular radius.
    versed: f64,
    pub(crate) radiance: Vec3,
}

impl Disc {
    /// One that lights what faces it as a sun of this strength does: by the irradiance pi x strength.
    pub(crate) fn new(toward: DVec3, strength: Vec3, radius: f64) -> Self {
        let sine = radius.sin();
        // 1 - cos, in a form that small angles do not lose
        let versed = 2.0 * (0.5 * radius).sin().powi(2);
        Self { toward, versed, radiance: strength / (sine * sine) as f32 }
    }

    /// Density per solid angle of [`Self::sample`], the same all over.
    pub(super) fn pdf(&self) -> f64 {
        1.0 / (TAU * self.versed)
    }

    /// A unit direction to a point of it.
    pub(super) fn sample(&self, u: DVec2) -> DVec3 {
        let versed = u.x * self.versed;
        let (sine, cosine) = ((versed * (2.0 - versed)).sqrt(), 1.0 - versed);
        let (x, y) = self.toward.any_orthonormal_pair();
        let (s, c) = (TAU * u.y).sin_cos();
        (sine * (c * x + s * y) + cosine * self.toward).normalize()
    }

    /// Whether it is seen in a unit direction.
    pub(super) fn contains(&self, direction: DVec3) -> bool {
        0.5 * (direction - self.toward).length_squared() <= self.versed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_disc_lie_in_it_and_light_as_its_strength_says() {
        for radius in [0.004_625_f64, 0.3] {
            let disc = Disc::new(DVec3::new(0.6, 0.0, 0.8), Vec3::splat(2.0), radius);
            let (side, mut irradiance) = (64, 0.0);
            for k in 0..side * side {
                let u = (DVec2::new(f64::from(k % side), f64::from(k / side)) + 0.5) / f64::from(side);
                let direction = disc.sample(u);
                assert!(disc.contains(direction), "{u}");
                irradiance += f64::from(disc.radiance.x) * direction.dot(disc.toward) / disc.pdf();
            }
            let expected = 2.0 * std::f64::consts::PI;
            assert!((irradiance / f64::from(side * side) / expected - 1.0).abs() < 1e-4, "{radius}");
            let beyond =
                DVec3::new((0.6_f64.asin() + 1.001 * radius).sin(), 0.0, (0.6_f64.asin() + 1.001 * radius).cos());
            assert!(!disc.contains(beyond));
        }
    }
}

//! How much of the light from a direction rough surfaces reflect in all, in tables.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec3};

use super::fresnel;
use super::microfacet::Ggx;

/// Steps of roughness and of the square root of the cosine.
const STEPS: usize = 32;
/// Directions that an entry is the mean of, along each of two axes.
const SAMPLES: usize = 24;
const MORE_SAMPLES: usize = 64;

/// Reflected share by roughness and direction.
#[derive(Clone)]
pub(crate) struct Albedo {
    shares: Vec<f32>,
    /// Mean over directions by roughness, weighted by the cosine.
    means: Vec<f32>,
}

/// Of window glass, lacquer and plastics, as most coats are.
static USUAL: LazyLock<Arc<Albedo>> =
    LazyLock::new(|| Arc::new(Albedo::new(|cosine| fresnel::dielectric(cosine, 1.5))));

/// Of facets that reflect everything: what is missing was reflected again between them.
pub(crate) static PERFECT: LazyLock<Albedo> = LazyLock::new(|| Albedo::new(|_| 1.0));

impl std::fmt::Debug for Albedo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Albedo")
    }
}

impl Albedo {
    /// Of facets that reflect a share by the cosine to their own normal.
    fn new(fresnel: impl Fn(f32) -> f32) -> Self {
        Self::of(SAMPLES, &fresnel, &|ggx, o, u| {
            let i = ggx.sample(o, u);
            if i.z <= 0.0 {
                return 0.0;
            }
            ggx.weight(o, i) * fresnel(o.dot((o + i).normalize()).clamp(0.0, 1.0))
        })
    }

    /// Of facets that keep a share of what they are sent, by facets, direction and the place of a sample; smooth ones keep all.
    pub(crate) fn from_shares(share: impl Fn(Ggx, Vec3, Vec2) -> f32) -> Self {
        // Where all light is reflected, beyond an angle, a jump takes more directions
        Self::of(MORE_SAMPLES, &|_| 1.0, &share)
    }

    /// From the share of a smooth surface by cosine, and that of a sample of a rough one.
    fn of(samples: usize, smooth: &dyn Fn(f32) -> f32, sample: &dyn Fn(Ggx, Vec3, Vec2) -> f32) -> Self {
        let share = |row: usize, column: usize| {
            let alpha = (row as f32 / (STEPS - 1) as f32).powi(2);
            let cosine = (column as f32 / (STEPS - 1) as f32).powi(2).max(1e-4);
            if row == 0 {
                return smooth(cosine);
            }
            let ggx = Ggx::new(alpha);
            let o = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let mut sum = 0.0;
            for k in 0..samples * samples {
                let place = Vec2::new((k % samples) as f32, (k / samples) as f32);
                sum += sample(ggx, o, (place + 0.5) / samples as f32);
            }
            sum / (samples * samples) as f32
        };
        let shares = (0..STEPS * STEPS).map(|k| share(k / STEPS, k % STEPS)).collect();
        let mut albedo = Self { shares, means: Vec::new() };
        albedo.means = (0..STEPS).map(|row| albedo.mean_of_row(row)).collect();
        albedo
    }

    /// Of a dielectric with this refractive index.
    pub(crate) fn of_dielectric(ior: f32) -> Arc<Self> {
        if ior == 1.5 {
            return Arc::clone(&USUAL);
        }
        Arc::new(Self::new(|cosine| fresnel::dielectric(cosine, ior)))
    }

    /// 2 int E cos dcos of the table as it is read, cos = t^2.
    fn mean_of_row(&self, row: usize) -> f32 {
        const FINE: usize = 1024;
        let roughness = row as f32 / (STEPS - 1) as f32;
        let at = |k: usize| {
            let t = (k as f32 + 0.5) / FINE as f32;
            f64::from(self.share(roughness, t * t)) * f64::from(4.0 * t * t * t)
        };
        ((0..FINE).map(at).sum::<f64>() / FINE as f64) as f32
    }

    /// Share that is reflected of the light from a direction with this cosine.
    pub(crate) fn share(&self, roughness: f32, cosine: f32) -> f32 {
        let (column, x) = place(cosine.max(0.0).sqrt());
        let (row, y) = place(roughness);
        let at = |row: usize| {
            let row = &self.shares[row * STEPS..(row + 1) * STEPS];
            row[column] + x * (row[column + 1] - row[column])
        };
        let (low, high) = (at(row), at(row + 1));
        low + y * (high - low)
    }

    /// The mean over all directions.
    pub(crate) fn mean(&self, roughness: f32) -> f32 {
        let (row, y) = place(roughness);
        self.means[row] + y * (self.means[row + 1] - self.means[row])
    }
}

/// Step and share of the next one, of a number in [0, 1].
fn place(t: f32) -> (usize, f32) {
    let place = t.clamp(0.0, 1.0) * (STEPS - 1) as f32;
    let step = (place as usize).min(STEPS - 2);
    (step, place - step as f32)
}

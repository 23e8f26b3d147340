//! Light from infinitely far, from a picture of all directions.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};

use crate::SceneError;

/// A picture of all directions, longitude across and latitude down, whose bright places are asked more often.
///
/// Its middle is seen looking along -z, its right edge along +z by way of +x; the top row is up (+y).
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
    /// Sums of chances along each row, and of rows.
    rows: Vec<f64>,
    columns: Vec<f64>,
    /// Turn about y in radians.
    turn: f64,
}

impl Environment {
    /// Most texels.
    pub const MOST_TEXELS: usize = 1 << 26;

    /// From radiances, row by row from the top, turned about y by `turn` radians.
    pub fn new(width: usize, height: usize, texels: Vec<Vec3>, turn: f64) -> Result<Self, SceneError> {
        let wanted = "as many texels as width times height, at least one and at most 2^26";
        if texels.is_empty() || texels.len() > Self::MOST_TEXELS || width.checked_mul(height) != Some(texels.len()) {
            return Err(SceneError::OutOfRange { what: "size of an environment", value: texels.len() as f64, wanted });
        }
        if !turn.is_finite() {
            let wanted = "finite";
            return Err(SceneError::OutOfRange { what: "turn of an environment", value: turn, wanted });
        }
        // What is no radiance is black, and none is brighter than a scene may be
        let texels: Vec<Vec3> = texels
            .into_iter()
            .map(|texel| {
                Vec3::from_array(
                    texel.to_array().map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, crate::MAX_RADIANCE) }),
                )
            })
            .collect();
        // A texel shines into its neighbours too, as it is read bilinearly
        let level = |x: usize, y: usize| f64::from(texels[y * width + x].element_sum());
        let across = |x: usize, y: usize| {
            0.125 * (level((x + width - 1) % width, y) + level((x + 1) % width, y)) + 0.75 * level(x, y)
        };
        let (mut rows, mut columns) = (Vec::with_capacity(height), Vec::with_capacity(width * height));
        let mut total = 0.0;
        for y in 0..height {
            let sine = (PI * (y as f64 + 0.5) / height as f64).sin();
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            let mut sum = 0.0;
            for x in 0..width {
                sum += (0.125 * (across(x, above) + across(x, below)) + 0.75 * across(x, y)) * sine;
                columns.push(sum);
            }
            total += sum;
            rows.push(total);
        }
        Ok(Self { width, height, texels, rows, columns, turn })
    }

    /// Whether it is black.
    pub(super) fn is_dark(&self) -> bool {
        self.rows[self.height - 1] <= 0.0
    }

    /// Adds it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        fingerprint.update(format!("{} {} {}", self.width, self.height, self.turn).as_bytes());
        self.texels.iter().flat_map(Vec3::to_array).for_each(|x| fingerprint.update(&x.to_le_bytes()));
    }

    /// Where a unit direction lies in the picture, both in [0, 1].
    fn place(&self, direction: DVec3) -> DVec2 {
        let across = (direction.x.atan2(-direction.z) + self.turn) / (2.0 * PI) + 0.5;
        DVec2::new(across - across.floor(), direction.y.clamp(-1.0, 1.0).acos() / PI)
    }

    /// Radiance from a unit direction, bilinear.
    pub(super) fn radiance(&self, direction: DVec3) -> Vec3 {
        let place = self.place(direction) * DVec2::new(self.width as f64, self.height as f64) - 0.5;
        let first = place.floor();
        let share = (place - first).as_vec2();
        let at = |dx: i64, dy: i64| {
            let x = (first.x as i64 + dx).rem_euclid(self.width as i64) as usize;
            let y = (first.y as i64 + dy).clamp(0, self.height as i64 - 1) as usize;
            self.texels[y * self.width + x]
        };
        at(0, 0).lerp(at(1, 0), share.x).lerp(at(0, 1).lerp(at(1, 1), share.x), share.y)
    }

    /// A direction, and its density per solid angle.
    pub(super) fn sample(&self, u: DVec2) -> (DVec3, f64) {
        let pick = |sums: &[f64], u: f64| {
            let wanted = u * sums[sums.len() - 1];
            let i = sums.partition_point(|&sum| sum <= wanted).min(sums.len() - 1);
            let before = if i == 0 { 0.0 } else { sums[i - 1] };
            (i, ((wanted - before) / (sums[i] - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
        };
        let (y, dy) = pick(&self.rows, u.y);
        let (x, dx) = pick(&self.columns[y * self.width..(y + 1) * self.width], u.x);
        let longitude = 2.0 * PI * ((x as f64 + dx) / self.width as f64 - 0.5) - self.turn;
        let latitude = PI * (y as f64 + dy) / self.height as f64;
        let (sine, cosine) = latitude.sin_cos();
        let direction = DVec3::new(sine * longitude.sin(), cosine, -sine * longitude.cos());
        (direction, self.density(x, y, sine))
    }

    /// Density of [`Self::sample`] at a unit direction.
    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        let place = self.place(direction) * DVec2::new(self.width as f64, self.height as f64);
        let x = (place.x as usize).min(self.width - 1);
        let y = (place.y as usize).min(self.height - 1);
        self.density(x, y, (1.0 - direction.y * direction.y).max(0.0).sqrt())
    }

    /// A texel's chance over the solid angle of where it is in it.
    fn density(&self, x: usize, y: usize, sine: f64) -> f64 {
        let of = |sums: &[f64], i: usize| if i == 0 { sums[0] } else { sums[i] - sums[i - 1] };
        let chance = of(&self.columns[y * self.width..(y + 1) * self.width], x) / self.rows[self.height - 1];
        let texels = (self.width * self.height) as f64;
        chance * texels / (2.0 * PI * PI * sine.max(1e-9))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spotted() -> Environment {
        let texel = |i: usize| Vec3::splat(if i == 37 { 40.0 } else { 1.0 + (i % 7) as f32 });
        Environment::new(16, 8, (0..128).map(texel).collect(), 0.4).unwrap()
    }

    #[test]
    fn samples_have_the_density_that_is_told_and_it_is_one() {
        let environment = spotted();
        let mut sum = 0.0;
        let side = 512;
        for k in 0..side * side {
            let u = (DVec2::new(f64::from(k % side), f64::from(k / side)) + 0.5) / f64::from(side);
            let (direction, pdf) = environment.sample(u);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!((pdf / environment.pdf(direction) - 1.0).abs() < 1e-6, "{direction}: {pdf}");
            sum += 1.0 / pdf;
        }
        // The mean of 1 / pdf is the solid angle of all that is not black: 4 pi
        let found = sum / f64::from(side * side);
        assert!((found / (4.0 * PI) - 1.0).abs() < 0.01, "{found}");
    }

    #[test]
    fn directions_go_as_documented() {
        let mut texels = vec![Vec3::ZERO; 8 * 4];
        texels[8 + 6] = Vec3::X; // three quarters across: +x
        texels[8 + 5] = Vec3::X;
        texels[16 + 6] = Vec3::X;
        texels[16 + 5] = Vec3::X;
        let environment = Environment::new(8, 4, texels, 0.0).unwrap();
        assert!(environment.radiance(DVec3::X).x > 0.99);
        assert_eq!(environment.radiance(DVec3::NEG_X), Vec3::ZERO);
        // The middle looks along -z
        let mut texels = vec![Vec3::ZERO; 2 * 8];
        (texels[3], texels[4], texels[11], texels[12]) = (Vec3::Y, Vec3::Y, Vec3::Y, Vec3::Y);
        let environment = Environment::new(8, 2, texels, 0.0).unwrap();
        assert!(environment.radiance(DVec3::NEG_Z).y > 0.99);
        assert_eq!(environment.radiance(DVec3::Z), Vec3::ZERO);
    }
}

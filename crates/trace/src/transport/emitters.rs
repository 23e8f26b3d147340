//! Surfaces that light others, and points on them to ask for light.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};

use crate::geometry::{Geometry, PrimitiveId, SurfaceId};
use crate::shape::PlacedShape;
use crate::{Hit, Ray, Shape};

/// A surface whose points can be chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Outline {
    /// A triangle.
    Triangle([DVec3; 3]),
    /// A parallelogram: a corner and the sides from there.
    Parallelogram([DVec3; 3]),
    /// A ball.
    Ball { centre: DVec3, radius: f64 },
}

#[derive(Debug, Clone, Copy)]
struct Emitter {
    outline: Outline,
    primitive: PrimitiveId,
    material: u32,
    /// The chance that it is chosen.
    chance: f64,
}

/// All of them, the brighter the more often chosen.
#[derive(Debug, Clone, Default)]
pub(super) struct Emitters {
    list: Vec<Emitter>,
    /// Sums of chances up to and with each.
    sums: Vec<f64>,
    number: HashMap<PrimitiveId, u32>,
}

/// A point that was chosen.
pub(super) struct Chosen {
    pub(super) hit: Hit,
    /// Density per solid angle as seen from where light is wanted.
    pub(super) pdf: f64,
}

impl Emitters {
    /// Collects what can be sampled among the primitives whose material `emits` (mean radiance). Cylinders, cones, boxes,
    /// endless planes and ellipsoids light too, but only where a path happens to meet them.
    pub(super) fn new(
        triangles: impl Iterator<Item = (PrimitiveId, u32, [Vec3; 3])>,
        shapes: &[PlacedShape],
        emits: impl Fn(u32) -> Vec3,
    ) -> Self {
        let mut found = Vec::new();
        for (primitive, material, corners) in triangles {
            let radiance = emits(material);
            if radiance != Vec3::ZERO {
                found.push((Outline::Triangle(corners.map(Vec3::as_dvec3)), primitive, material, radiance));
            }
        }
        for (number, shape) in shapes.iter().enumerate() {
            let radiance = emits(shape.material);
            if let Some(outline) = outline(shape).filter(|_| radiance != Vec3::ZERO) {
                found.push((outline, Geometry::SHAPE | number as u32, shape.material, radiance));
            }
        }
        // In the order of their names, whatever the order they came in
        found.sort_by_key(|&(_, primitive, _, _)| primitive);
        let power =
            |&(outline, _, _, radiance): &(Outline, u32, u32, Vec3)| outline.area() * f64::from(radiance.element_sum());
        let total: f64 = found.iter().map(power).sum();
        let mut emitters = Self::default();
        let mut sum = 0.0;
        for (i, item) in found.iter().enumerate() {
            let chance = power(item) / total;
            sum += chance;
            emitters.list.push(Emitter { outline: item.0, primitive: item.1, material: item.2, chance });
            emitters.sums.push(sum);
            emitters.number.insert(item.1, i as u32);
        }
        emitters
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// A point of one of them, as seen from `from`; `None` where none is seen at all.
    pub(super) fn sample(&self, from: DVec3, which: f64, u: DVec2) -> Option<Chosen> {
        let number = self.sums.partition_point(|&sum| sum <= which * self.sums[self.sums.len() - 1]);
        let emitter = self.list.get(number.min(self.list.len() - 1))?;
        let (point, normal, weights) = emitter.outline.point(from, u)?;
        let material = emitter.material;
        let (primitive, mover, time) = (emitter.primitive, SurfaceId::STILL, Ray::MIDDLE);
        let hit = Hit { t: 1.0, point, normal, material, primitive, weights, mover, time };
        let pdf = emitter.chance * emitter.outline.pdf(from, point, normal);
        (pdf > 0.0 && pdf.is_finite()).then_some(Chosen { hit, pdf })
    }

    /// Density of [`Self::sample`] per solid angle at a point that was hit; 0 where it cannot be chosen.
    pub(super) fn pdf(&self, from: DVec3, hit: &Hit) -> f64 {
        let still = hit.id().within(SurfaceId::STILL);
        let Some(&number) = self.number.get(&still) else { return 0.0 };
        let emitter = &self.list[number as usize];
        emitter.chance * emitter.outline.pdf(from, hit.point, hit.normal)
    }
}

fn outline(shape: &PlacedShape) -> Option<Outline> {
    let (shape, map) = shape.placed();
    match shape {
        Shape::Rectangle => {
            let corner = map.transform_point3(DVec3::new(-1.0, 0.0, -1.0));
            Some(Outline::Parallelogram([corner, 2.0 * map.matrix3.x_axis, 2.0 * map.matrix3.z_axis]))
        }
        Shape::Sphere => {
            let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            let radius = x.length();
            let is_round =
                [y.length() - radius, z.length() - radius, x.dot(y) / radius, x.dot(z) / radius, y.dot(z) / radius]
                    .iter()
                    .all(|error| error.abs() < 1e-9 * radius);
            is_round.then_some(Outline::Ball { centre: map.translation, radius })
        }
        Shape::Plane | Shape::Cuboid | Shape::Cylinder | Shape::Cone => None,
    }
}

impl Outline {
    fn area(&self) -> f64 {
        match self {
            Self::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
            Self::Parallelogram([_, x, y]) => x.cross(*y).length(),
            Self::Ball { radius, .. } => 4.0 * PI * radius * radius,
        }
    }

    /// A point, its unit normal, and a triangle's weights.
    fn point(&self, from: DVec3, u: DVec2) -> Option<(DVec3, DVec3, [f32; 2])> {
        match *self {
            Self::Triangle([a, b, c]) => {
                let root = u.x.sqrt();
                let (v, w) = (root * (1.0 - u.y), root * u.y);
                let (ab, ac) = (b - a, c - a);
                let normal = ab.cross(ac).try_normalize()?;
                Some((a + v * ab + w * ac, normal, [v as f32, w as f32]))
            }
            Self::Parallelogram([corner, x, y]) => {
                let normal = y.cross(x).try_normalize()?;
                Some((corner + u.x * x + u.y * y, normal, [0.0; 2]))
            }
            Self::Ball { centre, radius } => {
                let axis = centre - from;
                let distance = axis.length();
                let normal = if distance > radius {
                    // The cone that it fills, in a form that small balls far away do not lose
                    let sine2 = (radius / distance).powi(2);
                    let open = sine2 / (1.0 + (1.0 - sine2).sqrt());
                    let versed = u.x * open;
                    let cosine = 1.0 - versed;
                    let sine = (versed * (2.0 - versed)).sqrt();
                    let (x, y) = (axis / distance).any_orthonormal_pair();
                    let (s, c) = (2.0 * PI * u.y).sin_cos();
                    let direction = sine * (c * x + s * y) + cosine * (axis / distance);
                    let middle = distance * cosine;
                    let back = (radius * radius - (distance * sine).powi(2)).max(0.0).sqrt();
                    (from + (middle - back) * direction - centre).try_normalize()?
                } else {
                    let z = 1.0 - 2.0 * u.x;
                    let (s, c) = (2.0 * PI * u.y).sin_cos();
                    let r = (1.0 - z * z).max(0.0).sqrt();
                    DVec3::new(r * c, r * s, z)
                };
                Some((centre + radius * normal, normal, [0.0; 2]))
            }
        }
    }

    /// Density of that point per solid angle.
    fn pdf(&self, from: DVec3, point: DVec3, normal: DVec3) -> f64 {
        if let Self::Ball { centre, radius } = *self {
            let sine2 = radius * radius / (centre - from).length_squared();
            if sine2 < 1.0 {
                let open = sine2 / (1.0 + (1.0 - sine2).sqrt());
                return 1.0 / (2.0 * PI * open);
            }
        }
        let toward = point - from;
        let cosine = normal.dot(toward).abs();
        toward.length_squared() * toward.length() / (cosine * self.area())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solid angles by counting directions, against the mean of 1 / pdf over samples.
    #[test]
    fn samples_cover_the_solid_angle_that_each_outline_fills() {
        let from = DVec3::new(0.2, -0.1, 0.3);
        let square = Outline::Parallelogram([DVec3::new(-1.0, -1.0, 1.3), 2.0 * DVec3::X, 2.0 * DVec3::Y]);
        let triangle =
            Outline::Triangle([DVec3::ZERO + DVec3::Z, DVec3::new(1.0, 0.0, 1.5), DVec3::new(0.0, 2.0, 1.1)]);
        let ball = Outline::Ball { centre: DVec3::new(1.0, 1.0, 2.0), radius: 0.7 };
        let around = Outline::Ball { centre: DVec3::ZERO, radius: 2.0 };
        // Van Oosterom and Strackee 1983, with a square as two triangles
        let solid = |[a, b, c]: [DVec3; 3]| {
            let [a, b, c] = [a - from, b - from, c - from].map(DVec3::normalize);
            2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        };
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1.3);
        let of_square = solid([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)])
            + solid([corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        let Outline::Triangle(corners) = triangle else { unreachable!() };
        let distance2 = (DVec3::new(1.0, 1.0, 2.0) - from).length_squared();
        let of_ball = 2.0 * PI * (1.0 - (1.0 - 0.49 / distance2).sqrt());
        let cases = [(square, of_square), (triangle, solid(corners)), (ball, of_ball), (around, 4.0 * PI)];
        for (outline, expected) in cases {
            let side = 128;
            let mut sum = 0.0;
            for k in 0..side * side {
                let u = (DVec2::new(f64::from(k % side), f64::from(k / side)) + 0.5) / f64::from(side);
                let (point, normal, _) = outline.point(from, u).unwrap();
                sum += 1.0 / outline.pdf(from, point, normal);
            }
            let found = sum / f64::from(side * side);
            // Midpoints of 128 x 128 cells of a smooth function
            assert!((found / expected - 1.0).abs() < 1e-3, "{outline:?}: {found} instead of {expected}");
        }
    }

    #[test]
    fn a_tiny_ball_far_away_keeps_its_solid_angle() {
        let ball = Outline::Ball { centre: DVec3::new(0.0, 0.0, 1e5), radius: 1e-3 };
        let (point, normal, _) = ball.point(DVec3::ZERO, DVec2::new(0.7, 0.2)).unwrap();
        let expected = PI * 1e-16;
        assert!((1.0 / ball.pdf(DVec3::ZERO, point, normal) / expected - 1.0).abs() < 1e-6);
    }
}

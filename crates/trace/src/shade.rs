//! Radiance along all rays of a packet.

use fearless_simd::prelude::*;
use glam::{DVec3, Vec3};

use crate::Scene;
use crate::geometry::{Geometry, Search, Triangle};
use crate::packet::{Packet, RAYS};
use crate::triangle::Axes;

/// Triangles whose plane is kept; lens rays of neighbours hit the same ones again and again.
const KEPT: usize = 64;

/// A triangle's plane in double precision.
#[derive(Debug, Clone, Copy)]
struct Facet {
    primitive: u32,
    material: u32,
    corner: DVec3,
    sides: [DVec3; 2],
    normal: DVec3,
}

impl Facet {
    const NONE: Self = Self {
        primitive: Geometry::NO_PRIMITIVE,
        material: 0,
        corner: DVec3::ZERO,
        sides: [DVec3::ZERO; 2],
        normal: DVec3::ZERO,
    };

    fn new(primitive: u32, triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
        Self { primitive, material: triangle.material, corner: a, sides: [b - a, c - a], normal }
    }
}

/// Shades packets; what it keeps between them saves time only.
pub(crate) struct Shader<'a> {
    scene: &'a Scene,
    search: Search,
    shadow: Box<Packet>,
    facets: Box<[Facet; KEPT]>,
}

impl<'a> Shader<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let shadow = Box::new(Packet::new(0));
        Self { scene, search: Search::default(), shadow, facets: Box::new([Facet::NONE; KEPT]) }
    }

    /// Radiance along each ray of a packet that holds some, the same as [`Scene::radiance`] of each, to the bit.
    #[inline(always)]
    pub(crate) fn radiance<S: Simd>(&mut self, simd: S, packet: &mut Packet) -> [Vec3; RAYS] {
        let scene = self.scene;
        packet.seal(simd);
        self.search.first(simd, &scene.geometry, packet);

        // Find the points
        let mut radiance = [scene.sky; RAYS];
        let mut hits = [(DVec3::ZERO, DVec3::ZERO, 0_u32, 0_u32, 0_u32); RAYS];
        let mut count = 0;
        for lane in 0..packet.count() {
            let found = self.search.found(lane);
            let direction = packet.ray(lane).direction.as_dvec3();
            let (point, normal, material) = match found.primitive {
                Geometry::NO_PRIMITIVE => continue,
                shape if shape & Geometry::SHAPE != 0 => {
                    let Some(hit) = scene.geometry.surface(&packet.ray(lane), &found) else { continue };
                    (hit.point, hit.normal, hit.material)
                }
                triangle => {
                    let facet = &mut self.facets[triangle as usize % KEPT];
                    if facet.primitive != triangle {
                        *facet = Facet::new(triangle, &scene.geometry.triangle(triangle));
                    }
                    let [ab, ac] = facet.sides;
                    let point = facet.corner + f64::from(found.v) * ab + f64::from(found.w) * ac;
                    (point, facet.normal, facet.material)
                }
            };
            let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
            hits[count] = (point, normal, material, found.primitive, lane as u32);
            count += 1;
        }
        let hits = &hits[..count];

        // Add the light of each sun where it is not blocked
        let mut light = [scene.ambient; RAYS];
        for &(toward, strength) in &scene.suns {
            let mut skip = [0; RAYS];
            let mut lit = [(0_usize, 0.0_f64); RAYS];
            self.shadow.clear(Axes::class_of(toward.as_vec3()));
            for (i, &(point, normal, _, primitive, _)) in hits.iter().enumerate() {
                let cosine = normal.dot(toward);
                if cosine > 0.0 {
                    let lane = self.shadow.push(&scene.shadow_ray(point, normal, toward));
                    skip[lane] = primitive as i32;
                    lit[lane] = (i, cosine);
                }
            }
            if self.shadow.count() > 0 {
                self.shadow.seal(simd);
                self.search.any(simd, &scene.geometry, &self.shadow, &skip);
                for (lane, &(i, cosine)) in lit[..self.shadow.count()].iter().enumerate() {
                    if !self.search.is_blocked(lane) {
                        light[i] += strength * cosine as f32;
                    }
                }
            }
        }
        for (&(point, _, material, _, lane), light) in hits.iter().zip(light) {
            let material = &scene.materials[material as usize];
            radiance[lane as usize] = material.pigment.at(point) * light + material.emission;
        }
        radiance
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use glam::{DAffine3, Vec3Swizzles};

    use super::*;
    use crate::{Light, Material, Pigment, Ray, SceneBuilder, Shape, levels};

    /// Shapes and triangles under two suns.
    fn scene() -> Scene {
        let mut builder = SceneBuilder::new();
        let tiles = Pigment::Checker { colors: [Vec3::splat(0.8), Vec3::X], side: 0.3, axes: [0, 2] };
        let floor = builder.material(Material { pigment: tiles, emission: Vec3::splat(0.1) });
        let red = builder.material(Material::matte(Vec3::new(0.8, 0.1, 0.2)));
        builder.shape(Shape::Plane, DAffine3::IDENTITY, floor).unwrap();
        builder.shape(Shape::Sphere, DAffine3::from_translation(DVec3::Y), red).unwrap();
        let corners: Vec<_> = (0..300_u32)
            .map(|i| {
                let f = |k: u32| f64::from(i.wrapping_mul(k) % 997) / 997.0;
                DVec3::new(8.0 * f(271) - 4.0, 3.0 * f(577), 8.0 * f(733) - 4.0)
            })
            .collect();
        let triangles: Vec<_> = (0..298).map(|i| [i, i + 1, i + 2]).collect();
        builder.mesh(&corners, &triangles, |i| if i % 2 == 0 { red } else { floor }, DAffine3::IDENTITY).unwrap();
        builder.light(Light::Ambient { strength: Vec3::splat(0.2) });
        builder.light(Light::sun(DVec3::new(1.0, 2.0, 0.5), Vec3::new(0.5, 0.4, 0.3)).unwrap());
        builder.light(Light::sun(DVec3::new(-3.0, 1.0, 1.5), Vec3::new(0.1, 0.4, 0.3)).unwrap());
        builder.sky(Vec3::new(0.5, 0.6, 0.9));
        builder.build().unwrap()
    }

    #[test]
    fn a_packet_sees_what_its_rays_see_at_every_level() {
        let scene = scene();
        let mut shader = Shader::new(&scene);
        let mut seen = 0;
        for level in levels::all() {
            for row in 0..40 {
                let mut packets: Vec<_> = (0..Axes::CLASSES).map(Packet::new).collect();
                for i in 0..RAYS {
                    let place = Vec3::new(i as f32 / 32.0 - 1.0, row as f32 / 20.0 - 1.0, 0.0);
                    let lens = 0.2 * (place * 37.0).sin();
                    let ray = Ray::single(Vec3::new(0.0, 3.0, 7.0) + lens.yxz(), place - Vec3::new(0.0, 0.4, 1.2));
                    packets[Axes::class_of(ray.direction)].push(&ray);
                }
                for packet in packets.iter_mut().filter(|packet| packet.count() > 0) {
                    let radiance = dispatch!(level, simd => shader.radiance(simd, packet));
                    for (lane, &radiance) in radiance[..packet.count()].iter().enumerate() {
                        assert_eq!(radiance, scene.radiance(&packet.ray(lane)), "{level:?}, {:?}", packet.ray(lane));
                        seen += usize::from(radiance != scene.sky());
                    }
                }
            }
        }
        assert!(seen > 5000, "{seen}: the test would say little");
    }
}

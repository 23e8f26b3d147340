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

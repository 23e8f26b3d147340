//! A point of a surface with all that its material and mesh say of it.

use glam::{DMat3, DVec3, Mat3, Vec2, Vec3, Vec4};

use super::Transport;
use super::bsdf::{Bsdf, Glossy};
use super::fresnel;
use crate::geometry::{Geometry, SurfaceId};
use crate::mesh_detail::{Corners, Patches};
use crate::{Absorption, Alpha, Hit, Material, Matter, Scene, TextureMap};

/// A point seen along a ray.
#[derive(Debug, Clone)]
pub(super) struct SurfacePoint<'a> {
    /// Unit normal of the geometry, on the side that is seen.
    pub(super) outward: DVec3,
    pub(super) bsdf: Bsdf<'a>,
    pub(super) emission: Vec3,
    /// Of solid glass: whether it is seen from inside, and what it takes away there.
    pub(super) glass: Option<(bool, Option<Absorption>)>,
    /// World from the frame of the shading normal, that is z.
    frame: Mat3,
}

impl SurfacePoint<'_> {
    pub(super) fn to_local(&self, world: DVec3) -> Vec3 {
        (self.frame.transpose() * world.as_vec3()).normalize_or(Vec3::Z)
    }

    pub(super) fn to_world(&self, local: Vec3) -> DVec3 {
        (self.frame * local).as_dvec3().normalize_or(self.outward)
    }
}

/// What the mesh says at a point.
struct Place {
    corners: Option<Corners>,
    /// Corners of the triangle.
    sides: [DVec3; 2],
    weights: [f32; 2],
}

impl Place {
    fn new(scene: &Scene, transport: &Transport, hit: &Hit) -> Self {
        if hit.primitive & Geometry::SHAPE != 0 {
            return Self { corners: None, sides: [DVec3::ZERO; 2], weights: [0.0; 2] };
        }
        let still = |geometry: &Geometry, patches: &Patches| {
            let [a, b, c] = geometry.triangle(hit.primitive).corners.map(Vec3::as_dvec3);
            let corners = patches.corners(hit.primitive);
            Self { corners, sides: [b - a, c - a], weights: hit.weights }
        };
        match scene.things() {
            Some(things) if hit.mover != SurfaceId::STILL => {
                let solid = &things.movers[hit.mover as usize].solid;
                still(&solid.geometry, &solid.patches).mapped(&things.place(hit.mover, hit.time).world_from_own.matrix3)
            }
            _ => still(&scene.geometry, &transport.patches),
        }
    }

    /// The same in a space that a map leads to.
    fn mapped(self, linear: &DMat3) -> Self {
        let corners = self.corners.map(|corners| corners.mapped(linear));
        Self { corners, sides: self.sides.map(|side| *linear * side), ..self }
    }

    /// The value of a map, seen with a footprint of this width; `None` where the mesh has no coordinates for it.
    fn map(&self, map: &TextureMap, width: f64) -> Option<Vec4> {
        let uvs = self.corners.as_ref()?.uvs[map.set.min(1)]?;
        let [a, ab, ac] = [uvs[0], uvs[1] - uvs[0], uvs[2] - uvs[0]];
        let uv = a + self.weights[0] * ab + self.weights[1] * ac;
        // How far the coordinates go for each step in the world
        let area = self.sides[0].cross(self.sides[1]).length();
        let ratio = f64::from(ab.perp_dot(ac).abs()) / area.max(f64::MIN_POSITIVE);
        Some(map.at(uv, (width * ratio.sqrt()) as f32))
    }

    fn mix<T>(&self, corners: [T; 3]) -> T
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        corners[0] + (corners[1] - corners[0]) * self.weights[0] + (corners[2] - corners[0]) * self.weights[1]
    }

    /// RGBA that multiplies the material's.
    fn tint(&self, map: Option<&TextureMap>, width: f64) -> Vec4 {
        let colors = self.corners.as_ref().and_then(|corners| corners.colors);
        let own = colors.map_or(Vec4::ONE, |colors| self.mix(colors).clamp(Vec4::ZERO, Vec4::ONE));
        map.and_then(|map| self.map(map, width)).map_or(own, |texel| own * texel)
    }

    /// The normal that the mesh smooths its triangles to, on the outer side.
    fn normal(&self, geometric: DVec3) -> Vec3 {
        let plain = geometric.as_vec3();
        let Some(normals) = self.corners.as_ref().and_then(|corners| corners.normals) else { return plain };
        let unit = normals.map(|normal| normal.try_normalize().unwrap_or(plain));
        let normal = self.mix(unit).try_normalize().unwrap_or(plain);
        // One that leaves the surface's side is wrong
        if normal.dot(plain) > 0.0 { normal } else { plain }
    }

    /// The normal that a map bends a normal to: red along u, green against v.
    fn bent(&self, map: &TextureMap, strength: f32, width: f64, normal: Vec3) -> Option<Vec3> {
        let uvs = self.corners.as_ref()?.uvs[map.set.min(1)]?;
        let [du, dv] = [uvs[1] - uvs[0], uvs[2] - uvs[0]].map(Vec2::as_dvec2);
        let determinant = du.perp_dot(dv);
        let [p, q] = self.sides;
        let along = ((p * dv.y - q * du.y) / determinant).as_vec3();
        let down = ((q * du.x - p * dv.x) / determinant).as_vec3();
        let tangent = along.reject_from_normalized(normal).try_normalize()?;
        let bitangent = (-down).reject_from_normalized(normal).reject_from_normalized(tangent).try_normalize()?;
        let texel = self.map(map, width)?.truncate() * 2.0 - 1.0;
        (tangent * (texel.x * strength) + bitangent * (texel.y * strength) + normal * texel.z).try_normalize()
    }
}

impl Transport {
    /// Alpha of a point: what share of what lies behind it it covers.
    pub(super) fn alpha(&self, scene: &Scene, hit: &Hit, width: f64) -> f32 {
        let finish = &self.finishes[hit.material as usize];
        if finish.alpha == Alpha::Opaque {
            return 1.0;
        }
        let place = Place::new(scene, self, hit);
        let alpha = finish.opacity * place.tint(finish.color_map.as_ref(), width).w;
        match finish.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            Alpha::Blend => alpha.clamp(0.0, 1.0),
        }
    }

    /// What it emits at a point.
    pub(super) fn emission(&self, scene: &Scene, hit: &Hit, width: f64) -> Vec3 {
        let emission = scene.materials[hit.material as usize].emission;
        match &self.finishes[hit.material as usize].emission_map {
            Some(map) if emission != Vec3::ZERO => {
                let place = Place::new(scene, self, hit);
                place.map(map, width).map_or(emission, |texel| emission * texel.truncate())
            }
            _ => emission,
        }
    }

    /// What of light that comes along a direction goes straight through a polished pane; nothing through all else.
    pub(super) fn through_pane(&self, scene: &Scene, hit: &Hit, direction: DVec3) -> Vec3 {
        let point = self.surface(scene, hit, direction, 0.0);
        match point.bsdf {
            Bsdf::Glass { tint, eta, thin: true } => {
                let cosine = point.to_local(-direction).z.clamp(0.0, 1.0);
                tint * (1.0 - fresnel::sheet(cosine, eta))
            }
            _ => Vec3::ZERO,
        }
    }

    /// A point seen along `direction` with a footprint of a width.
    pub(super) fn surface<'a>(&'a self, scene: &Scene, hit: &Hit, direction: DVec3, width: f64) -> SurfacePoint<'a> {
        let (material, finish): (&Material, _) =
            (&scene.materials[hit.material as usize], &self.finishes[hit.material as usize]);
        let place = Place::new(scene, self, hit);
        let color = material.pigment.at(scene.resting(hit)) * place.tint(finish.color_map.as_ref(), width).truncate();

        // Turn the normals to the side that is seen, and keep a bent one only if it is seen too
        let is_inside = hit.normal.dot(direction) > 0.0;
        let outward = if is_inside { -hit.normal } else { hit.normal };
        let smooth = place.normal(hit.normal);
        let bent = finish.normal_map.as_ref().and_then(|(map, scale)| place.bent(map, *scale, width, smooth));
        let side = if is_inside { -1.0 } else { 1.0 };
        let toward_viewer = -direction.as_vec3();
        let is_seen = |normal: &Vec3| (*normal * side).dot(toward_viewer) > 1e-3 * toward_viewer.length();
        let normal = bent.filter(is_seen).or(Some(smooth).filter(is_seen)).map_or(outward.as_vec3(), |n| n * side);
        let (x, y) = normal.any_orthonormal_pair();
        let frame = Mat3::from_cols(x, y, normal);

        let bsdf = match finish.matter {
            Matter::Glossy { metallic, roughness, ior } if self.bounces > 0 => {
                let texel = finish.surface_map.as_ref().and_then(|map| place.map(map, width)).unwrap_or(Vec4::ONE);
                Bsdf::Glossy(Glossy {
                    color: color.min(Vec3::ONE),
                    metallic: (metallic * texel.z).clamp(0.0, 1.0),
                    roughness: (roughness * texel.y).clamp(0.0, 1.0),
                    ior,
                    coat: self.coat(hit.material),
                })
            }
            Matter::Glass { ior, thin, roughness, .. } if self.bounces > 0 => {
                let texel = finish.surface_map.as_ref().and_then(|map| place.map(map, width)).unwrap_or(Vec4::ONE);
                let roughness = (roughness * texel.y).clamp(0.0, 1.0);
                self.glass(color, (ior, thin, roughness), is_inside, hit.material)
            }
            Matter::Matte | Matter::Glossy { .. } | Matter::Glass { .. } => Bsdf::Matte(color),
        };
        let glass = match finish.matter {
            Matter::Glass { thin: false, absorption, .. } if self.bounces > 0 => Some((is_inside, absorption)),
            _ => None,
        };
        SurfacePoint { outward, bsdf, emission: self.emission(scene, hit, width), glass, frame }
    }
}

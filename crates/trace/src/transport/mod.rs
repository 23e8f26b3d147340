//! Light transport beyond the base shading, for scenes that need it.
//!
//! A scene has a [`Transport`] if its surfaces have textures, holes, smooth normals or point lights, or if light goes from
//! surface to surface in it. It is then traced ray by ray; all other scenes keep the packets of `shade`.

mod albedo;
mod bsdf;
mod chain;
mod disc;
mod emitters;
mod environment;
mod footprint;
mod fresnel;
mod gather;
mod microfacet;
mod path;
mod stream;
mod surface;
mod weighing;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::geometry::{Geometry, SurfaceId};
use crate::light::Cone;
use crate::mesh_detail::Patches;
use crate::{Alpha, Finish, Hit, Ray, Scene};
use albedo::{Albedo, PERFECT};
use bsdf::{Bsdf, RoughGlass, SMOOTH};
use emitters::Emitters;
use weighing::Weighing;

pub(crate) use chain::{Bent, Chain};
pub(crate) use disc::Disc;
pub use environment::Environment;
pub(crate) use footprint::Footprint;
pub(crate) use gather::{gather, pixel_size};
pub(crate) use stream::Stream;

/// Surfaces with holes that a ray passes before it is given up.
const MOST_HOLES: usize = 256;

/// Whether glass is rough: hardly bent light is hardly scattered, and its density could not be told in single precision.
fn is_rough(ior: f32, roughness: f32) -> bool {
    /// Refractive index up to which glass is as good as air.
    const AIR: f32 = 1.02;
    roughness >= SMOOTH && ior >= AIR
}

/// A light at a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointLight {
    pub(crate) at: DVec3,
    pub(crate) strength: Vec3,
    pub(crate) cone: Option<Cone>,
}

/// What a scene has beyond that.
#[derive(Debug, Clone)]
pub(crate) struct Transport {
    /// One for each material.
    pub(crate) finishes: Vec<Finish>,
    /// Of what stands still.
    patches: Patches,
    pub(crate) points: Vec<PointLight>,
    pub(crate) discs: Vec<Disc>,
    emitters: Emitters,
    environment: Option<Environment>,
    /// How often light goes from surface to surface.
    bounces: u32,
    /// Why it is needed, in words.
    reasons: Vec<String>,
    has_holes: bool,
    /// Whether anything is a polished pane.
    has_panes: bool,
    /// Coats by material; an index into the other.
    coat_of: Vec<usize>,
    coats: Vec<Arc<Albedo>>,
    /// What rough glass keeps, from outside and from inside, by material.
    panes: Vec<Option<Arc<[Albedo; 2]>>>,
    weighing: Weighing,
}

/// What a builder knows of it.
pub(crate) struct Parts {
    pub(crate) finishes: Vec<Finish>,
    pub(crate) patches: Patches,
    pub(crate) points: Vec<PointLight>,
    pub(crate) discs: Vec<Disc>,
    pub(crate) environment: Option<Environment>,
    pub(crate) bounces: u32,
    pub(crate) reasons: Vec<String>,
}

impl Transport {
    pub(crate) fn new(parts: Parts, geometry: &Geometry, emission: &[Vec3]) -> Self {
        // One table for each refractive index that occurs
        let (mut coats, mut iors, mut coat_of): (Vec<Arc<Albedo>>, Vec<f32>, Vec<usize>) = Default::default();
        for finish in &parts.finishes {
            let crate::Matter::Glossy { ior, .. } = finish.matter else {
                coat_of.push(0);
                continue;
            };
            let known = iors.iter().position(|known| *known == ior).filter(|_| parts.bounces > 0);
            coat_of.push(known.unwrap_or(coats.len()));
            if known.is_none() && parts.bounces > 0 {
                iors.push(ior);
                coats.push(Albedo::of_dielectric(ior));
            }
        }

        let mut known: Vec<(f32, Arc<[Albedo; 2]>)> = Vec::new();
        let panes = parts.finishes.iter().map(|finish| match finish.matter {
            crate::Matter::Glass { ior, thin: false, roughness, .. }
                if parts.bounces > 0 && is_rough(ior, roughness) =>
            {
                if let Some((_, pane)) = known.iter().find(|(other, _)| *other == ior) {
                    return Some(Arc::clone(pane));
                }
                let pane = Arc::new([RoughGlass::kept(ior), RoughGlass::kept(1.0 / ior)]);
                known.push((ior, Arc::clone(&pane)));
                Some(pane)
            }
            _ => None,
        });
        let panes = panes.collect();

        // Ask surfaces for light only if it goes from one to another
        let emits = |material: u32| {
            let finish = &parts.finishes[material as usize];
            let mean = finish.emission_map.as_ref().map_or(Vec3::ONE, |map| map.texture.mean().truncate());
            emission[material as usize] * mean
        };
        let emitters = if parts.bounces > 0 {
            let triangles = parts.patches.names().map(|primitive| {
                let triangle = geometry.triangle(primitive);
                (primitive, triangle.material, triangle.corners)
            });
            Emitters::new(triangles, geometry.shapes(), emits)
        } else {
            Emitters::default()
        };
        let is_pane = |finish: &Finish| matches!(finish.matter, crate::Matter::Glass { thin: true, .. });
        let has_panes = parts.bounces > 0 && parts.finishes.iter().any(is_pane);
        let has_holes = parts.finishes.iter().any(|finish| finish.alpha != Alpha::Opaque);
        Self {
            finishes: parts.finishes,
            patches: parts.patches,
            points: parts.points,
            discs: parts.discs,
            has_panes,
            emitters,
            environment: parts.environment,
            bounces: parts.bounces,
            reasons: parts.reasons,
            has_holes,
            coat_of,
            coats,
            panes,
            weighing: Weighing::default(),
        }
    }

    /// Polished glass, or rough glass where it is rough enough to be told from it.
    fn glass(&self, tint: Vec3, (ior, thin, roughness): (f32, bool, f32), is_inside: bool, material: u32) -> Bsdf<'_> {
        let eta = if is_inside && !thin { 1.0 / ior } else { ior };
        let kept = match &self.panes[material as usize] {
            Some(pane) => &pane[usize::from(is_inside)],
            None if thin => &*PERFECT,
            None => return Bsdf::Glass { tint, eta, thin },
        };
        if !is_rough(ior, roughness) {
            return Bsdf::Glass { tint, eta, thin };
        }
        Bsdf::RoughGlass(RoughGlass { tint, eta, thin, roughness, kept })
    }

    /// How often light goes from surface to surface.
    pub(crate) fn bounces(&self) -> u32 {
        self.bounces
    }

    /// Whether anything has holes.
    pub(crate) fn has_holes(&self) -> bool {
        self.has_holes
    }

    /// Why it is needed.
    pub(crate) fn reasons(&self) -> &[String] {
        &self.reasons
    }

    fn coat(&self, material: u32) -> &Albedo {
        &self.coats[self.coat_of[material as usize]]
    }

    /// Radiance from infinitely far along a direction of any length.
    pub(crate) fn sky(&self, scene: &Scene, direction: DVec3) -> Vec3 {
        self.environment
            .as_ref()
            .map_or(scene.sky, |environment| environment.radiance(direction.normalize_or(DVec3::Y)))
    }

    /// The first surface on a ray but `skip` that is half opaque or more.
    pub(crate) fn solid_hit(&self, scene: &Scene, ray: &Ray, skip: SurfaceId) -> Option<Hit> {
        self.hit_unless(scene, ray, skip, |hit| self.alpha(scene, hit, 0.0) < 0.5)
    }

    /// The first surface on a ray but `skip` that is not passed.
    fn hit_unless(
        &self,
        scene: &Scene,
        ray: &Ray,
        skip: SurfaceId,
        mut is_passed: impl FnMut(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut hit = scene.first(ray, skip)?;
        if !self.has_holes || !is_passed(&hit) {
            return Some(hit);
        }
        // Go on from there, and count from the start
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        for _ in 0..MOST_HOLES {
            let beyond = if hit.normal.dot(direction) < 0.0 { -hit.normal } else { hit.normal };
            let rest = Ray::leaving(hit.point, beyond, direction).timed(ray.time);
            hit = scene.first(&rest, hit.id())?;
            if !is_passed(&hit) {
                hit.t = (hit.point - origin).dot(direction) / direction.length_squared();
                return Some(hit);
            }
        }
        None
    }

    /// The same of light that comes from one point or direction: straight through polished panes too, through which no path would
    /// ever meet it.
    pub(crate) fn shining(&self, scene: &Scene, ray: &Ray, t_max: f64, skip: SurfaceId) -> Vec3 {
        if !self.has_panes {
            return Vec3::splat(self.passing(scene, ray, t_max, skip));
        }
        let mut share = Vec3::ONE;
        let (mut ray, mut skip, mut rest) = (*ray, skip, t_max);
        let direction = ray.direction.as_dvec3();
        for _ in 0..MOST_HOLES {
            let Some(hit) = scene.first(&ray, skip).filter(|hit| hit.t < rest) else { return share };
            let alpha = self.alpha(scene, &hit, 0.0);
            share *= Vec3::splat(1.0 - alpha) + alpha * self.through_pane(scene, &hit, direction);
            if share.max_element() <= 0.0 {
                return Vec3::ZERO;
            }
            let beyond = if hit.normal.dot(direction) < 0.0 { -hit.normal } else { hit.normal };
            rest -= hit.t;
            ray = Ray::leaving(hit.point, beyond, direction).timed(ray.time);
            skip = hit.id();
        }
        Vec3::ZERO
    }

    /// Share of the light that passes along a ray up to `t_max`, the triangle `skip` aside.
    pub(crate) fn passing(&self, scene: &Scene, ray: &Ray, t_max: f64, skip: SurfaceId) -> f32 {
        if !self.has_holes {
            return if scene.blocks(ray, t_max, skip) { 0.0 } else { 1.0 };
        }
        let mut share = 1.0;
        let (mut ray, mut skip, mut rest) = (*ray, skip, t_max);
        for _ in 0..MOST_HOLES {
            let Some(hit) = scene.first(&ray, skip).filter(|hit| hit.t < rest) else { return share };
            share *= 1.0 - self.alpha(scene, &hit, 0.0);
            if share <= 0.0 {
                return 0.0;
            }
            let direction = ray.direction.as_dvec3();
            let beyond = if hit.normal.dot(direction) < 0.0 { -hit.normal } else { hit.normal };
            rest -= hit.t;
            ray = Ray::leaving(hit.point, beyond, direction).timed(ray.time);
            skip = hit.id();
        }
        0.0
    }
}

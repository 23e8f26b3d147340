//! The way of a ray through mirrors and glass to what they show.

use glam::{DVec3, Vec2};

use super::bsdf::{Bsdf, RoughGlass};
use super::{Footprint, fresnel};
use crate::geometry::SurfaceId;
use crate::{Hit, Ray, Scene};

/// Metals up to this roughness show images.
const MIRROR: f32 = 0.1;
/// Surfaces that a ray follows.
const MOST: usize = 12;

/// Where a ray ends.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bent {
    /// On a surface that shows itself.
    At { point: DVec3, normal: DVec3 },
    /// Infinitely far in a unit direction.
    Sky(DVec3),
}

/// The surfaces that bend a ray, and where it ends.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    steps: Vec<(SurfaceId, bool)>,
    pub(crate) end: Bent,
}

/// Whether a surface shows what lies elsewhere, and if so whether by letting through.
fn shows_through(bsdf: &Bsdf<'_>, cosine: f32) -> Option<bool> {
    match bsdf {
        Bsdf::Matte(_) => None,
        Bsdf::Glossy(glossy) => (glossy.metallic > 0.5 && glossy.roughness <= MIRROR).then_some(false),
        Bsdf::RoughGlass(glass) if glass.roughness > MIRROR => None,
        Bsdf::RoughGlass(RoughGlass { eta, .. }) | Bsdf::Glass { eta, .. } => {
            Some(fresnel::dielectric(cosine, *eta) < 0.5)
        }
    }
}

/// The ray that leaves a surface, reflected or let through.
fn bent(scene: &Scene, hit: &Hit, direction: DVec3, choice: Option<bool>) -> Option<(bool, Ray)> {
    let transport = scene.transport.as_ref()?;
    let point = transport.surface(scene, hit, direction, Footprint::SHARP.at(0.0));
    let o = point.to_local(-direction);
    let through = match choice {
        Some(through) => through,
        None => shows_through(&point.bsdf, o.z)?,
    };
    let local = if through {
        // A lobe of 1 never reflects what Fresnel lets through; where glass is a little rough its middle counts
        let smooth = match point.bsdf {
            Bsdf::RoughGlass(RoughGlass { tint, eta, thin, .. }) => Bsdf::Glass { tint, eta, thin },
            bsdf => bsdf,
        };
        smooth.sample(o, 1.0, Vec2::ZERO)?.direction
    } else {
        glam::Vec3::new(-o.x, -o.y, o.z)
    };
    let next = point.to_world(local);
    let side = if next.dot(point.outward) > 0.0 { point.outward } else { -point.outward };
    Some((through, Ray::leaving(hit.point, side, next).timed(hit.time)))
}

impl Chain {
    /// Follows a ray whose first surface is a mirror or glass; `None` if it is not, or the way does not end.
    pub(crate) fn follow(scene: &Scene, ray: &Ray) -> Option<Self> {
        let mut steps = Vec::new();
        let mut ray = *ray;
        let mut hit = scene.hit(&ray);
        loop {
            let direction = ray.direction.as_dvec3();
            let Some(at) = hit else {
                let end = Bent::Sky(direction.normalize_or(DVec3::Z));
                return (!steps.is_empty()).then_some(Self { steps, end });
            };
            let Some((through, next)) = bent(scene, &at, direction, None) else {
                let end = Bent::At { point: at.point, normal: at.normal };
                return (!steps.is_empty()).then_some(Self { steps, end });
            };
            if steps.len() == MOST {
                return None;
            }
            steps.push((at.id(), through));
            hit = scene.hit_from(&next, at.id());
            ray = next;
        }
    }

    /// Where another ray ends that goes by the same surfaces: on the plane that touches the same surface; `None` if it misses
    /// one of them.
    pub(crate) fn same_way(&self, scene: &Scene, ray: &Ray) -> Option<Bent> {
        let mut ray = *ray;
        let mut from = SurfaceId::NONE;
        for &(id, through) in &self.steps {
            let hit = scene.hit_from(&ray, from).filter(|hit| hit.id() == id)?;
            ray = bent(scene, &hit, ray.direction.as_dvec3(), Some(through))?.1;
            from = id;
        }
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        match self.end {
            Bent::Sky(_) => Some(Bent::Sky(direction.normalize_or(DVec3::Z))),
            Bent::At { point, normal } => {
                let t = normal.dot(point - origin) / normal.dot(direction);
                (t > 0.0 && t.is_finite()).then(|| Bent::At { point: origin + t * direction, normal })
            }
        }
    }
}

//! A scene, ready to be looked at.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use optics::Camera;

use crate::geometry::{Geometry, Hit, SurfaceId};
use crate::sampler::Sampler;
use crate::stage::{Mover, Stage, Things};
use crate::transport::{Footprint, Stream, Transport};
use crate::{Exposure, Material, Ray};

/// The largest radiance that a scene may hold: sums of samples stay exact up to here (see `Accumulation`).
pub const MAX_RADIANCE: f32 = 262_144.0;

/// Surfaces, lights and sky during an exposure; immutable, shared by all threads. Clones share all that is large.
#[derive(Debug, Clone)]
pub struct Scene {
    /// All that stands still.
    pub(crate) geometry: Arc<Geometry>,
    /// All that moves.
    pub(crate) movers: Arc<[Mover]>,
    pub(crate) stage: Arc<Stage>,
    pub(crate) exposure: Exposure,
    pub(crate) materials: Vec<Material>,
    pub(crate) ambient: Vec3,
    pub(crate) suns: Vec<(DVec3, Vec3)>,
    pub(crate) sky: Vec3,
    pub(crate) shadow_bias: f64,
    pub(crate) metres_per_unit: Option<f64>,
    pub(crate) transport: Option<Arc<Transport>>,
    /// By material.
    pub(crate) double_sided: Vec<bool>,
}

impl Scene {
    /// The same scene during another exposure; as built it is one of no length at frame 0.
    #[must_use]
    pub fn exposed(&self, exposure: &Exposure) -> Self {
        let stage = Arc::new(Stage::new(&self.movers, exposure));
        Self { stage, exposure: exposure.clone(), ..self.clone() }
    }

    /// The same scene as it stands in the middle of its exposure, where depth and layers are those of.
    #[must_use]
    pub fn stopped(&self) -> Self {
        if self.is_timed() { self.exposed(&self.exposure.stopped()) } else { self.clone() }
    }

    /// The exposure.
    #[must_use]
    pub fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// How many things move during the exposure.
    #[must_use]
    pub fn moving_things(&self) -> usize {
        self.stage.moving()
    }

    /// Whether anything moves during the exposure, the camera or a thing.
    #[must_use]
    pub fn is_timed(&self) -> bool {
        self.exposure.moves_camera() || self.stage.moving() > 0
    }

    /// The first and the last frame in which something has a key, if anything ever moves.
    #[must_use]
    pub fn frames(&self) -> Option<[f64; 2]> {
        let frames = self.movers.iter().filter_map(|mover| mover.motion.frames());
        frames.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// A picture's camera at a time of the exposure.
    pub(crate) fn camera(&self, middle: &Camera, time: f32) -> Camera {
        self.exposure.camera(middle, time)
    }

    /// What moves, if anything does.
    pub(crate) fn things(&self) -> Option<Things<'_>> {
        let things = Things { movers: &self.movers, stage: &self.stage, exposure: &self.exposure };
        (!self.movers.is_empty()).then_some(things)
    }

    /// The first surface on a ray but `skip`, whatever holes it has.
    #[inline]
    pub(crate) fn first(&self, ray: &Ray, skip: SurfaceId) -> Option<Hit> {
        let found = self.geometry.hit_skipping(ray, skip.within(SurfaceId::STILL));
        match self.things() {
            None => found,
            Some(things) => things.first(&self.geometry, ray, skip, found),
        }
    }

    /// Whether any surface but `skip` lies on a ray before `t_max`, whatever holes it has.
    #[inline]
    pub(crate) fn blocks(&self, ray: &Ray, t_max: f64, skip: SurfaceId) -> bool {
        self.geometry.is_blocked(ray, t_max, skip.within(SurfaceId::STILL))
            || self.things().is_some_and(|things| things.block(&self.geometry, ray, t_max, skip))
    }

    /// Where a pattern that is fixed in the world is looked up for a point: what moves takes it along.
    #[inline]
    pub(crate) fn resting(&self, hit: &Hit) -> DVec3 {
        match self.things() {
            Some(things) if hit.mover != SurfaceId::STILL => things.resting(hit),
            _ => hit.point,
        }
    }

    /// The first surface that the ray meets; holes in it are none, and what covers less than half of what lies behind it.
    #[must_use]
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.hit_from(ray, SurfaceId::NONE)
    }

    /// The first surface that the ray meets but the triangle `skip`.
    pub(crate) fn hit_from(&self, ray: &Ray, skip: SurfaceId) -> Option<Hit> {
        match &self.transport {
            None => self.first(ray, skip),
            Some(transport) => transport.solid_hit(self, ray, skip),
        }
    }

    /// Whether a surface lies on the ray at t in (0, `t_max`).
    #[must_use]
    pub fn is_blocked(&self, ray: &Ray, t_max: f64) -> bool {
        self.is_blocked_skipping(ray, t_max, SurfaceId::NONE)
    }

    fn is_blocked_skipping(&self, ray: &Ray, t_max: f64, skip: SurfaceId) -> bool {
        match &self.transport {
            Some(transport) if transport.has_holes() => {
                transport.solid_hit(self, ray, skip).is_some_and(|hit| hit.t < t_max)
            }
            _ => self.blocks(ray, t_max, skip),
        }
    }

    /// Whether a surface other than `from`'s own lies between it and `target`.
    #[must_use]
    pub fn is_hidden(&self, from: &Hit, normal: DVec3, target: DVec3) -> bool {
        let ray = Ray::leaving(from.point, normal, target - from.point).timed(from.time);
        self.is_blocked_skipping(&ray, 1.0, from.id())
    }

    /// The next surface along `direction` from a point of another one, on the side that `normal` points to.
    pub(crate) fn hit_beyond(&self, from: &Hit, normal: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray::leaving(from.point, normal, direction).timed(from.time);
        self.hit_from(&ray, from.id())
    }

    /// The surface as it is seen along `direction`: the back of a double-sided one is its outer side too.
    pub(crate) fn facing(&self, hit: Hit, direction: DVec3) -> Hit {
        let turns = self.double_sided[hit.material as usize] && hit.normal.dot(direction) > 0.0;
        if turns { Hit { normal: -hit.normal, ..hit } } else { hit }
    }

    /// How often light goes from surface to surface: 0 with the base shading.
    #[must_use]
    pub fn bounces(&self) -> u32 {
        self.transport.as_ref().map_or(0, |transport| transport.bounces())
    }

    /// What of the scene needs more than the base shading, in words; nothing where packets of rays will do.
    #[must_use]
    pub fn needs(&self) -> &[String] {
        self.transport.as_ref().map_or(&[], |transport| transport.reasons())
    }

    /// Radiance that comes along a ray: of the first surface, or the sky; in a scene with bounces by one path of light.
    #[inline]
    #[must_use]
    pub fn radiance(&self, ray: &Ray) -> Vec3 {
        if let Some(transport) = &self.transport {
            return transport.radiance(
                self,
                ray,
                Footprint::SHARP,
                &mut Stream::new(&Sampler::new(0, 0, 0, 0), 0, false),
            );
        }
        self.hit(ray).map_or(self.sky, |hit| self.shade(&hit, ray.direction.as_dvec3()))
    }

    /// Radiance of a surface seen along a ray of a sample of a pixel.
    pub(crate) fn shade_sample(
        &self,
        hit: &Hit,
        direction: DVec3,
        pixel_size: f64,
        (sampler, index): (&Sampler, u32),
    ) -> Vec3 {
        let Some(transport) = &self.transport else { return self.shade(hit, direction) };
        let footprint = Footprint::of_pixel(pixel_size);
        transport.shade(self, hit, direction, footprint, &mut Stream::new(sampler, index, false))
    }

    /// Radiance of a surface seen along `direction`: Kd (ambient + sum of sun max(0, n . l) V) + emission, with the
    /// geometric normal turned towards the viewer; in a scene that [needs](Self::needs) more by one path of light.
    #[inline]
    #[must_use]
    pub fn shade(&self, hit: &Hit, direction: DVec3) -> Vec3 {
        if let Some(transport) = &self.transport {
            let mut stream = Stream::new(&Sampler::new(0, 0, 0, 0), 0, false);
            return transport.shade(self, hit, direction, Footprint::SHARP, &mut stream);
        }
        let material = &self.materials[hit.material as usize];
        let normal = if hit.normal.dot(direction) > 0.0 { -hit.normal } else { hit.normal };
        let mut light = self.ambient;
        for &(toward, strength) in &self.suns {
            let cosine = normal.dot(toward);
            if cosine > 0.0 {
                let ray = self.shadow_ray(hit.point, normal, toward);
                if !self.geometry.is_blocked(&ray, f64::INFINITY, hit.primitive) {
                    light += strength * cosine as f32;
                }
            }
        }
        material.pigment.at(hit.point) * light + material.emission
    }

    /// The ray from a surface towards a sun.
    #[inline]
    pub(crate) fn shadow_ray(&self, point: DVec3, normal: DVec3, toward: DVec3) -> Ray {
        let bias = self.shadow_bias * (1.0 + point.abs().max_element());
        Ray::leaving(point + bias * normal, normal, toward)
    }

    /// Radiance where nothing is hit in a direction.
    #[must_use]
    pub fn sky_toward(&self, direction: DVec3) -> Vec3 {
        self.transport.as_ref().map_or(self.sky, |transport| transport.sky(self, direction))
    }

    /// Radiance where nothing is hit, unless an environment tells it for each direction.
    #[must_use]
    pub fn sky(&self) -> Vec3 {
        self.sky
    }

    /// Bytes of memory that its surfaces occupy, with the tree over them.
    #[must_use]
    pub fn bytes(&self) -> usize {
        // Copies share their surfaces
        let mut counted = BTreeSet::new();
        let solids = self.movers.iter().filter(|mover| counted.insert(Arc::as_ptr(&mover.solid)));
        self.geometry.bytes() + solids.map(|mover| mover.solid.geometry.bytes()).sum::<usize>()
    }

    /// Metres in one scene unit, where known.
    #[must_use]
    pub fn metres_per_unit(&self) -> Option<f64> {
        self.metres_per_unit
    }
}

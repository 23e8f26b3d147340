//! A scene, ready to be looked at.

use glam::{DVec3, Vec3};

use crate::geometry::{Geometry, Hit};
use crate::sampler::Sampler;
use crate::transport::{Footprint, Stream, Transport};
use crate::{Material, Ray};

/// The largest radiance that a scene may hold: sums of samples stay exact up to here (see `Accumulation`).
pub const MAX_RADIANCE: f32 = 262_144.0;

/// Surfaces, lights and sky; immutable, shared by all threads.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(crate) geometry: Geometry,
    pub(crate) materials: Vec<Material>,
    pub(crate) ambient: Vec3,
    pub(crate) suns: Vec<(DVec3, Vec3)>,
    pub(crate) sky: Vec3,
    pub(crate) shadow_bias: f64,
    pub(crate) metres_per_unit: Option<f64>,
    pub(crate) transport: Option<Box<Transport>>,
    /// By material.
    pub(crate) double_sided: Vec<bool>,
}

impl Scene {
    /// The first surface that the ray meets; holes in it are none, and what covers less than half of what lies behind it.
    #[must_use]
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.hit_from(ray, Geometry::NO_PRIMITIVE)
    }

    /// The first surface that the ray meets but the triangle `skip`.
    pub(crate) fn hit_from(&self, ray: &Ray, skip: u32) -> Option<Hit> {
        match &self.transport {
            None => self.geometry.hit_skipping(ray, skip),
            Some(transport) => transport.solid_hit(self, ray, skip),
        }
    }

    /// Whether a surface lies on the ray at t in (0, `t_max`).
    #[must_use]
    pub fn is_blocked(&self, ray: &Ray, t_max: f64) -> bool {
        self.is_blocked_skipping(ray, t_max, Geometry::NO_PRIMITIVE)
    }

    fn is_blocked_skipping(&self, ray: &Ray, t_max: f64, skip: u32) -> bool {
        match &self.transport {
            Some(transport) if transport.has_holes() => {
                transport.solid_hit(self, ray, skip).is_some_and(|hit| hit.t < t_max)
            }
            _ => self.geometry.is_blocked(ray, t_max, skip),
        }
    }

    /// Whether a surface other than `from`'s own lies between it and `target`.
    #[must_use]
    pub fn is_hidden(&self, from: &Hit, normal: DVec3, target: DVec3) -> bool {
        let ray = Ray::leaving(from.point, normal, target - from.point);
        self.is_blocked_skipping(&ray, 1.0, from.primitive)
    }

    /// The next surface along `direction` from a point of another one, on the side that `normal` points to.
    pub(crate) fn hit_beyond(&self, from: &Hit, normal: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray::leaving(from.point, normal, direction);
        self.hit_from(&ray, from.primitive)
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
        self.geometry.bytes()
    }

    /// Metres in one scene unit, where known.
    #[must_use]
    pub fn metres_per_unit(&self) -> Option<f64> {
        self.metres_per_unit
    }
}

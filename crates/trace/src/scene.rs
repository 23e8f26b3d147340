//! A scene, ready to be looked at.

use glam::{DAffine3, DVec3, Vec3};

use crate::geometry::{Geometry, Hit, Triangle};
use crate::shape::PlacedShape;
use crate::{Light, Material, Ray, SceneError, Shape};

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
    shadow_bias: f64,
    metres_per_unit: Option<f64>,
}

impl Scene {
    /// The first surface that the ray meets.
    #[must_use]
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.geometry.hit(ray)
    }

    /// Whether a surface lies on the ray at t in (0, `t_max`).
    #[must_use]
    pub fn is_blocked(&self, ray: &Ray, t_max: f64) -> bool {
        self.geometry.is_blocked(ray, t_max, Geometry::NO_PRIMITIVE)
    }

    /// Whether a surface other than `from`'s own lies between it and `target`.
    #[must_use]
    pub fn is_hidden(&self, from: &Hit, normal: DVec3, target: DVec3) -> bool {
        let ray = Ray::leaving(from.point, normal, target - from.point);
        self.geometry.is_blocked(&ray, 1.0, from.primitive)
    }

    /// The next surface along `direction` from a point of another one, on the side that `normal` points to.
    pub(crate) fn hit_beyond(&self, from: &Hit, normal: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray::leaving(from.point, normal, direction);
        self.geometry.hit_skipping(&ray, from.primitive)
    }

    /// Radiance that comes along a ray: of the first surface, or the sky.
    #[inline]
    #[must_use]
    pub fn radiance(&self, ray: &Ray) -> Vec3 {
        self.hit(ray).map_or(self.sky, |hit| self.shade(&hit, ray.direction.as_dvec3()))
    }

    /// Radiance of a surface seen along `direction`: Kd (ambient + sum of sun max(0, n . l) V) + emission, with the
    /// geometric normal turned towards the viewer.
    #[inline]
    #[must_use]
    pub fn shade(&self, hit: &Hit, direction: DVec3) -> Vec3 {
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

    /// Radiance where nothing is hit.
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

/// Collects the parts of a [`Scene`].
#[derive(Debug, Clone, Default)]
pub struct SceneBuilder {
    triangles: Vec<Triangle>,
    shapes: Vec<PlacedShape>,
    materials: Vec<Material>,
    lights: Vec<Light>,
    sky: Vec3,
    shadow_bias: f64,
    metres_per_unit: Option<f64>,
}

/// A material of a [`SceneBuilder`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialId(u32);

impl SceneBuilder {
    /// An empty, black scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId((self.materials.len() - 1) as u32)
    }

    /// Adds a canonical shape under an affine map, which must be finite and invertible.
    pub fn shape(&mut self, shape: Shape, world_from_local: DAffine3, material: MaterialId) -> Result<(), SceneError> {
        self.shapes.push(PlacedShape::new(shape, world_from_local, material.0)?);
        Ok(())
    }

    /// Adds triangles: `corners` are indices into `vertices`, counter-clockwise seen from outside, each triangle with
    /// its own material. Triangles without area, or with a corner that is not finite, can never be seen: they are left
    /// out, and their number is returned.
    pub fn mesh(
        &mut self,
        vertices: &[DVec3],
        corners: &[[u32; 3]],
        materials: impl Fn(usize) -> MaterialId,
        world_from_local: DAffine3,
    ) -> Result<usize, SceneError> {
        // Rounding once per vertex keeps neighbours together
        let world: Vec<Vec3> = vertices.iter().map(|&v| world_from_local.transform_point3(v).as_vec3()).collect();
        let mut dropped = 0;
        for (triangle, indices) in corners.iter().enumerate() {
            if let Some(&vertex) = indices.iter().find(|&&i| i as usize >= world.len()) {
                return Err(SceneError::NoSuchVertex { triangle, vertex, count: world.len() });
            }
            let corners = indices.map(|i| world[i as usize]);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let area = (b - a).cross(c - a).length();
            if area > 0.0 && area.is_finite() {
                self.triangles.push(Triangle { corners, material: materials(triangle).0 });
            } else {
                dropped += 1;
            }
        }
        Ok(dropped)
    }

    /// Adds a light.
    pub fn light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// Sets the radiance of what is infinitely far away.
    pub fn sky(&mut self, radiance: Vec3) {
        self.sky = radiance;
    }

    /// Starts shadow rays off the surface by `share` x (1 + the point's largest coordinate).
    ///
    /// The default 0 is exact. Other renderers use a bias against self-shadowing (Mitsuba 3: 8.9e-5), which shortens
    /// the shadows of things that touch; with the same bias their pictures can be compared.
    pub fn shadow_bias(&mut self, share: f64) -> Result<(), SceneError> {
        if !(0.0..=1.0).contains(&share) {
            return Err(SceneError::OutOfRange { what: "shadow bias", value: share, wanted: "0 to 1" });
        }
        self.shadow_bias = share;
        Ok(())
    }

    /// Says how many metres one scene unit is.
    pub fn metres_per_unit(&mut self, metres: f64) -> Result<(), SceneError> {
        positive("metres per unit", metres)?;
        self.metres_per_unit = Some(metres);
        Ok(())
    }

    /// The scene; every colour and light must be finite and not negative, and no surface brighter than
    /// [`MAX_RADIANCE`].
    pub fn build(self) -> Result<Scene, SceneError> {
        let mut total = Vec3::ZERO;
        for light in &self.lights {
            not_negative("strength of a light", light.strength())?;
            total += light.strength();
        }
        not_negative("radiance of the sky", self.sky)?;
        not_too_bright("radiance of the sky", self.sky.max_element())?;
        for material in &self.materials {
            match material.pigment {
                crate::Pigment::Constant(color) => not_negative("color of a material", color)?,
                crate::Pigment::Checker { colors, side, axes } => {
                    not_negative("color of a checker", colors[0])?;
                    not_negative("color of a checker", colors[1])?;
                    positive("side of a checker's tiles", side)?;
                    if axes.iter().any(|&axis| axis > 2) {
                        let value = axes[0].max(axes[1]) as f64;
                        return Err(SceneError::OutOfRange { what: "axis of a checker", value, wanted: "0, 1 or 2" });
                    }
                }
            }
            not_negative("emission of a material", material.emission)?;
            not_too_bright("radiance of a material", material.brightest(total.max_element()))?;
        }
        let mut ambient = Vec3::ZERO;
        let mut suns = Vec::new();
        for light in self.lights {
            match light {
                Light::Ambient { strength } => ambient += strength,
                Light::Sun { toward, strength } => suns.push((toward, strength)),
            }
        }
        Ok(Scene {
            geometry: Geometry::new(self.triangles, self.shapes)?,
            materials: self.materials,
            ambient,
            suns,
            sky: self.sky,
            shadow_bias: self.shadow_bias,
            metres_per_unit: self.metres_per_unit,
        })
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), SceneError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(SceneError::OutOfRange { what, value, wanted: "positive and finite" })
}

fn not_negative(what: &'static str, color: Vec3) -> Result<(), SceneError> {
    match color.to_array().into_iter().find(|&x| !(x >= 0.0 && x.is_finite())) {
        Some(value) => Err(SceneError::OutOfRange { what, value: f64::from(value), wanted: "0 or more, and finite" }),
        None => Ok(()),
    }
}

fn not_too_bright(what: &'static str, value: f32) -> Result<(), SceneError> {
    if value <= MAX_RADIANCE {
        return Ok(());
    }
    Err(SceneError::OutOfRange { what, value: f64::from(value), wanted: "at most 262144; use a larger unit of light" })
}

//! What lies behind the first surface and is seen by some point of the lens.

use glam::{DVec2, DVec3, Vec3};
use optics::Camera;

use super::lens_points::lens_points;
use crate::sampler::Sampler;
use crate::transport::pixel_size;
use crate::{Hit, Ray, Scene};

/// Surfaces that a ray passes before it is given up.
const MOST_SURFACES: usize = 64;
/// How far a sample may lie from the plane that touches the surface at the pixel's centre, over its depth.
const SAME_SURFACE: f64 = 0.01;

/// A surface of a hidden layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    pub(super) depth: f32,
    pub(super) color: Vec3,
}

/// The ray through a continuous pixel coordinate from the lens centre.
pub(super) fn pinhole_ray(camera: &Camera, x: f64, y: f64) -> Ray {
    let direction = camera.film.q_from_pixel(DVec2::new(x, y)).extend(1.0);
    Ray::new(camera.pose.position, camera.pose.direction_to_world(direction))
}

/// Walks along the rays of pixels, from surface to surface.
pub(super) struct Walk<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    lens: Vec<DVec3>,
    count: usize,
    /// Of each pixel and half, those samples that the first layer's colour is the mean of.
    samples: u32,
    seed: u64,
}

impl<'a> Walk<'a> {
    /// A walk that collects up to `count` surfaces a pixel, with `samples` in each half.
    pub(super) fn new(scene: &'a Scene, camera: &'a Camera, count: usize, samples: u32, seed: u64) -> Self {
        Self { scene, camera, lens: lens_points(camera), count, samples, seed }
    }

    /// The surfaces behind the first one at a pixel's centre that some lens point sees, from near to far; the sky ends
    /// them.
    pub(super) fn hidden_surfaces(&self, x: i32, y: i32) -> Vec<Surface> {
        let ray = pinhole_ray(self.camera, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let direction = ray.direction.as_dvec3();
        let mut found = Vec::new();
        let Some(first) = self.scene.hit(&ray) else { return found };
        let mut from = first;
        for _ in 0..MOST_SURFACES {
            if found.len() == self.count {
                break;
            }
            let Some(hit) = self.next(&from, direction) else {
                if self.sees_sky(direction) {
                    found.push(Surface { depth: f32::INFINITY, color: self.scene.sky_toward(direction) });
                }
                break;
            };
            if hit.normal.dot(direction) < 0.0 && self.sees(&hit) {
                let depth = self.camera.pose.point_to_camera(hit.point).z;
                found.push(Surface { depth: depth as f32, color: self.color(x, y, &hit, direction) });
            }
            from = hit;
        }
        found
    }

    /// The next surface behind one.
    fn next(&self, from: &Hit, direction: DVec3) -> Option<Hit> {
        let outwards = if from.normal.dot(direction) < 0.0 { -from.normal } else { from.normal };
        let hit = self.scene.hit_beyond(from, outwards, direction)?;
        Some(self.scene.facing(hit, direction))
    }

    /// Whether some lens point sees the outer side of a surface.
    fn sees(&self, hit: &Hit) -> bool {
        self.lens.iter().any(|&l| hit.normal.dot(l - hit.point) > 0.0 && !self.scene.is_hidden(hit, hit.normal, l))
    }

    /// Whether some lens point sees the sky in this direction.
    fn sees_sky(&self, direction: DVec3) -> bool {
        self.lens.iter().any(|&l| !self.scene.is_blocked(&Ray::new(l, direction), f64::INFINITY))
    }

    /// The average colour of a surface over the pixel, from the samples that hit it.
    fn color(&self, x: i32, y: i32, centre: &Hit, direction: DVec3) -> Vec3 {
        let size = pixel_size(self.camera);
        let samplers = [0, 1].map(|half| Sampler::new(self.seed, x, y, half));
        // Other light than that of any sample, where light is left to chance
        let mut sum = self.scene.shade_sample(centre, direction, size, (&samplers[0], self.samples)).as_dvec3();
        let mut count = 1.0;
        for (sampler, index) in samplers.iter().flat_map(|sampler| (0..self.samples).map(move |i| (sampler, i))) {
            let offset = sampler.sample(index).pixel;
            let ray = pinhole_ray(self.camera, f64::from(x) + offset.x, f64::from(y) + offset.y);
            if let Some(hit) = self.same_surface(&ray, centre) {
                let direction = ray.direction.as_dvec3();
                sum += self.scene.shade_sample(&hit, direction, size, (sampler, index)).as_dvec3();
                count += 1.0;
            }
        }
        (sum / count).as_vec3()
    }

    /// Where a ray through the same pixel meets the surface that `centre` lies on.
    fn same_surface(&self, ray: &Ray, centre: &Hit) -> Option<Hit> {
        let direction = ray.direction.as_dvec3();
        // The touching plane says where to expect it
        let slope = centre.normal.dot(direction);
        if slope >= 0.0 {
            return None;
        }
        let expected = centre.normal.dot(centre.point - ray.origin.as_dvec3()) / slope;
        let mut hit = self.scene.facing(self.scene.hit(ray)?, direction);
        for _ in 0..MOST_SURFACES {
            let t = (hit.point - ray.origin.as_dvec3()).dot(direction) / direction.length_squared();
            if (t - expected).abs() <= SAME_SURFACE * expected && hit.normal.dot(direction) < 0.0 {
                return Some(hit);
            }
            if t > expected * (1.0 + SAME_SURFACE) {
                return None;
            }
            hit = self.next(&hit, direction)?;
        }
        None
    }
}

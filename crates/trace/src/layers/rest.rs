//! What of a pixel's colour belongs to another surface than the one at its centre.

use glam::{DVec2, DVec3, Vec3};
use optics::Camera;
use rgbd::{PixelRest, Plane};

use super::facing::Facing;
use super::walk::pinhole_ray;
use crate::sampler::Sampler;
use crate::transport::pixel_size;
use crate::{Ray, Scene};

/// Samples of each half that look for things which no pixel's centre meets.
const PROBES: u32 = 4;

/// Looks into pixels with the very samples that their colour is the mean of.
pub(super) struct Inside<'a> {
    pub(super) scene: &'a Scene,
    /// A pinhole.
    pub(super) camera: &'a Camera,
    /// Samples in each half.
    pub(super) samples: u32,
    pub(super) seed: u64,
}

/// A sample that meets another surface.
struct Other {
    is_nearer: bool,
    inverse: f64,
    color: Vec3,
}

impl Inside<'_> {
    /// The rest of a pixel; `depth` holds those of all centres.
    ///
    /// Where the centres around lie on the same surface only a few samples look for something thin. Of several other surfaces
    /// in one pixel the nearer or the farther ones count, whichever fill more of it.
    pub(super) fn rest(&self, x: i32, y: i32, depth: &Plane) -> Option<PixelRest> {
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (own, _) = self.look(&self.ray(middle));
        let is_other = |q: DVec2, inverse: f64| own.is_other(q, inverse);
        let mut around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let beside_edge = around.any(|(dx, dy)| {
            let there = depth.get(x + dx, y + dy);
            let q = self.camera.film.q_from_pixel(middle + DVec2::new(f64::from(dx), f64::from(dy)));
            there.is_some_and(|z| is_other(q, 1.0 / f64::from(z)))
        });

        let size = pixel_size(self.camera);
        let look = |samples: u32| {
            let of_half = |half| {
                let sampler = Sampler::new(self.seed, x, y, half);
                (0..samples).map(move |index| (sampler, index))
            };
            let others = [0, 1].into_iter().flat_map(of_half).filter_map(|(sampler, index)| {
                let at = DVec2::new(f64::from(x), f64::from(y)) + sampler.sample(index).pixel;
                let q = self.camera.film.q_from_pixel(at);
                let ray = self.ray(at);
                let (facing, hit) = self.look(&ray);
                let direction = ray.direction.as_dvec3();
                let color = || match hit {
                    Some(hit) => self.scene.shade_sample(&hit, direction, size, (&sampler, index)),
                    None => self.scene.sky_toward(direction),
                };
                let is_nearer = facing.inverse > own.plane_at(q);
                is_other(q, facing.inverse).then(|| Other { is_nearer, inverse: facing.inverse, color: color() })
            });
            others.collect::<Vec<_>>()
        };
        if !beside_edge && look(PROBES.min(self.samples)).is_empty() {
            return None;
        }
        let mut others = look(self.samples);
        let nearer = others.iter().filter(|other| other.is_nearer).count();
        let take_nearer = 2 * nearer >= others.len();
        others.retain(|other| other.is_nearer == take_nearer);

        // Depth is no mean; that of the middle one holds at the rim of round things too, where a plane tells nothing
        others.sort_by(|a, b| a.inverse.total_cmp(&b.inverse));
        let inverse = others.get(others.len() / 2)?.inverse;
        let total = f64::from(2 * self.samples);
        let sum: DVec3 = others.iter().map(|other| other.color.as_dvec3()).sum();
        let [r, g, b] = (sum / total).as_vec3().to_array();
        let share = others.len() as f64 / total;
        Some(PixelRest { rgba: [r, g, b, share as f32], depth: (1.0 / inverse) as f32 })
    }

    fn ray(&self, at: DVec2) -> Ray {
        pinhole_ray(self.camera, at.x, at.y)
    }

    /// What a ray meets.
    fn look(&self, ray: &Ray) -> (Facing, Option<crate::Hit>) {
        let hit = self.scene.hit(ray);
        (Facing::new(self.camera, hit.as_ref()), hit)
    }
}

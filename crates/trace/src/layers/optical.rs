//! How far away what a pixel shows seems to be, when it is seen in a mirror or through glass.

use glam::{DVec2, DVec3};
use optics::Camera;
use rayon::prelude::*;
use rgbd::{PixelWindow, Plane};

use super::walk::pinhole_ray;
use crate::transport::{Bent, Chain};
use crate::{Ray, Scene};

/// Step across the lens and across the picture, over the distance of what is seen: small against what is curved, large
/// against rounding to f32.
const STEP: f64 = 2e-3;

/// The optical depth of the pixels of a window at their centres: the planar depth of the point from which light seems to come.
///
/// Where the first surface is a mirror (a metal of roughness 0.1 at most) or glass, rays are followed to what they show. Two
/// neighbouring rays through another point of the lens, and in another direction, tell where light meets: a lens at that depth
/// of focus shows it sharp, whatever curved mirrors and glass lie between; what a curved mirror's image is blurred by in
/// the other direction (astigmatism) is averaged. Images behind the viewer and beyond infinity count as infinitely far. Elsewhere it
/// is the depth of the first surface, +inf where there is none.
#[must_use]
pub fn optical_depth(scene: &Scene, camera: &Camera, window: PixelWindow) -> Plane {
    let (scene, pinhole) = (&scene.stopped(), camera.pinhole());
    let mut depths = Plane::filled(window, f32::INFINITY);
    depths.values_mut().par_chunks_mut(window.width.max(1) as usize).enumerate().for_each(|(row, depths)| {
        for (column, depth) in depths.iter_mut().enumerate() {
            let at = DVec2::new(f64::from(window.x + column as i32) + 0.5, f64::from(window.y + row as i32) + 0.5);
            *depth = seen_at(scene, &pinhole, at) as f32;
        }
    });
    depths
}

fn seen_at(scene: &Scene, camera: &Camera, at: DVec2) -> f64 {
    let chief = pinhole_ray(camera, at.x, at.y);
    let Some(first) = scene.hit(&chief) else { return f64::INFINITY };
    let plain = camera.pose.point_to_camera(first.point).z;
    let Some(chain) = Chain::follow(scene, &chief) else { return plain };

    // Move the ray on the lens and turn it, in both directions of the picture
    let (origin, direction) = (chief.origin.as_dvec3(), chief.direction.as_dvec3());
    let (mut along, mut square) = (0.0, 0.0);
    for axis in [DVec3::X, DVec3::Y].map(|axis| camera.pose.direction_to_world(axis)) {
        let moved = Ray::new(origin + STEP * plain * axis, direction);
        let turned = Ray::new(origin, direction + STEP * axis);
        let [Some(moved), Some(turned)] = [moved, turned].map(|ray| chain.shift(scene, &ray)) else { return plain };
        along += moved.dot(turned) / plain;
        square += turned.length_squared();
    }
    // What is seen stays where it is if the ray turns by the move over the depth
    let inverse = along / square;
    if inverse > 1e-9 / plain { 1.0 / inverse } else { f64::INFINITY }
}

/// Where a ray through mirrors and glass ends, as far as a chain of surfaces is known.
impl Chain {
    /// How far another ray by the same surfaces ends from where this one did.
    fn shift(&self, scene: &Scene, ray: &Ray) -> Option<DVec3> {
        match (self.end, self.same_way(scene, ray)?) {
            (Bent::At { point, .. }, Bent::At { point: other, .. }) => Some(other - point),
            (Bent::Sky(direction), Bent::Sky(other)) => Some(other - direction),
            _ => None,
        }
    }
}

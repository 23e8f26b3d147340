//! Along lines of sight from the lens centre, from surface to surface, and whether some point of the lens sees them.

use glam::{DVec2, DVec3};
use optics::Camera;

use super::facing::Facing;
use super::lens_points::lens_points;
use crate::{Hit, Ray, Scene};

/// Surfaces that a ray passes before it is given up.
const MOST_SURFACES: usize = 64;

/// The ray through a continuous pixel coordinate from the lens centre.
pub(super) fn pinhole_ray(camera: &Camera, x: f64, y: f64) -> Ray {
    let direction = camera.film.q_from_pixel(DVec2::new(x, y)).extend(1.0);
    Ray::new(camera.pose.position, camera.pose.direction_to_world(direction))
}

/// A scene and the lens that looks at it.
pub(super) struct Walk<'a> {
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    lens: Vec<DVec3>,
}

/// What lies on a line of sight: a surface, or at its end the sky.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub(super) hit: Option<Hit>,
    pub(super) direction: DVec3,
    /// Whether it is the first on its line.
    pub(super) is_first: bool,
}

impl Met {
    /// Whether its outer side is turned to the viewer.
    pub(super) fn is_front(&self) -> bool {
        self.hit.is_none_or(|hit| hit.normal.dot(self.direction) < 0.0)
    }
}

impl<'a> Walk<'a> {
    pub(super) fn new(scene: &'a Scene, camera: &'a Camera) -> Self {
        Self { scene, camera, lens: lens_points(camera) }
    }

    /// All that lies on the line of sight through a continuous pixel coordinate, nearest first.
    pub(super) fn along(&self, at: DVec2) -> impl Iterator<Item = Met> {
        let ray = pinhole_ray(self.camera, at.x, at.y);
        let direction = ray.direction.as_dvec3();
        let facing = move |hit| self.scene.facing(hit, direction);
        let mut next = Some(self.scene.hit(&ray).map(facing));
        (0..MOST_SURFACES).map_while(move |index| {
            let hit = next?;
            next = hit.map(|from| {
                let outwards = if from.normal.dot(direction) < 0.0 { -from.normal } else { from.normal };
                self.scene.hit_beyond(&from, outwards, direction).map(facing)
            });
            Some(Met { hit, direction, is_first: index == 0 })
        })
    }

    /// What it is, as the plane that touches it.
    pub(super) fn facing(&self, met: &Met) -> Facing {
        Facing::new(self.camera, met.hit.as_ref())
    }

    /// Whether some lens point sees the outer side of a surface, or the sky in this direction.
    pub(super) fn sees(&self, met: &Met) -> bool {
        let is_seen = |l: DVec3| match &met.hit {
            Some(hit) => hit.normal.dot(l - hit.point) > 0.0 && !self.scene.is_hidden(hit, hit.normal, l),
            None => !self.scene.is_blocked(&Ray::new(l, met.direction), f64::INFINITY),
        };
        self.lens.iter().any(|&l| is_seen(l))
    }
}

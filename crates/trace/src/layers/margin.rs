//! How far beyond the picture the lens looks, found by tracing.

use glam::DVec2;
use optics::Camera;
use rayon::prelude::*;

use super::lens_points::lens_points;
use crate::{Ray, Scene};

/// Distance between the pixels that are asked, inside the picture and along its border.
const STEPS: [usize; 2] = [8, 2];

/// Columns and rows on each side that some ray of the picture reaches: what it hits, as the pinhole sees it.
///
/// Every second pixel of the border and every eighth inside looks through 48 points of the iris; one pixel is added for
/// what lies between them.
pub(super) fn needed(scene: &Scene, camera: &Camera) -> [u32; 2] {
    if camera.iris.radius() == 0.0 {
        return [0; 2];
    }
    let points: Vec<_> = lens_points(camera).into_iter().map(|p| camera.pose.point_to_camera(p)).collect();
    let size = DVec2::new(f64::from(camera.film.width()), f64::from(camera.film.height()));
    let [coarse, fine] = STEPS.map(|step| step as f64);
    let across =
        |length: f64, step: f64| (0..=(length / step).ceil() as u32).map(move |i| (f64::from(i) * step).min(length));
    let mut pixels: Vec<DVec2> = Vec::new();
    for y in across(size.y, coarse) {
        pixels.extend(across(size.x, coarse).map(|x| DVec2::new(x, y)));
    }
    for x in across(size.x, fine) {
        pixels.extend([DVec2::new(x, 0.0), DVec2::new(x, size.y)]);
    }
    for y in across(size.y, fine) {
        pixels.extend([DVec2::new(0.0, y), DVec2::new(size.x, y)]);
    }

    // A maximum is the same in any order
    let reach = pixels
        .par_iter()
        .flat_map_iter(|&pixel| points.iter().filter_map(move |&l| landing(scene, camera, pixel, l)))
        .map(|p| (-p).max(p - size).max(DVec2::ZERO))
        .reduce(|| DVec2::ZERO, DVec2::max);
    reach.to_array().map(|reach| if reach > 0.0 { reach.ceil().min(1e6) as u32 + 1 } else { 0 })
}

/// Where the pinhole sees what a pixel sees through the lens point `l` (camera space).
fn landing(scene: &Scene, camera: &Camera, pixel: DVec2, l: glam::DVec3) -> Option<DVec2> {
    let q1 = camera.film.q_from_pixel(pixel).extend(1.0);
    let direction = q1 - camera.focus.w().dot(q1) * l;
    let (origin, towards) = (camera.pose.point_to_world(l), camera.pose.direction_to_world(direction));
    let p_camera = match scene.hit(&Ray::new(origin, towards)) {
        Some(hit) => camera.pose.point_to_camera(hit.point),
        None => direction,
    };
    (p_camera.z > 0.0).then(|| camera.film.pixel_from_q(p_camera.truncate() / p_camera.z))
}

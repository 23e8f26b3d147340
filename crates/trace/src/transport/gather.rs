//! The samples of pixels, ray by ray.

use std::ops::Range;

use glam::{DVec2, Vec3};
use optics::Camera;

use super::{Footprint, Stream, Transport};
use crate::accumulation::Sum;
use crate::sampler::{MAX_ATTEMPTS, Sample, Sampler};
use crate::{Ray, Scene};

/// Adds the samples of pixel (x, y) that are wanted and missing, one path each, to its halves.
pub(crate) fn gather(
    scene: &Scene,
    transport: &Transport,
    camera: &Camera,
    (x, y): (i32, i32),
    sums: &mut [Sum; 2],
    wanted: &[Range<u32>; 2],
    seed: u64,
) {
    let corner = DVec2::new(f64::from(x), f64::from(y));
    let is_timed = scene.is_timed();
    let moves_camera = scene.exposure().moves_camera();
    let has_cat_eye = camera.iris.cat_eye() > 0.0;
    let footprint = Footprint::of_pixel(pixel_size(camera));
    for (half, (sum, wanted)) in sums.iter_mut().zip(wanted).enumerate() {
        let sampler = Sampler::new(seed, x, y, half).timed(is_timed);
        let samples = sum.missing(wanted);
        sum.start(samples.start);
        for index in samples {
            // Where a cat's eye is closed another point of the lens will do
            let attempts = if has_cat_eye { MAX_ATTEMPTS } else { 0 };
            let others = (1..=attempts).map(|attempt| sampler.other_lens(index, attempt));
            let Sample { pixel, lens } = sampler.sample(index);
            let time = sampler.time(index);
            let now = if moves_camera { scene.camera(camera, time) } else { *camera };
            let q = now.film.q_from_pixel(corner + pixel);
            let radiance = match std::iter::once(lens).chain(others).find_map(|u| now.world_ray(q, u, time.into())) {
                Some(ray) => {
                    let mut stream = Stream::new(&sampler, index, has_cat_eye);
                    let weight = ray.weight as f32;
                    let ray = Ray::new(ray.origin, ray.direction).timed(time);
                    transport.radiance(scene, &ray, footprint, &mut stream) * weight
                }
                None => Vec3::ZERO,
            };
            sum.add(radiance);
        }
    }
}

/// Width of a pixel in q.
pub(crate) fn pixel_size(camera: &Camera) -> f64 {
    let per_q = camera.film.pixels_per_q();
    1.0 / (per_q.x * per_q.y).sqrt()
}

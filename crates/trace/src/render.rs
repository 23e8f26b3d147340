//! From scene and camera to pixels.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, Vec3};
use optics::Camera;
use rayon::prelude::*;
use rgbd::{Cancelled, PixelWindow, Progress, Truth};

use crate::accumulation::{Accumulation, Sum};
use crate::sampler::{MAX_ATTEMPTS, MAX_SAMPLES, Sampler};
use crate::{Pixels, Ray, RenderError, Scene};

/// Pixels that one thread takes at a time.
const CHUNK: usize = 64;

/// Renders a range of samples of some pixels, in both halves: a pixel gets 2 x `samples.len()` camera rays.
///
/// Pixels count from the display window's top left corner and may lie outside (overscan). The result depends on the
/// arguments alone, to the bit, whatever the number of threads; parts join with [`Accumulation::merge`].
pub fn render(
    scene: &Scene,
    camera: &Camera,
    pixels: &Pixels,
    samples: Range<u32>,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Accumulation, RenderError> {
    if samples.start >= samples.end || samples.end > MAX_SAMPLES {
        return Err(RenderError::SampleRange { first: samples.start, end: samples.end });
    }
    let window = pixels.window();
    if window.is_empty() {
        return Err(RenderError::NoSamples(window));
    }
    let mut halves = vec![[Sum::default(); 2]; window.area()];
    let total = halves.len().div_ceil(CHUNK) as u64;
    let done = AtomicU64::new(0);
    halves.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, sums)| {
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        for (i, sums) in sums.iter_mut().enumerate() {
            let (x, y) = place(window, chunk * CHUNK + i);
            if pixels.contains(x, y) {
                for (half, sum) in sums.iter_mut().enumerate() {
                    let sampler = Sampler::new(seed, x, y, half);
                    samples.clone().for_each(|index| sum.add(see(scene, camera, x, y, &sampler, index)));
                }
            }
        }
        progress.report(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        Ok(())
    })?;
    Ok(Accumulation::new(*camera, seed, pixels.clone(), samples, halves))
}

/// The pixel at a row-major index.
fn place(window: PixelWindow, index: usize) -> (i32, i32) {
    let width = window.width as usize;
    (window.x.saturating_add_unsigned((index % width) as u32), window.y.saturating_add_unsigned((index / width) as u32))
}

/// What one sample of a pixel sees; black where the lens blocks it altogether.
#[inline]
fn see(scene: &Scene, camera: &Camera, x: i32, y: i32, sampler: &Sampler, index: u32) -> Vec3 {
    let sample = sampler.sample(index);
    let pixel = DVec2::new(f64::from(x), f64::from(y)) + sample.pixel;
    let q = camera.film.q_from_pixel(pixel);
    // A pixel is the mean over the open lens: take another point where a cat's eye is closed
    let attempts = if camera.iris.cat_eye() > 0.0 { MAX_ATTEMPTS } else { 0 };
    let others = (1..=attempts).map(|attempt| sampler.other_lens(index, attempt));
    let ray = std::iter::once(sample.lens).chain(others).find_map(|u| camera.world_ray(q, u, 0.0));
    match ray {
        Some(ray) => scene.radiance(&Ray::new(ray.origin, ray.direction)) * ray.weight as f32,
        None => Vec3::ZERO,
    }
}

/// Renders a window with `spp` samples per pixel, rounded up to an even number: half of them in each half.
pub fn truth(
    scene: &Scene,
    camera: &Camera,
    window: PixelWindow,
    spp: u32,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Truth, RenderError> {
    render(scene, camera, &window.into(), 0..spp.div_ceil(2), seed, progress)?.to_truth()
}

/// Renders a window until its noise (RMSE of the mean, R, G and B) is at most `target`, or `max_spp` is reached.
///
/// The number of samples doubles from 16 per pixel, so that the sequences stay complete.
pub fn truth_to_noise(
    scene: &Scene,
    camera: &Camera,
    window: PixelWindow,
    target: f64,
    max_spp: u32,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Truth, RenderError> {
    let max = (max_spp / 2).clamp(1, MAX_SAMPLES);
    let mut end = max.min(8);
    let mut sums = render(scene, camera, &window.into(), 0..end, seed, progress)?;
    loop {
        let truth = sums.to_truth()?;
        if truth.noise_rmse(window) <= target || end == max {
            return Ok(truth);
        }
        let next = (end * 2).min(max);
        sums.merge(&render(scene, camera, &window.into(), end..next, seed, progress)?)?;
        end = next;
    }
}

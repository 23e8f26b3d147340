//! From scene and camera to pixels.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{dispatch, prelude::*};
use glam::{DVec2, Vec3};
use optics::Camera;
use rayon::prelude::*;
use rgbd::{Cancelled, PixelWindow, Progress, Truth};

use crate::accumulation::{Accumulation, Sum};
use crate::job::check;
use crate::lens::Lens;
use crate::packet::{Packet, RAYS};
use crate::sampler::{MAX_ATTEMPTS, MAX_SAMPLES, Sample, Sampler, eight_samples};
use crate::shade::Shader;
use crate::triangle::Axes;
use crate::{Goal, Job, Pixels, Ray, RenderError, Scene, transport};

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
    check(&samples)?;
    let window = pixels.window();
    if window.is_empty() {
        return Err(RenderError::NoSamples(window));
    }
    let mut sums = Accumulation::new(*camera, window, seed);
    sums.extend(
        scene,
        &|x, y| if pixels.contains(x, y) { [samples.clone(), samples.clone()] } else { [0..0, 0..0] },
        progress,
    )?;
    Ok(sums)
}

/// The samples that both halves of pixel (x, y) shall have.
pub type Wanted<'a> = &'a (dyn Fn(i32, i32) -> [Range<u32>; 2] + Sync);

impl Accumulation {
    /// Adds the samples of each pixel that follow those it has, up to those that are wanted of it or [`MAX_SAMPLES`].
    ///
    /// When it is cancelled, some pixels have theirs and others not: it can go on from there.
    pub fn extend(&mut self, scene: &Scene, wanted: Wanted<'_>, progress: &dyn Progress) -> Result<(), Cancelled> {
        let (window, camera, seed) = (self.window(), *self.camera(), self.seed());
        let total = window.area().div_ceil(CHUNK) as u64;
        let done = AtomicU64::new(0);
        let lens = Lens::new(&camera);
        self.halves_mut().par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, sums)| {
            let of_pixel = |i: usize| {
                let (x, y) = place(window, chunk * CHUNK + i);
                ((x, y), wanted(x, y))
            };
            let is_complete = |(i, sums): (usize, &[Sum; 2])| {
                let (_, wanted) = of_pixel(i);
                sums.iter().zip(&wanted).all(|(sum, wanted)| sum.missing(wanted).is_empty())
            };
            // What was done before it was stopped takes no time
            if !sums.iter().enumerate().all(is_complete) {
                if progress.is_cancelled() {
                    return Err(Cancelled);
                }
                if let Some(transport) = &scene.transport {
                    for (i, sums) in sums.iter_mut().enumerate() {
                        let (place, wanted) = of_pixel(i);
                        transport::gather(scene, transport, &camera, place, sums, &wanted, seed);
                    }
                    progress.report(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                    return Ok(());
                }
                dispatch!(scene.geometry.level(), simd => {
                    let mut gather = Gather::new(scene, sums);
                    for i in 0..gather.sums.len() {
                        let (place, wanted) = of_pixel(i);
                        gather.pixel(simd, &lens, place, i, &wanted, seed);
                    }
                    gather.finish(simd);
                });
            }
            progress.report(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            Ok(())
        })
    }
}

/// The pixel at a row-major index.
fn place(window: PixelWindow, index: usize) -> (i32, i32) {
    let width = window.width as usize;
    (window.x.saturating_add_unsigned((index % width) as u32), window.y.saturating_add_unsigned((index / width) as u32))
}

/// Collects the rays of a chunk of pixels in packets, one for each class of axes, and counts what they see.
///
/// What a ray sees does not depend on its company, and sums are exact: how rays come together is never seen.
struct Gather<'a> {
    scene: &'a Scene,
    shader: Shader<'a>,
    sums: &'a mut [[Sum; 2]],
    packets: Vec<Packet>,
    /// The pixel and half of each ray, and its weight.
    owners: Vec<[(u32, f32); RAYS]>,
}

impl<'a> Gather<'a> {
    fn new(scene: &'a Scene, sums: &'a mut [[Sum; 2]]) -> Self {
        let packets = (0..Axes::CLASSES).map(Packet::new).collect();
        Self { scene, shader: Shader::new(scene), sums, packets, owners: vec![[(0, 0.0); RAYS]; Axes::CLASSES] }
    }

    /// Adds the samples of pixel (x, y), the `index`-th of the chunk, that are wanted and missing.
    #[inline(always)]
    fn pixel<S: Simd>(
        &mut self,
        simd: S,
        lens: &Lens,
        (x, y): (i32, i32),
        index: usize,
        wanted: &[Range<u32>; 2],
        seed: u64,
    ) {
        let samples = [0, 1].map(|half| self.sums[index][half].missing(&wanted[half]));
        let counts = [0, 1].map(|half| samples[half].len());
        if counts == [0; 2] {
            return;
        }
        for (sum, samples) in self.sums[index].iter_mut().zip(&samples) {
            sum.start(samples.start);
        }
        let corner = DVec2::new(f64::from(x), f64::from(y));
        let moves = self.scene.exposure().moves_camera();
        let samplers = [0, 1].map(|half| Sampler::new(seed, x, y, half).timed(moves));
        let Some(pixel) = lens.pixel(corner).filter(|_| !moves) else {
            return self.edge(simd, lens.camera(), corner, index, &samplers, &samples);
        };
        // Take eight at a time, those of the second half after those of the first
        let total = counts[0] + counts[1];
        for first in (0..total).step_by(8) {
            let (mut of_lane, mut indices) = ([samplers[0]; 8], [samples[0].start; 8]);
            let end = (first + 8).min(total);
            for (lane, i) in (first..end).enumerate() {
                let half = usize::from(i >= counts[0]);
                of_lane[lane] = samplers[half];
                indices[lane] = samples[half].start + (i - half * counts[0]) as u32;
            }
            let rays = lens.rays(simd, &pixel, eight_samples(simd, &of_lane, &indices));
            for (lane, i) in (first..end).enumerate() {
                let [ox, oy, oz] = &rays.origin;
                let [dx, dy, dz] = &rays.direction;
                let origin = Vec3::new(ox[lane], oy[lane], oz[lane]);
                let direction = Vec3::new(dx[lane], dy[lane], dz[lane]);
                let owner = (2 * index + usize::from(i >= counts[0])) as u32;
                self.ray(simd, &Ray::single(origin, direction), (owner, 1.0));
            }
        }
    }

    /// Adds the samples of a pixel some of which the lens may block: those take another point of the lens where a cat's
    /// eye is closed, since a pixel is the mean over the open lens, and see black where the whole lens is turned away. Those of a
    /// camera that moves go this way too.
    #[cold]
    #[inline(never)]
    fn edge<S: Simd>(
        &mut self,
        simd: S,
        camera: &Camera,
        corner: DVec2,
        index: usize,
        samplers: &[Sampler; 2],
        samples: &[Range<u32>; 2],
    ) {
        let attempts = if camera.iris.cat_eye() > 0.0 { MAX_ATTEMPTS } else { 0 };
        for (half, (sampler, samples)) in samplers.iter().zip(samples).enumerate() {
            for sample in samples.clone() {
                let others = (1..=attempts).map(|attempt| sampler.other_lens(sample, attempt));
                let Sample { pixel, lens } = sampler.sample(sample);
                let time = sampler.time(sample);
                let now = self.scene.camera(camera, time);
                let q = now.film.q_from_pixel(corner + pixel);
                match std::iter::once(lens).chain(others).find_map(|u| now.world_ray(q, u, time.into())) {
                    Some(ray) => {
                        let owner = ((2 * index + half) as u32, ray.weight as f32);
                        self.ray(simd, &Ray::new(ray.origin, ray.direction), owner);
                    }
                    None => self.sums[index][half].add(Vec3::ZERO),
                }
            }
        }
    }

    #[inline(always)]
    fn ray<S: Simd>(&mut self, simd: S, ray: &Ray, owner: (u32, f32)) {
        let class = Axes::class_of(ray.direction);
        let lane = self.packets[class].push(ray);
        self.owners[class][lane] = owner;
        if lane == RAYS - 1 {
            self.trace(simd, class);
        }
    }

    /// Traces what is left.
    #[inline(always)]
    fn finish<S: Simd>(&mut self, simd: S) {
        for class in 0..Axes::CLASSES {
            if self.packets[class].count() > 0 {
                self.trace(simd, class);
            }
        }
    }

    fn trace<S: Simd>(&mut self, simd: S, class: usize) {
        let packet = &mut self.packets[class];
        let shader = &mut self.shader;
        let radiance = simd.vectorize(
            #[inline(always)]
            || shader.radiance(simd, packet),
        );
        for (radiance, &(owner, weight)) in radiance.iter().zip(&self.owners[class][..packet.count()]) {
            self.sums[owner as usize / 2][owner as usize % 2].add(radiance * weight);
        }
        packet.clear(class);
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

/// Renders a window until its noise (RMSE of the mean, R, G and B) is at most `target`, or every pixel has `max_spp` samples.
///
/// Samples go where they count: see [`Job`].
pub fn truth_to_noise(
    scene: &Scene,
    camera: &Camera,
    window: PixelWindow,
    target: f64,
    max_spp: u32,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Truth, RenderError> {
    let mut job = Job::new(*camera, window, seed);
    let most = (max_spp / 2).clamp(1, MAX_SAMPLES);
    job.run(scene, &Goal::Noise { rmse: target, most }, progress)?;
    job.into_sums().to_truth()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DVec3};
    use optics::{ApertureShape, Film, Focus, Iris, Pose};

    use super::*;
    use crate::{Light, Material, SceneBuilder, Shape, levels};

    #[test]
    fn the_picture_is_the_same_at_every_level() {
        let mut builder = SceneBuilder::new();
        let grey = builder.material(Material::matte(Vec3::new(0.7, 0.6, 0.5)));
        builder.shape(Shape::Plane, DAffine3::IDENTITY, grey).unwrap();
        let corners = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.3), DVec3::new(0.0, 1.5, 0.2)];
        builder.mesh(&corners, &[[0, 1, 2]], |_| grey, DAffine3::IDENTITY).unwrap();
        builder.light(Light::sun(DVec3::new(1.0, 2.0, 0.5), Vec3::ONE).unwrap());
        let mut scene = builder.build().unwrap();
        let window = PixelWindow::of_size(40, 30);
        for shape in [ApertureShape::Disc, ApertureShape::polygon(6, 0.1).unwrap()] {
            let camera = Camera {
                pose: Pose::look_at(DVec3::new(0.0, 2.0, 4.0), 0.5 * DVec3::Y, DVec3::Y).unwrap(),
                film: Film::from_fov(0.8, 40, 30).unwrap(),
                focus: Focus::new(DVec3::new(0.05, -0.1, 0.2)).unwrap(),
                iris: Iris::new(DVec3::new(0.1, -0.3, 1.0), 0.3, shape).unwrap(),
            };
            let pictures = levels::all().into_iter().map(|level| {
                Arc::make_mut(&mut scene.geometry).set_level(level);
                (level, truth(&scene, &camera, window, 10, 1, &rgbd::Silent).unwrap())
            });
            let pictures: Vec<_> = pictures.collect();
            for (level, picture) in &pictures {
                assert!(*picture == pictures[0].1, "{level:?} is not {:?}", pictures[0].0);
            }
        }
    }
}

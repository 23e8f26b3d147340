//! How fast the tracer is, in CPU time of one thread: build, camera samples, time to a noise, and single rays of a file.
//!
//! ```text
//! cargo run --release -p trace --example ray_speed -- MESH.obj [SPP [RAYS]]
//! ```
//!
//! The mesh is seen as `simple` of the references is, through an untilted lens at 1280 x 720, with a sun and an ambient
//! light: one hard-shadow ray per hit. With `RAYS`, a folder, the rays of every 16th pixel are written there for other
//! tracers: `primary.f32` and `shadow.f32`, origin and direction of each as six little-endian numbers, and `blocked.u8`,
//! 1 for each shadow ray that is blocked.
#![allow(clippy::print_stdout)] // a program

use std::error::Error;
use std::path::Path;

use glam::{DAffine3, DVec2, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{PixelWindow, Silent};
use trace::{Goal, Job, Light, Material, Ray, Scene, SceneBuilder};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 1280, height: 720 };
const TOWARD_SUN: DVec3 = DVec3::new(-0.45, 1.0, 0.35);

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let path = args.first().ok_or("the first argument is an OBJ file")?;
    let spp: u32 = args.get(1).map_or(Ok(16), |spp| spp.parse())?;

    // Everything is done by one thread, whose CPU time another process cannot lengthen much
    let (builder, triangles) = read(Path::new(path))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (scene, seconds) = pool.install(|| timed(|| builder.build()));
    let scene = scene?;
    let bytes = scene.bytes() as f64 / triangles as f64;
    println!("{triangles} triangles, built in {seconds:.3} CPU s, {bytes:.1} bytes each");
    let camera = camera()?;
    for _ in 0..3 {
        let (truth, seconds) = pool.install(|| timed(|| trace::truth(&scene, &camera, WINDOW, spp, 1, &Silent)));
        let rate = WINDOW.area() as f64 * f64::from(spp) / seconds * 1e-6;
        let noise = truth?.noise_rmse(WINDOW);
        println!("{spp} spp: {seconds:.3} CPU s, {:.2} M samples per 2 CPU s, noise {noise:.5}", 2.0 * rate);
    }

    // How long the noise takes to come down, where samples count and with the same number everywhere
    for rmse in [0.01, 0.005] {
        let mut job = Job::new(camera, WINDOW, 1);
        let goal = Goal::Noise { rmse, most: 1 << 14 };
        let (result, seconds) = pool.install(|| timed(|| job.run(&scene, &goal, &Silent)));
        result?;
        let sums = job.sums();
        let mean = sums.samples() as f64 / WINDOW.area() as f64;
        println!("noise {rmse}: {seconds:.2} CPU s, {mean:.1} spp on average, noise {:.5}", sums.noise());
    }

    // The same kind of rays one by one
    let (primary, shadow) = rays(&scene, &camera);
    let rate = |rays: &[Ray], ask: &dyn Fn(&Ray) -> bool| {
        let (count, seconds) = (0..3)
            .map(|_| timed(|| rays.iter().filter(|ray| ask(ray)).count()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f64::NAN));
        format!("{:.2} M/s ({} of {})", rays.len() as f64 / seconds * 1e-6, count, rays.len())
    };
    println!("single rays: primary {}", rate(&primary, &|ray| scene.hit(ray).is_some()));
    println!("single rays: shadow {}", rate(&shadow, &|ray| scene.is_blocked(ray, f64::INFINITY)));
    if let Some(folder) = args.get(2) {
        write(&Path::new(folder).join("primary.f32"), &primary)?;
        write(&Path::new(folder).join("shadow.f32"), &shadow)?;
        let blocked: Vec<u8> = shadow.iter().map(|ray| u8::from(scene.is_blocked(ray, f64::INFINITY))).collect();
        std::fs::write(Path::new(folder).join("blocked.u8"), blocked)?;
    }
    Ok(())
}

/// What `work` returns, and the CPU seconds that this thread spent on it.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let spent = || {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
        text.split(' ').next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1e-9
    };
    let start = spent();
    let result = work();
    (result, spent() - start)
}

/// The camera of `simple_untilted`, 11 units from what it looks at, 41.2 degrees down.
fn camera() -> Result<Camera, Box<dyn Error>> {
    let (target, down) = (DVec3::new(0.0, 0.9, 0.0), 41.2_f64.to_radians());
    let eye = target + 11.0 * DVec3::new(0.0, down.sin(), down.cos());
    let half = DVec2::new(0.325 * 16.0 / 9.0, 0.325);
    Ok(Camera {
        pose: Pose::look_at(eye, target, DVec3::Y)?,
        film: Film::new(-half, half, WINDOW.width, WINDOW.height)?,
        focus: Focus::at_depth(11.0)?,
        iris: Iris::upright(0.3, ApertureShape::Disc)?,
    })
}

/// The triangles of an OBJ file with the colours of its material library.
fn read(path: &Path) -> Result<(SceneBuilder, usize), Box<dyn Error>> {
    let (models, materials) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS)?;
    let mut builder = SceneBuilder::new();
    let ids: Vec<_> = materials?
        .iter()
        .map(|m| builder.material(Material::matte(m.diffuse.map_or(Vec3::splat(0.8), Vec3::from_array))))
        .collect();
    let mut triangles = 0;
    for model in models {
        let positions = model.mesh.positions.as_chunks::<3>().0;
        let vertices: Vec<DVec3> = positions.iter().map(|&p| Vec3::from_array(p).as_dvec3()).collect();
        let corners = model.mesh.indices.as_chunks::<3>().0;
        let id = ids[model.mesh.material_id.ok_or("a model without a material")?];
        builder.mesh(&vertices, corners, |_| id, DAffine3::IDENTITY)?;
        triangles += corners.len();
    }
    builder.light(Light::Ambient { strength: Vec3::splat(0.25) });
    builder.light(Light::sun(TOWARD_SUN, Vec3::splat(0.75))?);
    builder.sky(Vec3::new(0.55, 0.7, 0.9));
    Ok((builder, triangles))
}

/// Rays through 16 points of the lens of every 16th pixel, and the shadow rays of what they hit.
fn rays(scene: &Scene, camera: &Camera) -> (Vec<Ray>, Vec<Ray>) {
    let (mut primary, mut shadow) = (Vec::new(), Vec::new());
    for y in (0..WINDOW.height).step_by(4) {
        for x in (0..WINDOW.width).step_by(4) {
            for i in 0..16_u32 {
                let part = |step: f64| (f64::from(i + 1) * step).fract();
                let q = camera.film.q_from_pixel(DVec2::new(f64::from(x) + part(0.857), f64::from(y) + part(0.734)));
                let Some(ray) = camera.world_ray(q, DVec2::new(part(0.629), part(0.539)), 0.0) else { continue };
                let ray = Ray::new(ray.origin, ray.direction);
                primary.push(ray);
                if let Some(hit) = scene.hit(&ray) {
                    let normal = if hit.normal.dot(ray.direction.as_dvec3()) > 0.0 { -hit.normal } else { hit.normal };
                    if normal.dot(TOWARD_SUN) > 0.0 {
                        shadow.push(Ray::leaving(hit.point, normal, TOWARD_SUN.normalize()));
                    }
                }
            }
        }
    }
    (primary, shadow)
}

fn write(path: &Path, rays: &[Ray]) -> std::io::Result<()> {
    let numbers = rays.iter().flat_map(|ray| ray.origin.to_array().into_iter().chain(ray.direction.to_array()));
    std::fs::write(path, numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

//! Speed of the tracer and of each rung of the filter, whole calls on this machine.
//!
//! `cargo bench --bench speed` prints times; the tracer's as camera samples per second (one hard-shadow ray per hit).
//! Every figure is of one process: compare ratios within one run, not times between machines.
#![allow(missing_docs)] // what criterion's macros make has no place for them

use std::hint::black_box;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use filter::{FrameView, GatherSettings, Method, apply};
use optics::Camera;
use rgbd::{PixelWindow, Silent};
use trace::{LayerSettings, SceneFile, layers, truth};

const SPP: u32 = 4;

fn simple() -> SceneFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/simple.toml");
    SceneFile::open(path).expect("the project's own scene")
}

fn tracer(c: &mut Criterion) {
    let file = simple();
    let shot = file.shot(Some("tilt")).expect("the project's own shot").camera;
    let camera = Camera { film: shot.film.resized(1280, 720).expect("a film"), ..shot };
    let display = PixelWindow::of_size(1280, 720);
    let mut group = c.benchmark_group("trace simple/tilt 1280x720");
    group.sample_size(10).throughput(Throughput::Elements(display.area() as u64 * u64::from(SPP)));
    group.bench_function("camera samples", |b| {
        b.iter(|| black_box(truth(file.scene(), &camera, display, SPP, 1, &Silent)));
    });
    group.finish();
}

fn rungs(c: &mut Criterion) {
    let file = simple();
    let shot = file.shot(Some("tilt")).expect("the project's own shot").camera;
    let mut group = c.benchmark_group("filter simple/tilt 640x360 by aperture");
    group.sample_size(10).throughput(Throughput::Elements(640 * 360));
    for opening in [1.0, 2.0, 4.0] {
        // Twice the aperture is twice the blur
        let iris = shot.iris.with_radius(opening * shot.iris.radius()).expect("an iris");
        let camera = Camera { iris, ..shot };
        let frame = layers(file.scene(), &camera, &LayerSettings::default(), &Silent).expect("a frame").frame;
        let one_layer = GatherSettings { layers: 1, ..GatherSettings::default() };
        let methods = [
            Method::OwnCoc(one_layer),
            Method::Gather(GatherSettings::default()),
            Method::Merged(one_layer),
            Method::default(),
        ];
        for (method, name) in
            methods.iter().zip(["own-coc", "gather, all layers", "merged, 1 layer", "merged, all layers"])
        {
            group.bench_function(BenchmarkId::new(name, format!("{opening} x aperture")), |b| {
                b.iter(|| black_box(apply(&FrameView::whole(&frame), &camera, method, frame.display, &Silent)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, tracer, rungs);
criterion_main!(benches);

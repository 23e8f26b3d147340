//! What the filter allocates, counted.
#![allow(unsafe_code)] // an allocator that hands everything to the system's, and only counts; tests alone use it

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use filter::{FrameView, GatherSettings, LensRaysSettings, Method, apply, apply_in_bands};
use glam::DVec3;
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, Silent};

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: both calls go to the system's allocator as they came
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(NOW.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: as the caller promises
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// The most bytes that were allocated at once while `work` ran, beyond those before.
fn peak_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let result = work();
    (result, PEAK.load(Relaxed) - before)
}

/// Cards of some 40 pixels before a sloped floor, with a hidden layer behind them or without.
fn frame(window: PixelWindow, layers: usize) -> Frame {
    let on_card = |x: i32, y: i32| (x.div_euclid(20) + y.div_euclid(20)) % 4 == 0;
    let floor = |y: i32| 1.0 / (0.1 + 0.0004 * y as f32);
    let color = Picture::from_fn(window, |x, y| [(x % 7) as f32 * 0.1, (y % 5) as f32 * 0.2, 0.5, 1.0]);
    let depth = Plane::from_fn(window, |x, y| if on_card(x, y) { 1.5 } else { floor(y) });
    let behind = Plane::from_fn(window, |x, y| if on_card(x, y) { floor(y) } else { f32::NAN });
    let hidden = Picture::from_fn(window, |x, y| if on_card(x, y) { [0.3, 0.3, 0.3, 1.0] } else { [0.0; 4] });
    let all = vec![Layer::from_raw_depth(color, depth), Layer::from_raw_depth(hidden, behind)];
    Frame::new(window, all.into_iter().take(layers).collect()).unwrap()
}

fn camera(window: PixelWindow, radius: f64) -> Camera {
    Camera {
        pose: Pose::IDENTITY,
        film: Film::from_fov(0.8, window.width, window.height).unwrap(),
        focus: Focus::new(DVec3::new(0.0, -0.1, 0.3)).unwrap(),
        iris: Iris::upright(radius, ApertureShape::Disc).unwrap(),
    }
}

/// One test, so that no other allocates meanwhile.
#[test]
fn no_method_takes_more_memory_than_it_says_and_bands_keep_to_their_limit_and_the_bits() {
    let settings = GatherSettings { predict_error: true, ..GatherSettings::default() };
    let rays = LensRaysSettings { samples: 2, ..LensRaysSettings::default() };
    let methods = [
        Method::Pinhole,
        Method::OwnCoc(settings),
        Method::Gather(settings),
        Method::Merged(settings),
        Method::LensRays(rays),
    ];
    // So high that bands and what is read around them are less than half of it
    let window = PixelWindow::of_size(320, 1200);
    for layers in [1, 2] {
        let frame = frame(window, layers);
        let view = FrameView::whole(&frame);
        let bytes = layers * window.area() * (4 * 4 + 4 + 1);
        for (method, radius) in methods.iter().flat_map(|method| [0.008, 0.04].map(|radius| (method, radius))) {
            let camera = camera(window, radius);
            let (whole, peak) = peak_of(|| apply(&view, &camera, method, window, &Silent).unwrap());
            let times = peak as f64 / bytes as f64;
            let what = format!("{}, {layers} layers, radius {radius}", method.name());
            assert!(times < Method::MEMORY_FACTOR as f64, "{what}: {times:.2} times the frame");

            // Half of what all of it may take: bands and their margins, where the reach is short enough
            let limit = Method::MEMORY_FACTOR * bytes as u64 / 2;
            let (banded, peak) = peak_of(|| apply_in_bands(&view, &camera, method, window, limit, &Silent).unwrap());
            assert!(banded == whole, "{what}: bands differ");
            // What was joined stands beside the band, and the first band with it: picture and predicted error
            let result = 9 * 4 * window.area();
            let reach = filter::reach_px(&view, &camera, method);
            assert!(2 * reach + 64 <= window.height / 2, "{what}: reach {reach}");
            assert!(peak <= limit as usize + result + result / 2, "{what}: {peak} bytes, limit {limit}");
        }
    }
}

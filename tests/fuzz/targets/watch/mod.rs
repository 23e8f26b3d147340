//! What every target keeps an eye on: panics that nobody catches, and memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Crates whose panics on damaged files the readers catch (`crates/rgbd/src/guard.rs`, `crates/rgbd/src/photo/decode.rs`).
const CAUGHT: [&str; 7] = ["/exr-", "/image-", "/png-", "/tiff-", "/zune-", "/fdeflate-", "/weezl-"];

/// Lets panics in these crates unwind, so that the fuzzer goes on behind them. One that is caught nowhere ends it all the same:
/// libFuzzer's own guard aborts. All other panics abort on the spot.
pub fn let_caught_panics_pass() {
    let abort = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let file = info.location().map_or("", |at| at.file());
        if !CAUGHT.iter().any(|name| file.contains(name)) {
            abort(info);
        }
    }));
}

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

/// What a reader may take beside three times the picture.
const BESIDE: usize = 256 << 20;

/// Does the work; panics if it takes more than three times `declared` bytes and 256 MB.
pub fn within_memory<T>(declared: usize, work: impl FnOnce() -> T) -> T {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let done = work();
    let peak = PEAK.load(Relaxed).saturating_sub(before);
    assert!(peak <= 3 * declared + BESIDE, "{peak} bytes for {declared} declared");
    done
}

//! How near each rung of the filter comes to the reference pictures, in dB and HDR-FLIP, and how long it takes:
//! `TILTSHIFT_SHARED=... cargo bench --bench quality -- [part of a case's name] [part of a rung's name]`.

#[path = "../tests/support"]
mod support {
    pub(crate) mod cases;
    pub(crate) mod rungs;
    pub(crate) mod score;
    pub(crate) mod shared;
}

use std::time::Instant;

use compare::{Comparison, MaskKind};
use filter::{FrameView, Method, apply};
use rgbd::Silent;
use support::cases::{Case, REFERENCES};
use support::score::Score;
use support::{cases, rungs, shared};

#[expect(clippy::print_stdout, reason = "the figures are what the bench is for")]
fn main() {
    // `cargo bench` passes --bench along
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let wanted = |i: usize, name: &str| words.get(i).is_none_or(|word| name.contains(word.as_str()));
    let Some(folder) = shared::folder() else { return };
    println!("{:<20} {:<22} {:>7} {:>7} {:>9} {:>8} {:>7}", "case", "rung", "all", "edges", "interior", "FLIP", "s");
    for name in REFERENCES.into_iter().chain(["blender/simple", "blender/occluder"]) {
        if !wanted(0, name) {
            continue;
        }
        let case = match name.strip_prefix("blender/") {
            Some(scene) => Case::of_cycles(&folder.join("reference/blender"), scene),
            None => Case::read(&folder.join("reference"), name),
        };
        for (rung, method, layers) in rungs::all() {
            if !wanted(1, rung) || layers > case.frame.layers().len() {
                continue;
            }
            let (row, seconds) = measure(&case, &method);
            println!("{name:<20} {rung:<22} {row} {seconds:>7.2}");
        }
    }
}

/// The figures of one method, and its seconds.
fn measure(case: &cases::Case, method: &Method) -> (String, f64) {
    let started = Instant::now();
    let filtered = apply(&FrameView::whole(&case.frame), &case.camera, method, case.frame.display, &Silent);
    let picture = filtered.expect("a frame of the camera's size").picture;
    let seconds = started.elapsed().as_secs_f64();
    let Score([all, edges, interior]) = Score::new(&case.reference, &picture, &case.masks);
    let flip = Comparison::new(&case.reference, &picture, &case.masks).expect("pictures of one window");
    let flip = flip.within(MaskKind::All).expect("a whole picture").flip_hdr;
    (format!("{all:>7.2} {edges:>7.2} {interior:>9.2} {flip:>8.4}"), seconds)
}

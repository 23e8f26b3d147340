//! The hybrid on a shot of the project, against the tracer and the filter that it is made of.

use std::path::Path;

use filter::{FrameView, GatherSettings, Method};
use optics::Camera;
use rgbd::{Frame, Picture, PixelWindow, Silent, Truth};
use study::{Hybrid, HybridSettings, StudyError, hybrid};
use trace::{Accumulation, LayerSettings, SceneFile};

/// Samples of the traced pixels, and of the truth.
const SAMPLES: u32 = 64;
const TRUTH_SAMPLES: u32 = 1024;

/// Seeds of the truth, the frame and the hybrid.
const SEEDS: [u64; 3] = [1, 2, 3];

/// The tilted lens on the simple scene, 160x90.
struct Shot {
    file: SceneFile,
    camera: Camera,
    frame: Frame,
}

impl Shot {
    fn new() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/simple.toml");
        let file = SceneFile::open(path).unwrap();
        let shot = file.shot(Some("double")).unwrap().camera;
        let camera = Camera { film: shot.film.resized(160, 90).unwrap(), ..shot };
        let settings = LayerSettings { seed: SEEDS[1], ..LayerSettings::default() };
        let frame = trace::layers(file.scene(), &camera, &settings, &Silent).unwrap().frame;
        Self { file, camera, frame }
    }

    fn display(&self) -> PixelWindow {
        self.frame.display
    }

    fn traced(&self, samples: u32, seed: u64) -> Accumulation {
        let pixels = self.display().into();
        trace::render(self.file.scene(), &self.camera, &pixels, 0..samples / 2, seed, &Silent).unwrap()
    }

    fn truth(&self) -> Truth {
        self.traced(TRUTH_SAMPLES, SEEDS[0]).to_truth().unwrap()
    }

    fn filtered(&self) -> Picture {
        let method = Method::Merged(GatherSettings::default());
        filter::apply(&FrameView::whole(&self.frame), &self.camera, &method, self.display(), &Silent).unwrap().picture
    }

    fn hybrid(&self, tolerance: f32) -> Result<Hybrid, StudyError> {
        let settings = HybridSettings { tolerance, samples: SAMPLES, seed: SEEDS[2], ..HybridSettings::default() };
        hybrid(self.file.scene(), &self.camera, &self.frame, &settings, &Silent)
    }
}

/// Root mean square error against the truth, whose noise drops out between its halves.
fn rmse(picture: &Picture, truth: &Truth) -> f64 {
    let [a, b] = &truth.halves;
    let square = |(x, y): (i32, i32)| {
        let (p, a, b) = (picture.at(x, y), a.at(x, y), b.at(x, y));
        (0..3).map(|c| f64::from((p[c] - a[c]) * (p[c] - b[c]))).sum::<f64>() / 3.0
    };
    let window = truth.display;
    (window.pixels().map(square).sum::<f64>() / window.area() as f64).max(0.0).sqrt()
}

#[test]
fn no_tolerance_is_the_trace_and_an_infinite_one_the_filter_to_the_bit() {
    let shot = Shot::new();
    let all = shot.hybrid(0.0).unwrap();
    assert_eq!(all.traced_share(), 1.0);
    assert!(all.picture == shot.traced(SAMPLES, SEEDS[2]).picture(), "tolerance 0 is the trace");
    let none = shot.hybrid(f32::INFINITY).unwrap();
    assert_eq!(none.traced_share(), 0.0);
    assert!(none.picture == shot.filtered(), "an infinite tolerance is the filter");
}

#[test]
fn a_smaller_tolerance_traces_more_and_errs_less() {
    let shot = Shot::new();
    let truth = shot.truth();
    let mut last = (0.0, rmse(&shot.filtered(), &truth));
    for tolerance in [0.03, 0.015, 0.007] {
        let hybrid = shot.hybrid(tolerance).unwrap();
        let now = (hybrid.traced_share(), rmse(&hybrid.picture, &truth));
        assert!(now.0 > last.0 && now.1 < last.1, "{tolerance}: {now:?} after {last:?}");
        last = now;
    }
}

/// Neighbours of which only one is traced, each pair once.
fn seam(hybrid: &Hybrid) -> Vec<[(i32, i32); 2]> {
    let weight = &hybrid.weight;
    let pairs = weight.window().pixels().flat_map(|(x, y)| [[(x, y), (x + 1, y)], [(x, y), (x, y + 1)]]);
    let is_seam = |[a, b]: &[(i32, i32); 2]| {
        let [Some(a), Some(b)] = [a, b].map(|&(x, y)| weight.get(x, y)) else { return false };
        (a > 0.0) != (b > 0.0)
    };
    pairs.filter(is_seam).collect()
}

/// Root mean square over pairs, R, G and B.
fn rms(pairs: &[[(i32, i32); 2]], value: impl Fn([(i32, i32); 2], usize) -> f64) -> f64 {
    let square = |&pair: &[(i32, i32); 2]| (0..3).map(|c| value(pair, c).powi(2)).sum::<f64>() / 3.0;
    (pairs.iter().map(square).sum::<f64>() / pairs.len() as f64).sqrt()
}

/// The seam between two pictures mixed by weights w is the part of a step between neighbours a and b that is in neither of
/// them: (w_a - w_b) times what they differ by there. Whole differences are what a plain switch leaves.
#[test]
fn where_trace_meets_filter_no_step_is_added_that_could_be_seen() {
    // Mixed pixels have the noise of their few samples: at a tolerance of 0.004 steps are off by 0.0013, of the filter by 0.0012
    const WORSE: f64 = 1.2;
    const SHARE: f64 = 0.25; // 12 dB below what may be wrong with each pixel anyway
    let shot = Shot::new();
    let truth = shot.truth().picture();
    let (filtered, traced) = (shot.filtered(), shot.traced(SAMPLES, SEEDS[2]).picture());
    for tolerance in [0.004, 0.008, 0.016] {
        let hybrid = shot.hybrid(tolerance).unwrap();
        let pairs = seam(&hybrid);
        assert!(pairs.len() > 200, "{tolerance}: a seam of {} pairs", pairs.len());
        let at = |picture: &Picture, (x, y): (i32, i32), c: usize| f64::from(picture.at(x, y)[c]);
        let differ = |[a, b]: [(i32, i32); 2], c| {
            0.5 * [a, b].map(|p| at(&traced, p, c) - at(&filtered, p, c)).iter().sum::<f64>()
        };
        let weight = |(x, y): (i32, i32)| f64::from(hybrid.weight.at(x, y));
        let added = rms(&pairs, |[a, b], c| (weight(a) - weight(b)) * differ([a, b], c));
        let switched = rms(&pairs, differ);
        let wrong = |picture: &Picture| {
            rms(&pairs, |[a, b], c| at(picture, a, c) - at(picture, b, c) - at(&truth, a, c) + at(&truth, b, c))
        };
        let (joined, filter) = (wrong(&hybrid.picture), wrong(&filtered));
        let said = format!(
            "tolerance {tolerance}: adds {added:.5}, a switch {switched:.5}; steps are off by {joined:.5}, of the filter \
             {filter:.5}"
        );
        assert!(added <= SHARE * f64::from(tolerance), "{said}");
        assert!(added < 0.5 * switched, "the ramp is worth something; {said}");
        assert!(joined <= WORSE * filter, "no step errs more than in the filter itself; {said}");
    }
}

#[test]
fn settings_that_are_none_are_refused() {
    let shot = Shot::new();
    for tolerance in [-0.1, f32::NAN] {
        assert!(matches!(shot.hybrid(tolerance), Err(StudyError::BadSetting { .. })), "{tolerance}");
    }
    for samples in [0, 1, 2 * trace::MAX_SAMPLES + 1] {
        let settings = HybridSettings { samples, ..HybridSettings::default() };
        let refused = hybrid(shot.file.scene(), &shot.camera, &shot.frame, &settings, &Silent);
        assert!(matches!(refused, Err(StudyError::BadSetting { .. })), "{samples}");
    }
}

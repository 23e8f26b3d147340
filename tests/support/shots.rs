//! The shots on which the filter is held against the tracer, with the floors of every rung.

use std::sync::LazyLock;

use filter::{GatherSettings, Method};
use optics::Camera;

use crate::support::score::Score;
use crate::support::traced::{Traced, scene};

/// The rungs of the ladder, cheapest first.
pub(crate) const RUNGS: [&str; 4] = ["0 pinhole", "1 own CoC", "3 merged, one layer", "3 merged, two layers"];

/// How far below the measured figures the floors lie, dB: all, edges, interior. Another seed, and so another truth and
/// another frame, moves them by a tenth; the interior is so near to the truth that the truth's noise moves it more.
pub(crate) const SLACK_DB: [f64; 3] = [0.3, 0.3, 1.0];

/// A shot `SCENE/NAME`.
pub(crate) struct Shot {
    pub(crate) name: &'static str,
    /// Samples per pixel that bring the noise 6 dB below the error of the truest rung.
    samples: u32,
    /// What each rung was measured to reach: all, edges, interior.
    measured: [[f64; 3]; 4],
}

impl Shot {
    /// What a rung must reach.
    pub(crate) fn floor(&self, rung: usize) -> Score {
        let mut floor = self.measured[rung];
        floor.iter_mut().zip(SLACK_DB).for_each(|(db, slack)| *db -= slack);
        Score(floor)
    }
}

const fn shot(name: &'static str, samples: u32, measured: [[f64; 3]; 4]) -> Shot {
    Shot { name, samples, measured }
}

#[rustfmt::skip]
pub(crate) const SHOTS: [Shot; 7] = [
    shot("simple/blur", 640, [[22.57, 23.73, 22.45], [41.35, 33.34, 45.67], [43.53, 37.00, 45.85], [45.38, 42.57, 45.87]]),
    shot("simple/tilt", 256, [[31.17, 29.36, 31.44], [38.53, 33.05, 40.07], [39.03, 34.69, 40.01], [39.82, 38.49, 40.01]]),
    shot("simple/reverse", 768, [[20.24, 20.50, 20.23], [41.55, 32.79, 44.32], [43.17, 35.60, 44.97], [44.75, 40.97, 45.21]]),
    shot("simple/double", 448, [[24.13, 24.42, 24.08], [37.87, 30.76, 43.62], [39.09, 32.73, 42.95], [42.54, 40.74, 42.95]]),
    shot("simple/swing_shift", 512, [[24.10, 25.34, 24.00], [41.14, 32.97, 44.39], [42.83, 36.11, 44.71], [44.57, 42.67, 44.80]]),
    shot("landscape/miniature", 608, [[26.49, 26.22, 26.91], [41.84, 39.69, 54.55], [49.37, 47.39, 57.64], [52.72, 51.00, 58.16]]),
    shot("landscape/double", 256, [[32.02, 31.90, 33.15], [39.19, 38.69, 55.64], [43.73, 43.25, 56.25], [48.27, 47.84, 56.25]]),
];

/// A shot, traced and filtered by every rung.
pub(crate) struct Filtered {
    pub(crate) shot: &'static Shot,
    pub(crate) traced: Traced,
    /// One score for each rung.
    pub(crate) scores: [Score; 4],
}

/// All shots; traced once, whichever test comes first.
pub(crate) fn filtered() -> &'static [Filtered] {
    static ALL: LazyLock<Vec<Filtered>> = LazyLock::new(|| {
        let scenes = ["simple", "landscape"].map(|name| (name, scene(name)));
        let all = SHOTS.iter().map(|shot| {
            let (wanted, name) = shot.name.split_once('/').expect("SCENE/NAME");
            let (_, scene) = scenes.iter().find(|(name, _)| *name == wanted).expect("a scene of the project");
            let traced = Traced::new(scene, name, shot.samples, Camera::clone);
            let scores = [0, 1, 2, 3].map(|i| traced.score(rung(i)));
            Filtered { shot, traced, scores }
        });
        all.collect()
    });
    &ALL
}

/// The method of a rung.
pub(crate) fn rung(index: usize) -> Method {
    let one_layer = GatherSettings { layers: 1, ..GatherSettings::default() };
    match index {
        0 => Method::Pinhole,
        1 => Method::OwnCoc(one_layer),
        2 => Method::Merged(one_layer),
        _ => Method::default(),
    }
}

//! The shots on which the filter is held against the tracer, with the floors of every rung.

use std::sync::LazyLock;

use filter::{GatherSettings, Method};

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
    /// Samples per pixel that bring the noise 10 dB below the error of the truest rung.
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
    shot("simple/blur", 640, [[22.57, 23.73, 22.45], [41.35, 33.33, 45.68], [41.77, 33.91, 45.79], [43.44, 36.77, 45.90]]),
    shot("simple/tilt", 256, [[31.19, 29.39, 31.45], [38.30, 33.05, 39.70], [38.60, 34.05, 39.67], [39.31, 37.04, 39.67]]),
    shot("simple/reverse", 768, [[20.24, 20.51, 20.22], [41.58, 32.78, 44.37], [41.87, 32.99, 44.76], [43.40, 36.47, 44.85]]),
    shot("simple/double", 448, [[24.13, 24.42, 24.08], [37.90, 30.76, 43.73], [39.18, 32.65, 43.37], [41.10, 35.91, 43.37]]),
    shot("simple/swing_shift", 512, [[24.10, 25.34, 24.00], [41.13, 32.96, 44.37], [40.83, 32.26, 44.65], [43.16, 36.99, 44.70]]),
    shot("landscape/miniature", 608, [[26.48, 26.22, 26.90], [41.84, 39.69, 54.54], [44.07, 41.89, 58.01], [49.04, 47.03, 57.93]]),
    shot("landscape/double", 256, [[32.02, 31.90, 33.15], [39.19, 38.70, 55.61], [40.26, 39.77, 56.44], [45.90, 45.45, 56.46]]),
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
            let traced = Traced::new(scene, name, shot.samples, None);
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

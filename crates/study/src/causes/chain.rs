//! From the squared errors along a chain of experiments, and along the same chain reversed, to shares and a map.

use rgbd::{PixelWindow, Plane};
use serde::Serialize;

use crate::Cause;

/// Reach in pixels over which squared errors are averaged before pixels are judged: a pixel alone is mostly chance.
const AROUND: i32 = 2;

/// The part of the error that an experiment must remove to explain it.
const EXPLAINS: f64 = 0.5;

/// Side of the tiles that are left out in turn for a share's standard error, pixels.
const TILE: i32 = 20;

/// What a cause has to do with the error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CauseShare {
    /// The cause.
    pub cause: Cause,
    /// Drop of the squared error at its step of the chain, over the whole error; negative where the step makes it worse.
    pub forward: f64,
    /// The same in the reversed chain.
    pub reversed: f64,
    /// Standard error of the forward share, from leaving out one tile of the picture after the other.
    pub standard_error: f64,
    /// The part of the error that stands in pixels where it leads and its experiment removes at least half.
    pub explains: f64,
}

impl CauseShare {
    /// Both shares, the smaller one first.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.forward.min(self.reversed), self.forward.max(self.reversed)]
    }
}

/// What holds most of a pixel's error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// A cause whose experiment removes at least half of what was left of the error before it, and most of all.
    Cause(Cause),
    /// No cause alone, but all of them together remove at least half.
    Several,
    /// Not even all experiments together remove half.
    Unexplained,
}

/// The causes of a picture's error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shares {
    /// Mean squared error with every cause in it, the reference's noise taken off.
    pub mse: f64,
    /// Every cause of the chain, in its order.
    pub causes: Vec<CauseShare>,
    /// What is left over when all are switched off, over the whole error.
    pub rest: f64,
    /// Standard error of the rest.
    pub rest_standard_error: f64,
    /// The part of the error in pixels of [`Verdict::Several`].
    pub several: f64,
    /// The part of the error in pixels of [`Verdict::Unexplained`].
    pub unexplained: f64,
    /// Squared error around each pixel, and the verdict.
    #[serde(skip)]
    pub map: Vec<(f32, Verdict)>,
    #[serde(skip)]
    window: PixelWindow,
}

impl Shares {
    /// The shares of `causes`, from the squared errors of each pixel after none, one, ... and all of them are switched off
    /// in their order (`forward`) and in the opposite one (`reversed`).
    ///
    /// The planes are of one window; there is one more of them than causes.
    #[must_use]
    pub fn new(causes: &[Cause], forward: &[Plane], reversed: &[Plane]) -> Self {
        assert_eq!([forward.len(), reversed.len()], [causes.len() + 1; 2], "one step for each cause");
        let window = forward[0].window();
        let sums: Vec<Vec<f64>> = forward.iter().map(tile_sums).collect();
        let total = |step: usize| sums[step].iter().sum::<f64>();
        let share_of = |drop: f64| if total(0) > 0.0 { drop / total(0) } else { 0.0 };

        // Judge each pixel by the errors around it
        let smooth: Vec<Plane> = forward.iter().map(averaged).collect();
        let verdict = |i: usize| {
            let errors: Vec<f64> = smooth.iter().map(|plane| f64::from(plane.values()[i]).max(0.0)).collect();
            (errors[0] as f32, verdict(causes, &errors))
        };
        let map: Vec<(f32, Verdict)> = (0..window.area()).map(verdict).collect();
        let all = map.iter().map(|(error, _)| f64::from(*error)).sum::<f64>();
        let part_of = |wanted: Verdict| {
            let sum: f64 = map.iter().filter(|(_, v)| *v == wanted).map(|(error, _)| f64::from(*error)).sum();
            if all > 0.0 { sum / all } else { 0.0 }
        };

        let reversed: Vec<f64> = reversed.iter().map(|plane| tile_sums(plane).iter().sum()).collect();
        let count = causes.len();
        let shares = causes.iter().enumerate().map(|(k, &cause)| CauseShare {
            cause,
            forward: share_of(total(k) - total(k + 1)),
            reversed: share_of(reversed[count - 1 - k] - reversed[count - k]),
            standard_error: jackknife(&difference(&sums[k], &sums[k + 1]), &sums[0]),
            explains: part_of(Verdict::Cause(cause)),
        });
        Self {
            mse: total(0) / window.area().max(1) as f64,
            causes: shares.collect(),
            rest: share_of(total(count)),
            rest_standard_error: jackknife(&sums[count], &sums[0]),
            several: part_of(Verdict::Several),
            unexplained: part_of(Verdict::Unexplained),
            map,
            window,
        }
    }

    /// The pixels of the map.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }
}

/// The verdict on a pixel whose error was `errors` before the first and after each experiment.
fn verdict(causes: &[Cause], errors: &[f64]) -> Verdict {
    let explains = |k: &usize| errors[*k] - errors[k + 1] >= EXPLAINS * errors[*k] && errors[*k] > errors[k + 1];
    let drop = |k: &usize| errors[*k] - errors[k + 1];
    let leading = (0..causes.len()).max_by(|a, b| drop(a).total_cmp(&drop(b)));
    match leading.filter(explains) {
        Some(k) => Verdict::Cause(causes[k]),
        None if errors[causes.len()] <= (1.0 - EXPLAINS) * errors[0] => Verdict::Several,
        None => Verdict::Unexplained,
    }
}

/// Sums over the tiles of a plane, row by row.
fn tile_sums(plane: &Plane) -> Vec<f64> {
    let window = plane.window();
    let across = window.width.div_ceil(TILE as u32) as usize;
    let mut sums = vec![0.0; across * window.height.div_ceil(TILE as u32) as usize];
    for (x, y) in window.pixels() {
        let (column, row) = ((x - window.x) / TILE, (y - window.y) / TILE);
        sums[row as usize * across + column as usize] += f64::from(plane.at(x, y));
    }
    sums
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Standard error of the ratio of two sums over tiles, by the jackknife (Efron 1982): one tile left out after the other.
fn jackknife(part: &[f64], whole: &[f64]) -> f64 {
    let (sum, total): (f64, f64) = (part.iter().sum(), whole.iter().sum());
    let n = part.len() as f64;
    let without = part.iter().zip(whole).map(|(p, w)| (sum - p) / (total - w)).filter(|ratio| ratio.is_finite());
    let without: Vec<f64> = without.collect();
    let mean = without.iter().sum::<f64>() / without.len().max(1) as f64;
    ((n - 1.0) / n * without.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>()).sqrt()
}

/// Mean over the squares of 2 [`AROUND`] + 1 pixels, those at the border smaller.
fn averaged(plane: &Plane) -> Plane {
    let window = plane.window();
    let along = |source: &Plane, step: (i32, i32)| {
        Plane::from_fn(window, |x, y| {
            let near = (-AROUND..=AROUND).filter_map(|k| source.get(x + k * step.0, y + k * step.1));
            let (sum, count) = near.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            sum / count
        })
    };
    along(&along(plane, (1, 0)), (0, 1))
}

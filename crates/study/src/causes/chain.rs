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

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 60, height: 40 };
    const CAUSES: [Cause; 2] = [Cause::MixedColor, Cause::Leakage];
    const ROUNDING: f64 = 1e-6;

    fn plane(left: f32, right: f32) -> Plane {
        Plane::from_fn(WINDOW, |x, _| if x < 30 { left } else { right })
    }

    #[test]
    fn a_known_cause_gets_its_share_and_its_pixels() {
        // Left an error of 4 that the first experiment removes, right one of 2 of which the second removes a little over half
        let forward = [plane(4.0, 2.0), plane(0.0, 2.0), plane(0.0, 0.9)];
        let reversed = [plane(4.0, 2.0), plane(4.0, 0.9), plane(0.0, 0.9)];
        let shares = Shares::new(&CAUSES, &forward, &reversed);
        for (share, wanted) in shares.causes.iter().zip([4.0 / 6.0, 1.1 / 6.0]) {
            assert!(share.range().iter().all(|s| (s - wanted).abs() < ROUNDING), "{share:?}");
        }
        assert!((shares.rest - 0.9 / 6.0).abs() < ROUNDING && (shares.mse - 3.0).abs() < ROUNDING);
        let at = |x: i32| shares.map[WINDOW.index(x, 20)].1;
        assert_eq!([at(10), at(50)], [Verdict::Cause(Cause::MixedColor), Verdict::Cause(Cause::Leakage)]);
        assert!(shares.unexplained < ROUNDING && shares.several < ROUNDING, "at the seam, too, one of both leads");
    }

    #[test]
    fn the_shares_and_the_rest_are_the_whole_error_in_either_order() {
        let forward = [plane(4.0, 2.0), plane(5.0, 0.5), plane(1.0, 0.25)];
        let reversed = [plane(4.0, 2.0), plane(1.0, 2.5), plane(1.0, 0.25)];
        let shares = Shares::new(&CAUSES, &forward, &reversed);
        for of_order in [|s: &CauseShare| s.forward, |s: &CauseShare| s.reversed] {
            let sum = shares.causes.iter().map(of_order).sum::<f64>() + shares.rest;
            assert!((sum - 1.0).abs() < ROUNDING, "{shares:?}");
        }
        let parts = shares.causes.iter().map(|s| s.explains).sum::<f64>() + shares.several + shares.unexplained;
        assert!((parts - 1.0).abs() < ROUNDING, "every pixel has one verdict");
    }

    #[test]
    fn experiments_that_change_nothing_have_no_share_and_explain_nothing() {
        let same = [plane(4.0, 2.0), plane(4.0, 2.0), plane(4.0, 2.0)];
        let shares = Shares::new(&CAUSES, &same, &same);
        for share in &shares.causes {
            assert_eq!((share.range(), share.standard_error, share.explains), ([0.0; 2], 0.0, 0.0));
        }
        assert_eq!((shares.rest, shares.unexplained), (1.0, 1.0));
    }

    #[test]
    fn what_makes_it_worse_has_a_negative_share() {
        let forward = [plane(1.0, 1.0), plane(2.0, 1.0), plane(0.0, 0.0)];
        let shares = Shares::new(&CAUSES, &forward, &forward);
        assert!((shares.causes[0].forward + 0.5).abs() < ROUNDING, "{:?}", shares.causes[0]);
        assert!((shares.causes[1].forward - 1.5).abs() < ROUNDING, "{:?}", shares.causes[1]);
    }

    #[test]
    fn small_removals_are_several_together_and_none_is_unexplained() {
        let chain = [Cause::Border, Cause::MixedColor, Cause::SmallDiscs, Cause::Leakage];
        let errors = [1.0, 0.7, 0.45, 0.3, 0.2];
        assert_eq!(verdict(&chain, &errors), Verdict::Several, "none removes half, all remove 80 %");
        assert_eq!(verdict(&chain, &[1.0, 0.9, 0.8, 0.7, 0.6]), Verdict::Unexplained);
        assert_eq!(verdict(&chain, &[0.0; 5]), Verdict::Several, "where nothing is wrong there is nothing to explain");
    }

    #[test]
    fn an_error_of_zero_has_shares_of_zero() {
        let none = [plane(0.0, 0.0), plane(0.0, 0.0), plane(0.0, 0.0)];
        let shares = Shares::new(&CAUSES, &none, &none);
        assert!(shares.causes.iter().all(|s| s.range() == [0.0; 2] && s.standard_error == 0.0), "{shares:?}");
        assert_eq!((shares.mse, shares.rest), (0.0, 0.0));
    }
}

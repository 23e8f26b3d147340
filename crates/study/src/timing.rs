//! How long something takes: several runs, told by their median and the middle half of them.

use serde::Serialize;

/// Seconds of one or more runs of the same work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timing {
    runs: Vec<f64>,
    median: f64,
    low: f64,
    high: f64,
}

impl Timing {
    /// The statistics of some runs, each in seconds above 0; `None` if there is no run or one is not such a number.
    #[must_use]
    pub fn new(runs: Vec<f64>) -> Option<Self> {
        if runs.is_empty() || runs.iter().any(|&seconds| !(seconds > 0.0 && seconds.is_finite())) {
            return None;
        }
        let mut sorted = runs.clone();
        sorted.sort_by(f64::total_cmp);
        let [low, median, high] = [0.25, 0.5, 0.75].map(|share| quantile(&sorted, share));
        Some(Self { runs, median, low, high })
    }

    /// The runs in seconds, in the order in which they were made.
    #[must_use]
    pub fn runs(&self) -> &[f64] {
        &self.runs
    }

    /// The median in seconds.
    #[must_use]
    pub fn median(&self) -> f64 {
        self.median
    }

    /// The first quartile in seconds: a quarter of the runs took no longer.
    #[must_use]
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The third quartile in seconds: a quarter of the runs took at least as long.
    #[must_use]
    pub fn high(&self) -> f64 {
        self.high
    }
}

/// The value below which a `share` (0 to 1) of sorted values lies, linear between neighbours (type 7 of Hyndman and Fan
/// 1996).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    below + (above - below) * at.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_quartiles_are_those_of_the_sorted_runs() {
        let timing = Timing::new(vec![5.0, 1.0, 4.0, 2.0, 100.0]).unwrap();
        assert_eq!((timing.low(), timing.median(), timing.high()), (2.0, 4.0, 5.0), "one slow run changes nothing");
        assert_eq!(timing.runs(), [5.0, 1.0, 4.0, 2.0, 100.0]);
        let even = Timing::new(vec![4.0, 1.0, 2.0, 3.0]).unwrap();
        assert_eq!((even.low(), even.median(), even.high()), (1.75, 2.5, 3.25));
        let one = Timing::new(vec![0.5]).unwrap();
        assert_eq!((one.low(), one.median(), one.high()), (0.5, 0.5, 0.5));
    }

    #[test]
    fn no_run_and_impossible_runs_are_no_timing() {
        for runs in [vec![], vec![1.0, 0.0], vec![-1.0], vec![f64::NAN], vec![f64::INFINITY, 1.0]] {
            assert!(Timing::new(runs.clone()).is_none(), "{runs:?}");
        }
    }
}

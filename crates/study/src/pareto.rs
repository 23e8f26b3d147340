//! Which methods are worth their time: the Pareto frontier of time and error.

/// What a method costs and what it is worth; smaller is better in both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tradeoff {
    /// Time in seconds.
    pub seconds: f64,
    /// Error, in any unit.
    pub error: f64,
}

impl Tradeoff {
    /// Whether it is nowhere worse than `other` and somewhere better.
    #[must_use]
    pub fn dominates(&self, other: &Self) -> bool {
        self.seconds <= other.seconds && self.error <= other.error && self != other
    }
}

/// For each method the most accurate one that dominates it, by its index; `None` for those on the frontier.
///
/// Of equals none dominates the other. All figures must be numbers.
#[must_use]
pub fn dominated_by(methods: &[Tradeoff]) -> Vec<Option<usize>> {
    let dominator = |method: &Tradeoff| {
        let dominators = (0..methods.len()).filter(|&i| methods[i].dominates(method));
        // The most accurate one, and of those the fastest, is on the frontier itself
        dominators.min_by(|&a, &b| {
            let (a, b) = (methods[a], methods[b]);
            a.error.total_cmp(&b.error).then(a.seconds.total_cmp(&b.seconds))
        })
    };
    methods.iter().map(dominator).collect()
}

/// The indices of the methods that none dominates, the fastest first.
#[must_use]
pub fn frontier(methods: &[Tradeoff]) -> Vec<usize> {
    let dominated = dominated_by(methods);
    let mut on_it: Vec<usize> = (0..methods.len()).filter(|&i| dominated[i].is_none()).collect();
    on_it.sort_by(|&a, &b| methods[a].seconds.total_cmp(&methods[b].seconds));
    on_it
}

#[cfg(test)]
mod tests {
    use super::*;

    fn methods(figures: &[(f64, f64)]) -> Vec<Tradeoff> {
        figures.iter().map(|&(seconds, error)| Tradeoff { seconds, error }).collect()
    }

    #[test]
    fn the_frontier_holds_what_nothing_beats_in_both() {
        // A staircase of three, one above it, one slower than the best of all
        let methods = methods(&[(4.0, 1.0), (1.0, 9.0), (2.0, 3.0), (3.0, 8.0), (9.0, 1.5)]);
        assert_eq!(frontier(&methods), [1, 2, 0]);
        assert_eq!(dominated_by(&methods), [None, None, None, Some(2), Some(0)]);
    }

    #[test]
    fn of_all_that_beat_a_method_the_most_accurate_is_named() {
        let methods = methods(&[(1.0, 5.0), (2.0, 2.0), (3.0, 1.0), (3.0, 6.0)]);
        assert_eq!(dominated_by(&methods)[3], Some(2));
    }

    #[test]
    fn a_tie_in_one_figure_is_decided_by_the_other_and_equals_stand_side_by_side() {
        let methods = methods(&[(1.0, 2.0), (1.0, 3.0), (2.0, 2.0), (1.0, 2.0)]);
        assert_eq!(dominated_by(&methods), [None, Some(0), Some(0), None]);
        assert_eq!(frontier(&methods), [0, 3]);
    }

    #[test]
    fn on_random_figures_a_method_is_on_the_frontier_or_names_one_on_it() {
        // Figures of a small linear congruential sequence, with ties
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 60) as f64
        };
        for _ in 0..100 {
            let figures: Vec<_> = (0..12).map(|_| (next(), next())).collect();
            let methods = methods(&figures);
            for (i, dominator) in dominated_by(&methods).into_iter().enumerate() {
                let beaten = methods.iter().any(|other| other.dominates(&methods[i]));
                assert_eq!(dominator.is_some(), beaten);
                assert!(dominator.is_none_or(|j| frontier(&methods).contains(&j) && methods[j].dominates(&methods[i])));
            }
        }
    }
}

//! A logarithmic axis: where values stand, and which are written beside it.

/// Values from `low` to `high` along an axis from pixel `from` to pixel `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LogAxis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// How much of the axis stays free at each end.
const MARGIN: f64 = 0.06;

/// The least span of an axis, as a factor.
const LEAST_SPAN: f64 = 4.0;

/// An axis of more decades than this names only these.
const DECADES_ONLY: f64 = 2.4;

impl LogAxis {
    /// An axis that holds all values above 0, with some room beyond them.
    pub(crate) fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let seen = values.filter(|&value| value > 0.0 && value.is_finite());
        let (low, high) = seen.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if high > 0.0 { (low, high) } else { (1.0, 1.0) };
        // Widen what is too narrow, then both ends
        let widen = (LEAST_SPAN / (high / low)).max(1.0).sqrt();
        let (low, high) = (low / widen, high * widen);
        let margin = (high / low).powf(MARGIN / (1.0 - 2.0 * MARGIN));
        Self { low: low / margin, high: high * margin, from, to }
    }

    /// Where a value stands, in pixels; the near end for what is below the axis or 0, the far end for what is above it.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let share = (value.max(self.low) / self.low).ln() / (self.high / self.low).ln();
        self.from + share.min(1.0) * (self.to - self.from)
    }

    /// Whether a value lies within the axis.
    pub(crate) fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Round values along it, the smallest first: powers of ten, and 2 and 5 times those where there are few decades.
    pub(crate) fn ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let digits: &[f64] = if decades > DECADES_ONLY { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let powers = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = powers.flat_map(|power| digits.iter().map(move |digit| scaled(*digit, power)));
        all.filter(|&tick| self.holds(tick)).collect()
    }

    /// Where finer lines may stand: all digits of all decades.
    pub(crate) fn fine_ticks(&self) -> Vec<f64> {
        let powers = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = powers.flat_map(|power| (1..10).map(move |digit| scaled(f64::from(digit), power)));
        all.filter(|&tick| self.holds(tick)).collect()
    }
}

/// `digit` times a power of ten, as its decimal is read.
fn scaled(digit: f64, power: i32) -> f64 {
    if power < 0 { digit / 10_f64.powi(-power) } else { digit * 10_f64.powi(power) }
}

/// A time in words: `20 ms`, `0.5 s`, `30 s`; two digits count.
pub(crate) fn seconds_text(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{} µs", two_digits(s * 1e6)),
        s if s < 0.1 => format!("{} ms", two_digits(s * 1e3)),
        s => format!("{} s", two_digits(s)),
    }
}

/// A number with two digits that count, without needless zeros or an exponent.
pub(crate) fn two_digits(value: f64) -> String {
    if value <= 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    let rounded = (value / unit).round() * unit;
    let decimals = (1 - rounded.log10().floor() as i32).max(0) as usize;
    let text = format!("{rounded:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_factors_are_equal_steps_and_the_ends_have_room() {
        const PX: f64 = 1e-9;
        let axis = LogAxis::around([1.0, 10.0, 100.0].into_iter(), 0.0, 100.0);
        let [a, b, c] = [1.0, 10.0, 100.0].map(|value| axis.place(value));
        assert!((b - a - (c - b)).abs() < PX && (a - 6.0).abs() < PX && (c - 94.0).abs() < PX, "{a} {b} {c}");
        // Against the direction of the page, and beyond the ends
        let up = LogAxis::around([1.0, 10.0].into_iter(), 100.0, 0.0);
        assert!(up.place(1.0) > up.place(10.0));
        assert_eq!((up.place(0.0), up.place(-1.0), up.place(1e9)), (100.0, 100.0, 0.0));
    }

    #[test]
    fn ticks_are_round_lie_on_the_axis_and_are_some() {
        let few = LogAxis::around([0.003, 0.04].into_iter(), 0.0, 1.0);
        assert_eq!(few.ticks(), [0.005, 0.01, 0.02]);
        let many = LogAxis::around([0.002, 30.0].into_iter(), 0.0, 1.0);
        assert_eq!(many.ticks(), [0.01, 0.1, 1.0, 10.0]);
        for low in [1e-6, 0.7, 3.0, 123.0] {
            for span in [1.0, 2.0, 9.0, 1e3] {
                let axis = LogAxis::around([low, low * span].into_iter(), 0.0, 1.0);
                assert!(axis.ticks().len() >= 2, "{low} {span}: {:?}", axis.ticks());
                assert!(axis.holds(low) && axis.holds(low * span));
            }
        }
        assert!(!LogAxis::around(std::iter::empty(), 0.0, 1.0).ticks().is_empty(), "nothing to show is no panic");
    }

    #[test]
    fn times_and_numbers_are_short() {
        let cases = [
            (0.000_25, "250 µs"),
            (0.02, "20 ms"),
            (0.0994, "99 ms"),
            (0.5, "0.5 s"),
            (1.26, "1.3 s"),
            (314.0, "310 s"),
        ];
        for (seconds, text) in cases {
            assert_eq!(seconds_text(seconds), text);
        }
        let numbers =
            [(0.001, "0.001"), (0.004_567, "0.0046"), (0.0996, "0.1"), (10.0, "10"), (100.0, "100"), (2.0, "2")];
        for (value, text) in numbers {
            assert_eq!(two_digits(value), text);
        }
    }
}

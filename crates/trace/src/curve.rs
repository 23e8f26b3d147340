//! Ways of a number from key to key: a key is a frame, and the value there.

/// The keys about a frame: the one before and the share of the way to the next, or the only one that counts.
fn about(keys: &[(f64, f64)], frame: f64) -> (usize, f64) {
    let after = keys.partition_point(|key| key.0 <= frame);
    if after == 0 || after == keys.len() {
        return (after.saturating_sub(1), 0.0);
    }
    let (from, to) = (keys[after - 1].0, keys[after].0);
    (after - 1, (frame - from) / (to - from))
}

/// Straight from key to key.
pub(crate) fn linear(keys: &[(f64, f64)], frame: f64) -> f64 {
    let (i, share) = about(keys, frame);
    if share == 0.0 { keys[i].1 } else { keys[i].1 + share * (keys[i + 1].1 - keys[i].1) }
}

/// A cubic through all keys that starts and ends at rest and never leaves the values of the keys on both sides (Fritsch
/// and Butland, "A method for constructing local monotone piecewise cubic interpolants", 1984: harmonic mean of slopes).
pub(crate) fn smooth(keys: &[(f64, f64)], frame: f64) -> f64 {
    let (i, t) = about(keys, frame);
    if t == 0.0 {
        return keys[i].1;
    }
    let slope = |i: usize| (keys[i + 1].1 - keys[i].1) / (keys[i + 1].0 - keys[i].0);
    let at = |i: usize| {
        if i == 0 || i + 1 == keys.len() {
            return 0.0;
        }
        let (before, after) = (slope(i - 1), slope(i));
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    };
    let length = keys[i + 1].0 - keys[i].0;
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * keys[i].1
        + (t3 - 2.0 * t2 + t) * length * at(i)
        + (3.0 * t2 - 2.0 * t3) * keys[i + 1].1
        + (t3 - t2) * length * at(i + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [(f64, f64); 4] = [(1.0, 0.0), (11.0, 10.0), (21.0, 30.0), (31.0, 30.0)];

    #[test]
    fn both_ways_go_through_all_keys_and_stay_beyond_them() {
        for path in [linear, smooth] {
            for (frame, value) in KEYS {
                assert_eq!(path(&KEYS, frame), value);
            }
            assert_eq!((path(&KEYS, -5.0), path(&KEYS, 99.0)), (0.0, 30.0));
        }
        assert_eq!(linear(&KEYS, 6.0), 5.0);
    }

    #[test]
    fn the_smooth_way_never_turns_back_and_has_no_corner() {
        let values: Vec<f64> = (0..=300).map(|i| smooth(&KEYS, 1.0 + 0.1 * f64::from(i))).collect();
        assert!(values.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "it turns back");
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let largest = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        // The linear way's steps change by 0.1 and 0.2 at its corners
        assert!(largest < 0.03, "{largest}");
        assert!(steps[0] < 0.01 && steps[299] < 1e-9, "it starts and ends at rest");
    }
}

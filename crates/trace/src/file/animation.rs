//! Shots whose camera, lens or film changes from frame to frame.

use std::ops::RangeInclusive;

use serde::Deserialize;
use toml::{Table, Value};

use super::error::Fault;
use super::shot::ShotTables;
use super::spec::{CameraSpec, EaseSpec, FilmSpec, KeySpec, LensSpec};

/// Frames that a shot may have: 1 to 10 days at 24 frames a second would be two million; more is a mistake.
const MOST_FRAMES: i64 = 1_000_000;

/// Keyframes of a shot: what each sets holds at its frame, and goes to what the next one sets that names the same value.
#[derive(Debug, Clone)]
pub(crate) struct Animation {
    keys: Vec<KeySpec>,
    ease: EaseSpec,
}

/// How a number goes on from key to key.
type Path<'a> = &'a dyn Fn(&[(f64, f64)], f64) -> f64;

impl Animation {
    pub(crate) fn new(keys: &[KeySpec], ease: EaseSpec) -> Result<Self, Fault> {
        if keys.windows(2).any(|pair| pair[0].frame >= pair[1].frame) {
            return Fault::says("keys must come in the order of their frames, each of its own");
        }
        let frames: Vec<i64> = keys.iter().map(|key| key.frame).collect();
        if frames.iter().any(|frame| frame.abs() > MOST_FRAMES) {
            return Fault::says(format!("frames must lie between -{MOST_FRAMES} and {MOST_FRAMES}"));
        }
        if keys.iter().any(|key| key.film.contains_key("size")) {
            return Fault::says("the size of the film cannot change from frame to frame; set it in the shot");
        }
        Ok(Self { keys: keys.to_vec(), ease })
    }

    /// From the first key to the last.
    pub(crate) fn frames(&self) -> RangeInclusive<i64> {
        let of = |key: Option<&KeySpec>| key.map_or(0, |key| key.frame);
        of(self.keys.first())..=of(self.keys.last())
    }

    /// The tables of a shot in a frame; before the first key and after the last nothing moves.
    pub(crate) fn over(&self, base: &ShotTables, frame: i64) -> Result<ShotTables, Fault> {
        let table = |of_key: fn(&KeySpec) -> &Table| -> Result<Table, Fault> {
            let mut names: Vec<&String> = self.keys.iter().flat_map(|key| of_key(key).keys()).collect();
            names.sort_unstable();
            names.dedup();
            let value = |name: &String| {
                let given = self.keys.iter().filter_map(|key| Some((key.frame as f64, of_key(key).get(name)?)));
                let given: Vec<(f64, &Value)> = given.collect();
                Ok((name.clone(), between(name, &given, frame as f64, self.path())?))
            };
            names.into_iter().map(value).collect()
        };
        Ok(ShotTables {
            camera: read::<CameraSpec>(table(|key| &key.camera)?)?.over(&base.camera),
            lens: read::<LensSpec>(table(|key| &key.lens)?)?.over(&base.lens),
            film: read::<FilmSpec>(table(|key| &key.film)?)?.over(&base.film),
        })
    }

    fn path(&self) -> Path<'_> {
        match self.ease {
            EaseSpec::Linear => &linear,
            EaseSpec::Smooth => &smooth,
        }
    }
}

fn read<'de, T: Deserialize<'de>>(table: Table) -> Result<T, Fault> {
    T::deserialize(table).map_err(|error| Fault::Says(error.to_string().trim_end().to_owned()))
}

/// The value at a frame, from those that keys give: numbers go on, in lists and tables too, all else must stay.
fn between(name: &str, given: &[(f64, &Value)], frame: f64, path: Path<'_>) -> Result<Value, Fault> {
    let first = given[0].1;
    if given.iter().all(|(_, value)| *value == first) {
        return Ok(first.clone());
    }
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|n| n as f64));
    let numbers = given.iter().map(|&(at, value)| Some((at, number(value)?))).collect::<Option<Vec<_>>>();
    if let Some(numbers) = numbers {
        return Ok(Value::Float(path(&numbers, frame)));
    }
    if let Some(lists) = given.iter().map(|&(at, value)| Some((at, value.as_array()?))).collect::<Option<Vec<_>>>() {
        let length = lists[0].1.len();
        if lists.iter().all(|(_, list)| list.len() == length) {
            let item = |i: usize| {
                let items: Vec<_> = lists.iter().map(|&(at, list)| (at, &list[i])).collect();
                between(name, &items, frame, path)
            };
            return (0..length).map(item).collect::<Result<_, _>>().map(Value::Array);
        }
    }
    if let Some(tables) = given.iter().map(|&(at, value)| Some((at, value.as_table()?))).collect::<Option<Vec<_>>>() {
        let names: Vec<&String> = tables[0].1.keys().collect();
        if tables.iter().all(|(_, table)| table.keys().eq(names.iter().copied())) {
            let item = |key: &String| {
                let items: Vec<_> = tables.iter().map(|&(at, table)| (at, &table[key])).collect();
                Ok((key.clone(), between(name, &items, frame, path)?))
            };
            return names.into_iter().map(item).collect::<Result<_, _>>().map(Value::Table);
        }
    }
    Fault::says(format!("{name} is not of one kind in all keys; only numbers can go from one to another"))
}

/// The keys about a frame: the one before and the share of the way to the next, or the only one that counts.
fn about(keys: &[(f64, f64)], frame: f64) -> (usize, f64) {
    let after = keys.partition_point(|key| key.0 <= frame);
    if after == 0 || after == keys.len() {
        return (after.saturating_sub(1), 0.0);
    }
    let (from, to) = (keys[after - 1].0, keys[after].0);
    (after - 1, (frame - from) / (to - from))
}

fn linear(keys: &[(f64, f64)], frame: f64) -> f64 {
    let (i, share) = about(keys, frame);
    if share == 0.0 { keys[i].1 } else { keys[i].1 + share * (keys[i + 1].1 - keys[i].1) }
}

/// A cubic through all keys that starts and ends at rest and never leaves the values of the keys on both sides (Fritsch
/// and Butland, "A method for constructing local monotone piecewise cubic interpolants", 1984: harmonic mean of slopes).
fn smooth(keys: &[(f64, f64)], frame: f64) -> f64 {
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

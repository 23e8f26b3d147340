//! Shots whose camera, lens or film changes from frame to frame.

use std::ops::RangeInclusive;

use serde::Deserialize;
use toml::{Table, Value};

use super::error::Fault;
use super::shot::ShotTables;
use super::spec::{CameraSpec, EaseSpec, FilmSpec, KeySpec, LensSpec};
use crate::curve::{linear, smooth};

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
        if keys.iter().any(|key| key.camera.contains_key("frame")) {
            return Fault::says("a key has a frame of its own; camera.frame is for shots without keys");
        }
        Ok(Self { keys: keys.to_vec(), ease })
    }

    /// From the first key to the last.
    pub(crate) fn frames(&self) -> RangeInclusive<i64> {
        let of = |key: Option<&KeySpec>| key.map_or(0, |key| key.frame);
        of(self.keys.first())..=of(self.keys.last())
    }

    /// The tables of a shot in a frame, or between two; before the first key and after the last nothing moves.
    pub(crate) fn over(&self, base: &ShotTables, frame: f64) -> Result<ShotTables, Fault> {
        let table = |of_key: fn(&KeySpec) -> &Table| -> Result<Table, Fault> {
            let mut names: Vec<&String> = self.keys.iter().flat_map(|key| of_key(key).keys()).collect();
            names.sort_unstable();
            names.dedup();
            let value = |name: &String| {
                let given = self.keys.iter().filter_map(|key| Some((key.frame as f64, of_key(key).get(name)?)));
                let given: Vec<(f64, &Value)> = given.collect();
                Ok((name.clone(), between(name, &given, frame, self.path())?))
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

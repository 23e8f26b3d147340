//! Renders that are not finished, in files.

use std::path::{Path, PathBuf};

use rgbd::{Compression, Head, LensAttributes, Notes, PixelWindow, Plane, ReadError, WriteError, WriteOptions};
use thiserror::Error;

use crate::accumulation::Sum;
use crate::spread::Spread;
use crate::{Accumulation, Job, MAX_SAMPLES};

/// A render that is not finished, or a part of one, and the scene it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The render.
    pub job: Job,
    /// [`SceneFile::fingerprint`](crate::SceneFile::fingerprint) of the scene.
    pub scene: u32,
    /// What its file tells other programs of the lens.
    pub lens: LensAttributes,
}

/// Why a part of a render cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PartError {
    /// It is no OpenEXR file, or lacks what a part holds.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It holds what no render would have written.
    #[error("{path:?} is no part of a render: {reason}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// Bits of a sum in each of its three planes: f32 holds such integers exactly.
const BITS: u32 = 21;
const SEED: &str = "seed";
const SCENE: &str = "scene-fingerprint";
const SCALE: &str = "samples-per-noise";
const FIRST: &str = "samples-before";
const NOISE: &str = "noise";

/// Names of the planes of both halves: nine for the sums, the first sample, and the number of samples.
fn names() -> Vec<String> {
    let of_half = |half: usize| {
        let sums = ["R", "G", "B"].into_iter().flat_map(move |c| (0..3).map(move |i| format!("half{half}.{c}.{i}")));
        sums.chain(["first", "count"].map(|name| format!("half{half}.{name}")))
    };
    (0..2).flat_map(of_half).collect()
}

/// The eleven numbers of a half.
fn numbers(sum: &Sum) -> [f32; 11] {
    let mut numbers = [0.0; 11];
    for (c, &value) in sum.rgb().iter().enumerate() {
        for i in 0..3 {
            numbers[3 * c + i] = ((value >> (BITS * i as u32)) & ((1 << BITS) - 1)) as f32;
        }
    }
    let samples = sum.samples();
    (numbers[9], numbers[10]) = (samples.start as f32, samples.len() as f32);
    numbers
}

/// The half that has these numbers, if one can.
fn sum(numbers: [f32; 11]) -> Option<Sum> {
    let whole = |x: f32, most: u32| (x >= 0.0 && x.fract() == 0.0 && x <= most as f32).then_some(x as i64);
    let mut rgb = [0; 3];
    for (c, value) in rgb.iter_mut().enumerate() {
        for i in 0..3 {
            *value |= whole(numbers[3 * c + i], (1 << BITS) - 1)? << (BITS * i as u32);
        }
    }
    let (first, count) = (whole(numbers[9], MAX_SAMPLES)?, whole(numbers[10], MAX_SAMPLES)?);
    Sum::from_parts(rgb, first as u32, count as u32)
}

impl Part {
    /// Writes it as OpenEXR: the mean so far as `R G B A`, and beside it in further channels, exactly, the sums. The file
    /// stands whole or not at all.
    pub fn write(&self, path: &Path, compression: Compression, notes: &Notes) -> Result<(), WriteError> {
        let sums = self.job.sums();
        let window = sums.window();
        let names = names();
        let mut planes = vec![Vec::with_capacity(window.area()); names.len()];
        for halves in sums.halves() {
            for (half, sum) in halves.iter().enumerate() {
                let planes = &mut planes[half * 11..(half + 1) * 11];
                planes.iter_mut().zip(numbers(sum)).for_each(|(plane, number)| plane.push(number));
            }
        }
        let planes: Vec<Plane> = planes.into_iter().filter_map(|values| Plane::from_values(window, values)).collect();
        let mut named: Vec<(&str, &Plane)> = names.iter().map(String::as_str).zip(&planes).collect();

        let mut options = WriteOptions { compression, lens: self.lens, notes: notes.clone() };
        options.notes.insert(SEED.into(), sums.seed().to_string());
        options.notes.insert(SCENE.into(), self.scene.to_string());
        if let Some(spread) = self.job.spread() {
            options.notes.insert(SCALE.into(), spread.scale().to_string());
            options.notes.insert(FIRST.into(), spread.first().to_string());
            named.push((NOISE, spread.noise()));
        }
        let film = sums.camera().film;
        let head = Head::new(PixelWindow::of_size(film.width(), film.height())).with_camera(*sums.camera());
        rgbd::write_picture_with(path, &sums.picture(), &named, &head, &options)
    }

    /// Reads what [`Self::write`] wrote, to the bit; windows of more than `max_pixels` are refused.
    pub fn read(path: &Path, max_pixels: u64) -> Result<Self, PartError> {
        let names = names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let invalid = |reason: &str| PartError::Invalid { path: path.into(), reason: reason.into() };
        let loaded = match rgbd::read_planes(path, &names, max_pixels) {
            Err(ReadError::NotFound { name, .. }) => {
                return Err(invalid(&format!("it has no channel {name:?}")));
            }
            loaded => loaded?,
        };
        let note = |name: &str| loaded.notes.get(name);
        let missing = |name: &str| invalid(&format!("its note {name:?} is missing or no number"));
        let seed = note(SEED).and_then(|seed| seed.parse().ok()).ok_or_else(|| missing(SEED))?;
        let scene = note(SCENE).and_then(|scene| scene.parse().ok()).ok_or_else(|| missing(SCENE))?;
        let camera = loaded.head.camera.ok_or_else(|| invalid("it has no camera"))?;

        // Put the sums together
        let planes = &loaded.value;
        let window = planes[0].window();
        let mut sums = Accumulation::new(camera, window, seed);
        for (i, halves) in sums.halves_mut().iter_mut().enumerate() {
            for (half, target) in halves.iter_mut().enumerate() {
                let numbers = std::array::from_fn(|k| planes[11 * half + k].values()[i]);
                *target = sum(numbers).ok_or_else(|| invalid("some of its sums are none"))?;
            }
        }

        // And what they were spread by
        let spread = match note(SCALE) {
            None => None,
            Some(scale) => {
                let scale = scale.parse().ok().filter(|scale| *scale >= 0.0 && f64::is_finite(*scale));
                let scale = scale.ok_or_else(|| missing(SCALE))?;
                let first = note(FIRST).and_then(|first| first.parse().ok()).filter(|first| *first <= MAX_SAMPLES);
                let first = first.ok_or_else(|| missing(FIRST))?;
                let noise = rgbd::read_planes(path, &[NOISE], max_pixels)?.value.swap_remove(0);
                if !noise.values().iter().all(|noise| *noise >= 0.0 && noise.is_finite()) {
                    return Err(invalid("its noise is not that of a picture"));
                }
                Some(Spread::from_parts(noise, first, scale))
            }
        };
        Ok(Self { job: Job::from_parts(sums, spread), scene, lens: loaded.lens })
    }
}

//! Renders that take a while: they stop and go on, and put samples where they count.

use std::ops::Range;

use optics::Camera;
use rgbd::{PixelWindow, Progress};

use crate::spread::Spread;
use crate::{Accumulation, MAX_SAMPLES, RenderError, Scene};

/// Samples that each pixel gets in each half before anything is decided.
const PILOT: u32 = 16;

/// When a render is done.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// Every pixel has these samples in each half.
    Samples(Range<u32>),
    /// The noise, RMS error of the mean over R, G and B of all pixels, is at most this.
    Noise {
        /// Linear radiance, above 0.
        rmse: f64,
        /// Samples that a pixel may take in each half, 1 to [`MAX_SAMPLES`]; the render ends when all have them.
        most: u32,
    },
}

/// A render that can be stopped at any time and go on later, to the same bits as one that was never stopped.
///
/// Towards [`Goal::Noise`] samples go where they count. After 16 samples in each half of every pixel the noise of a pixel
/// is told by how much the halves of its eight neighbours differ, and the noisier it is, the more samples it gets from then
/// on. A pixel's own samples never decide
/// how many it gets, so that its mean stays unbiased, and the two halves, which have the same number, stay independent:
/// their difference is as honest as it is with a fixed number (Kirk and Arvo, "Unbiased sampling techniques for image
/// synthesis", SIGGRAPH 1991, on the bias of estimates that decide over themselves).
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    sums: Accumulation,
    spread: Option<Spread>,
}

impl Job {
    /// A render of a window that has not begun.
    #[must_use]
    pub fn new(camera: Camera, window: PixelWindow, seed: u64) -> Self {
        Self { sums: Accumulation::new(camera, window, seed), spread: None }
    }

    /// A render that was stopped.
    pub(crate) fn from_parts(sums: Accumulation, spread: Option<Spread>) -> Self {
        Self { sums, spread }
    }

    /// What there is so far.
    #[must_use]
    pub fn sums(&self) -> &Accumulation {
        &self.sums
    }

    /// What there is so far.
    #[must_use]
    pub fn into_sums(self) -> Accumulation {
        self.sums
    }

    /// How samples are spread over the pixels, once that is decided.
    pub(crate) fn spread(&self) -> Option<&Spread> {
        self.spread.as_ref()
    }

    /// Renders on until the goal is reached; when it is cancelled, another call goes on from there.
    ///
    /// A render that was begun towards a number of samples cannot go on towards a noise, as its samples were not spread by
    /// it, nor the other way round.
    pub fn run(&mut self, scene: &Scene, goal: &Goal, progress: &dyn Progress) -> Result<(), RenderError> {
        if self.sums.window().is_empty() {
            return Err(RenderError::NoSamples(self.sums.window()));
        }
        match goal {
            Goal::Samples(samples) => self.take(scene, samples, progress),
            Goal::Noise { rmse, most } => self.reduce_noise(scene, *rmse, *most, progress),
        }
    }

    /// Takes samples in rounds, each as large as all before, so that the whole picture is there early.
    fn take(&mut self, scene: &Scene, samples: &Range<u32>, progress: &dyn Progress) -> Result<(), RenderError> {
        check(samples)?;
        if self.spread.is_some() {
            return Err(RenderError::AnotherGoal);
        }
        let per_step = 2 * self.sums.window().area() as u64;
        let total = per_step * samples.len() as u64;
        let mut end = samples.start;
        while end < samples.end {
            let from = per_step * u64::from(end - samples.start);
            end = (end + (end - samples.start).max(PILOT)).min(samples.end);
            let round = Round { progress, from, to: per_step * u64::from(end - samples.start), total };
            let wanted = [samples.start..end, samples.start..end];
            self.sums.extend(scene, &|_, _| wanted.clone(), &round)?;
        }
        Ok(())
    }

    fn reduce_noise(
        &mut self,
        scene: &Scene,
        rmse: f64,
        most: u32,
        progress: &dyn Progress,
    ) -> Result<(), RenderError> {
        check(&(0..most))?;
        let pilot = PILOT.min(most);
        let window = self.sums.window();
        if self.spread.is_none() {
            if window.pixels().any(|(x, y)| self.sums.samples_at(x, y).into_iter().any(|count| count > pilot)) {
                return Err(RenderError::AnotherGoal);
            }
            // What is to come is not known yet: show the first round as a part of four
            let pilots = 2 * window.area() as u64 * u64::from(pilot);
            let round = Round { progress, from: 0, to: pilots, total: 4 * pilots };
            self.sums.extend(scene, &|_, _| [0..pilot, 0..pilot], &round)?;
            self.spread = Some(Spread::new(&self.sums, pilot));
        }
        let Some(spread) = &mut self.spread else { return Ok(()) };
        let mut total = 2.0 * spread.total(most);
        loop {
            // Finish the round, perhaps of a render that was stopped in it
            let from = self.sums.samples();
            let to = (spread.total(most) as u64).max(from);
            let wanted = |x: i32, y: i32| {
                let count = spread.count(x, y, most);
                [0..count, 0..count]
            };
            self.sums.extend(scene, &wanted, &Round { progress, from, to, total: (total as u64).max(to) })?;
            total = spread.next_round(self.sums.noise(), rmse, most);
            if total == 0.0 {
                return Ok(());
            }
        }
    }
}

/// Refuses samples that the sequences do not have.
pub(crate) fn check(samples: &Range<u32>) -> Result<(), RenderError> {
    if samples.start >= samples.end || samples.end > MAX_SAMPLES {
        return Err(RenderError::SampleRange { first: samples.start, end: samples.end });
    }
    Ok(())
}

/// One round of a longer work, in samples.
struct Round<'a> {
    progress: &'a dyn Progress,
    from: u64,
    to: u64,
    total: u64,
}

impl Progress for Round<'_> {
    fn report(&self, done: u64, total: u64) {
        let done = self.from as f64 + (self.to - self.from) as f64 * done as f64 / total.max(1) as f64;
        self.progress.report((done as u64).min(self.total), self.total);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}

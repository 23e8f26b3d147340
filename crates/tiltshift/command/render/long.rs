//! Renders that survive: saved while they go on, stopped, resumed, and cut into parts.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Args;
use optics::Camera;
use rgbd::{PixelWindow, Progress, ReadOptions, WriteOptions};
use trace::{Goal, Job, Part, RenderError, Scene};

use crate::command::render::Quality;
use crate::console::{Bar, is_interrupted, say};
use crate::failure::{Failure, Outcome};
use crate::values::{Crop, SampleRange, not_negative};

/// What becomes of a render that takes long.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Long renders")]
pub(crate) struct Long {
    /// Go on with what an interrupted render left beside its output (`NAME.part.exr`), to the same bits.
    #[arg(long)]
    resume: bool,
    /// Keep that file when the render is done, so that a larger --spp or a smaller --noise can go on from there.
    #[arg(long)]
    keep_part: bool,
    /// Save what there is after so many seconds, again and again.
    #[arg(long, value_name = "SECONDS", default_value_t = 45.0, value_parser = not_negative)]
    save_every: f64,
    /// Trace these samples of each pixel only, both ends even, and write a part for `tiltshift merge`.
    #[arg(long, value_name = "A..B", conflicts_with_all = ["noise", "spp"])]
    samples: Option<SampleRange>,
    /// Trace these pixels only (left, top, size), and write a part for `tiltshift merge`.
    #[arg(long, value_name = "X,Y,WxH", conflicts_with = "noise", allow_hyphen_values = true)]
    crop: Option<Crop>,
}

impl Long {
    /// Whether only a part of the picture is asked for.
    pub(crate) fn is_part(&self) -> bool {
        self.samples.is_some() || self.crop.is_some()
    }

    /// Whether what is there already shall be gone on with.
    pub(crate) fn is_resumed(&self) -> bool {
        self.resume
    }

    /// What a part's name says of it.
    pub(crate) fn name_of_part(&self) -> String {
        let samples = self.samples.map(|SampleRange(range)| format!("_{}-{}", range[0], range[1]));
        let crop =
            self.crop.map(|Crop(window)| format!("_{},{},{}x{}", window.x, window.y, window.width, window.height));
        [samples, crop].into_iter().flatten().collect()
    }

    /// Where a result is kept that is not complete yet.
    pub(crate) fn place_of_part(&self, output: &Path) -> PathBuf {
        if self.is_part() { output.into() } else { output.with_extension("part.exr") }
    }

    /// Renders until the goal is reached or the user stops it, and saves what there is in between.
    pub(crate) fn run(
        &self,
        (scene, fingerprint): (&Scene, u32),
        camera: &Camera,
        quality: &Quality,
        place: &Path,
        write: &WriteOptions,
    ) -> Result<Job, Failure> {
        let goal = match self.samples {
            Some(SampleRange([first, end])) => Goal::Samples(first / 2..end / 2),
            None => quality.goal(),
        };
        // Long enough to get on at all
        let save_every = Duration::from_secs_f64(self.save_every.clamp(0.05, 1e6));
        let mut part =
            Part { job: self.begin(fingerprint, camera, quality, place)?, scene: fingerprint, lens: write.lens };
        let bar = Bar::new("trace the truth");
        loop {
            let slice = Slice { bar: &bar, end: Instant::now() + save_every };
            let outcome = part.job.run(scene, &goal, &slice);
            match outcome {
                Ok(()) => break,
                Err(RenderError::Cancelled(_)) if part.job.sums().samples() > 0 => {
                    part.write(place, write.compression, &write.notes)?;
                }
                Err(RenderError::Cancelled(_)) => {}
                Err(RenderError::AnotherGoal) => {
                    return Err(anyhow::anyhow!("{place:?} was begun otherwise: with --noise or without").into());
                }
                Err(error) => return Err(error.into()),
            }
            if is_interrupted() {
                drop(bar);
                if part.job.sums().samples() > 0 {
                    say(format_args!("what there is so far stands in {}; --resume goes on with it", place.display()));
                }
                return Err(Failure::Interrupted);
            }
        }
        if self.is_part() || self.keep_part {
            part.write(place, write.compression, &write.notes)?;
            say(format_args!("wrote {}", place.display()));
        }
        Ok(part.job)
    }

    /// Removes what was saved on the way to a result that now stands.
    pub(crate) fn finish(&self, place: &Path) -> Outcome {
        if !self.is_part() && !self.keep_part && place.exists() {
            std::fs::remove_file(place).with_context(|| format!("cannot remove {place:?}, which is done"))?;
        }
        Ok(())
    }

    /// A new render, or the one that was stopped.
    fn begin(&self, scene: u32, camera: &Camera, quality: &Quality, place: &Path) -> anyhow::Result<Job> {
        let display = PixelWindow::of_size(camera.film.width(), camera.film.height());
        let window = match self.crop {
            None => display,
            Some(Crop(crop)) if display.contains_window(&crop) => crop,
            Some(Crop(crop)) => bail!("--crop {crop}: the picture is {display}"),
        };
        if !place.exists() {
            return Ok(Job::new(*camera, window, quality.seed));
        }
        if !self.resume {
            bail!("{place:?} holds a render that was stopped: go on with it by --resume, or delete it");
        }
        let part = Part::read(place, ReadOptions::MAX_PIXELS)?;
        let sums = part.job.sums();
        let (same_scene, same_camera) = (part.scene == scene, sums.camera() == camera);
        let faults = [
            ("scene, frame or shutter", same_scene),
            ("camera, lens or size", same_camera),
            ("seed", sums.seed() == quality.seed),
            ("crop", sums.window() == window),
        ];
        let others: Vec<&str> = faults.iter().filter(|(_, same)| !same).map(|(what, _)| *what).collect();
        if !others.is_empty() {
            bail!("{place:?} was rendered with another {}; delete it to begin anew", others.join(", another "));
        }
        Ok(part.job)
    }
}

/// Work up to a point in time.
struct Slice<'a> {
    bar: &'a Bar,
    end: Instant,
}

impl Progress for Slice<'_> {
    fn report(&self, done: u64, total: u64) {
        self.bar.report(done, total);
    }

    fn is_cancelled(&self) -> bool {
        self.bar.is_cancelled() || Instant::now() >= self.end
    }
}

//! Every rung run on this machine: its picture, and how long that takes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use filter::{FrameView, Method};
use optics::Camera;
use rgbd::{
    Cancelled, Frame, Head, Picture, PixelWindow, Progress, ReadOptions, WriteOptions, read_frame, write_frame,
    write_picture,
};
use trace::Scene;

use crate::{Rung, StudyError, Timing, hybrid, step::Step};

/// What the rungs make a picture of.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The scene, for the tracer.
    pub scene: &'a Scene,
    /// The camera, whose film is the frame's display window.
    pub camera: &'a Camera,
    /// Colour and depth, for the filter, with all the layers that the rungs use.
    pub frame: &'a Frame,
    /// Seed of the tracer's samples; another one than the truth's.
    pub seed: u64,
    /// A folder that exists, for the files that are read and written, each under its rung's name.
    pub folder: &'a Path,
}

/// What a rung made, and how long that took.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The rung.
    pub rung: Rung,
    /// Its picture over the display window.
    pub picture: Picture,
    /// Seconds of the filter or the tracer alone, everything in memory.
    pub kernel: Timing,
    /// Seconds of the whole: reading the RGB-D picture (of as many layers as the rung uses), filtering and writing the
    /// result, both OpenEXR; for the tracer only tracing and writing. Without the start of a program and the reading of a scene.
    pub command: Timing,
}

/// Runs each rung `runs` times (at least once), in turns, so that what else the machine does meets all alike.
///
/// Works in parallel as the methods themselves do; nothing else should run.
pub fn measure(
    subject: &Subject,
    rungs: &[Rung],
    runs: usize,
    progress: &dyn Progress,
) -> Result<Vec<Measured>, StudyError> {
    // Give each rung a file of just the layers that it uses
    for layers in 1..=subject.frame.layers().len() {
        let frame = subject.frame.clone().with_layers(layers);
        write_frame(&subject.input(layers), &frame, &WriteOptions::default())?;
    }

    let runs = runs.max(1);
    let mut made: Vec<Vec<Run>> = rungs.iter().map(|_| Vec::with_capacity(runs)).collect();
    for turn in 0..runs {
        for (i, (rung, made)) in rungs.iter().zip(&mut made).enumerate() {
            let step = Step { whole: progress, index: turn * rungs.len() + i, count: runs * rungs.len() };
            made.push(subject.run(rung, &step)?);
            if progress.is_cancelled() {
                return Err(Cancelled.into());
            }
        }
    }
    Ok(rungs.iter().zip(made).map(|(&rung, runs)| measured(rung, runs)).collect())
}

/// One run of a rung.
struct Run {
    picture: Picture,
    kernel: f64,
    command: f64,
}

/// The picture of the last run, as every run makes the same, and the times of all.
fn measured(rung: Rung, mut runs: Vec<Run>) -> Measured {
    // A clock that did not tick in between saw less than a nanosecond
    let seconds = |time: fn(&Run) -> f64| runs.iter().map(|run| time(run).max(1e-9)).collect();
    let [kernel, command] =
        [seconds(|run| run.kernel), seconds(|run| run.command)].map(|runs| Timing::new(runs).expect("positive times"));
    Measured { rung, picture: runs.pop().expect("a run").picture, kernel, command }
}

impl Subject<'_> {
    /// The file of the first `layers` layers.
    fn input(&self, layers: usize) -> PathBuf {
        self.folder.join(format!("rgbd_{layers}.exr"))
    }

    /// Where a rung's picture is written.
    fn output(&self, rung: &Rung) -> PathBuf {
        self.folder.join(format!("{}.exr", rung.name().replace(' ', "_")))
    }

    fn display(&self) -> PixelWindow {
        self.frame.display
    }

    /// The frame that a rung starts from.
    fn read(&self, rung: &Rung) -> Result<Frame, StudyError> {
        let layers = rung.layers().unwrap_or(1).clamp(1, self.frame.layers().len());
        Ok(read_frame(&self.input(layers), &ReadOptions::default())?.value.covering(self.display()))
    }

    /// Makes the picture once, from file to file.
    fn run(&self, rung: &Rung, progress: &dyn Progress) -> Result<Run, StudyError> {
        let started = Instant::now();
        let (picture, kernel) = match rung {
            Rung::Filter(method) => self.filter(rung, method, progress)?,
            Rung::Hybrid(settings) => {
                let frame = self.read(rung)?;
                let started = Instant::now();
                let picture = hybrid(self.scene, self.camera, &frame, settings, progress)?.picture;
                (picture, started.elapsed().as_secs_f64())
            }
            Rung::Trace { samples } => {
                let samples = 0..samples.div_ceil(2);
                let pixels = self.display().into();
                let sums = trace::render(self.scene, self.camera, &pixels, samples, self.seed, progress)?;
                (sums.picture(), started.elapsed().as_secs_f64())
            }
        };
        let head = Head { camera: Some(*self.camera), ..Head::from(self.frame) };
        write_picture(&self.output(rung), &picture, &head, &WriteOptions::default())?;
        Ok(Run { picture, kernel, command: started.elapsed().as_secs_f64() })
    }

    fn filter(&self, rung: &Rung, method: &Method, progress: &dyn Progress) -> Result<(Picture, f64), StudyError> {
        let frame = self.read(rung)?;
        let started = Instant::now();
        let filtered = filter::apply(&FrameView::whole(&frame), self.camera, method, self.display(), progress)?;
        Ok((filtered.picture, started.elapsed().as_secs_f64()))
    }
}

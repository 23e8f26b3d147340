//! Many frames: which they are, several at a time, and what became of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Instant, SystemTime};

use anyhow::{anyhow, bail};
use rgbd::{PhotoFormat, Progress, photo_size, survey_file};
use serde_json::json;

use super::Options;
use super::job::{Job, Report, Shown};
use super::steady::share;
use crate::console::{Bar, is_interrupted, print, say};
use crate::failure::{Failure, Outcome};
use crate::focus_keys::FocusKeys;
use crate::frame_pattern::{FramePattern, expect_some, globbed, in_words, is_glob, last_number, numbered};
use crate::values::Frames;

/// No more failures than this are told one by one.
const MOST_TOLD: usize = 10;

/// The frames to work on.
pub(super) struct Sequence {
    /// The file of each.
    inputs: BTreeMap<i64, PathBuf>,
    /// Frames that should be there and are not.
    missing: Vec<i64>,
    /// Whether the user named the frames, so that a missing one is a failure.
    are_named: bool,
}

impl Sequence {
    /// The sequence that the options name; `None` for a single picture.
    pub(super) fn of(options: &Options) -> anyhow::Result<Option<Self>> {
        let (first, range) = (&options.inputs[0], options.frames.frames);
        if options.inputs.len() > 1 {
            return Self::listed(options.inputs.clone(), range).map(Some);
        }
        if first.is_dir() {
            bail!(
                "{first:?} is a folder; name the frames in it, like {:?} or {:?}",
                first.join("shot.####.exr"),
                first.join("*.exr")
            );
        }
        if first.exists() {
            if range.is_some() {
                bail!("--frames needs a name with a place for the number, like shot.####.exr; {first:?} is one file");
            }
            return Ok(None);
        }
        if let Some(pattern) = FramePattern::of(first) {
            let mut inputs = pattern.found()?;
            if let Some(Frames([a, b])) = range {
                expect_some(first, &inputs)?;
                inputs.retain(|frame, _| (a..=b).contains(frame));
                if inputs.is_empty() {
                    bail!("no file that fits {first:?} is of frames {a}..{b}");
                }
            }
            expect_some(first, &inputs)?;
            return Ok(Some(Self::new(inputs, range)));
        }
        if is_glob(first) {
            let found = globbed(first)?;
            if found.is_empty() {
                bail!("no file fits {first:?}");
            }
            return Self::listed(found, range).map(Some);
        }
        Ok(None)
    }

    /// Of files with a number at the end of each name; where some have none, or two the same, they are counted from 1.
    fn listed(files: Vec<PathBuf>, range: Option<Frames>) -> anyhow::Result<Self> {
        let count = files.len();
        let inputs: Option<BTreeMap<i64, PathBuf>> =
            files.iter().map(|file| Some((last_number(file)?, file.clone()))).collect();
        let mut inputs = match inputs.filter(|inputs| inputs.len() == count) {
            Some(inputs) => inputs,
            None => (1..).zip(files).collect(),
        };
        if let Some(Frames([a, b])) = range {
            inputs.retain(|frame, _| (a..=b).contains(frame));
            if inputs.is_empty() {
                bail!("none of the files is of frames {a}..{b}");
            }
        }
        Ok(Self::new(inputs, range))
    }

    fn new(inputs: BTreeMap<i64, PathBuf>, range: Option<Frames>) -> Self {
        let ends = || Some([*inputs.keys().next()?, *inputs.keys().next_back()?]);
        let [first, last] = range.map(|Frames(ends)| ends).or_else(ends).unwrap_or([0, -1]);
        let missing = (first..=last).filter(|frame| !inputs.contains_key(frame)).collect();
        Self { inputs, missing, are_named: range.is_some() }
    }
}

/// What became of a frame.
enum Fate {
    Written(Box<Report>),
    /// It was complete already.
    Kept,
    Failed(String),
}

/// Filters all frames.
pub(super) fn run(sequence: &Sequence, options: &Options, keys: Option<&FocusKeys>) -> Outcome {
    let mut frames: Vec<(i64, Job)> =
        sequence.inputs.iter().map(|(&frame, input)| (frame, job(frame, input, options, keys))).collect();
    let outputs: Vec<&Path> = frames.iter().flat_map(|(_, job)| job.outputs()).collect();
    let mut sorted = outputs.clone();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(anyhow!("{:?} is named for two results; give each its own name", pair[0]).into());
    }
    if let Some(output) = outputs.iter().find(|output| sequence.inputs.values().any(|input| input == *output)) {
        return Err(anyhow!("{output:?} is a frame of the input; give another name to write to").into());
    }
    if !sequence.missing.is_empty() {
        say(format_args!("missing: frames {}", in_words(&sequence.missing)));
    }

    // Share what must not jump, then memory and cores
    share(&mut frames, options);
    let workers = workers(&frames, options);
    let limit = options.method.memory_limit / workers as u64;
    say(format_args!("{} frames, {workers} at a time", frames.len()));
    let started = Instant::now();
    let bar = Bar::new("filter");
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let fates: Mutex<BTreeMap<i64, Fate>> = Mutex::new(BTreeMap::new());
    let work = || {
        while let Some((frame, job)) = frames.get(next.fetch_add(1, Ordering::SeqCst)) {
            if is_interrupted() {
                return;
            }
            let fate = one(*frame, job, options, limit, *frame == frames[0].0);
            if is_interrupted() && matches!(fate, Fate::Failed(_)) {
                return;
            }
            fates.lock().expect("no worker panics").insert(*frame, fate);
            bar.report(done.fetch_add(1, Ordering::SeqCst) as u64 + 1, frames.len() as u64);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(work);
        }
    });
    drop(bar);
    let fates = fates.into_inner().expect("no worker panics");
    if options.json {
        print_json(&fates);
    }
    tell(sequence, &fates, started.elapsed().as_secs_f64())
}

/// One line of JSON for each frame.
fn print_json(fates: &BTreeMap<i64, Fate>) {
    for (frame, fate) in fates {
        print(match fate {
            Fate::Written(report) => json!({ "frame": frame, "status": "written", "report": report }),
            Fate::Kept => json!({ "frame": frame, "status": "kept" }),
            Fate::Failed(why) => json!({ "frame": frame, "status": "failed", "error": why }),
        });
    }
}

/// Says what became of the frames, and fails if some did.
fn tell(sequence: &Sequence, fates: &BTreeMap<i64, Fate>, seconds: f64) -> Outcome {
    let of = |wanted: &dyn Fn(&Fate) -> bool| -> Vec<i64> {
        fates.iter().filter(|(_, fate)| wanted(fate)).map(|(&frame, _)| frame).collect()
    };
    let written = of(&|fate| matches!(fate, Fate::Written(_)));
    let kept = of(&|fate| matches!(fate, Fate::Kept));
    let failed = of(&|fate| matches!(fate, Fate::Failed(_)));
    let mut summary = format!("{} frames written in {seconds:.1} s", written.len());
    if !kept.is_empty() {
        summary = format!("{summary}, {} kept that were complete", kept.len());
    }
    if is_interrupted() {
        say(format_args!("{summary}; --resume goes on with the others"));
        return Err(Failure::Interrupted);
    }
    if !failed.is_empty() {
        for (frame, fate) in fates.iter().filter(|(_, fate)| matches!(fate, Fate::Failed(_))).take(MOST_TOLD) {
            if let Fate::Failed(why) = fate {
                say(format_args!("frame {frame}: {why}"));
            }
        }
        summary = format!("{summary}; {} failed: frames {}", failed.len(), in_words(&failed));
    }
    if !sequence.missing.is_empty() {
        summary = format!("{summary}; {} missing: frames {}", sequence.missing.len(), in_words(&sequence.missing));
    }
    let missed = of(&|fate| matches!(fate, Fate::Written(report) if report.missed().is_some()));
    if !missed.is_empty() {
        summary = format!("{summary}; {} not surely within the tolerance: frames {}", missed.len(), in_words(&missed));
    }
    let is_incomplete =
        !missed.is_empty() || !failed.is_empty() || (sequence.are_named && !sequence.missing.is_empty());
    if is_incomplete {
        return Err(Failure::Exceeded(summary));
    }
    say(summary);
    Ok(())
}

/// What a frame needs.
fn job(frame: i64, input: &Path, options: &Options, keys: Option<&FocusKeys>) -> Job {
    let result = |path: &PathBuf| numbered(path, frame);
    // A depth map in one file serves all frames
    let depth = options.read.depth_file().map(|path| match FramePattern::of(&path) {
        Some(pattern) if !path.exists() => pattern.path(frame),
        _ => path,
    });
    Job {
        input: input.to_path_buf(),
        depth,
        output: result(&options.output),
        png: options.png.as_ref().map(result),
        overlay: options.overlay.as_ref().map(result),
        lens: keys.map_or_else(|| options.lens.clone(), |keys| keys.at(frame, &options.lens)),
        convention: None,
        ground: None,
    }
}

/// Filters one frame, unless it is there.
fn one(frame: i64, job: &Job, options: &Options, memory_limit: u64, is_first: bool) -> Fate {
    if options.frames.resume {
        if is_complete(job) {
            return Fate::Kept;
        }
        job.outputs().for_each(remove_unfinished);
    }
    let lines = Mutex::new(Vec::new());
    let collect =
        |line: std::fmt::Arguments<'_>| lines.lock().expect("one thread says something").push(line.to_string());
    let outcome = job.run(options, memory_limit, Shown::Nothing, &collect);
    // Warnings are told of each frame
    for line in lines.into_inner().expect("one thread says something") {
        if options.verbose || is_first || line.starts_with("warning") {
            say(format_args!("frame {frame}: {line}"));
        }
    }
    match outcome {
        Ok(report) => Fate::Written(Box::new(report)),
        Err(error) => Fate::Failed(Failure::Input(error).to_string()),
    }
}

/// Whether all results of a frame are there and no older than what they are made from. Results are renamed into their places
/// only when whole.
fn is_complete(job: &Job) -> bool {
    let changed = |path: &Path| path.metadata().and_then(|data| data.modified()).ok();
    let inputs = [Some(job.input.as_path()), job.depth.as_deref()];
    let newest: Option<SystemTime> = inputs.into_iter().flatten().filter_map(changed).max();
    let is_whole = |path: &Path| path.metadata().is_ok_and(|data| data.is_file() && data.len() > 0);
    job.outputs().all(|output| is_whole(output) && changed(output) >= newest)
}

/// Removes what a run that was killed left beside a result.
fn remove_unfinished(output: &Path) {
    let (Some(folder), Some(name)) = (output.parent(), output.file_name()) else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let start = format!(".{}.tmp-", name.to_string_lossy());
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&start) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// How many frames are worked on at a time: one for each core, as far as the memory limit goes.
fn workers(frames: &[(i64, Job)], options: &Options) -> usize {
    /// Bytes that a pixel takes at the peak: read, taken apart, gathered and written.
    const BYTES: u64 = 21 * 12;
    let size = |job: &Job| match PhotoFormat::of_file(&job.input).ok()? {
        Some(format) => photo_size(&job.input, format).ok().map(|(width, height)| u64::from(width) * u64::from(height)),
        None => {
            let survey = survey_file(&job.input, options.read.max_pixels()).ok()?;
            let parts =
                survey.parts.iter().map(|part| part.window.area() as u64 * (part.channels.len() as u64).div_ceil(5));
            Some(parts.sum())
        }
    };
    let cores = rayon::current_num_threads().min(frames.len()).max(1);
    // Frames of a sequence are of one size, but for the damaged
    let largest = frames.iter().take(8).filter_map(|(_, job)| size(job)).max().unwrap_or(1);
    let fitting = options.method.memory_limit / (largest * BYTES).max(1);
    (fitting as usize).clamp(1, cores)
}

//! `tiltshift benchmark`: anybody's pictures against truths that anybody can make.

use std::path::PathBuf;
use std::str::FromStr;

use ::filter::{FrameView, Method, apply};
use anyhow::{Context, bail};
use clap::Args;
use optics::Camera;
use rgbd::{
    Frame, Picture, PixelWindow, ReadOptions, Truth, WriteOptions, read_frame, read_truth, write_frame, write_truth,
};
use serde_json::json;
use study::{BENCHMARK_FORMAT, Benchmark, Case, RmsError, Score, checksum, score};
use trace::{LayerSettings, SceneFile};

use crate::command::compare::read_candidate;
use crate::console::{Bar, print, say};
use crate::failure::{Failure, Outcome};
use crate::files::{command_line, make_folder, write_text};

/// Score pictures of any program against the truths of the benchmark.
///
/// Each case is a shot of a scene of the project. Its truth and its RGB-D frame (with overscan and hidden layers) are traced
/// into the folder --out, once: CASE/truth.exr and CASE/rgbd.exr. Give your program the frame, or the scene, and name the
/// folder in which it left CASE.exr. Without candidates the default filter's own pictures are scored, and the unfiltered ones.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The benchmark's file (TOML).
    #[arg(default_value = "data/benchmark/benchmark.toml")]
    benchmark: PathBuf,
    /// Another program's pictures: a name, and the folder that holds CASE.exr for each case.
    #[arg(long, value_name = "NAME,DIR")]
    candidate: Vec<Candidate>,
    /// Only cases whose names contain this.
    #[arg(long, value_name = "TEXT", default_value = "")]
    case: String,
    /// Folder for truths and frames; what is there already is used.
    #[arg(long, value_name = "DIR", default_value = "out/benchmark")]
    out: PathBuf,
    /// Also write all scores as JSON.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// List the cases and stop.
    #[arg(long)]
    list: bool,
}

/// Another program's pictures.
#[derive(Debug, Clone, PartialEq)]
struct Candidate {
    name: String,
    folder: PathBuf,
}

impl FromStr for Candidate {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        match text.split_once(',').map(|(name, folder)| (name.trim(), folder.trim())) {
            Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
                Ok(Self { name: name.to_owned(), folder: folder.into() })
            }
            _ => bail!("a name and a folder with a comma between, please"),
        }
    }
}

/// One program's scores, and the cases of which it has no picture.
struct Scores {
    name: String,
    scores: Vec<Score>,
    missing: Vec<String>,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let path = &options.benchmark;
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read the benchmark {path:?}"))?;
    let benchmark = Benchmark::parse(&text).with_context(|| format!("{path:?}"))?;
    let cases: Vec<&Case> = benchmark.cases.iter().filter(|case| case.name.contains(&options.case)).collect();
    if cases.is_empty() {
        return Err(anyhow::anyhow!("no case of {path:?} has {:?} in its name; --list names them", options.case).into());
    }
    if options.list {
        list(&benchmark, &cases);
        return Ok(());
    }

    // Ours stand in where there are no others
    let mut all: Vec<Scores> = if options.candidate.is_empty() {
        ["unfiltered", "tiltshift filter"].map(Scores::new).into()
    } else {
        options.candidate.iter().map(|candidate| Scores::new(&candidate.name)).collect()
    };
    for case in cases {
        let (truth, frame) = made(case, options)?;
        let camera = truth.camera.context("a truth without a camera")?;
        for (i, scores) in all.iter_mut().enumerate() {
            let picture = match options.candidate.get(i) {
                Some(candidate) => {
                    let file = candidate.folder.join(format!("{}.exr", case.name));
                    if !file.exists() {
                        scores.missing.push(case.name.clone());
                        continue;
                    }
                    read_candidate(&file, truth.display)?.0
                }
                None => own(i, &frame, &camera)?,
            };
            scores.scores.push(score(case, &truth, &frame, &picture)?);
        }
    }
    all.iter().for_each(Scores::print);
    if let Some(file) = &options.json {
        let scores: Vec<_> =
            all.iter().map(|of| json!({ "candidate": of.name, "scores": of.scores, "missing": of.missing })).collect();
        let json = json!({ "format": BENCHMARK_FORMAT, "command": command_line(), "candidates": scores });
        write_text(file, &(serde_json::to_string_pretty(&json).context("scores as JSON")? + "\n"))?;
        say(format_args!("wrote {}", file.display()));
    }
    let missing: Vec<String> = all
        .iter()
        .filter(|of| !of.missing.is_empty())
        .map(|of| format!("{} has no picture of {}", of.name, of.missing.join(", ")))
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(Failure::Exceeded(missing.join("; "))) }
}

/// The unfiltered picture, or that of the default filter.
fn own(which: usize, frame: &Frame, camera: &Camera) -> anyhow::Result<Picture> {
    let method = if which == 0 { Method::Pinhole } else { Method::default() };
    Ok(apply(&FrameView::whole(frame), camera, &method, frame.display, &Bar::new("filter"))?.picture)
}

/// Truth and frame of a case, traced unless they are there.
fn made(case: &Case, options: &Options) -> anyhow::Result<(Truth, Frame)> {
    let folder = options.out.join(&case.name);
    let [truth_file, frame_file] = ["truth.exr", "rgbd.exr"].map(|name| folder.join(name));
    let scene = case.scene_file(&options.benchmark);
    let file = SceneFile::open(&scene)?;
    let [width, height] = case.size;
    // No method here knows motion blur: all see the middle of the exposure
    let shot = file.shot(Some(&case.shot))?;
    let (scene, camera) = (&file.scene_of(shot).stopped(), shot.camera);
    let camera = Camera { film: camera.film.resized(width, height)?, ..camera };
    let display = PixelWindow::of_size(width, height);
    make_folder(&folder)?;

    // A truth of another camera is not this case's
    let known = read_truth(&truth_file, ReadOptions::MAX_PIXELS).ok().map(|read| read.value);
    let truth = match known.filter(|truth| truth.camera == Some(camera) && truth.display == display) {
        Some(truth) => truth,
        None => {
            let bar = Bar::new(format!("{}: trace the truth", case.name));
            let truth = trace::truth(scene, &camera, display, case.samples, 1, &bar)?;
            write_truth(&truth_file, &truth, &WriteOptions::default())?;
            truth
        }
    };
    let known = read_frame(&frame_file, &ReadOptions::default()).ok().map(|read| read.value);
    let frame = match known.filter(|frame| frame.camera == Some(camera) && frame.display == display) {
        Some(frame) => frame,
        None => {
            let bar = Bar::new(format!("{}: trace colour and depth", case.name));
            let settings = LayerSettings { seed: 2, ..LayerSettings::default() };
            let frame = trace::layers(scene, &camera, &settings, &bar)?.frame;
            write_frame(&frame_file, &frame, &WriteOptions::default())?;
            frame
        }
    };

    // Say so where it is not the picture that others have
    let (found, noise) = (checksum(&truth.picture(), display), truth.noise_rmse(display));
    let verdict = if found == case.checksum { "as recorded" } else { "not the recorded bits" };
    say(format_args!("{}: truth {found} ({verdict}), noise {noise:.6} (recorded {:.6})", case.name, case.noise));
    Ok((truth, frame))
}

fn list(benchmark: &Benchmark, cases: &[&Case]) {
    print(&benchmark.description);
    for case in cases {
        let [width, height] = case.size;
        print(format_args!(
            "  {:24} {width}x{height}, {} samples, noise {:.5}, {}: {} --shot {}",
            case.name,
            case.samples,
            case.noise,
            case.checksum,
            case.scene.display(),
            case.shot
        ));
    }
}

impl Scores {
    fn new(name: &str) -> Self {
        Self { name: name.to_owned(), scores: Vec::new(), missing: Vec::new() }
    }

    /// A line for each case, and the mean in dB.
    fn print(&self) {
        let db = |error: RmsError| ::compare::psnr_db(error.rmse * error.rmse);
        let text = |error: Option<RmsError>| error.map_or_else(String::new, |error| format!("{:.2}", db(error)));
        print(format_args!("{:24} {:>8} {:>8} {:>8} {:>9}", self.name, "all dB", "edges", "interior", "HDR-FLIP"));
        for Score { case, error } in &self.scores {
            let cells = [Some(error.all), error.edges, error.interior].map(text);
            print(format_args!("  {case:22} {:>8} {:>8} {:>8} {:>9.5}", cells[0], cells[1], cells[2], error.flip_hdr));
        }
        if !self.scores.is_empty() {
            let count = self.scores.len() as f64;
            let mean = |of: &dyn Fn(&Score) -> f64| self.scores.iter().map(of).sum::<f64>() / count;
            let (all, flip) = (mean(&|score| db(score.error.all)), mean(&|score| score.error.flip_hdr));
            print(format_args!("  {:22} {all:>8.2} {:>8} {:>8} {flip:>9.5}", "mean", "", ""));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_candidate_is_a_name_and_a_folder() {
        let candidate: Candidate = "Open Defocus, out/a,b".parse().unwrap();
        assert_eq!(candidate, Candidate { name: "Open Defocus".to_owned(), folder: PathBuf::from("out/a,b") });
        for text in ["", "a", "a,", ",b"] {
            assert!(text.parse::<Candidate>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_benchmark_of_the_project_is_one() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/benchmark/benchmark.toml");
        let benchmark = Benchmark::parse(&std::fs::read_to_string(&file).unwrap()).unwrap();
        for case in &benchmark.cases {
            let scene = SceneFile::open(case.scene_file(&file).as_path()).unwrap();
            scene.shot(Some(&case.shot)).unwrap();
        }
        assert!(benchmark.cases.len() >= 8, "{}", benchmark.cases.len());
    }
}

//! `tiltshift chart`: every method by time and error.

mod series;

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use ::compare::{Comparison, MaskKind, Masks, Reference};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use rgbd::{Picture, WriteOptions, write_truth};
use study::{Chart, Clock, Conditions, HybridSettings, Machine, Point, PointError, Rung, Subject, Timing, measure};
use trace::SceneFile;

use crate::command::compare::read_candidate;
use crate::command::hybrid::tolerance;
use crate::command::render::{Quality, say_layers};
use crate::console::{Bar, is_interrupted, print, say};
use crate::failure::{Failure, Outcome};
use crate::files::{command_line, make_folder, write_text};

/// Run every method on a shot of a scene, and chart time against error.
///
/// Every rung of the filter and the tracer at several numbers of samples make the same picture; each is timed on this
/// machine (in turns; nothing else should run) and held against a truth of its own, whose noise is taken off. Leaves
/// chart.svg (filter or tracer alone), chart_command.svg (whole commands with their files), chart.csv, chart.json and all
/// pictures in one folder.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    mut_arg("spp", |arg| arg.long("truth-samples").default_value("4096")),
    mut_arg("noise", |arg| arg.long("truth-noise").help(
        "Sample the truth until its noise (RMS error of linear values) is at most this, instead of --truth-samples"
    )),
    mut_arg("max_spp", |arg| arg.long("truth-max-samples").help("Most samples per pixel that --truth-noise may take"))
)]
pub(crate) struct Options {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Shot to take; the file's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// Folder for charts, figures and pictures.
    #[arg(long, value_name = "DIR", default_value = "out/chart")]
    out: PathBuf,
    /// Samples per pixel at which the tracer runs; it takes them in pairs, 2 at least.
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', default_value = "2,4,16,64,256",
          value_parser = clap::value_parser!(u32).range(2..=131_072))]
    samples: Vec<u32>,
    /// Tolerances at which the hybrid runs (rung 6: filtered, and traced where more error is predicted).
    #[arg(long, value_name = "RMSE,...", value_delimiter = ',', default_value = "0.0025,0.005,0.01,0.02",
          value_parser = tolerance)]
    hybrid: Vec<f32>,
    /// Samples of a pixel that the hybrid traces.
    #[arg(long, value_name = "N", default_value_t = HybridSettings::default().samples,
          value_parser = clap::value_parser!(u32).range(2..=131_072))]
    hybrid_samples: u32,
    /// How often each method runs; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    /// Another program's picture of the same view, and the seconds that it took.
    #[arg(long, value_name = "NAME,FILE.exr,SECONDS")]
    candidate: Vec<Candidate>,
    /// Show how cost grows instead, with the size of the picture (a quarter and half as wide, as wide) or with the blur (half,
    /// once, twice and four times the iris): series_SIZE_OR_BLUR.svg, .csv and .json. Needs no truth.
    #[arg(long, value_enum, value_name = "OVER", conflicts_with = "candidate")]
    series: Option<series::Growing>,
    #[command(flatten)]
    quality: Quality,
}

/// Another program's picture.
#[derive(Debug, Clone, PartialEq)]
struct Candidate {
    name: String,
    path: PathBuf,
    seconds: f64,
}

impl FromStr for Candidate {
    type Err = anyhow::Error;

    /// The name ends at the first comma, the file at the last.
    fn from_str(text: &str) -> anyhow::Result<Self> {
        let parts = text.split_once(',').and_then(|(name, rest)| Some((name, rest.rsplit_once(',')?)));
        let Some((name, (path, seconds))) = parts else {
            bail!("a name, a file and seconds with commas between, please");
        };
        match seconds.trim().parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() && !name.trim().is_empty() && !path.trim().is_empty() => {
                Ok(Self { name: name.trim().to_owned(), path: path.trim().into(), seconds: number })
            }
            Ok(number) if number > 0.0 && number.is_finite() => bail!("name and file must not be empty"),
            _ => bail!("{seconds:?} is not a number of seconds above 0"),
        }
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = SceneFile::open(&options.scene)?;
    let shot = file.shot(options.shot.as_deref())?;
    // No method here knows motion blur: all see the middle of the exposure
    let scene = &file.scene_of(shot).stopped();
    let camera = options.quality.camera(shot)?;
    make_folder(&options.out)?;
    if let Some(growing) = options.series {
        return series::run(options, scene, &camera, growing);
    }

    // Read other programs' pictures first: what is wrong with them is wrong at once
    let display = rgbd::PixelWindow::of_size(camera.film.width(), camera.film.height());
    let candidates = options.candidate.iter().map(|candidate| {
        let (picture, _) = read_candidate(&candidate.path, display)?;
        Ok((candidate, picture))
    });
    let candidates = candidates.collect::<Result<Vec<_>, Failure>>()?;

    // Trace the truth, and what the filter gets
    let truth = options.quality.truth(scene, &camera)?;
    write_truth(&options.out.join("truth.exr"), &truth, &WriteOptions::default())?;
    let started = Instant::now();
    let layered = options.quality.layers(scene, &camera)?;
    let rgbd_seconds = started.elapsed().as_secs_f64();
    say_layers(&layered);
    let frame = &layered.frame;

    // Run all methods
    let rungs = rungs(options, frame.layers().len());
    let subject = Subject { scene, camera: &camera, frame, seed: options.quality.other_seed(), folder: &options.out };
    let bar = Bar::new("run all methods");
    let measured = measure(&subject, &rungs, options.runs.into(), &bar)?;
    drop(bar);

    // Hold them against the truth
    let reference = Reference::from_truth(&truth)?;
    let masks = Masks::from_frame(frame, &camera, None)?;
    let error = |picture: &Picture| {
        if is_interrupted() {
            return Err(Failure::Interrupted);
        }
        Ok(PointError::from(&Comparison::new(&reference, picture, &masks)?))
    };
    let mut points = Vec::new();
    for measured in &measured {
        points.push(Point::of_rung(measured, error(&measured.picture)?));
    }
    for (candidate, picture) in &candidates {
        let seconds = Timing::new(vec![candidate.seconds]).ok_or_else(|| anyhow!("no time"))?;
        points.push(Point::of_candidate(candidate.name.clone(), seconds, error(picture)?));
    }
    let conditions = Conditions {
        subject: subject_name(&options.scene, options.shot.as_deref()),
        size: [display.width, display.height],
        largest_coc_radius_px: masks.largest_coc_radius_px(),
        truth_samples: truth.samples.iter().sum(),
        truth_noise_rmse: reference.noise_mse(&masks, MaskKind::All).unwrap_or(0.0).sqrt(),
        rgbd_seconds,
        runs: options.runs.into(),
        machine: Machine::this(),
        command: command_line(),
    };
    let chart = Chart::new(conditions, points);
    print_points(&chart);
    write_chart(&chart, &options.out)
}

/// Every method that was asked for.
fn rungs(options: &Options, layers: usize) -> Vec<Rung> {
    let mut rungs = Rung::of_filter(layers);
    let seed = options.quality.other_seed();
    let samples = options.hybrid_samples;
    let hybrid = |&tolerance| Rung::Hybrid(HybridSettings { tolerance, samples, seed, ..HybridSettings::default() });
    rungs.extend(options.hybrid.iter().map(hybrid));
    rungs.extend(tracer_samples(&options.samples).into_iter().map(|samples| Rung::Trace { samples }));
    rungs
}

/// Even numbers, each once, in rising order.
fn tracer_samples(asked: &[u32]) -> Vec<u32> {
    let mut samples: Vec<u32> = asked.iter().map(|samples| samples.next_multiple_of(2)).collect();
    samples.sort_unstable();
    samples.dedup();
    samples
}

/// Scene and shot in words.
pub(crate) fn subject_name(scene: &Path, shot: Option<&str>) -> String {
    let scene = scene.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    shot.map_or_else(|| scene.clone(), |shot| format!("{scene}, {shot}"))
}

/// Prints what each method reached.
fn print_points(chart: &Chart) {
    let width = chart.points().iter().map(|point| point.name.chars().count()).max().unwrap_or(0);
    print(format_args!("{:width$}  {:>10}  {:>10}  {:>9}  {:>8}", "", "alone s", "command s", "RMSE", "PSNR dB"));
    for point in chart.points() {
        let error = point.error.all;
        let (sign, db) = (if error.below_noise { "<" } else { "" }, ::compare::psnr_db(error.rmse * error.rmse));
        let verdict = match point.dominated_by(Clock::Kernel) {
            Some(name) => format!("dominated by {name}"),
            None => "on the frontier".to_owned(),
        };
        print(format_args!(
            "{:width$}  {:10.4}  {:10.4}  {:>9}  {db:8.2}  {verdict}",
            point.name,
            point.kernel.median(),
            point.command.median(),
            format!("{sign}{:.5}", error.rmse),
        ));
    }
}

fn write_chart(chart: &Chart, folder: &Path) -> Outcome {
    let json = serde_json::to_string_pretty(&chart.to_json()).context("figures as JSON")?;
    write_text(&folder.join("chart.json"), &(json + "\n"))?;
    write_text(&folder.join("chart.csv"), &chart.to_csv())?;
    write_text(&folder.join("chart_command.svg"), &chart.to_svg(Clock::Command))?;
    let svg = folder.join("chart.svg");
    write_text(&svg, &chart.to_svg(Clock::Kernel))?;
    say(format_args!("wrote {}", svg.display()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_candidate_is_a_name_a_file_and_seconds() {
        let candidate: Candidate = "Open Defocus, out/a,b.exr, 1.5".parse().unwrap();
        let path = PathBuf::from("out/a,b.exr");
        assert_eq!(candidate, Candidate { name: "Open Defocus".to_owned(), path, seconds: 1.5 });
        for text in ["", "a", "a,b.exr", "a,b.exr,", "a,b.exr,0", "a,b.exr,-1", "a,b.exr,inf", ",b.exr,1", "a,,1"] {
            assert!(text.parse::<Candidate>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_tracer_runs_even_numbers_of_samples_once_each() {
        assert_eq!(tracer_samples(&[64, 3, 4, 2]), [2, 4, 64]);
    }
}

//! `tiltshift advise`: the cheapest method that will do.

use std::path::PathBuf;
use std::time::Instant;

use ::filter::Method;
use anyhow::{Context, anyhow, bail};
use clap::Args;
use optics::Camera;
use rgbd::{Frame, PixelWindow, ReadOptions};
use serde_json::json;
use study::{Choice, Evidence, Forecast, Rung, Tolerance, Tradeoff, choose, forecasts, frontier};
use trace::{LayerSettings, SceneFile};

use crate::command::filter::Source;
use crate::command::filter::aim::{self, Taken};
use crate::command::filter::input::{self, Input};
use crate::command::filter::job::{Job, Say};
use crate::command::render::say_layers;
use crate::console::{Bar, print, say};
use crate::failure::{Failure, Outcome};
use crate::lens_options::{FilmOptions, LensOptions};
use crate::read_arguments::ReadArguments;
use crate::values::{Size, positive};

/// Say which method is the cheapest that comes within a tolerance.
///
/// A few cheap runs (the filter with its own prediction of its error, a trace of few samples, a few tiles traced well) tell what every method would
/// cost on this machine and how wrong it would be; the cheapest that is expected to be within the tolerance is named, with
/// the reason. Of a scene the tracer and the hybrid are methods too, and the time to trace colour and depth for the filter is
/// in no method's time, as if the frame were there already; of a picture with depth, read as `tiltshift filter` reads it, only
/// the filter's.
/// Exit code 1: nothing is expected to be within the tolerance.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Scene file (TOML), or a picture with depth: OpenEXR, or a photo with --depth FILE.
    input: PathBuf,
    /// Shot to take; the scene's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// How wrong the picture may be: psnr=40dB, rmse=0.01 or hdr-flip=0.02, over the whole picture, linear values.
    #[arg(long, value_name = "FIGURE=VALUE", default_value = "psnr=40dB")]
    tolerance: Tolerance,
    /// Most seconds that the method may take.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    budget: Option<f64>,
    /// Print all forecasts as JSON.
    #[arg(long)]
    json: bool,
    /// Samples per pixel of the RGB-D frame's colour (of a scene).
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536))]
    rgbd_spp: u32,
    /// Size of the picture in pixels; the shot's own without.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Seed of the samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    lens: LensOptions,
    #[command(flatten)]
    film: FilmOptions,
    #[command(flatten)]
    read: ReadArguments,
}

impl Options {
    /// Whether a scene is asked about, and not a picture.
    fn is_scene(&self) -> bool {
        self.input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
    }
}

/// What is looked at.
struct Subject {
    scene: Option<SceneFile>,
    camera: Camera,
    frame: Frame,
    /// Seconds that colour and depth took.
    frame_seconds: Option<f64>,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let subject = subject(options)?;
    let evidence = Evidence {
        scene: subject.scene.as_ref().map(SceneFile::scene),
        camera: &subject.camera,
        frame: &subject.frame,
        seed: options.seed,
    };
    let started = Instant::now();
    let all = forecasts(&evidence, options.tolerance.needs_flip(), &Bar::new("try methods"))?;
    let seconds = started.elapsed().as_secs_f64();
    let choice = choose(&all, &options.tolerance, options.budget).ok_or_else(|| anyhow!("no method could be tried"))?;
    if options.json {
        print_json(options, &subject, &all, &choice, seconds)?;
    } else {
        print_text(options, &subject, &all, &choice, seconds);
    }
    if choice.is_within {
        return Ok(());
    }
    Err(Failure::Exceeded(format!("no method is expected to be within {}", bounds(options))))
}

/// The frame of a shot, or of a file.
fn subject(options: &Options) -> anyhow::Result<Subject> {
    if !options.is_scene() {
        return of_picture(options);
    }
    if options.lens.is_given() {
        bail!(
            "{:?} is a scene, whose shot says what lens it has; leave out the options of lens and focus",
            options.input
        );
    }
    let file = SceneFile::open(&options.input)?;
    let shot = file.shot(options.shot.as_deref())?;
    // No method here knows motion blur: all see the middle of the exposure
    let scene = file.scene_of(shot).stopped();
    let camera = match options.size {
        Some(Size { width, height }) => Camera { film: shot.camera.film.resized(width, height)?, ..shot.camera },
        None => shot.camera,
    };
    let pixels = PixelWindow::of_size(camera.film.width(), camera.film.height()).area();
    if pixels as u64 > ReadOptions::MAX_PIXELS {
        return Err(anyhow!("the picture has {pixels} pixels; at most {} will do", ReadOptions::MAX_PIXELS));
    }
    let seed = options.seed.wrapping_add(1);
    let settings = LayerSettings { color_samples: options.rgbd_spp, seed, ..LayerSettings::default() };
    let started = Instant::now();
    let layered = trace::layers(&scene, &camera, &settings, &Bar::new("trace colour and depth"))?;
    let frame_seconds = Some(started.elapsed().as_secs_f64());
    say_layers(&layered);
    Ok(Subject { camera, frame: layered.frame, scene: Some(file), frame_seconds })
}

/// The frame of a file, and the lens that was asked for.
fn of_picture(options: &Options) -> anyhow::Result<Subject> {
    options.film.check()?;
    options.lens.check()?;
    let job = Job {
        input: options.input.clone(),
        depth: options.read.depth_file(),
        output: PathBuf::new(),
        png: None,
        overlay: None,
        lens: options.lens.clone(),
        convention: None,
        ground: None,
    };
    let source = Source { film: &options.film, read: &options.read };
    let say: Say<'_> = &|line| say(line);
    let Input { frame, lens: attributes, .. } = input::read(&job, &source, say)?;
    let display = frame.display;
    let frame = frame.covering(display);
    let Taken { camera, .. } = aim::camera(&job, &source, &frame, &attributes, say)?;
    Ok(Subject { scene: None, camera, frame, frame_seconds: None })
}

/// The tolerance and the budget in words.
fn bounds(options: &Options) -> String {
    match options.budget {
        Some(seconds) => format!("{} in {seconds} s", options.tolerance),
        None => options.tolerance.to_string(),
    }
}

fn print_text(options: &Options, subject: &Subject, all: &[Forecast], choice: &Choice, seconds: f64) {
    // What is slower and no truer than another need not be read
    let tolerance = &options.tolerance;
    let tradeoff =
        |forecast: &Forecast| Tradeoff { seconds: forecast.seconds, error: tolerance.used_by(&forecast.error) };
    let worth = frontier(&all.iter().map(tradeoff).collect::<Vec<_>>());
    let is_worth = |index: usize| worth.contains(&index) || all[index] == *choice.forecast;
    let mut shown: Vec<&Forecast> = (0..all.len()).filter(|&index| is_worth(index)).map(|index| &all[index]).collect();
    shown.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    for forecast in shown {
        print(format_args!(
            "{} {:20} {:>9.4} s  {}",
            if forecast == choice.forecast { ">" } else { " " },
            forecast.rung.name(),
            forecast.seconds,
            tolerance.text_of(&forecast.error)
        ));
    }
    if worth.len() < all.len() {
        say(format_args!("of {} methods; the others are slower and no truer (--json lists all)", all.len()));
    }
    let chosen = choice.forecast;
    let expected = tolerance.text_of(&chosen.error);
    let kernel = chosen.kernel.map(|kernel| format!(", {kernel} footprint")).unwrap_or_default();
    let verdict = match (choice.is_within, chosen.doubt) {
        (true, Some(_)) => format!("expected to be within (chance {:.0} %)", (100.0 * choice.chance).min(99.0)),
        (true, None) => "expected to be within".to_owned(),
        (false, _) => "the nearest, but not expected to be within".to_owned(),
    };
    print(format_args!(
        "{}{kernel}: {expected} in {:.3} s, {verdict} {}",
        chosen.rung.name(),
        chosen.seconds,
        bounds(options)
    ));
    print(match (choice.cheaper, choice.is_limited_by_budget) {
        (_, true) => "what would be within it takes longer than the budget".to_owned(),
        (Some(other), _) => format!(
            "the next cheaper one, {}, would save {:.3} s and is expected at {}: too near or beyond",
            other.rung.name(),
            chosen.seconds - other.seconds,
            tolerance.text_of(&other.error)
        ),
        (None, _) => "nothing is cheaper".to_owned(),
    });
    let frame =
        subject.frame_seconds.map(|seconds| format!("; colour and depth took {seconds:.2} s")).unwrap_or_default();
    say(format_args!("found out in {seconds:.2} s{frame}"));
    let like_here = if options.is_scene() { "" } else { ", with the options of lens, focus and depth as here" };
    say(format_args!("run: {}{like_here}", command(options, &chosen.rung)));
}

/// The command that runs a rung.
fn command(options: &Options, rung: &Rung) -> String {
    let input = options.input.display();
    let shot = options.shot.as_ref().map(|shot| format!(" --shot {shot}")).unwrap_or_default();
    let size = options.size.map(|Size { width, height }| format!(" --size {width}x{height}")).unwrap_or_default();
    match rung {
        Rung::Filter(method) => {
            let layers = match method {
                Method::Merged(settings) if settings.layers == 1 => " --layers 1",
                _ => "",
            };
            let file = if options.is_scene() { "RGBD.exr".to_owned() } else { input.to_string() };
            format!("tiltshift filter {file} -o OUT.exr --method {}{layers}", method.name())
        }
        Rung::Hybrid(settings) => format!(
            "tiltshift hybrid {input}{shot}{size} --tolerance {} --samples {} -o OUT.exr",
            settings.tolerance, settings.samples
        ),
        Rung::Trace { samples } => format!("tiltshift render {input}{shot}{size} --spp {samples} -o OUT.exr"),
    }
}

fn print_json(
    options: &Options,
    subject: &Subject,
    all: &[Forecast],
    choice: &Choice,
    seconds: f64,
) -> anyhow::Result<()> {
    let told = |forecast: &Forecast| {
        json!({
            "method": forecast.rung.name(),
            "seconds": forecast.seconds,
            "rmse": forecast.error.rmse,
            "hdr_flip": forecast.error.hdr_flip,
            "kernel": forecast.kernel.map(|kernel| kernel.to_string()),
            "command": command(options, &forecast.rung),
        })
    };
    let advice = json!({
        "format": 1,
        "tolerance": options.tolerance,
        "budget_seconds": options.budget,
        "chosen": told(choice.forecast),
        "is_within": choice.is_within,
        "chance": choice.chance,
        "is_limited_by_budget": choice.is_limited_by_budget,
        "methods": all.iter().map(told).collect::<Vec<_>>(),
        "pilot_seconds": seconds,
        "frame_seconds": subject.frame_seconds,
    });
    print(serde_json::to_string_pretty(&advice).context("advice as JSON")?);
    Ok(())
}

//! `tiltshift demo`: the whole road on a scene of the project.

use std::path::{Path, PathBuf};
use std::time::Instant;

use ::compare::{Comparison, Entry, Masks, Parameter, Reference, Report};
use ::filter::{FrameView, GatherSettings, Method, apply};
use anyhow::Context;
use clap::{Args, ValueEnum};
use rgbd::{Head, Picture, write_frame, write_picture, write_png, write_truth};
use study::{Evidence, Tolerance, choose, forecasts};
use trace::{Scene, SceneFile, Shot};

use crate::command::compare::{print_table, write_report};
use crate::command::filter::sensor_mm;
use crate::command::render::{Quality, lens_in_metres, say_layers, say_scene};
use crate::console::{Bar, say};
use crate::failure::Outcome;
use crate::files::{Packing, command_line, make_folder, notes, write_options};

/// Trace, filter and compare a scene of the project, and leave a report to open.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, mut_arg("spp", |spp| spp.default_value("128")))]
pub(crate) struct Options {
    /// Scene.
    #[arg(long, value_enum, default_value_t)]
    scene: SceneName,
    /// Shot of the scene; one that shows what it is for without (miniature, tilt_swing_shift, blur, fence); `tiltshift render
    /// data/scenes/SCENE.toml --list` lists them.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// Folder for the report and the pictures.
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    /// How wrong a picture may be for which the cheapest method is asked: psnr=40dB, rmse=0.01 or hdr-flip=0.02.
    #[arg(long, value_name = "FIGURE=VALUE", default_value = "psnr=40dB")]
    tolerance: Tolerance,
    #[command(flatten)]
    quality: Quality,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum SceneName {
    /// A ball, a box and a cylinder on a checkered floor.
    Simple,
    /// A village with roads and trees.
    #[default]
    Landscape,
    /// A town of several hundred houses from a hill.
    Town,
    /// Glossy and glass things on a table, small lamps far behind.
    Tabletop,
    /// Leaves, a fence and wires before fine detail.
    Thicket,
}

impl SceneName {
    fn default_shot(self) -> &'static str {
        match self {
            Self::Simple => "tilt_swing_shift",
            Self::Landscape | Self::Town => "miniature",
            Self::Tabletop => "blur",
            Self::Thicket => "fence",
        }
    }

    /// The scene, which is part of the program.
    fn open(self) -> anyhow::Result<SceneFile> {
        let (text, path) = match self {
            Self::Simple => (include_str!("../../../data/scenes/simple.toml"), "data/scenes/simple.toml"),
            Self::Landscape => (include_str!("../../../data/scenes/landscape.toml"), "data/scenes/landscape.toml"),
            Self::Town => (include_str!("../../../data/scenes/town.toml"), "data/scenes/town.toml"),
            Self::Tabletop => (include_str!("../../../data/scenes/tabletop.toml"), "data/scenes/tabletop.toml"),
            Self::Thicket => (include_str!("../../../data/scenes/thicket.toml"), "data/scenes/thicket.toml"),
        };
        Ok(SceneFile::parse(text, Path::new(path))?)
    }
}

/// A picture of the demo, how it was made and how long that took.
struct Made {
    method: String,
    name: &'static str,
    note: String,
    picture: Picture,
    seconds: f64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = options.scene.open()?;
    let name = options.shot.as_deref().unwrap_or(options.scene.default_shot());
    let shot = file.shot(Some(name))?;
    // No method here knows motion blur: all see the middle of the exposure
    let scene = &file.scene_of(shot).stopped();
    let camera = options.quality.camera(shot)?;
    say(format_args!("{} / {name}: {}", file.description(), shot.description));
    say_scene(&file);
    make_folder(&options.out)?;

    // Trace the truth and what the filter gets
    let started = Instant::now();
    let truth = options.quality.truth(scene, &camera)?;
    let truth_seconds = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let layered = options.quality.layers(scene, &camera)?;
    let frame_seconds = started.elapsed().as_secs_f64();
    say_layers(&layered);
    let frame = &layered.frame;

    // Climb the ladder
    let one_layer = GatherSettings { layers: 1, ..GatherSettings::default() };
    let rungs = [
        (Method::OwnCoc(one_layer), "own-coc", "rung 1: every pixel averages its own circle of confusion"),
        (Method::Merged(one_layer), "merged-1-layer", "rung 3: gather in depth order, what is hidden is guessed"),
        (Method::default(), "merged", "rung 3: gather in depth order, with hidden layers"),
    ];
    let mut made = Vec::new();
    for (method, name, note) in rungs {
        let started = Instant::now();
        let filtered =
            apply(&FrameView::whole(frame), &camera, &method, frame.display, &Bar::new(format!("filter ({name})")))?;
        let (method, note, seconds) = (format!("{method:?}"), note.to_owned(), started.elapsed().as_secs_f64());
        made.push(Made { method, name, note, picture: filtered.picture, seconds });
    }

    // Take the cheapest that is expected to do
    let tolerance = options.tolerance;
    let seed = options.quality.other_seed();
    let evidence = Evidence { scene: Some(scene), camera: &camera, frame, seed };
    let all = forecasts(&evidence, tolerance.needs_flip(), &Bar::new("ask for advice"))?;
    let choice = choose(&all, &tolerance, None).context("no method could be tried")?;
    let (rung, expected) = (choice.forecast.rung, tolerance.text_of(&choice.forecast.error));
    let note = format!("the cheapest for {tolerance}: {}, expected at {expected}", rung.name());
    say(format_args!("advice: {note}"));
    let started = Instant::now();
    let picture = evidence.picture(&rung, &Bar::new(format!("{} (advised)", rung.name())))?;
    let seconds = started.elapsed().as_secs_f64();
    made.push(Made { method: format!("{rung:?}"), name: "advised", note, picture, seconds });

    // Compare all with the truth
    let reference = Reference::from_truth(&truth)?;
    let masks = Masks::from_frame(frame, &camera, None)?.with_highlights(&reference);
    let pinhole = frame.layers()[0].color.cropped(frame.display);
    let entry = |name: &str, note: String, picture: &Picture| {
        Ok::<_, anyhow::Error>(Entry {
            name: name.to_owned(),
            note,
            comparison: Comparison::new(&reference, picture, &masks)?,
        })
    };
    let candidates =
        made.iter().rev().map(|made| entry(made.name, format!("{}; {:.2} s", made.note, made.seconds), &made.picture));
    let report = Report {
        title: format!("tiltshift demo: {}, {name}", file.description()),
        about: format!(
            "{}. The traced truth beside the post-process filter, with the same tilted lens.",
            shot.description
        ),
        reference_name: "truth".to_owned(),
        reference: &reference,
        masks: &masks,
        unfiltered: Some(entry("unfiltered", "the pinhole picture".to_owned(), &pinhole)?),
        candidates: candidates.collect::<Result<Vec<_>, _>>()?,
        exposure_stops: 0.0,
        parameters: parameters(shot, scene, &options.quality, [truth_seconds, frame_seconds])?,
        commands: vec![command_line()],
    };
    print_table(&report);

    // Leave everything to look at
    let lens = lens_in_metres(shot, file.scene())?;
    let write = write_options(Packing::Rle, lens.as_ref(), lens.map(|lens| sensor_mm(&camera, &lens)), notes([]));
    write_truth(&options.out.join("truth.exr"), &truth, &write)?;
    write_frame(&options.out.join("rgbd.exr"), frame, &write)?;
    write_png(&options.out.join("truth.png"), &truth.picture(), 0.0)?;
    write_png(&options.out.join("pinhole.png"), &pinhole, 0.0)?;
    for made in &made {
        let path = options.out.join(format!("{}.exr", made.name));
        let head = Head { camera: Some(camera), ..Head::from(frame) };
        let method = notes([("method", made.method.clone())]);
        write_picture(&path, &made.picture, &head, &rgbd::WriteOptions { notes: method, ..write.clone() })?;
        write_png(&path.with_extension("png"), &made.picture, 0.0)?;
    }
    write_report(&report, &options.out)
}

/// Everything that the pictures depend on.
fn parameters(shot: &Shot, scene: &Scene, quality: &Quality, seconds: [f64; 2]) -> anyhow::Result<Vec<Parameter>> {
    let camera = serde_json::to_string(&quality.camera(shot)?).context("camera as JSON")?;
    let mut parameters = vec![
        Parameter::new("version", env!("CARGO_PKG_VERSION")),
        Parameter::new("quality", format!("{quality:?}")),
        Parameter::new("time to trace the truth (s)", format!("{:.2}", seconds[0])),
        Parameter::new("time to trace colour and depth (s)", format!("{:.2}", seconds[1])),
        Parameter::new("camera (scene units)", camera),
    ];
    if let Some(lens) = lens_in_metres(shot, scene)? {
        let lens = serde_json::to_string(&lens).context("lens as JSON")?;
        parameters.push(Parameter::new("lens (metres, radians)", lens));
    }
    Ok(parameters)
}

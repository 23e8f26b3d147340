//! `tiltshift stability`: every method swept through the points where methods fail.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use filter::{GatherSettings, LensRaysSettings, Method};
use study::{
    Clip, Contender, HybridSettings, Machine, Mode, Quality, Rung, Stability, StabilityConditions, Stage, Sweep,
    refusals, run_clip, run_sensitivity, run_sweep,
};
use trace::SceneFile;

use crate::command::chart::subject_name;
use crate::console::{Bar, print, say};
use crate::failure::{Failure, Outcome};
use crate::files::{command_line, make_folder, write_text};
use crate::values::Size;

/// Sweep every method through the points where methods fail, and say where it does not fail softly.
///
/// Each sweep leads through one bad point in small steps, each step with a truth of its own. At every step no pixel may be
/// other than finite, the picture may change by twice what the truth changes by, and the error may be 10 % above that of no
/// filter. Lens, plane of focus and depth are swept on the shot, near, thin and bright things in small scenes. Then come
/// flicker over a pan and a rack focus, and what doubtful depth costs. Leaves stability.svg, stability.csv and
/// stability.json in one folder. Exit code 1 if a criterion is not held.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Shot to take; the file's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// Folder for the figures.
    #[arg(long, value_name = "DIR", default_value = "out/stability")]
    out: PathBuf,
    /// Only these sweeps (and no clips); all without.
    #[arg(long, value_name = "MODE,...", value_delimiter = ',', value_parser = mode)]
    modes: Vec<Mode>,
    /// Steps of a sweep; an odd number has the bad point itself among them.
    #[arg(long, value_name = "N", default_value_t = 65, value_parser = clap::value_parser!(u16).range(3..=1000))]
    steps: u16,
    /// Frames of a clip.
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u16).range(3..=1000))]
    frames: u16,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "96x54")]
    size: Size,
    /// Samples per pixel of each truth.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=8192))]
    truth_samples: u32,
    /// Samples per pixel of the RGB-D frames' colour.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=8192))]
    rgbd_spp: u32,
    /// Seed of the samples, the same at every step.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print the figures as JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// A mode by its name.
fn mode(text: &str) -> anyhow::Result<Mode> {
    let wanted = Mode::EVERY.into_iter().find(|mode| mode.name() == text.trim());
    let names = || Mode::EVERY.map(Mode::name).join(", ");
    wanted.with_context(|| format!("{text:?} is no mode; there are {}", names()))
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = SceneFile::open(&options.scene)?;
    let shot = file.shot(options.shot.as_deref())?;
    let Size { width, height } = options.size;
    // No method here knows motion blur: all see the middle of the exposure
    let scene = file.scene_of(shot).stopped();
    let stage = Stage::new(&scene, shot, width, height)?;
    make_folder(&options.out)?;
    let quality = Quality { truth_samples: options.truth_samples, frame_samples: options.rgbd_spp, seed: options.seed };
    let rungs = rungs(quality.seed.wrapping_add(2));
    let contenders: Vec<&dyn Contender> = rungs.iter().map(|rung| rung as &dyn Contender).collect();

    // Walk through the bad points
    let modes = if options.modes.is_empty() { &Mode::EVERY[..] } else { &options.modes };
    let mut sweeps = Vec::new();
    for &mode in modes {
        let sweep = Sweep::new(mode, &stage, options.steps.into())?;
        sweeps.push(run_sweep(&sweep, &contenders, &quality, &Bar::new(mode.name()))?);
    }

    // Let the lens move, and the depth get worse
    let (mut flickers, mut sensitivity) = (Vec::new(), Vec::new());
    if options.modes.is_empty() {
        for clip in Clip::EVERY {
            let bar = Bar::new(clip.name());
            flickers.push(run_clip(clip, &stage, options.frames.into(), &contenders, &quality, &bar)?);
        }
        sensitivity = run_sensitivity(&stage, &contenders, &quality, &Bar::new("doubtful depth"))?;
    }

    let conditions = StabilityConditions {
        subject: subject_name(&options.scene, options.shot.as_deref()),
        size: [width, height],
        steps: options.steps.into(),
        quality,
        machine: Machine::this(),
        command: command_line(),
    };
    let stability = Stability::new(conditions, sweeps, flickers, sensitivity, refusals());
    finish(&stability, options)
}

/// The rungs that are swept: all that blur, and the hybrid.
fn rungs(seed: u64) -> Vec<Rung> {
    let gather = |layers| GatherSettings { layers, ..GatherSettings::default() };
    let rays = |layers| LensRaysSettings { layers, ..LensRaysSettings::default() };
    let mut methods = vec![Method::OwnCoc(gather(1))];
    for layers in [1, 2] {
        methods.extend([
            Method::Gather(gather(layers)),
            Method::Merged(gather(layers)),
            Method::LensRays(rays(layers)),
        ]);
    }
    let hybrid = Rung::Hybrid(HybridSettings { seed, ..HybridSettings::default() });
    methods.into_iter().map(Rung::Filter).chain([hybrid]).collect()
}

/// Prints and writes the figures, and fails where a criterion is not held.
fn finish(stability: &Stability, options: &Options) -> Outcome {
    let json = serde_json::to_string_pretty(&stability.to_json()).context("figures as JSON")?;
    if options.json {
        print(&json);
    } else {
        print(stability.to_text());
    }
    write_text(&options.out.join("stability.json"), &(json + "\n"))?;
    write_text(&options.out.join("stability.csv"), &stability.to_csv())?;
    let svg = options.out.join("stability.svg");
    write_text(&svg, &stability.to_svg())?;
    say(format_args!("wrote {}", svg.display()));

    let failed = stability.failed();
    for failure in &failed {
        say(format_args!("  {} {}: {}", failure.place, failure.method, failure.what));
    }
    match failed.len() {
        0 => Ok(()),
        count => Err(Failure::Exceeded(format!("{count} criteria are not held"))),
    }
}

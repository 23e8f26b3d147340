//! `tiltshift filter`: the lens put onto an RGB-D picture.

pub(super) mod aim;
pub(super) mod input;
pub(super) mod job;
mod method;
mod overlay;
mod result;
mod sequence;
mod steady;
mod tolerance;

use std::path::PathBuf;

use anyhow::{Context, anyhow};
use clap::Args;
use optics::{Camera, ThinLens};
use study::Tolerance;

use self::job::{Job, Shown};
use self::method::{HighlightOptions, MethodOptions};
use self::sequence::Sequence;
use self::steady::GroundRule;
use crate::console::{print, say};
use crate::failure::{Failure, Outcome};
use crate::files::Packing;
use crate::focus_keys::{Between, FocusKeys};
use crate::lens_options::{FilmOptions, LensOptions};
use crate::read_arguments::ReadArguments;
use crate::values::{Frames, stops};

/// Put a tilt-shift lens onto a picture with depth.
///
/// Reads colour and depth from an OpenEXR file, or colour from a photo (PNG, JPEG, TIFF, Radiance HDR, PFM) and depth from a
/// map beside it (--depth FILE), and writes what the lens would have taken. Lens and focus come from the options, or from the
/// file where it was written by `tiltshift render`.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:\n  \
        tiltshift filter shot.exr -o tilted.exr --png tilted.png --focal-length 50 --sensor-width 36 \\\n      \
        -N 1.4 --tilt 6 --focus-pixel 480,330\n  \
        tiltshift filter photo.jpg -o tilted.jpg --depth disparity_white_near.png --depth-as inverse \\\n      \
        --depth-range 20,1 --focal-length 28 --sensor full-frame -N 1.4 --focus ground\n  \
        tiltshift filter shot.####.exr -o tilted.####.exr --frames 1..240 --resume --fov 40 \\\n      \
        --sensor-width 36 -N 2 --focus-keys keys.csv"
)]
pub(crate) struct Options {
    /// Picture: OpenEXR with colour and depth, or a photo with --depth FILE. A sequence: shot.####.exr, shot.%04d.exr,
    /// 'shot.*.exr', or many files; then all other names may hold #### or %04d too, and results without get the number put
    /// before their ending.
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Where to write the result: .exr (linear, premultiplied), .png, .jpg, .tif, .hdr or .pfm. A photo's result keeps the
    /// photo's transfer, profile and bits as far as the format holds them.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Also write an 8-bit sRGB PNG.
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Also draw over the result, as a PNG: the trace of the plane of focus (green), the limits of what is sharp within 1 px of
    /// radius (yellow), what is blurred before (orange) and behind it (blue).
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
    /// Also write the signed radius (of the wider axis) of the circle of confusion in pixels, positive on the lens's side of
    /// the plane of focus, as a channel "coc" of the result.
    #[arg(long)]
    coc: bool,
    /// Also write how far each pixel may be from the truth, as a channel "predicted_error" of the result (methods gather,
    /// merged and lens-rays).
    #[arg(long)]
    predicted_error: bool,
    /// How wrong the picture may be: psnr=40dB, rmse=0.01 or hdr-flip=0.02, over the whole picture, linear values. The method
    /// predicts its own error; where that is too large, lens rays are tried too, and exit code 1 says that even they are not
    /// surely within it (methods gather, merged and lens-rays).
    #[arg(long, value_name = "FIGURE=VALUE")]
    tolerance: Option<Tolerance>,
    /// Exposure in stops of PNG, JPEG, TIFF, HDR and PFM; an OpenEXR result keeps its light.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// How the EXR is packed.
    #[arg(long, value_enum, default_value_t)]
    compression: Packing,
    /// Write what was done to standard output as JSON: one line, or one for each frame.
    #[arg(long)]
    json: bool,
    /// Say what is done, in full.
    #[arg(long, short)]
    verbose: bool,

    #[command(flatten)]
    lens: LensOptions,
    #[command(flatten)]
    film: FilmOptions,
    #[command(flatten)]
    read: ReadArguments,
    #[command(flatten)]
    frames: SequenceOptions,
    #[command(flatten)]
    method: MethodOptions,
    #[command(flatten)]
    highlights: HighlightOptions,
}

/// Which frames of a sequence, and what changes from one to the next. As many are filtered at a time as there are cores and
/// --memory-limit has room for; a frame that fails does not stop the others, and makes the exit code 1.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
struct SequenceOptions {
    /// Frames, first and last; all that are there without. One that is missing is named, and makes the exit code 1.
    #[arg(long, value_name = "A..B")]
    frames: Option<Frames>,
    /// Leave out frames whose results are complete, and no older than what they are made from.
    #[arg(long)]
    resume: bool,
    /// How the ground of --focus ground and --focus miniature is found: `steady` looks at the first frame, the last, and all whose
    /// number is a multiple of 8; where they agree within 2 %, the median is the ground of all frames, else (the camera moves) it goes
    /// from one to the next, each the median of three. `each` finds it anew in each frame, which may tremble.
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    ground: GroundRule,
    /// Focus from a table (CSV): the first line names the columns, frame first, then any of focus-distance (metres), tilt,
    /// swing (degrees), f-number, hinge-distance (metres); each further line is a key.
    #[arg(long, value_name = "FILE.csv")]
    focus_keys: Option<PathBuf>,
    /// How frames between two keys are made; inverse distances and inverse f-numbers are what is interpolated.
    #[arg(long, value_enum, value_name = "HOW", default_value_t, requires = "focus_keys")]
    keys: Between,
}

/// What tells how a picture is read and what its camera sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) film: &'a FilmOptions,
    pub(crate) read: &'a ReadArguments,
}

/// Filters what was asked for.
pub(crate) fn run(options: &Options) -> Outcome {
    options.film.check()?;
    options.lens.check()?;
    let keys = options.frames.focus_keys.as_ref().map(|path| FocusKeys::read(path, options.frames.keys)).transpose()?;
    if let Some(keys) = &keys {
        keys.check(&options.lens)?;
    }
    if let Some(sequence) = Sequence::of(options)? {
        return sequence::run(&sequence, options, keys.as_ref());
    }
    if keys.is_some() {
        return Err(anyhow!("--focus-keys needs a sequence, like shot.####.exr").into());
    }
    let job = Job {
        input: options.inputs[0].clone(),
        depth: options.read.depth_file(),
        output: options.output.clone(),
        png: options.png.clone(),
        overlay: options.overlay.clone(),
        lens: options.lens.clone(),
        convention: None,
        ground: None,
    };
    let report = job.run(options, options.method.memory_limit, Shown::Bar, &|line| say(line))?;
    if options.json {
        print(serde_json::to_string(&report).context("the report makes no JSON")?);
    }
    match report.missed() {
        Some(promise) => Err(Failure::Exceeded(format!("{}: {promise}", job.output.display()))),
        None => Ok(()),
    }
}

/// Sensor size in mm that the window stands for at the lens's image distance.
pub(crate) fn sensor_mm(camera: &Camera, lens: &ThinLens) -> [f64; 2] {
    camera.sensor_size(lens.image_distance()).map(|metres| metres * 1e3)
}

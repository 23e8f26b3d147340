//! `tiltshift info`: what a picture file holds, and what would be made of it.

mod json;
mod photo;
mod words;

use std::path::PathBuf;

use anyhow::{Context, anyhow, bail};
use clap::Args;
use optics::Film;
use rgbd::{PhotoFormat, inspect, survey_file};

use self::words::Words;
use crate::console;
use crate::failure::Outcome;
use crate::lens_options::FilmOptions;
use crate::read_arguments::ReadArguments;
use crate::values::positive;

/// Say what a picture file holds: parts, channels and windows, what would be taken as colour and depth and why, how deep
/// the picture is, and what is known of its camera.
///
/// A file that `tiltshift filter` would refuse is described all the same, with the reason. A damaged one ends with exit
/// code 2.
#[derive(Debug, Args)]
#[command(mut_args(without_a_map))]
pub(crate) struct Options {
    /// Picture: OpenEXR of any program, or a photo or depth map (PNG, JPEG, TIFF, Radiance HDR, PFM).
    file: PathBuf,
    /// Write JSON instead of words: numbers that JSON does not have are the strings "inf", "-inf" and "nan".
    #[arg(long)]
    json: bool,
    /// Horizontal field of view of the picture in degrees, to tell distances along the ray from planar depth.
    #[arg(long, value_name = "DEG", value_parser = degrees)]
    fov: Option<f64>,
    #[command(flatten)]
    read: ReadArguments,
}

impl Options {
    /// What a picture of this size shows, where that is said.
    fn film(&self, width: u32, height: u32, pixel_aspect: f64) -> Option<Film> {
        let fov = FilmOptions { fov: self.fov, ..FilmOptions::default() };
        fov.film(width, height, pixel_aspect).ok().flatten()
    }
}

/// A field of view.
fn degrees(text: &str) -> anyhow::Result<f64> {
    let degrees = positive(text)?;
    if degrees < 180.0 { Ok(degrees) } else { bail!("it must be below 180 degrees") }
}

/// Options as they are meant where one file is looked at.
fn without_a_map(arg: clap::Arg) -> clap::Arg {
    match arg.get_id().as_str() {
        "depth_channel" | "keep_holes" => arg.hide(true),
        "depth" => arg.value_name("NAME").help("Channel to take depth from, e.g. depth.Z, or PART/CHANNEL"),
        _ => arg,
    }
}

/// Says what there is.
pub(crate) fn run(options: &Options) -> Outcome {
    if let Some(map) = options.read.depth_file() {
        return Err(anyhow!("info looks at one file; for the depth map say `tiltshift info {}`", map.display()).into());
    }
    if let Some(format) = PhotoFormat::of_file(&options.file)? {
        return photo::run(options, format);
    }
    let survey = survey_file(&options.file, options.read.max_pixels())?;
    let film = options.film(survey.display.width, survey.display.height, f64::from(survey.pixel_aspect));
    let inspection = inspect(&options.file, &options.read.options(film, None))?;
    if options.json {
        let report = json::report(&options.file, &inspection);
        console::print(serde_json::to_string_pretty(&report).context("the report makes no JSON")?);
    } else {
        console::print(Words { path: &options.file, inspection: &inspection });
    }
    Ok(())
}

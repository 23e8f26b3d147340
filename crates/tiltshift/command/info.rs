//! `tiltshift info`: what a picture file holds, and what would be made of it.

mod json;
mod photo;
mod words;

use std::path::PathBuf;

use anyhow::{Context, anyhow};
use clap::Args;
use rgbd::{PhotoFormat, inspect};

use self::words::Words;
use crate::console;
use crate::failure::Outcome;
use crate::read_arguments::ReadArguments;

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
    #[command(flatten)]
    read: ReadArguments,
}

/// Options as they are meant where one file is looked at.
fn without_a_map(arg: clap::Arg) -> clap::Arg {
    match arg.get_id().as_str() {
        "depth_channel" | "depth_range" | "fill_holes" => arg.hide(true),
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
    let inspection = inspect(&options.file, &options.read.options(None, None))?;
    if options.json {
        let report = json::report(&options.file, &inspection);
        console::print(serde_json::to_string_pretty(&report).context("the report makes no JSON")?);
    } else {
        console::print(Words { path: &options.file, inspection: &inspection });
    }
    Ok(())
}

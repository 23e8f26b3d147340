//! `tiltshift info`: what a picture file holds, and what would be made of it.

mod json;
mod photo;
mod words;

use std::path::PathBuf;

use anyhow::Context;
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
pub(crate) struct Options {
    /// Picture: OpenEXR of any program, or a photo or depth map (PNG, JPEG, TIFF, Radiance HDR, PFM).
    file: PathBuf,
    /// Write JSON instead of words: numbers that JSON does not have are the strings "inf", "-inf" and "nan".
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    read: ReadArguments,
}

/// Says what there is.
pub(crate) fn run(options: &Options) -> Outcome {
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

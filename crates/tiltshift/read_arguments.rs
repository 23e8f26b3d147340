//! Options that say how an input picture is to be understood.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use optics::Film;
use rgbd::{DepthConvention, PhotoFormat, ReadOptions};

use crate::values::Ends;

/// What the numbers of a depth channel or map mean.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum DepthAs {
    /// Depth along the sensor's normal.
    Planar,
    /// Distance from the lens, along the ray of the pixel.
    Ray,
    /// One over planar depth: disparity, as phones, stereo and depth-guessing networks give it.
    #[value(alias = "disparity")]
    Inverse,
}

impl From<DepthAs> for DepthConvention {
    fn from(depth_as: DepthAs) -> Self {
        match depth_as {
            DepthAs::Planar => Self::Planar,
            DepthAs::Ray => Self::Ray,
            DepthAs::Inverse => Self::Inverse,
        }
    }
}

/// How an input picture is to be understood.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct ReadArguments {
    /// Layer or part to take colour from, e.g. ViewLayer.Combined.
    #[arg(long, value_name = "NAME")]
    color: Option<String>,
    /// Channel to take depth from, e.g. depth.Z, or PART/CHANNEL; or the file of a depth map beside the picture (.png, .jpg,
    /// .tif, .pfm, .exr), of any size.
    #[arg(long, value_name = "NAME|FILE")]
    depth: Option<String>,
    /// Channel of the depth map's OpenEXR file.
    #[arg(long, value_name = "NAME", requires = "depth")]
    depth_channel: Option<String>,
    /// View (eye) to take.
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// What the numbers of the depth are. Without, where a renderer names the channel, what its flat surfaces surely say, else
    /// planar; the log says which.
    #[arg(long, value_enum, value_name = "KIND")]
    depth_as: Option<DepthAs>,
    /// Distances in metres that black (0) and white (1) of a normalised depth stand for, e.g. 0.5,10, or 10,0.5 where white is
    /// near; with --depth-as inverse one may be `inf`.
    #[arg(long, value_name = "BLACK,WHITE")]
    depth_range: Option<Ends>,
    /// Stored depth that means that nothing was hit, so that the pixel is infinitely far, e.g. 0, -1, 1000 or nan. Infinity, 1e10
    /// and above, the largest half, and 0 where alpha is 0 mean so anyway.
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    background: Option<f32>,
    /// Leave the holes of a depth map; they are filled without from what is known around them, along the colours of the picture.
    #[arg(long, requires = "depth")]
    keep_holes: bool,
    /// What is done without --keep-holes.
    #[arg(long, requires = "depth", conflicts_with = "keep_holes", hide = true)]
    fill_holes: bool,
    /// Refuse pictures of more pixels than this.
    #[arg(long, value_name = "N", default_value_t = ReadOptions::MAX_PIXELS)]
    max_pixels: u64,
}

impl ReadArguments {
    /// The options as the reader takes them.
    pub(crate) fn options(&self, film: Option<Film>, metres_per_unit: Option<f64>) -> ReadOptions {
        // A range is typed in metres
        let metres_per_unit = metres_per_unit.or(self.depth_range.map(|_| 1.0));
        let convention = self.depth_as.map_or(DepthConvention::Planar, DepthConvention::from);
        ReadOptions {
            color: self.color.clone(),
            depth: self.depth.clone().filter(|name| !names_file(name)),
            view: self.view.clone(),
            convention,
            depth_range: self.depth_range(),
            background: self.background,
            film,
            metres_per_unit,
            max_pixels: self.max_pixels,
        }
    }

    /// The file of the depth map, where --depth names one.
    pub(crate) fn depth_file(&self) -> Option<PathBuf> {
        self.depth.as_deref().filter(|name| names_file(name)).map(PathBuf::from)
    }

    /// What the numbers of a map mean, where that is said.
    pub(crate) fn depth_as(&self) -> Option<DepthConvention> {
        self.depth_as.map(DepthConvention::from)
    }

    /// Distances at black and at white.
    pub(crate) fn depth_range(&self) -> Option<[f32; 2]> {
        self.depth_range.map(|Ends(ends)| ends)
    }

    /// The stored depth that is the sky.
    pub(crate) fn background(&self) -> Option<f32> {
        self.background
    }

    /// The channel of a map's file.
    pub(crate) fn depth_channel(&self) -> Option<&str> {
        self.depth_channel.as_deref()
    }

    /// Whether holes are to be filled.
    pub(crate) fn fills_holes(&self) -> bool {
        !self.keep_holes
    }

    /// The most pixels that are read.
    pub(crate) fn max_pixels(&self) -> u64 {
        self.max_pixels
    }
}

/// Whether what was typed for --depth is a file: it is there, or ends as pictures do, which channels do not.
fn names_file(name: &str) -> bool {
    let path = Path::new(name);
    path.is_file()
        || PhotoFormat::of_name(path).is_some()
        || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"))
}

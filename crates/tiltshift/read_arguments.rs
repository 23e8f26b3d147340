//! Options that say how an input picture is to be understood.

use clap::{Args, ValueEnum};
use optics::Film;
use rgbd::{DepthConvention, ReadOptions};

/// What the numbers of a depth channel mean.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum DepthAs {
    /// Along the sensor's normal.
    #[default]
    Planar,
    /// Along the ray of the pixel.
    Ray,
    /// One over planar depth.
    Inverse,
}

/// How an input picture is to be understood; all is detected without.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct ReadArguments {
    /// Layer or part to take colour from, e.g. ViewLayer.Combined.
    #[arg(long, value_name = "NAME")]
    color: Option<String>,
    /// Channel to take depth from, e.g. depth.Z, or PART/CHANNEL.
    #[arg(long, value_name = "NAME")]
    depth: Option<String>,
    /// View (eye) to take.
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// What the depth channel holds.
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    depth_as: DepthAs,
    /// Refuse pictures of more pixels than this.
    #[arg(long, value_name = "N", default_value_t = ReadOptions::MAX_PIXELS)]
    max_pixels: u64,
}

impl ReadArguments {
    /// The options as the reader takes them.
    pub(crate) fn options(&self, film: Option<Film>, metres_per_unit: Option<f64>) -> ReadOptions {
        let convention = match self.depth_as {
            DepthAs::Planar => DepthConvention::Planar,
            DepthAs::Ray => DepthConvention::Ray,
            DepthAs::Inverse => DepthConvention::Inverse,
        };
        ReadOptions {
            color: self.color.clone(),
            depth: self.depth.clone(),
            view: self.view.clone(),
            convention,
            film,
            metres_per_unit,
            max_pixels: self.max_pixels,
        }
    }
}

//! Which method filters, and with what settings.

use ::filter::{GatherSettings, Highlights, KernelRule, LensRaysSettings, Method, Sides};
use clap::{Args, ValueEnum};
use optics::KernelModel;

use crate::values::bytes;

/// Which method, and its settings.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodOptions {
    /// Rung of the ladder.
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,
    /// Shape of the footprint.
    #[arg(long, value_enum, default_value_t)]
    kernel: KernelName,
    /// Largest error in pixels that a simpler footprint may make (with --kernel auto).
    #[arg(long, value_name = "PX", default_value_t = KernelModel::DEFAULT_TOLERANCE_PX)]
    kernel_tolerance: f64,
    /// Largest radius (of the wider axis) of the circle of confusion in pixels; a quarter of the picture's width without.
    #[arg(long, value_name = "PX")]
    max_radius: Option<f32>,
    /// How many of the file's layers to use; all without.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    layers: Option<u16>,
    /// Blur what mirrors and glass show as if it lay on them, although the file knows its optical depth ("optical.Z", which
    /// `tiltshift render` writes).
    #[arg(long)]
    pub(super) no_optical_depth: bool,
    /// How many rays a pixel gets (with --method lens-rays).
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65536))]
    rays: u32,
    /// Blur this many times as much as the lens would, by a wider or narrower iris.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub(super) blur_scale: f64,
    /// What is blurred (methods gather, merged and lens-rays).
    #[arg(long, value_enum, default_value_t)]
    blur: Blur,
    /// Memory that filtering may take beside the picture itself, in bytes or with KiB, MiB, GiB: a larger picture goes
    /// through in bands, to the same bits.
    #[arg(long, value_name = "SIZE", value_parser = bytes, default_value = "4GiB")]
    pub(super) memory_limit: u64,
}

/// How much light clipped highlights get back.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Clipped highlights")]
pub(crate) struct HighlightOptions {
    /// Take what was clipped at white (1.0) to have been this many times as bright, so that lamps out of focus become
    /// bright discs; the result is not clipped again. For pictures made for a display; nothing is raised without.
    #[arg(long, value_name = "GAIN")]
    highlight_gain: Option<f32>,
    /// Linear value from which on a pixel counts as partly clipped (with --highlight-gain).
    #[arg(long, value_name = "VALUE", requires = "highlight_gain", allow_negative_numbers = true,
          default_value_t = Highlights::DEFAULT_THRESHOLD)]
    highlight_threshold: f32,
}

impl HighlightOptions {
    /// What was asked for, if anything.
    pub(super) fn highlights(&self) -> Result<Option<Highlights>, ::filter::FilterError> {
        self.highlight_gain.map(|gain| Highlights::new(gain, self.highlight_threshold)).transpose()
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum Blur {
    /// What is nearer and what is farther than the plane of focus.
    #[default]
    Both,
    /// Only what is nearer.
    Near,
    /// Only what is farther.
    Far,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum MethodName {
    /// No blur.
    Pinhole,
    /// Every pixel averages its own circle of confusion: fast, no occlusion.
    OwnCoc,
    /// Every neighbour whose footprint covers the pixel contributes, nearest first.
    Gather,
    /// The same with neighbours merged where the blur is large: as good, and fast.
    #[default]
    Merged,
    /// Rays through points of the iris, marched through the surfaces: the exact footprint, slow.
    LensRays,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum KernelName {
    /// The simplest that is good enough.
    #[default]
    Auto,
    /// Disc: as if the iris stood upright.
    Disc,
    /// Ellipse: the iris foreshortened.
    Ellipse,
    /// The exact footprint.
    Exact,
}

impl MethodOptions {
    /// The method as the library takes it.
    pub(super) fn method(&self, predict_error: bool) -> Method {
        let kernel = match self.kernel {
            KernelName::Auto => KernelRule::Auto { tolerance_px: self.kernel_tolerance },
            KernelName::Disc => KernelRule::Forced(KernelModel::Disc),
            KernelName::Ellipse => KernelRule::Forced(KernelModel::Ellipse),
            KernelName::Exact => KernelRule::Forced(KernelModel::Exact),
        };
        let layers = self.layers.map_or(usize::MAX, usize::from);
        let sides = match self.blur {
            Blur::Both => Sides::Both,
            Blur::Near => Sides::Near,
            Blur::Far => Sides::Far,
        };
        let settings = GatherSettings { kernel, max_radius_px: self.max_radius, layers, sides, predict_error };
        match self.method {
            MethodName::Pinhole => Method::Pinhole,
            MethodName::OwnCoc => Method::OwnCoc(settings),
            MethodName::Gather => Method::Gather(settings),
            MethodName::Merged => Method::Merged(settings),
            MethodName::LensRays => {
                let (samples, max_radius_px) = (self.rays, self.max_radius);
                Method::LensRays(LensRaysSettings { samples, max_radius_px, layers, sides, predict_error })
            }
        }
    }
}

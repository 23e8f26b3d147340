//! How much work a render puts in.

use anyhow::bail;
use clap::Args;
use optics::Camera;
use rgbd::{PixelWindow, ReadOptions, Truth};
use trace::{Accumulation, Goal, Job, LayerSettings, LayeredFrame, Margin, Scene, Shot};

use crate::console::{Bar, say};
use crate::values::{Size, positive};

/// How much work to put in.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Quality")]
pub(crate) struct Quality {
    /// Samples per pixel of the truth.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=131072))]
    pub(crate) spp: u32,
    /// Sample until the noise (RMS error of linear values) is at most this, instead of --spp; samples go where they count.
    #[arg(long, value_name = "RMSE", conflicts_with = "spp", value_parser = positive)]
    pub(crate) noise: Option<f64>,
    /// Most samples per pixel that --noise may take.
    #[arg(long, value_name = "N", default_value_t = 16384, requires = "noise",
          value_parser = clap::value_parser!(u32).range(2..=131072))]
    max_spp: u32,
    /// Layers of the RGB-D frame; all after the first hold what lies hidden.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=16))]
    layers: u8,
    /// Samples per pixel of the RGB-D frame's colour.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536))]
    rgbd_spp: u32,
    /// Overscan of the RGB-D frame in pixels on each side; what the lens needs, at most a quarter of the width, without.
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(0..=65536))]
    overscan: Option<u32>,
    /// Size of the picture in pixels; the shot's own without.
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Seed of the samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

impl Quality {
    /// The shot's camera, at the size that was asked for.
    pub(crate) fn camera(&self, shot: &Shot) -> anyhow::Result<Camera> {
        let camera = match self.size {
            Some(Size { width, height }) => Camera { film: shot.camera.film.resized(width, height)?, ..shot.camera },
            None => shot.camera,
        };
        // Refuse before anything is allocated
        let margin = self.overscan.unwrap_or(camera.film.width() / 4);
        let side = |pixels: u32| u64::from(pixels) + 2 * u64::from(margin);
        let pixels = side(camera.film.width()) * side(camera.film.height());
        if pixels > ReadOptions::MAX_PIXELS {
            bail!("the picture with its overscan has {pixels} pixels; at most {} will do", ReadOptions::MAX_PIXELS);
        }
        Ok(camera)
    }

    /// A seed that neither the truth nor the RGB-D frame uses.
    pub(crate) fn other_seed(&self) -> u64 {
        self.seed.wrapping_add(2)
    }

    /// When the truth is done.
    pub(crate) fn goal(&self) -> Goal {
        match self.noise {
            None => Goal::Samples(0..self.spp.div_ceil(2)),
            Some(rmse) => Goal::Noise { rmse, most: self.max_spp.div_ceil(2) },
        }
    }

    /// A render of the display window that has not begun.
    pub(crate) fn job(&self, camera: &Camera) -> Job {
        Job::new(*camera, PixelWindow::of_size(camera.film.width(), camera.film.height()), self.seed)
    }

    /// The ground truth over the display window.
    pub(crate) fn truth(&self, scene: &Scene, camera: &Camera) -> anyhow::Result<Truth> {
        let mut job = self.job(camera);
        job.run(scene, &self.goal(), &Bar::new("trace the truth"))?;
        self.say_noise(job.sums());
        Ok(job.into_sums().to_truth()?)
    }

    /// Says how noisy a truth is, and what it took.
    pub(crate) fn say_noise(&self, sums: &Accumulation) {
        let counts = sums.window().pixels().map(|(x, y)| sums.samples_at(x, y).into_iter().sum::<u32>());
        let (least, most) = counts.fold((u32::MAX, 0), |(least, most), count| (least.min(count), most.max(count)));
        let noise = sums.noise();
        let spp = if least == most {
            least.to_string()
        } else {
            let mean = sums.samples() as f64 / sums.window().area() as f64;
            format!("{least} to {most}, on average {mean:.0}")
        };
        say(format_args!("truth: {spp} samples per pixel, noise (RMS error of the mean) {noise:.5}"));
        if self.noise.is_some_and(|wanted| noise > wanted) {
            say(format_args!("  the noise is still above what was asked; --max-spp allows more than {}", self.max_spp));
        }
    }

    /// The RGB-D frame.
    pub(crate) fn layers(&self, scene: &Scene, camera: &Camera) -> anyhow::Result<LayeredFrame> {
        let margin = self.overscan.map_or(LayerSettings::default().margin, Margin::Pixels);
        let count = usize::from(self.layers);
        let settings = LayerSettings { count, margin, color_samples: self.rgbd_spp, seed: self.seed.wrapping_add(1) };
        Ok(trace::layers(scene, camera, &settings, &Bar::new("trace colour and depth"))?)
    }
}

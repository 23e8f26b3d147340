//! `tiltshift render`: a scene traced through the lens.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use optics::{Camera, ThinLens};
use rgbd::{PixelWindow, ReadOptions, Truth, write_frame, write_png, write_truth};
use trace::{LayerSettings, LayeredFrame, Margin, Scene, SceneFile, Shot};

use crate::command::filter::sensor_mm;
use crate::console::{Bar, print, say};
use crate::failure::Outcome;
use crate::files::{Packing, expect_exr, make_folder_of, notes, refuse_overwriting, write_options};
use crate::values::{Size, positive, stops};

/// Trace a scene through a tilted lens.
///
/// Writes the ground truth (two independent halves, so that it knows its own noise) and the RGB-D frame that a filter
/// needs: colour and depth in layers, with overscan.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Shot to take; the file's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// List the shots of the scene and stop.
    #[arg(long)]
    list: bool,
    /// Where to write the truth; `out/SCENE_SHOT.exr` without.
    #[arg(long, short, value_name = "FILE.exr")]
    output: Option<PathBuf>,
    /// Where to write the RGB-D frame; `out/SCENE_SHOT_rgbd.exr` without.
    #[arg(long, value_name = "FILE.exr")]
    rgbd: Option<PathBuf>,
    /// Also write the truth as 8-bit sRGB PNG.
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Exposure of the PNG in stops.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// How the EXRs are packed.
    #[arg(long, value_enum, default_value_t)]
    compression: Packing,
    #[command(flatten)]
    quality: Quality,
}

/// How much work to put in.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Quality")]
pub(crate) struct Quality {
    /// Samples per pixel of the truth.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=131072))]
    spp: u32,
    /// Sample until the noise (RMS error of linear values) is at most this, instead of --spp.
    #[arg(long, value_name = "RMSE", conflicts_with = "spp", value_parser = positive)]
    noise: Option<f64>,
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
    size: Option<Size>,
    /// Seed of the samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = SceneFile::open(&options.scene)?;
    if options.list {
        list(&file);
        return Ok(());
    }
    let shot = file.shot(options.shot.as_deref())?;
    let camera = options.quality.camera(shot)?;

    // Name the files after scene and shot
    let scene = options.scene.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let name = [Some(scene), options.shot.clone()]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join("_")
        .replace(['/', '\\'], "_");
    let truth_path = options.output.clone().unwrap_or_else(|| format!("out/{name}.exr").into());
    let rgbd_path = options.rgbd.clone().unwrap_or_else(|| format!("out/{name}_rgbd.exr").into());
    expect_exr(&truth_path)?;
    expect_exr(&rgbd_path)?;
    let outputs = [Some(truth_path.as_path()), Some(rgbd_path.as_path()), options.png.as_deref()];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().collect();
    refuse_overwriting(&[&options.scene], &outputs)?;
    for output in outputs {
        make_folder_of(output)?;
    }
    let lens = lens_in_metres(shot, file.scene())?;
    let sensor = lens.map(|lens| sensor_mm(&camera, &lens));
    let from = [("scene", options.scene.display().to_string()), ("shot", options.shot.clone().unwrap_or_default())];
    let write = write_options(options.compression, lens.as_ref(), sensor, notes(from));

    // Trace, and write each part as soon as it is there
    let truth = options.quality.truth(file.scene(), &camera)?;
    say_noise(&truth);
    write_truth(&truth_path, &truth, &write)?;
    say(format_args!("wrote {}", truth_path.display()));
    if let Some(png) = &options.png {
        write_png(png, &truth.picture(), options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    let layered = options.quality.layers(file.scene(), &camera)?;
    say_layers(&layered);
    write_frame(&rgbd_path, &layered.frame, &write)?;
    say(format_args!("wrote {}", rgbd_path.display()));
    Ok(())
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

    /// The ground truth over the display window.
    pub(crate) fn truth(&self, scene: &Scene, camera: &Camera) -> anyhow::Result<Truth> {
        let display = PixelWindow::of_size(camera.film.width(), camera.film.height());
        let bar = Bar::new("trace the truth");
        let Some(noise) = self.noise else {
            return Ok(trace::truth(scene, camera, display, self.spp, self.seed, &bar)?);
        };
        let truth = trace::truth_to_noise(scene, camera, display, noise, self.max_spp, self.seed, &bar)?;
        if truth.noise_rmse(display) > noise {
            say(format_args!(
                "the noise is still above {noise} after {} samples per pixel; --max-spp allows more",
                self.max_spp
            ));
        }
        Ok(truth)
    }

    /// The RGB-D frame.
    pub(crate) fn layers(&self, scene: &Scene, camera: &Camera) -> anyhow::Result<LayeredFrame> {
        let margin = self.overscan.map_or(LayerSettings::default().margin, Margin::Pixels);
        let count = usize::from(self.layers);
        let settings = LayerSettings { count, margin, color_samples: self.rgbd_spp, seed: self.seed.wrapping_add(1) };
        Ok(trace::layers(scene, camera, &settings, &Bar::new("trace colour and depth"))?)
    }
}

/// The shot's lens in metres, where it has one.
pub(crate) fn lens_in_metres(shot: &Shot, scene: &Scene) -> anyhow::Result<Option<ThinLens>> {
    let (Some(lens), Some(metres)) = (shot.lens, scene.metres_per_unit()) else { return Ok(None) };
    Ok(Some(lens.scaled(metres).context("metres_per_unit of the scene")?))
}

/// Says how noisy a truth is.
pub(crate) fn say_noise(truth: &Truth) {
    let noise = truth.noise_rmse(truth.display);
    let spp = truth.samples[0] + truth.samples[1];
    say(format_args!("truth: {spp} samples per pixel, noise (RMS error of the mean) {noise:.5}"));
}

/// Says what the RGB-D frame holds.
pub(crate) fn say_layers(layered: &LayeredFrame) {
    let [columns, rows] = layered.margin;
    let frame = &layered.frame;
    let hidden: usize = frame.layers()[1..].iter().map(|layer| layer.known.count()).sum();
    let share = 100.0 * hidden as f64 / frame.data().area() as f64;
    say(format_args!(
        "RGB-D: {} layers, {share:.1} % of the pixels hide something; overscan {columns} x {rows} px",
        frame.layers().len()
    ));
    if layered.is_capped() {
        let [columns, rows] = layered.needed_margin;
        say(format_args!(
            "  the lens would need {columns} x {rows} px; the border will be less true (--overscan sets it)"
        ));
    }
}

fn list(file: &SceneFile) {
    print(file.description());
    let width = file.shots().keys().map(String::len).max().unwrap_or(0);
    for (name, shot) in file.shots() {
        let film = shot.camera.film;
        print(format_args!("  {name:width$}  {}x{}  {}", film.width(), film.height(), shot.description));
    }
}

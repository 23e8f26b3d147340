//! `tiltshift hybrid`: filtered, and traced where that would be wrong.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::Args;
use optics::Camera;
use rgbd::{Head, ReadOptions, read_frame, write_picture_with, write_png};
use study::HybridSettings;
use trace::{LayerSettings, SceneFile};

use crate::command::filter::sensor_mm;
use crate::command::render::{lens_in_metres, say_layers};
use crate::console::{Bar, say};
use crate::failure::Outcome;
use crate::files::{Packing, expect_exr, make_folder_of, notes, refuse_overwriting, write_options};
use crate::values::{Size, stops};

/// Filter a shot of a scene, and trace the pixels that the filter predicts to get wrong.
///
/// Writes the picture with two further channels: "predicted_error" of the filter (RMS over R, G and B of linear values) and
/// "traced", how much of each pixel comes from the tracer, 0 to 1.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Shot to take; the file's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// Where to write the picture.
    #[arg(long, short, value_name = "FILE.exr", default_value = "out/hybrid.exr")]
    output: PathBuf,
    /// Also write an 8-bit sRGB PNG.
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Exposure of the PNG in stops.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// Predicted error (RMS over R, G and B of linear values) that the filter may leave in a pixel: 0 traces all, inf
    /// nothing.
    #[arg(long, value_name = "RMSE", value_parser = tolerance, default_value_t = HybridSettings::default().tolerance)]
    tolerance: f32,
    /// Samples of a pixel that is traced alone; pixels that are mixed get fewer.
    #[arg(long, value_name = "N", default_value_t = HybridSettings::default().samples,
          value_parser = clap::value_parser!(u32).range(2..=131_072))]
    samples: u32,
    /// RGB-D frame of this very shot (of `tiltshift render`), instead of one traced here.
    #[arg(long, value_name = "FILE.exr", conflicts_with_all = ["size", "rgbd_spp"])]
    rgbd: Option<PathBuf>,
    /// Samples per pixel of the RGB-D frame's colour.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536))]
    rgbd_spp: u32,
    /// Size of the picture in pixels; the shot's own without.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Seed of the samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// A tolerance: 0, a positive number or `inf`.
pub(crate) fn tolerance(text: &str) -> anyhow::Result<f32> {
    match text.trim().parse::<f32>() {
        Ok(number) if number >= 0.0 => Ok(number),
        _ => bail!("{text:?} is no tolerance; it must be 0, a positive number or inf"),
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = SceneFile::open(&options.scene)?;
    let shot = file.shot(options.shot.as_deref())?;
    // No method here knows motion blur: all see the middle of the exposure
    let scene = &file.scene_of(shot).stopped();
    expect_exr(&options.output)?;
    let inputs: Vec<_> =
        [Some(&options.scene), options.rgbd.as_ref()].into_iter().flatten().map(PathBuf::as_path).collect();
    let outputs: Vec<_> =
        [Some(&options.output), options.png.as_ref()].into_iter().flatten().map(PathBuf::as_path).collect();
    refuse_overwriting(&inputs, &outputs)?;
    for output in outputs {
        make_folder_of(output)?;
    }

    // Get colour and depth, of a frame's size or of the size that was asked for
    let (camera, frame) = match &options.rgbd {
        Some(path) => {
            let frame = read_frame(path, &ReadOptions::default())?.value;
            let camera = frame.camera.ok_or_else(|| anyhow!("{path:?} does not say what camera took it"))?;
            let asked =
                Camera { film: shot.camera.film.resized(camera.film.width(), camera.film.height())?, ..shot.camera };
            if camera != asked {
                return Err(anyhow!("{path:?} was not taken by this shot's camera").into());
            }
            (camera, frame.covering(rgbd::PixelWindow::of_size(camera.film.width(), camera.film.height())))
        }
        None => {
            let camera = match options.size {
                Some(Size { width, height }) => {
                    Camera { film: shot.camera.film.resized(width, height)?, ..shot.camera }
                }
                None => shot.camera,
            };
            let seed = options.seed.wrapping_add(1);
            let settings = LayerSettings { color_samples: options.rgbd_spp, seed, ..LayerSettings::default() };
            let layered = trace::layers(scene, &camera, &settings, &Bar::new("trace colour and depth"))?;
            say_layers(&layered);
            (camera, layered.frame)
        }
    };

    // Filter, and trace where that is not enough
    let HybridSettings { layers, .. } = HybridSettings::default();
    let settings =
        HybridSettings { tolerance: options.tolerance, samples: options.samples, layers, seed: options.seed };
    let started = Instant::now();
    let hybrid = study::hybrid(scene, &camera, &frame, &settings, &Bar::new("filter and trace"))?;
    let seconds = started.elapsed().as_secs_f64();
    let (share, rays) = (100.0 * hybrid.traced_share(), hybrid.mean_samples);
    say(format_args!(
        "traced {share:.1} % of the pixels, {rays:.1} rays for each pixel of the picture; {seconds:.2} s"
    ));

    // Write what came out
    let lens = lens_in_metres(shot, file.scene())?;
    let sensor = lens.map(|lens| sensor_mm(&camera, &lens));
    let made = [("tolerance", options.tolerance.to_string()), ("samples", options.samples.to_string())];
    let write = write_options(Packing::default(), lens.as_ref(), sensor, notes(made));
    let head = Head { camera: Some(camera), ..Head::from(&frame) };
    let planes = [("predicted_error", &hybrid.predicted_error), ("traced", &hybrid.weight)];
    write_picture_with(&options.output, &hybrid.picture, &planes, &head, &write)?;
    say(format_args!("wrote {}", options.output.display()));
    if let Some(png) = &options.png {
        write_png(png, &hybrid.picture, options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    Ok(())
}

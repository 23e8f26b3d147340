//! `tiltshift merge`: parts of a render into one.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use rgbd::{LensAttributes, PixelWindow, ReadOptions, WriteOptions, write_png, write_truth};
use trace::{Accumulation, Part};

use crate::console::say;
use crate::failure::Outcome;
use crate::files::{Packing, expect_exr, make_folder_of, notes, refuse_overwriting};
use crate::values::stops;

/// Join parts of a render (`render --samples` and `--crop`, or stopped renders) to the bits of one run.
///
/// In each pixel the parts' samples must follow each other. The truth is written when every pixel has samples.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Parts of one picture, in any order.
    #[arg(required = true, value_name = "PART.exr")]
    parts: Vec<PathBuf>,
    /// Where to write the truth.
    #[arg(long, short, value_name = "FILE.exr")]
    output: PathBuf,
    /// Also write it as 8-bit sRGB PNG.
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Exposure of the PNG in stops.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// How the EXR is packed.
    #[arg(long, value_enum, default_value_t)]
    compression: Packing,
}

pub(crate) fn run(options: &Options) -> Outcome {
    expect_exr(&options.output)?;
    let inputs: Vec<&Path> = options.parts.iter().map(PathBuf::as_path).collect();
    let outputs = [Some(options.output.as_path()), options.png.as_deref()];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().collect();
    refuse_overwriting(&inputs, &outputs)?;

    // Join them
    let mut sums = Vec::new();
    let mut of_first = None;
    for path in &options.parts {
        let part = Part::read(path, ReadOptions::MAX_PIXELS)?;
        if of_first.get_or_insert((part.scene, part.lens)).0 != part.scene {
            return Err(anyhow::anyhow!("{path:?} is of another scene than {:?}", options.parts[0]).into());
        }
        sums.push(part.job.into_sums());
    }
    let sums = Accumulation::join(sums).context("the parts do not join")?;
    expect_whole(&sums)?;
    let truth = sums.to_truth()?;

    // Write what they make
    outputs.into_iter().try_for_each(make_folder_of)?;
    let from = options.parts.iter().map(|part| part.display().to_string()).collect::<Vec<_>>().join(" ");
    let lens = of_first.map_or_else(LensAttributes::default, |(_, lens)| lens);
    let write = WriteOptions { compression: options.compression.into(), lens, notes: notes([("parts", from)]) };
    write_truth(&options.output, &truth, &write)?;
    let spp = truth.samples[0] + truth.samples[1];
    let noise = truth.noise_rmse(truth.display);
    say(format_args!(
        "{} parts: {spp} samples per pixel, noise (RMS error of the mean) {noise:.5}",
        options.parts.len()
    ));
    say(format_args!("wrote {}", options.output.display()));
    if let Some(png) = &options.png {
        write_png(png, &truth.picture(), options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    Ok(())
}

/// Fails if some pixel of the picture has no sample.
fn expect_whole(sums: &Accumulation) -> anyhow::Result<()> {
    let film = sums.camera().film;
    let display = PixelWindow::of_size(film.width(), film.height());
    let mut empty = display.pixels().filter(|&(x, y)| sums.samples_at(x, y).contains(&0));
    let Some((x, y)) = empty.next() else { return Ok(()) };
    let count = 1 + empty.count();
    bail!(
        "{count} of the picture's {} pixels have no samples, the first at ({x}, {y}); a part is missing",
        display.area()
    );
}

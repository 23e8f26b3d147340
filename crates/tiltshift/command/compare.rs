//! `tiltshift compare`: how far pictures are from a reference, and where.

mod limit;

use std::path::{Path, PathBuf};

use ::compare::{Comparison, CorrectedError, Entry, GivenNoise, Masks, Parameter, Reference, Report};
use anyhow::Context;
use clap::Args;
use optics::Camera;
use rgbd::{Frame, Loaded, PixelWindow, ReadError, ReadOptions, read_frame, read_picture, read_truth};

use crate::command::compare::limit::{Limit, Metric};
use crate::console::{is_interrupted, print, say};
use crate::failure::{Failure, Outcome};
use crate::files::{command_line, make_folder, write_text};
use crate::values::{finite, positive, stops};

/// Say how far pictures are from a reference, and where.
///
/// Figures are of linear values. The reference's own noise is subtracted where it is known: a truth of `tiltshift
/// render` knows its own.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Reference: a truth of `tiltshift render`, or any picture (OpenEXR).
    reference: PathBuf,
    /// Pictures to compare with it (OpenEXR).
    #[arg(required = true)]
    candidates: Vec<PathBuf>,
    /// RGB-D frame of the same view: masks edges and interior, and adds the unfiltered picture.
    #[arg(long, value_name = "FILE.exr")]
    rgbd: Option<PathBuf>,
    /// Width in pixels of the band around depth edges; the largest circle of confusion's radius, at least 8, without.
    #[arg(long, value_name = "PX", requires = "rgbd", value_parser = positive)]
    edge_reach: Option<f64>,
    /// Mean squared error of the reference's own noise, where it does not know it.
    #[arg(long, value_name = "MSE", value_parser = positive)]
    noise_mse: Option<f64>,
    /// Folder for report.html and report.json.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Exposure of the report's pictures in stops.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// Print the figures as JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Exit with code 1 if any candidate's RMS error over the whole picture is larger.
    #[arg(long, value_name = "RMSE", value_parser = positive)]
    max_rmse: Option<f64>,
    /// Exit with code 1 if any candidate's PSNR over the whole picture is lower.
    #[arg(long, value_name = "DB", value_parser = finite)]
    min_psnr: Option<f64>,
    /// Exit with code 1 if any candidate is worse than this over the whole picture: rmse, mae, relmse, flip (LDR), hdr-flip above
    /// the value, psnr or ssim below it; such as flip=0.05,psnr=35dB.
    #[arg(long, value_name = "METRIC=VALUE,...", value_delimiter = ',')]
    fail_above: Vec<Limit>,
}

/// A reference picture as read.
struct Read {
    reference: Reference,
    camera: Option<Camera>,
}

pub(crate) fn run(options: &Options) -> Outcome {
    if let Some(folder) = &options.report {
        make_folder(folder)?;
    }
    let Read { reference, camera } = read_reference(options)?;
    let display = reference.display();

    // Draw the masks from the depth, with the camera of whichever file knows it
    let frame = options.rgbd.as_deref().map(|path| read_rgbd(path, display)).transpose()?;
    let (pictures, cameras): (Vec<_>, Vec<_>) = options
        .candidates
        .iter()
        .map(|path| read_candidate(path, display))
        .collect::<Result<Vec<_>, Failure>>()?
        .into_iter()
        .unzip();
    let masks = match &frame {
        Some(frame) => {
            let camera = frame.camera.or(camera).or(cameras.into_iter().flatten().next());
            let camera = camera.with_context(|| {
                "none of the files says what lens was used, so that there is no telling where its edges are; leave --rgbd out"
            })?;
            Masks::from_frame(frame, &camera, options.edge_reach)?
        }
        None => Masks::without_depth(display),
    };
    let masks = masks.with_highlights(&reference);

    // Compare
    let entry = |name: String, note: &str, picture: &rgbd::Picture| {
        if is_interrupted() {
            return Err(Failure::Interrupted);
        }
        let comparison = Comparison::new(&reference, picture, &masks)?;
        if comparison.non_finite > 0 {
            say(format_args!("{name}: {} pixels are not finite, taken as 0", comparison.non_finite));
        }
        Ok::<_, Failure>(Entry { name, note: note.to_owned(), comparison })
    };
    let unfiltered = match &frame {
        Some(frame) => {
            let picture = frame.layers()[0].color.cropped(display);
            Some(entry("unfiltered".to_owned(), "colour of the RGB-D frame: no depth of field", &picture)?)
        }
        None => None,
    };
    // Files of one name in several folders go by their paths
    let stems: Vec<String> = options.candidates.iter().map(|path| short_name(path)).collect();
    let is_unique = |stem: &String| stems.iter().filter(|other| *other == stem).count() == 1;
    let name_of = |path: &Path| Some(short_name(path)).filter(is_unique).unwrap_or_else(|| path.display().to_string());
    let named = options.candidates.iter().zip(&pictures);
    let candidates = named.map(|(path, picture)| entry(name_of(path), "", picture)).collect::<Result<Vec<_>, _>>()?;

    if is_interrupted() {
        return Err(Failure::Interrupted);
    }
    let report = Report {
        title: format!("{} against {}", names(&options.candidates), short_name(&options.reference)),
        about: String::new(),
        reference_name: short_name(&options.reference),
        reference: &reference,
        masks: &masks,
        unfiltered,
        candidates,
        exposure_stops: options.exposure,
        parameters: vec![Parameter::new("reference", options.reference.display())],
        commands: vec![command_line()],
    };
    if options.json {
        print(serde_json::to_string_pretty(&report.to_json()).context("figures as JSON")?);
    } else {
        print_table(&report);
    }
    if let Some(folder) = &options.report {
        write_report(&report, folder)?;
    }
    thresholds(options, &report)
}

/// Writes report.html and report.json into a folder.
pub(crate) fn write_report(report: &Report, folder: &Path) -> Outcome {
    make_folder(folder)?;
    let page = folder.join("report.html");
    write_text(&page, &report.to_html()?)?;
    let json = serde_json::to_string_pretty(&report.to_json()).context("figures as JSON")?;
    write_text(&folder.join("report.json"), &json)?;
    say(format_args!("wrote {}", page.display()));
    Ok(())
}

/// Prints the figures of all pictures over all masks.
pub(crate) fn print_table(report: &Report) {
    let entries: Vec<&Entry> = report.unfiltered.iter().chain(&report.candidates).collect();
    let width = entries.iter().map(|entry| entry.name.len()).max().unwrap_or(0).max(10);
    for kind in report.masks.kinds() {
        let noise = match report.reference.noise_mse(report.masks, kind) {
            Some(mse) => format!("reference noise {:.5}", mse.sqrt()),
            None => "reference noise unknown".to_owned(),
        };
        print(format_args!(
            "{} ({:.1} % of the pixels; {noise})",
            kind.name().replace('_', " "),
            100.0 * report.masks.share(kind)
        ));
        print(format_args!(
            "  {:width$}  {:>9}  {:>14}  {:>14}  {:>8}  {:>8}  {:>6}  {:>8}  {:>8}",
            "", "RMSE", "PSNR dB", "95 % sure", "MAE", "relMSE", "SSIM", "FLIP", "HDR-FLIP"
        ));
        for entry in &entries {
            let Some(figures) = entry.comparison.within(kind) else { continue };
            let (rmse, psnr) = match figures.corrected {
                CorrectedError::Above { mse, .. } => {
                    (format!("{:.5}", mse.sqrt()), format!("{:.2}", ::compare::psnr_db(mse)))
                }
                CorrectedError::BelowNoise { at_most } => (format!("<{:.5}", at_most.sqrt()), "below noise".to_owned()),
                CorrectedError::UnknownNoise => (format!("{:.5}", figures.rmse()), format!("{:.2}", figures.psnr_db())),
            };
            let sure = figures.intervals.corrected_mse.map_or_else(String::new, |mse| {
                format!("{:.2} to {:.2}", ::compare::psnr_db(mse.high), ::compare::psnr_db(mse.low))
            });
            print(format_args!(
                "  {:width$}  {rmse:>9}  {psnr:>14}  {sure:>14}  {:8.5}  {:8.5}  {:6.4}  {:8.5}  {:8.5}",
                entry.name, figures.mae, figures.rel_mse, figures.ssim, figures.flip_ldr, figures.flip_hdr
            ));
        }
    }
}

fn read_reference(options: &Options) -> Result<Read, Failure> {
    let path = &options.reference;
    match read_truth(path, ReadOptions::MAX_PIXELS) {
        Ok(Loaded { value: truth, .. }) => {
            if options.noise_mse.is_some() {
                say(format_args!("{} knows its own noise; --noise-mse is not used", path.display()));
            }
            Ok(Read { reference: Reference::from_truth(&truth)?, camera: truth.camera })
        }
        Err(ReadError::WrongKind { .. }) => {
            let Loaded { value: picture, head, .. } = read_picture(path, &ReadOptions::default())?;
            let noise = GivenNoise { all: options.noise_mse, ..GivenNoise::default() };
            Ok(Read { reference: Reference::from_picture(&picture, head.display, noise)?, camera: head.camera })
        }
        Err(error) => Err(error.into()),
    }
}

/// The frame, with data for the whole picture.
fn read_rgbd(path: &Path, display: PixelWindow) -> Result<Frame, Failure> {
    let frame = read_frame(path, &ReadOptions::default())?.value;
    if frame.display != display {
        let text = format!("{path:?} shows {}, the reference {display}; they must be of one view", frame.display);
        return Err(anyhow::Error::msg(text).into());
    }
    Ok(frame.covering(display))
}

/// A picture over the reference's display window, and its camera.
pub(crate) fn read_candidate(path: &Path, display: PixelWindow) -> Result<(rgbd::Picture, Option<Camera>), Failure> {
    let Loaded { value: picture, head, .. } = read_picture(path, &ReadOptions::default())?;
    if head.display != display {
        let text = format!("{path:?} shows {}, the reference {display}; pictures must be of one size", head.display);
        return Err(anyhow::Error::msg(text).into());
    }
    Ok((picture.covering(picture.window().union(&display)).cropped(display), head.camera))
}

/// Fails if any candidate exceeds a threshold over the whole picture; names them all.
fn thresholds(options: &Options, report: &Report) -> Outcome {
    let limits: Vec<Limit> = [
        options.max_rmse.map(|value| Limit { metric: Metric::Rmse, value }),
        options.min_psnr.map(|value| Limit { metric: Metric::Psnr, value }),
    ]
    .into_iter()
    .flatten()
    .chain(options.fail_above.iter().copied())
    .collect();
    let failures = report.candidates.iter().flat_map(|entry| {
        limits.iter().filter_map(|limit| Some(format!("{}: {}", entry.name, limit.exceeded(entry.comparison.all())?)))
    });
    let exceeded: Vec<String> = failures.collect();
    if exceeded.is_empty() { Ok(()) } else { Err(Failure::Exceeded(exceeded.join("; "))) }
}

fn short_name(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

fn names(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| short_name(path)).collect::<Vec<_>>().join(", ")
}

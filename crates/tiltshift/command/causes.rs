//! `tiltshift causes`: why the filter is wrong.

use std::path::{Path, PathBuf};

use ::compare::{MaskKind, Masks, Reference};
use anyhow::{Context, bail};
use clap::Args;
use optics::Camera;
use rgbd::{PixelWindow, write_png};
use study::{Cause, Causes, CausesReport, CausesSettings, causes};
use trace::{Scene, SceneFile};

use crate::command::chart::subject_name;
use crate::console::{Bar, is_interrupted, print, say};
use crate::failure::{Failure, Outcome};
use crate::files::{command_line, make_folder, write_text};
use crate::values::Size;

/// Say why the filter is wrong on a shot of a scene: every named cause's share of its squared error.
///
/// One fixed chain of experiments gives the filter what a real frame lacks, one thing more at each step; a share is the
/// drop of the squared error at its step, in the chain and in the chain reversed. The truth's noise is in no error. Leaves
/// for each shot SCENE_SHOT.html, .json and a map for the filter with one layer and with two, and causes.csv for all.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Shots to take; the file's own camera without.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    shot: Vec<String>,
    /// Take every shot in which something is blurred.
    #[arg(long, conflicts_with = "shot")]
    every_shot: bool,
    /// Folder for pages, maps and figures.
    #[arg(long, value_name = "DIR", default_value = "out/causes")]
    out: PathBuf,
    /// Size of the picture in pixels; half the shot's own width and height without.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Samples per pixel of the truth.
    #[arg(long, value_name = "N", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(2..=131_072))]
    truth_samples: u32,
    /// Samples per pixel of the RGB-D frame's colour.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=16_384))]
    rgbd_spp: u32,
    /// Overscan of the shipped frame in pixels on each side; what the lens needs, at most a quarter of the width, without.
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(0..=65_536))]
    overscan: Option<u32>,
    /// Finer pixels along the side of a pixel in the experiments.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..=8))]
    fine: u32,
    /// Lens rays of each finer pixel in the last experiment.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1024))]
    lens_rays: u32,
    /// Seed of the samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let file = SceneFile::open(&options.scene)?;
    let shots: Vec<Option<&str>> = if options.every_shot {
        file.shots().iter().filter(|(_, shot)| shot.camera.iris.radius() > 0.0).map(|(name, _)| Some(&**name)).collect()
    } else if options.shot.is_empty() {
        vec![None]
    } else {
        options.shot.iter().map(|name| Some(name.as_str())).collect()
    };
    // Find what is wrong with any of them before hours of work
    let views = shots.iter().map(|&name| {
        // No method here knows motion blur: all see the middle of the exposure
        let shot = file.shot(name)?;
        Ok((name, options.camera(shot.camera)?, file.scene_of(shot).stopped()))
    });
    let views = views.collect::<anyhow::Result<Vec<_>>>()?;
    make_folder(&options.out)?;

    let mut csv = csv_heading();
    for (shot, camera, scene) in views {
        let subject = subject_name(&options.scene, shot);
        let taken = take(options, &scene, &camera, &subject)?;
        for of_filter in &taken {
            csv.push_str(&csv_row(&subject, of_filter));
        }
    }
    let path = options.out.join("causes.csv");
    write_text(&path, &csv)?;
    say(format_args!("wrote {}", path.display()));
    Ok(())
}

impl Options {
    /// A shot's camera at the size that is studied.
    fn camera(&self, camera: Camera) -> anyhow::Result<Camera> {
        if camera.iris.radius() == 0.0 {
            bail!("the shot's lens is a pinhole: nothing is blurred, and nothing can be wrong");
        }
        let half = |side: u32| side.div_ceil(2);
        let [width, height] = match self.size {
            Some(Size { width, height }) => [width, height],
            None => [half(camera.film.width()), half(camera.film.height())],
        };
        let fine = u64::from(width) * u64::from(height) * u64::from(self.fine * self.fine);
        const MOST: u64 = 1 << 24;
        if fine > MOST {
            bail!(
                "{width}x{height} pixels, each of {} finer ones, are {fine}; at most {MOST} will do",
                self.fine * self.fine
            );
        }
        Ok(Camera { film: camera.film.resized(width, height)?, ..camera })
    }
}

/// Studies one shot.
fn take(options: &Options, scene: &Scene, camera: &Camera, subject: &str) -> Result<[Causes; 2], Failure> {
    let display = PixelWindow::of_size(camera.film.width(), camera.film.height());
    let bar = Bar::new(format!("{subject}: truth"));
    let truth = trace::truth(scene, camera, display, options.truth_samples, options.seed, &bar)?;
    drop(bar);
    let reference = Reference::from_truth(&truth)?;

    let shipped = CausesSettings::shipped(camera);
    let settings = CausesSettings {
        color_samples: options.rgbd_spp,
        margin: options.overscan.map_or(shipped.margin, |pixels| [pixels; 2]),
        fine: options.fine,
        lens_samples: options.lens_rays,
        seed: options.seed.wrapping_add(1),
        ..shipped
    };
    let bar = Bar::new(format!("{subject}: causes"));
    let taken = causes(scene, camera, &reference, &settings, &bar)?;
    drop(bar);
    if is_interrupted() {
        return Err(Failure::Interrupted);
    }
    let noise_mse = reference.noise_mse(&Masks::without_depth(display), MaskKind::All).unwrap_or(0.0);
    print_shares(subject, noise_mse, &taken);

    // Leave page, figures and maps
    let report = CausesReport {
        subject: subject.to_owned(),
        command: command_line(),
        noise_mse,
        truth_samples: options.truth_samples,
        settings,
        causes: &taken,
    };
    let path =
        |ending: &str| options.out.join(format!("{}{ending}", subject.replace(", ", "_").replace(['/', '\\'], "_")));
    let json = serde_json::to_string_pretty(&report.to_json()).context("figures as JSON")?;
    write_text(&path(".json"), &(json + "\n"))?;
    for of_filter in &taken {
        let layers = of_filter.layers;
        let write = |name: &str, picture| write_png(&path(&format!("_{layers}_{name}.png")), picture, 0.0);
        write("map", &of_filter.shares.draw())?;
    }
    let page: &Path = &path(".html");
    write_text(page, &report.to_html()?)?;
    say(format_args!("wrote {}", page.display()));
    Ok(taken)
}

/// Prints the shares of both filters in per cent, the chain's and the reversed one's.
fn print_shares(subject: &str, noise_mse: f64, taken: &[Causes; 2]) {
    print(format_args!(
        "{subject}: squared error in %, chain / reversed; truth's noise {:.5} taken off",
        noise_mse.sqrt()
    ));
    print(format_args!("  {:28}  {:>20}  {:>20}", "", "one layer", "two layers"));
    let row = |name: &str, cell: &dyn Fn(&Causes) -> String| {
        print(format_args!("  {name:28}  {:>20}  {:>20}", cell(&taken[0]), cell(&taken[1])));
    };
    row("RMSE", &|of| format!("{:.5}", of.shares.mse.max(0.0).sqrt()));
    for cause in Cause::EVERY {
        row(cause.name(), &|of| {
            let share = of.shares.causes.iter().find(|share| share.cause == cause);
            share.map_or_else(String::new, |s| format!("{:.1} / {:.1}", 100.0 * s.forward, 100.0 * s.reversed))
        });
    }
    row("rest", &|of| format!("{:.1} ± {:.1}", 100.0 * of.shares.rest, 100.0 * of.shares.rest_standard_error));
    row("in unexplained pixels", &|of| format!("{:.1}", 100.0 * of.shares.unexplained));
}

fn csv_heading() -> String {
    let causes = Cause::EVERY.map(|cause| {
        let name = cause.name().replace(' ', "_");
        format!("{name},{name}_reversed,{name}_explains")
    });
    format!("subject,layers,kernel,rmse,{},rest,rest_se,several,unexplained\n", causes.join(","))
}

fn csv_row(subject: &str, of_filter: &Causes) -> String {
    let shares = &of_filter.shares;
    let mut cells = vec![format!("\"{subject}\""), of_filter.layers.to_string()];
    cells.push(format!("{:?}", of_filter.kernel).to_lowercase());
    cells.push(shares.mse.max(0.0).sqrt().to_string());
    for cause in Cause::EVERY {
        match shares.causes.iter().find(|share| share.cause == cause) {
            Some(s) => cells.extend([s.forward, s.reversed, s.explains].map(|share| format!("{share:.5}"))),
            None => cells.extend([const { String::new() }; 3]),
        }
    }
    let ends = [shares.rest, shares.rest_standard_error, shares.several, shares.unexplained];
    cells.extend(ends.map(|share| format!("{share:.5}")));
    cells.join(",") + "\n"
}

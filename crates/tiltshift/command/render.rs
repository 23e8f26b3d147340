//! `tiltshift render`: a scene traced through the lens.

mod long;
mod quality;
mod view;

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use optics::ThinLens;
use rgbd::{Head, write_frame, write_picture_with, write_png, write_truth};
use trace::{LayeredFrame, Scene, SceneFile, Shot, Wishes};

use crate::command::filter::sensor_mm;
use crate::command::render::long::Long;
pub(crate) use crate::command::render::quality::Quality;
use crate::console::{print, say};
use crate::failure::Outcome;
use crate::files::{Packing, expect_exr, make_folder_of, notes, numbered, refuse_overwriting, write_options};
use crate::lens_options::{FilmOptions, LensOptions};
use crate::values::{Frames, not_negative, stops};

/// Trace a scene through a tilted lens.
///
/// Writes the ground truth (two independent halves, so that it knows its own noise) and the RGB-D frame that a filter
/// needs: colour and depth in layers, with overscan.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// Scene file (TOML), or a model (glTF, GLB, OBJ): seen by its own camera, or from the right, above and in front;
    /// under its own lights, or sun and sky.
    scene: PathBuf,
    /// Shot to take; the file's own camera without.
    #[arg(long, value_name = "NAME")]
    shot: Option<String>,
    /// Camera of a model, counted from 0: the same as `--shot cameraN`.
    #[arg(long, value_name = "N", conflicts_with = "shot")]
    camera: Option<usize>,
    /// How often light goes from surface to surface, instead of what the scene needs (0: none, and what is glossy or glass
    /// looks matte).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1024))]
    bounces: Option<u32>,
    /// How many frames the shutter is open, about each frame, instead of what the shot says (0: no motion blur; 0.5 is a shutter
    /// of 180 degrees). It takes a scene in which something moves.
    #[arg(long, value_name = "FRAMES", value_parser = not_negative)]
    shutter: Option<f64>,
    /// List the shots of the scene and stop.
    #[arg(long)]
    list: bool,
    /// Take these frames of a shot that moves, first and last; each file gets its number where its name has `####`, or
    /// before its ending.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// Where to write the truth; `out/SCENE_SHOT.exr` without.
    #[arg(long, short, value_name = "FILE.exr")]
    output: Option<PathBuf>,
    /// Where to write the RGB-D frame; `out/SCENE_SHOT_rgbd.exr` without.
    #[arg(long, value_name = "FILE.exr")]
    rgbd: Option<PathBuf>,
    /// Also write the pinhole picture with two depths: `Z`, that of the first surface, and `optical.Z`, that of the images that
    /// mirrors and glass show (`filter --depth optical.Z` goes by it).
    #[arg(long, value_name = "FILE.exr")]
    optical_depth: Option<PathBuf>,
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
    #[command(flatten)]
    long: Long,
    #[command(flatten)]
    film: Box<FilmOptions>,
    #[command(flatten)]
    lens: Box<LensOptions>,
}

/// The files of one picture.
struct Outputs {
    truth: PathBuf,
    rgbd: PathBuf,
    png: Option<PathBuf>,
    optical_depth: Option<PathBuf>,
}

pub(crate) fn run(options: &Options) -> Outcome {
    if options.film.metres_per_unit.is_some() && !options.is_model() {
        return Err(anyhow!("--metres-per-unit is for models; a scene file says it itself").into());
    }
    let wishes =
        Wishes { bounces: options.bounces, metres_per_unit: options.film.metres_per_unit, shutter: options.shutter };
    let file = SceneFile::open_with(&options.scene, &wishes)?;
    if options.list {
        list(&file);
        return Ok(());
    }
    say_scene(&file);
    let name = options.shot();
    let name = name.as_deref();
    let moving = name.and_then(|name| file.frames(name));
    let (Some(Frames([first, last])), Some(name)) = (options.frames, name) else {
        if options.frames.is_some() {
            return Err(anyhow!("--frames needs a --shot that moves").into());
        }
        if let Some(frames) = moving {
            let (first, last) = (frames.start(), frames.end());
            let now = file.shot(name)?.exposure.middle();
            say(format_args!("the shot moves; this is frame {now} (--frames {first}..{last} takes them all)"));
        }
        return take(options, &file, file.shot(name)?, &options.outputs(None));
    };
    if moving.is_none() {
        return Err(anyhow!("the shot {name:?} does not move: neither it nor any thing has keys").into());
    }
    for frame in first..=last {
        let outputs = options.outputs(Some(frame));
        if options.long.is_resumed() && outputs.truth.exists() && outputs.rgbd.exists() {
            say(format_args!("frame {frame} is there already"));
            continue;
        }
        say(format_args!("frame {frame} of {first}..{last}"));
        take(options, &file, &file.shot_at(name, frame)?, &outputs)?;
    }
    Ok(())
}

impl Options {
    /// Whether the scene is a model rather than a scene file.
    fn is_model(&self) -> bool {
        let extension = self.scene.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        matches!(extension.as_deref(), Some("gltf" | "glb" | "obj"))
    }

    /// The shot that was named.
    fn shot(&self) -> Option<String> {
        self.camera.map_or_else(|| self.shot.clone(), |number| Some(format!("camera{number}")))
    }

    /// What is written where, of a still picture or of a frame: named after scene and shot unless the user named it.
    fn outputs(&self, frame: Option<i64>) -> Outputs {
        let scene = self.scene.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        let name = [Some(scene), self.shot()].into_iter().flatten().collect::<Vec<_>>().join("_");
        let name = name.replace(['/', '\\'], "_");
        let name_of_part = self.long.name_of_part();
        let ending = if self.long.is_part() { "part.exr" } else { "exr" };
        let truth = self.output.clone().unwrap_or_else(|| format!("out/{name}{name_of_part}.{ending}").into());
        let rgbd = self.rgbd.clone().unwrap_or_else(|| format!("out/{name}_rgbd.exr").into());
        let of_frame = |path: PathBuf| match frame {
            Some(frame) => numbered(&path, frame),
            None => path,
        };
        Outputs {
            truth: of_frame(truth),
            rgbd: of_frame(rgbd),
            png: self.png.clone().map(of_frame),
            optical_depth: self.optical_depth.clone().map(of_frame),
        }
    }
}

/// Renders one picture.
fn take(options: &Options, file: &SceneFile, shot: &Shot, outputs: &Outputs) -> Outcome {
    let seen =
        view::seen(shot, &file.scene_of(shot), &options.film, &options.lens, options.quality.size, options.is_model())?;
    let shot = &seen;
    let scene = &file.scene_of(shot);
    say_motion(scene);
    let camera = options.quality.camera(shot)?;
    expect_exr(&outputs.truth)?;
    expect_exr(&outputs.rgbd)?;
    if let Some(path) = &outputs.optical_depth {
        expect_exr(path)?;
    }
    let own = [Some(outputs.truth.as_path()), Some(outputs.rgbd.as_path())];
    let paths = own.into_iter().chain([outputs.png.as_deref(), outputs.optical_depth.as_deref()]);
    let paths: Vec<&Path> = paths.flatten().collect();
    refuse_overwriting(&[&options.scene], &paths)?;
    for path in paths {
        make_folder_of(path)?;
    }
    let lens = lens_in_metres(shot, scene)?;
    let sensor = lens.map(|lens| sensor_mm(&camera, &lens));
    let from = [("scene", options.scene.display().to_string()), ("shot", options.shot.clone().unwrap_or_default())];
    let write = write_options(options.compression, lens.as_ref(), sensor, notes(from));

    // Trace, and write each file as soon as it can be
    let place = options.long.place_of_part(&outputs.truth);
    let job = options.long.run((scene, file.fingerprint_of(shot)), &camera, &options.quality, &place, &write)?;
    options.quality.say_noise(job.sums());
    if options.long.is_part() {
        return Ok(());
    }
    let truth = job.into_sums().to_truth()?;
    write_truth(&outputs.truth, &truth, &write)?;
    say(format_args!("wrote {}", outputs.truth.display()));
    options.long.finish(&place)?;
    if let Some(png) = &outputs.png {
        write_png(png, &truth.picture(), options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    let layered = options.quality.layers(scene, &camera)?;
    say_layers(&layered);
    write_frame(&outputs.rgbd, &layered.frame, &write)?;
    say(format_args!("wrote {}", outputs.rgbd.display()));
    if let Some(path) = &outputs.optical_depth {
        let frame = &layered.frame;
        let first = &frame.layers()[0];
        let optical = trace::optical_depth(scene, &camera, frame.data());
        let planes = [("Z", &first.depth), ("optical.Z", &optical)];
        write_picture_with(path, &first.color, &planes, &Head::from(frame), &write)?;
        say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// The shot's lens in metres, where it has one.
pub(crate) fn lens_in_metres(shot: &Shot, scene: &Scene) -> anyhow::Result<Option<ThinLens>> {
    let (Some(lens), Some(metres)) = (shot.lens, scene.metres_per_unit()) else { return Ok(None) };
    Ok(Some(lens.scaled(metres).context("metres_per_unit of the scene")?))
}

/// Says what was wrong with the scene's files, and what of it takes more than the base shading.
pub(crate) fn say_scene(file: &SceneFile) {
    for warning in file.warnings() {
        say(format_args!("warning: {warning}"));
    }
    let (scene, needs) = (file.scene(), file.scene().needs().join(", "));
    match scene.bounces() {
        0 if needs.is_empty() => {}
        0 => say(format_args!("rays traced one by one, without bounces: {needs}")),
        1 => say(format_args!("path tracing to 1 bounce: {needs}")),
        bounces => say(format_args!("path tracing to {bounces} bounces: {needs}")),
    }
}

/// Says what motion blurs a picture.
fn say_motion(scene: &Scene) {
    let things = match scene.moving_things() {
        0 => None,
        1 => Some("a thing that moves".to_owned()),
        count => Some(format!("{count} things that move")),
    };
    let camera = scene.exposure().moves_camera().then(|| "a camera that moves".to_owned());
    let what: Vec<_> = [camera, things].into_iter().flatten().collect();
    let [open, close] = scene.exposure().times();
    if !what.is_empty() {
        let what = what.join(" and ");
        say(format_args!(
            "motion blur: time is sampled from frame {open} to {close} for {what}; layers show its middle"
        ));
    } else if close > open {
        say(format_args!("no motion blur: nothing moves from frame {open} to {close}"));
    }
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

//! `tiltshift filter`: the lens put onto an RGB-D picture.

use std::path::{Path, PathBuf};

use ::filter::{
    FrameView, GatherSettings, Highlights, KernelRule, LensRaysSettings, Method, Sides, apply_in_bands, coc_radius_px,
};
use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use optics::{Camera, Film, KernelModel, Pose, ThinLens};
use rgbd::{Frame, Head, LensAttributes, Loaded, PixelWindow, read_frame, survey_file, write_picture_with, write_png};

use crate::console::{Bar, say};
use crate::failure::Outcome;
use crate::files::{Packing, expect_exr, make_folder_of, notes, refuse_overwriting, write_options};
use crate::lens_options::{Chosen, FilmOptions, LensOptions};
use crate::read_arguments::ReadArguments;
use crate::values::{Pixel, bytes, stops};

/// Put a tilt-shift lens onto an RGB-D picture.
///
/// Reads an OpenEXR file with colour and depth and writes what the lens would have taken. Lens and focus come from the
/// options, or from the file where it was written by `tiltshift render`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Options {
    /// RGB-D picture: OpenEXR with colour and depth.
    input: PathBuf,
    /// Where to write the result (OpenEXR, linear, premultiplied).
    #[arg(long, short, value_name = "FILE.exr")]
    output: PathBuf,
    /// Also write an 8-bit sRGB PNG.
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Also write the signed radius (of the wider axis) of the circle of confusion in pixels, positive on the lens's side of
    /// the plane of focus, as a channel "coc" of the result.
    #[arg(long)]
    coc: bool,
    /// Also write how far each pixel may be from the truth, as a channel "predicted_error" of the result (methods gather,
    /// merged and lens-rays).
    #[arg(long)]
    predicted_error: bool,
    /// Exposure of the PNG in stops.
    #[arg(long, value_name = "STOPS", value_parser = stops, allow_negative_numbers = true, default_value_t = 0.0)]
    exposure: f32,
    /// How the EXR is packed.
    #[arg(long, value_enum, default_value_t)]
    compression: Packing,
    /// Say what is done, in full.
    #[arg(long, short)]
    verbose: bool,

    #[command(flatten)]
    method: MethodOptions,
    #[command(flatten)]
    highlights: HighlightOptions,
    #[command(flatten)]
    lens: LensOptions,
    #[command(flatten)]
    film: FilmOptions,
    #[command(flatten)]
    read: ReadArguments,
}

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
    /// How many rays a pixel gets (with --method lens-rays).
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65536))]
    rays: u32,
    /// Blur this many times as much as the lens would, by a wider or narrower iris.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    blur_scale: f64,
    /// What is blurred (methods gather, merged and lens-rays).
    #[arg(long, value_enum, default_value_t)]
    blur: Blur,
    /// Memory that filtering may take beside the picture itself, in bytes or with KiB, MiB, GiB: a larger picture goes
    /// through in bands, to the same bits.
    #[arg(long, value_name = "SIZE", value_parser = bytes, default_value = "4GiB")]
    memory_limit: u64,
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
    fn highlights(&self) -> Result<Option<Highlights>, ::filter::FilterError> {
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
    fn method(&self, predict_error: bool) -> Method {
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

pub(crate) fn run(options: &Options) -> Outcome {
    options.film.check()?;
    options.lens.check()?;
    let highlights = options.highlights.highlights()?;
    expect_exr(&options.output)?;
    let outputs: Vec<&Path> = [Some(options.output.as_path()), options.png.as_deref()].into_iter().flatten().collect();
    refuse_overwriting(&[&options.input], &outputs)?;
    for output in outputs {
        make_folder_of(output)?;
    }

    // Read the picture; rays need the film before the depth makes sense
    let film = film_before_reading(options)?;
    let read = options.read.options(film, options.film.metres_per_unit);
    let Loaded { value: frame, choice, lens: attributes, .. } = read_frame(&options.input, &read)?;
    say(format_args!("read {}: {choice}", options.input.display()));
    let display = frame.display;
    let frame = frame.covering(display);

    let Taken { camera, lens } = camera(options, &frame, &attributes)?;
    describe(&camera, lens.as_ref(), options.verbose);

    // Open or close the iris as asked
    let scale = options.method.blur_scale;
    if !(scale >= 0.0 && scale.is_finite()) {
        return Err(anyhow!("--blur-scale is {scale}; it must be 0 or positive").into());
    }
    let iris = camera.iris.with_radius(camera.iris.radius() * scale)?;
    let camera = Camera { iris, ..camera };

    // Give highlights back what clipping took
    let frame = match highlights {
        Some(highlights) => recover(&highlights, frame),
        None => frame,
    };

    // Filter it
    let method = options.method.method(options.predicted_error);
    if options.predicted_error && matches!(method, Method::Pinhole | Method::OwnCoc(_)) {
        let name = method.name();
        return Err(anyhow!("--predicted-error is known for gather, merged and lens-rays only, not for {name}").into());
    }
    let started = std::time::Instant::now();
    let bar = Bar::new(format!("filter ({})", method.name()));
    let limit = options.method.memory_limit;
    let filtered = apply_in_bands(&FrameView::whole(&frame), &camera, &method, display, limit, &bar)?;
    drop(bar);
    let seconds = started.elapsed().as_secs_f64();
    say(format_args!(
        "method {}; largest circle of confusion {:.1} px in diameter; {seconds:.2} s",
        method.name(),
        2.0 * filtered.largest_radius_px
    ));
    if let Some(limit) = filtered.cut_to_px {
        say(format_args!("  cut to a radius of {limit} px; --max-radius sets the limit"));
    }
    if let (Some(choice), true) = (filtered.kernel_choice, options.verbose) {
        say(format_args!("  {choice}"));
    }

    // Write what came out
    let head = Head { camera: Some(camera), ..Head::from(&frame) };
    let kernel = ("kernel", filtered.kernel.to_string());
    let notes = notes([("method", method.name().to_owned()), kernel, ("input", options.input.display().to_string())]);
    let sensor_mm = lens.map(|lens| sensor_mm(&camera, &lens));
    let coc = options.coc.then(|| coc_radius_px(&FrameView::whole(&frame), &camera).cropped(display));
    let planes =
        [("coc", coc.as_ref()), ("predicted_error", filtered.predicted_error.as_ref().map(|error| &error.total))];
    let planes: Vec<_> = planes.into_iter().filter_map(|(name, plane)| Some((name, plane?))).collect();
    write_picture_with(
        &options.output,
        &filtered.picture,
        &planes,
        &head,
        &write_options(options.compression, lens.as_ref(), sensor_mm, notes),
    )?;
    say(format_args!("wrote {}", options.output.display()));
    if let Some(png) = &options.png {
        write_png(png, &filtered.picture.to_rec709(&frame.primaries), options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    Ok(())
}

/// Raises highlights and says how many there were.
fn recover(highlights: &Highlights, frame: Frame) -> Frame {
    let color = &frame.layers()[0].color;
    let raised = color.window().pixels().filter(|&(x, y)| {
        let was = color.at(x, y);
        highlights.recovered(was).iter().zip(was).any(|(&now, was)| now > was)
    });
    let share = 100.0 * raised.count() as f64 / frame.data().area() as f64;
    say(format_args!("highlights raised in {share:.2} % of the pixels"));
    highlights.recover(frame)
}

/// Sensor size in mm that the window stands for at the lens's image distance.
pub(crate) fn sensor_mm(camera: &Camera, lens: &ThinLens) -> [f64; 2] {
    camera.sensor_size(lens.image_distance()).map(|metres| metres * 1e3)
}

/// The film that the options alone tell, from the size that the header tells.
fn film_before_reading(options: &Options) -> anyhow::Result<Option<Film>> {
    let survey = survey_file(&options.input, options.read.options(None, None).max_pixels)?;
    options.film.film(survey.display.width, survey.display.height, f64::from(survey.pixel_aspect))
}

/// The camera to filter with, and its lens where one was made.
struct Taken {
    camera: Camera,
    lens: Option<ThinLens>,
}

fn camera(options: &Options, frame: &Frame, attributes: &LensAttributes) -> anyhow::Result<Taken> {
    // A frame of our own brings its camera along
    if let (Some(camera), false) = (frame.camera, options.lens.is_given()) {
        return Ok(Taken { camera, lens: None });
    }
    if !options.lens.is_given() {
        bail!(
            "{:?} does not say what lens to use; give --f-number and a focus (--focus-distance, --focus-pixel, \
             --focus-points or --focus-plane)",
            options.input
        );
    }

    // Take what the options leave open from the header
    let told = |given: Option<f64>, header: Option<f32>| given.or(header.map(f64::from));
    let film_options = FilmOptions {
        focal_length: told(options.film.focal_length, attributes.focal_length_mm),
        sensor_width: told(options.film.sensor_width, attributes.sensor_mm.map(|size| size[0])),
        fov: told(options.film.fov, attributes.horizontal_fov_deg),
        ..options.film.clone()
    };
    let display = frame.display;
    let typed = &options.film;
    if frame.camera.is_some() && (typed.fov.is_some() || typed.sensor_width.is_some() || typed.shift.is_some()) {
        bail!("{:?} tells what its camera sees; leave out --fov, --sensor-width and --shift", options.input);
    }
    // What was typed comes before what the header says
    let (width, height, aspect) = (display.width, display.height, f64::from(frame.pixel_aspect));
    let film = match frame.camera {
        Some(camera) => camera.film,
        None => typed.film(width, height, aspect)?.or(film_options.film(width, height, aspect)?).ok_or_else(|| {
            anyhow!(
                "{:?} does not say what its camera sees; give --focal-length and --sensor-width, or --fov",
                options.input
            )
        })?,
    };

    // Metres are needed wherever the lens is given in millimetres
    let metres_per_unit = options.film.metres_per_unit.or(frame.metres_per_unit).unwrap_or_else(|| {
        say("the unit of depth is not stated: taken as 1 m (--metres-per-unit says otherwise)");
        1.0
    });
    let pose = frame.camera.map_or(Pose::IDENTITY, |camera| camera.pose);
    let depth_at = |pixel| depth_in_units(frame, pixel).map(|depth| depth * metres_per_unit);
    let focal_length = typed.focal_length_mm().or_else(|| film_options.focal_length_mm());
    let Chosen { camera, lens } = options.lens.camera(pose, film, focal_length, metres_per_unit, depth_at)?;
    Ok(Taken { camera, lens: Some(lens) })
}

/// Depth of what a pixel of the display window shows, in scene units.
fn depth_in_units(frame: &Frame, pixel: Pixel) -> anyhow::Result<f64> {
    let display: PixelWindow = frame.display;
    let size = PixelWindow::of_size(display.width, display.height);
    if !size.contains(pixel.x, pixel.y) {
        bail!("pixel {pixel} is outside the picture of {}x{} pixels", display.width, display.height);
    }
    let (x, y) = (pixel.x + display.x, pixel.y + display.y);
    let layer = &frame.layers()[0];
    if !layer.known.at(x, y) {
        bail!("the depth at pixel {pixel} is not known; choose another pixel");
    }
    Ok(f64::from(layer.depth.at(x, y)))
}

/// Says what the lens does.
fn describe(camera: &Camera, lens: Option<&ThinLens>, verbose: bool) {
    if let Some(lens) = lens {
        let [tilt, swing] = [lens.tilt(), lens.swing()].map(f64::to_degrees);
        let (focal_length, f_number) = (lens.focal_length() * 1e3, lens.f_number());
        let focus = match lens.focus().depth(glam::DVec2::ZERO) {
            Some(depth) => format!("{depth:.4} m on the axis"),
            None => "not in front of the lens on the axis".to_owned(),
        };
        say(format_args!(
            "lens {focal_length:.1} mm f/{f_number:.2}, tilt {tilt:.2}°, swing {swing:.2}°; focus {focus}"
        ));
    }
    if verbose {
        let (w, iris) = (camera.focus.w(), camera.iris);
        say(format_args!("  plane of focus w = {w}, iris radius {} and normal {}", iris.radius(), iris.normal()));
    }
}

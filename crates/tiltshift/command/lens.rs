//! `tiltshift lens`: what a lens setting means, in words or as JSON.

mod report;
mod words;

use std::str::FromStr;

use anyhow::{Context, anyhow, bail};
use clap::Args;
use glam::DVec2;
use optics::{OpticsError, Pose};

use self::report::{Asked, Report};
use crate::console::{self, say};
use crate::failure::Outcome;
use crate::focus_wish::Seen;
use crate::lens_options::{Chosen, FilmOptions, LensOptions, positive_mm};
use crate::presets::{LENSES, SENSORS, Table};
use crate::values::{Pixel, Size};

/// What was typed.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    mut_args(without_a_picture),
    after_help = "Example: a floor from near to far, with the tilt that three points of it need\n  \
                  tiltshift lens --focal-length 24 --sensor-width 36 -N 4 \\\n    \
                  --point 100,700,1.6 --point 1200,700,1.6 --point 640,400,12"
)]
pub(crate) struct Options {
    #[command(flatten)]
    film: FilmOptions,
    #[command(flatten)]
    lens: LensOptions,
    /// Focus by the image distance in mm: from the lens to the sensor, along the sensor's normal.
    #[arg(long, value_name = "MM", group = "focus", help_heading = "Focus")]
    image_distance: Option<f64>,
    /// Focus on a depth seen at a pixel: column, row (from the top left), depth in metres (`inf` for the sky). Given
    /// two or three times it lays the plane of focus through the points; the tilt follows, and with three the swing too.
    #[arg(long, value_name = "X,Y,M", group = "focus", allow_hyphen_values = true, help_heading = "Focus")]
    point: Vec<Point>,

    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "What to say")]
    size: Size,
    /// Radius in pixels of the circle of confusion that still counts as sharp.
    #[arg(long, value_name = "PX", default_value_t = 1.0, help_heading = "What to say")]
    coc: f64,
    /// Depth of the nearest thing in the picture in metres; half the nearest sharp depth without.
    #[arg(long, value_name = "M", help_heading = "What to say")]
    nearest: Option<f64>,
    /// List the lenses of --lens-preset and the sensors of --sensor, and nothing else.
    #[arg(long, help_heading = "What to say")]
    list_presets: bool,
    /// Write JSON instead of words: units are in the names, infinity is the string "inf", and what does not exist is null
    /// (a hinge without tilt, a sharp depth behind the camera).
    #[arg(long, help_heading = "What to say")]
    json: bool,
}

/// A pixel and the depth of what it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    pixel: Pixel,
    depth: f64,
}

impl FromStr for Point {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (pixel, depth) = text
            .rsplit_once(',')
            .filter(|(pixel, _)| pixel.contains(','))
            .ok_or_else(|| anyhow!("column, row and depth with commas between, please"))?;
        let depth = depth.trim().parse().map_err(|_| anyhow!("{depth:?} is not a depth in metres"))?;
        Ok(Self { pixel: pixel.parse()?, depth })
    }
}

/// Options as they are meant where there is no picture to look at.
fn without_a_picture(arg: clap::Arg) -> clap::Arg {
    let arg = match arg.get_id().as_str() {
        "focus_pixel" | "focus_points" | "focus_band" | "focus_wish" | "metres_per_unit" => arg.hide(true),
        _ => arg,
    };
    match arg.get_help_heading() {
        Some(heading) if heading.starts_with("Camera") => arg.help_heading("Camera"),
        _ => arg,
    }
}

/// Says what the setting means.
pub(crate) fn run(options: &Options) -> Outcome {
    if options.list_presets {
        list_presets(options.json)?;
        return Ok(());
    }
    let options = &options.settled()?;
    options.check()?;
    let film = options.film.film(options.size.width, options.size.height, 1.0)?;
    let film = film.ok_or_else(|| anyhow!("the field of view is not known; give --sensor-width or --fov"))?;
    let chosen = options.chosen(film).map_err(with_unit)?;
    for limit in options.lens.lens_preset.iter().flat_map(|preset| preset.beyond(&chosen.lens)) {
        say(format_args!("warning: {limit}"));
    }
    let shift = options.film.shift.map_or(DVec2::ZERO, |shift| DVec2::new(shift.0, shift.1));
    let asked = Asked {
        shift_mm: shift,
        coc_radius_px: options.coc,
        nearest: options.nearest,
        tilt_follows_from: options.tilt_follows_from(),
    };
    let report = Report::new(&chosen, &asked)?;
    if options.json {
        console::print(serde_json::to_string_pretty(&report).context("the report makes no JSON")?);
    } else {
        console::print(report);
    }
    Ok(())
}

/// Writes the table of lenses and sensors.
fn list_presets(json: bool) -> anyhow::Result<()> {
    if json {
        let lists = serde_json::json!({ "lenses": LENSES, "sensors": SENSORS });
        console::print(serde_json::to_string_pretty(&lists).context("the list makes no JSON")?);
    } else {
        console::print(Table);
    }
    Ok(())
}

/// The depths of the points that were typed.
struct Typed<'a>(&'a [Point]);

impl Seen for Typed<'_> {
    fn depth_at(&self, pixel: Pixel) -> anyhow::Result<f64> {
        let point = self.0.iter().find(|point| point.pixel == pixel);
        point.map(|point| point.depth).ok_or_else(|| anyhow!("no depth is known at pixel {pixel}"))
    }

    fn row(&self, _: i32) -> Option<Vec<(Pixel, f64)>> {
        None
    }

    fn say(&self, line: std::fmt::Arguments<'_>) {
        say(line);
    }
}

impl Options {
    /// The same with names of lens and sensor as numbers.
    fn settled(&self) -> anyhow::Result<Self> {
        let film = self.film.settled(&self.lens, self.size.width, self.size.height, 1.0)?;
        let mut lens = self.lens.clone();
        if lens.aperture_radius.is_none() {
            lens.f_number = lens.f_number.or(lens.lens_preset.map(|preset| preset.widest_f_number));
        }
        Ok(Self { film, lens, point: self.point.clone(), ..*self })
    }

    /// Finds in one go what is missing or cannot be, in the words of the options.
    fn check(&self) -> anyhow::Result<()> {
        let (film, lens) = (&self.film, &self.lens);
        if film.metres_per_unit.is_some() {
            bail!("distances are in metres here; leave out --metres-per-unit");
        }
        if lens.focus_pixel.is_some()
            || lens.focus_points.is_some()
            || lens.focus_band.is_some()
            || lens.focus.is_some()
        {
            bail!("there is no picture here to take a depth from; name it with --point X,Y,M, up to three times");
        }

        // Name all that is missing
        let has_focus = lens.focus_distance.is_some()
            || lens.focus_plane.is_some()
            || self.image_distance.is_some()
            || !self.point.is_empty();
        let needs = [
            (film.focal_length_mm().is_some(), "--focal-length (or --lens-preset, or --fov with --sensor-width)"),
            (film.sensor_width.or(film.fov).is_some(), "--sensor-width (36 for full frame), --sensor or --fov"),
            (lens.f_number.or(lens.aperture_radius).is_some(), "--f-number or --aperture-radius"),
            (has_focus, "a focus (--focus-distance, --image-distance, --point or --focus-plane)"),
        ];
        let missing: Vec<&str> = needs.iter().filter(|(is_given, _)| !is_given).map(|&(_, what)| what).collect();
        if !missing.is_empty() {
            bail!("the lens is not fully known; please add {}", missing.join("; "));
        }

        film.check()?;
        lens.check()?;
        positive_mm("--image-distance", self.image_distance)?;
        if !(self.coc >= 0.0 && self.coc.is_finite()) {
            bail!("--coc is {} px; it must be 0 or positive", self.coc);
        }
        self.check_points()
    }

    /// One point or three, inside the picture, and no tilt beside three.
    fn check_points(&self) -> anyhow::Result<()> {
        let (lens, Size { width, height }) = (&self.lens, self.size);
        if self.point.len() > 3 {
            bail!(
                "--point is given {} times; give it once (focus there), twice or three times (the plane of focus through them)",
                self.point.len()
            );
        }
        if self.point.len() > 1 && [lens.tilt, lens.swing, lens.hinge_distance].iter().any(Option::is_some) {
            bail!(
                "two or three points fix tilt and swing; leave out --tilt, --swing and --hinge-distance, or give one point"
            );
        }
        for Point { pixel, .. } in &self.point {
            let is_inside = |at: i32, size: u32| u32::try_from(at).is_ok_and(|at| at < size);
            if !(is_inside(pixel.x, width) && is_inside(pixel.y, height)) {
                bail!("pixel {pixel} is outside the picture of {width} x {height} pixels; say its --size");
            }
        }
        Ok(())
    }

    /// The lens and its camera, in metres.
    fn chosen(&self, film: optics::Film) -> anyhow::Result<Chosen> {
        // The points are picks, each with a depth of its own
        let mut lens = self.lens.clone();
        match self.point.as_slice() {
            [] => {}
            [point] => lens.focus_pixel = Some(point.pixel),
            points => lens.focus_points = Some(points.iter().map(|point| point.pixel).collect()),
        }
        let seen = &Typed(&self.point);

        // Where the image distance is given, any focus will do until it is set
        let Some(image_distance) = self.image_distance else {
            return lens.camera(Pose::IDENTITY, film, self.film.focal_length_mm(), 1.0, seen);
        };
        lens.focus_distance = Some(f64::INFINITY);
        let chosen = lens.camera(Pose::IDENTITY, film, self.film.focal_length_mm(), 1.0, seen)?;
        let lens = chosen.lens.with_image_distance(image_distance * 1e-3)?;
        Ok(Chosen { camera: lens.camera(Pose::IDENTITY, film, chosen.camera.iris)?, lens })
    }

    /// What tilt and swing were found from, where they were not typed.
    fn tilt_follows_from(&self) -> Option<&'static str> {
        let wishes = [
            (self.point.len() == 2, "two points"),
            (self.point.len() == 3, "three points"),
            (self.lens.focus_plane.is_some(), "plane of focus"),
            (self.lens.hinge_distance.is_some(), "hinge distance"),
        ];
        wishes.iter().find(|(is_given, _)| *is_given).map(|&(_, what)| what)
    }
}

/// Names the unit where the lengths of an error have none.
fn with_unit(error: anyhow::Error) -> anyhow::Error {
    match error.downcast_ref::<OpticsError>() {
        Some(
            OpticsError::HingeTooNear { .. }
            | OpticsError::PlaneTooNear { .. }
            | OpticsError::DepthTooNear { .. }
            | OpticsError::FacesAway { .. },
        ) => anyhow!("{error} (lengths in metres)"),
        _ => error,
    }
}

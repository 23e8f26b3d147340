//! The camera to filter with: what the picture sees, and the lens that was asked for.

use anyhow::{anyhow, bail};
use optics::{Camera, Film, Ground, Pose, ThinLens};
use rgbd::{Frame, LensAttributes, PixelWindow};

use super::Source;
use super::job::{Job, Say};
use crate::focus_wish::{Seen, find_ground};
use crate::lens_options::{Chosen, FilmOptions};
use crate::values::Pixel;

/// The camera to filter with, and its lens where one was made.
pub(in crate::command) struct Taken {
    pub(in crate::command) camera: Camera,
    pub(in crate::command) lens: Option<ThinLens>,
}

/// The frame's own camera, or the lens that the options ask for on what the picture sees.
pub(in crate::command) fn camera(
    job: &Job,
    options: &Source<'_>,
    frame: &Frame,
    attributes: &LensAttributes,
    say: Say<'_>,
) -> anyhow::Result<Taken> {
    // A frame of our own brings its camera along
    if let (Some(camera), false) = (frame.camera, job.lens.is_given()) {
        return Ok(Taken { camera, lens: None });
    }
    // Ask for all that is missing at once
    let film = &options.film;
    let knows_film = frame.camera.is_some()
        || film.fov.or(film.sensor_width).is_some()
        || film.sensor.is_some()
        || attributes.horizontal_fov_deg.is_some()
        || (attributes.focal_length_mm.is_some() && attributes.sensor_mm.is_some());
    if !job.lens.is_given() {
        let sees = if knows_film {
            ""
        } else {
            ", and what its camera sees: --focal-length and --sensor-width (or --sensor), or --fov"
        };
        bail!(
            "{:?} does not say what lens to use; give --f-number (or --lens-preset) and a focus (--focus-distance, --focus-pixel, \
             --focus-points, --focus-plane, --focus-band or --focus){sees}",
            job.input
        );
    }

    let Sight { film, focal_length, metres_per_unit } = sight(job, options, frame, attributes, say)?;
    let pose = frame.camera.map_or(Pose::IDENTITY, |camera| camera.pose);
    let seen = Depths { frame, metres_per_unit, ground: job.ground, say };
    let Chosen { camera, lens } = job.lens.camera(pose, film, focal_length, metres_per_unit, &seen)?;
    for limit in job.lens.lens_preset.iter().flat_map(|preset| preset.beyond(&lens)) {
        say(format_args!("warning: {limit}"));
    }
    Ok(Taken { camera, lens: Some(lens) })
}

/// The ground in a picture, in metres, and the film that shows it.
pub(super) fn ground(
    job: &Job,
    options: &Source<'_>,
    frame: &Frame,
    attributes: &LensAttributes,
) -> anyhow::Result<(Ground, Film)> {
    let say: Say<'_> = &|_| ();
    let Sight { film, metres_per_unit, .. } = sight(job, options, frame, attributes, say)?;
    Ok((find_ground(&film, &Depths { frame, metres_per_unit, ground: None, say })?, film))
}

/// What a picture shows, and in which unit.
struct Sight {
    film: Film,
    focal_length: Option<f64>,
    metres_per_unit: f64,
}

/// What the picture shows, by what was typed, and by its header where that leaves it open.
fn sight(
    job: &Job,
    options: &Source<'_>,
    frame: &Frame,
    attributes: &LensAttributes,
    say: Say<'_>,
) -> anyhow::Result<Sight> {
    let display = frame.display;
    let (width, height, aspect) = (display.width, display.height, f64::from(frame.pixel_aspect));
    let typed = &options.film.settled(&job.lens, width, height, aspect)?;
    let told = |given: Option<f64>, header: Option<f32>| given.or(header.map(f64::from));
    let film_options = FilmOptions {
        focal_length: told(typed.focal_length, attributes.focal_length_mm),
        sensor_width: told(typed.sensor_width, attributes.sensor_mm.map(|size| size[0])),
        fov: told(typed.fov, attributes.horizontal_fov_deg),
        ..typed.clone()
    };
    if frame.camera.is_some() && (typed.fov.is_some() || typed.sensor_width.is_some() || typed.shift.is_some()) {
        bail!("{:?} tells what its camera sees; leave out --fov, --sensor-width and --shift", job.input);
    }
    // What was typed comes before what the header says
    let film = match frame.camera {
        Some(camera) => camera.film,
        None => typed.film(width, height, aspect)?.or(film_options.film(width, height, aspect)?).ok_or_else(|| {
            anyhow!(
                "{:?} does not say what its camera sees; give --focal-length and --sensor-width (or --sensor), or --fov",
                job.input
            )
        })?,
    };

    // Metres are needed wherever the lens is given in millimetres
    let metres_per_unit = options.film.metres_per_unit.or(frame.metres_per_unit).unwrap_or_else(|| {
        say(format_args!("the unit of depth is not stated: taken as 1 m (--metres-per-unit says otherwise)"));
        1.0
    });
    let focal_length = typed.focal_length_mm().or_else(|| film_options.focal_length_mm());
    Ok(Sight { film, focal_length, metres_per_unit })
}

/// The depths of a frame in metres, by pixels of its display window.
struct Depths<'a> {
    frame: &'a Frame,
    metres_per_unit: f64,
    ground: Option<Ground>,
    say: Say<'a>,
}

impl Seen for Depths<'_> {
    fn depth_at(&self, pixel: Pixel) -> anyhow::Result<f64> {
        depth_in_units(self.frame, pixel).map(|depth| depth * self.metres_per_unit)
    }

    fn row(&self, row: i32) -> Option<Vec<(Pixel, f64)>> {
        let (display, layer) = (self.frame.display, &self.frame.layers()[0]);
        let inverse = |x: i32| {
            let (column, line) = (x + display.x, row + display.y);
            let is_known = layer.window().contains(column, line) && layer.known.at(column, line);
            let inverse = || (f64::from(layer.depth.at(column, line)) * self.metres_per_unit).recip();
            is_known.then(|| (Pixel { x, y: row }, inverse()))
        };
        Some((0..display.width as i32).filter_map(inverse).collect())
    }

    fn ground(&self) -> Option<Ground> {
        self.ground
    }

    fn say(&self, line: std::fmt::Arguments<'_>) {
        (self.say)(line);
    }
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
pub(in crate::command) fn describe(camera: &Camera, lens: Option<&ThinLens>, verbose: bool, say: Say<'_>) {
    if let Some(lens) = lens {
        // A rounding below 0 is no -0.00
        let [tilt, swing] = [lens.tilt(), lens.swing()].map(|angle| (angle.to_degrees() * 100.0).round() / 100.0 + 0.0);
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

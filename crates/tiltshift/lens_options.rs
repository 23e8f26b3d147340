//! Options that say what lens is wanted, and the camera they make.

use anyhow::{Context, anyhow, bail};
use clap::Args;
use glam::DVec2;
use optics::{ApertureShape, Camera, Film, Focus, Nakane, Pose, ThinLens};

use crate::focus_wish::{Band, FocusWish, Seen, ground_plane};
use crate::presets::{LensPreset, SensorFormat};
use crate::values::{Pair, Pixel};

/// What the picture shows: the field of view of the camera that rendered it.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera (where the file does not tell it)")]
pub(crate) struct FilmOptions {
    /// Focal length of the lens in mm; with --sensor-width it also gives the field of view.
    #[arg(long, value_name = "MM")]
    pub(crate) focal_length: Option<f64>,
    /// Width of the sensor in mm (36 for full frame).
    #[arg(long, value_name = "MM")]
    pub(crate) sensor_width: Option<f64>,
    /// Format of the sensor, instead of --sensor-width; its long side lies along the picture's.
    #[arg(long, value_enum, value_name = "NAME", conflicts_with_all = ["sensor_width", "fov"], hide_possible_values = true)]
    pub(crate) sensor: Option<SensorFormat>,
    /// Horizontal field of view of the picture in degrees.
    #[arg(long, value_name = "DEG")]
    pub(crate) fov: Option<f64>,
    /// Shift in mm, right and rise, that the picture was rendered with.
    #[arg(long, value_name = "RIGHT,RISE", allow_hyphen_values = true)]
    pub(crate) shift: Option<Pair>,
    /// Metres in one unit of depth.
    #[arg(long, value_name = "M")]
    pub(crate) metres_per_unit: Option<f64>,
}

/// How the lens stands, opens and focuses.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Lens")]
pub(crate) struct LensOptions {
    /// A real tilt-shift lens: its focal length, its widest f-number unless --f-number is given, and a warning where the setting
    /// is beyond what it can do. `tiltshift lens --list-presets` lists them, and the sensors.
    #[arg(long, value_enum, value_name = "NAME", hide_possible_values = true)]
    pub(crate) lens_preset: Option<LensPreset>,
    /// F-number; the aperture radius is focal length / (2 N).
    #[arg(long, short = 'N', value_name = "N")]
    pub(crate) f_number: Option<f64>,
    /// Aperture radius in mm, instead of an f-number.
    #[arg(long, value_name = "MM", conflicts_with = "f_number")]
    pub(crate) aperture_radius: Option<f64>,
    /// Tilt in degrees: positive turns the lens axis down.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub(crate) tilt: Option<f64>,
    /// Swing in degrees: positive turns the lens axis right.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub(crate) swing: Option<f64>,
    /// Tilt by the distance of the hinge below the lens in metres, instead of --tilt (negative: above).
    #[arg(long, value_name = "M", allow_hyphen_values = true, conflicts_with = "tilt")]
    pub(crate) hinge_distance: Option<f64>,
    /// Keep the iris parallel to the sensor: only the plane of focus tilts.
    #[arg(long)]
    pub(crate) upright_iris: bool,
    /// Number of aperture blades (3 to 32); a disc without.
    #[arg(long, value_name = "N")]
    pub(crate) blades: Option<u32>,
    /// Rotation of the aperture in degrees.
    #[arg(long, value_name = "DEG", requires = "blades", allow_hyphen_values = true, default_value_t = 0.0)]
    pub(crate) blade_rotation: f64,
    /// Squeeze of an anamorphic lens: light out of focus makes ovals RATIO times as tall as wide (0.25 to 4; 2 for a 2x
    /// anamorphic lens). The aperture is then that of the longer axis.
    #[arg(long, value_name = "RATIO")]
    pub(crate) anamorphic: Option<f64>,
    /// Cat's eye (optical vignetting): towards the corners a second rim covers a part of the iris, there moved by STRENGTH
    /// aperture radii (0 to 1) towards the centre. The exposure is kept: nothing gets darker.
    #[arg(long, visible_alias = "catseye", value_name = "STRENGTH")]
    pub(crate) cat_eye: Option<f64>,

    /// Focus at this depth in metres on the optical axis (`inf` for infinity).
    #[arg(long, value_name = "M", group = "focus", help_heading = "Focus")]
    pub(crate) focus_distance: Option<f64>,
    /// Focus on what is seen at a pixel of the picture.
    #[arg(long, value_name = "X,Y", group = "focus", help_heading = "Focus")]
    pub(crate) focus_pixel: Option<Pixel>,
    /// Lay the plane of focus through what is seen at three pixels, and tilt and swing follow; or at two, and the tilt follows,
    /// without swing.
    #[arg(long, value_name = "X,Y", num_args = 2..=3, group = "focus", help_heading = "Focus", conflicts_with_all = ["tilt", "swing", "hinge_distance"])]
    pub(crate) focus_points: Option<Vec<Pixel>>,
    /// Lay the plane of focus at this angle in degrees from the optical axis and this distance in metres along it; the
    /// tilt follows.
    #[arg(long, value_name = "DEG,M", group = "focus", help_heading = "Focus", allow_hyphen_values = true,
          conflicts_with_all = ["tilt", "swing", "hinge_distance"])]
    pub(crate) focus_plane: Option<Pair>,
    /// Keep sharp what lies between two rows of the picture (from the top), by the median depth of each: focus follows, and the
    /// aperture too unless it is given, so that the band blurs by 1 px radius at its borders. The tilt is kept.
    #[arg(long, value_name = "ROW,ROW", group = "focus", help_heading = "Focus")]
    pub(crate) focus_band: Option<Band>,
    /// Find the ground in the depth, and lay the plane of focus along it (`ground`: sharp from near to far) or stand it up on
    /// it, across the view (`miniature`: a sharp strip, through the middle of the picture or --focus-pixel); the tilt follows.
    #[arg(long = "focus", id = "focus_wish", value_enum, value_name = "WISH", help_heading = "Focus",
          conflicts_with_all = ["tilt", "swing", "hinge_distance", "focus_distance", "focus_points", "focus_plane", "focus_band"])]
    pub(crate) focus: Option<FocusWish>,
}

/// What was made of the options.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chosen {
    /// The camera, in scene units.
    pub(crate) camera: Camera,
    /// The lens behind it, in metres.
    pub(crate) lens: ThinLens,
}

/// Fails unless a length in mm is positive, if it was typed.
pub(crate) fn positive_mm(name: &str, length: Option<f64>) -> anyhow::Result<()> {
    match length.filter(|&length| !(length > 0.0 && length.is_finite())) {
        Some(length) => bail!("{name} is {length} mm; it must be positive"),
        None => Ok(()),
    }
}

impl FilmOptions {
    /// Fails for lengths that cannot be, as they were typed.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        positive_mm("--focal-length", self.focal_length)?;
        positive_mm("--sensor-width", self.sensor_width)
    }

    /// The same with the names of sensor and lens as numbers, for a picture of `width` x `height` pixels of `pixel_aspect`.
    pub(crate) fn settled(
        &self,
        lens: &LensOptions,
        width: u32,
        height: u32,
        pixel_aspect: f64,
    ) -> anyhow::Result<Self> {
        if let (Some(preset), Some(typed)) = (lens.lens_preset, self.focal_length)
            && preset.focal_length_mm != typed
        {
            let LensPreset { name, focal_length_mm, .. } = preset;
            bail!("--lens-preset {name} has {focal_length_mm} mm; leave out --focal-length {typed}");
        }
        let named = self.sensor.map(|sensor| sensor.width_mm(f64::from(width) * pixel_aspect, f64::from(height)));
        Ok(Self {
            sensor_width: self.sensor_width.or(named),
            focal_length: self.focal_length.or(lens.lens_preset.map(|preset| preset.focal_length_mm)),
            ..self.clone()
        })
    }

    /// Focal length in mm as the picture's scale needs it: given, or from sensor width and field of view.
    pub(crate) fn focal_length_mm(&self) -> Option<f64> {
        let from_fov = || Some(0.5 * self.sensor_width? / (0.5 * self.fov?.to_radians()).tan());
        self.focal_length.or_else(from_fov)
    }

    /// The window of q that a picture of `width` x `height` pixels of `pixel_aspect` shows; `None` if too little is known.
    pub(crate) fn film(&self, width: u32, height: u32, pixel_aspect: f64) -> anyhow::Result<Option<Film>> {
        // Take the field of view as said, or as a renderer makes it from focal length and sensor
        let half_width = match (self.fov, self.focal_length, self.sensor_width) {
            (Some(fov), ..) => {
                if !(fov > 0.0 && fov < 180.0) {
                    bail!("--fov is {fov} degrees; it must be between 0 and 180");
                }
                (0.5 * fov.to_radians()).tan()
            }
            (None, Some(focal_length), Some(sensor_width)) => 0.5 * sensor_width / focal_length,
            _ => return Ok(None),
        };
        let half_height = half_width * f64::from(height) / f64::from(width) / pixel_aspect;
        let half = DVec2::new(half_width, half_height);
        let film = Film::new(-half, half, width, height).context("the field of view makes no sense")?;

        // Move it by the shift
        let Some(shift) = self.shift else { return Ok(Some(film)) };
        let focal_length = self.focal_length_mm().ok_or_else(|| anyhow!("--shift needs --focal-length"))?;
        Ok(Some(film.shifted(DVec2::new(shift.0, shift.1) / focal_length)))
    }
}

impl LensOptions {
    /// Fails for lengths and angles that cannot be, as they were typed.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        for (name, angle) in [("--tilt", self.tilt), ("--swing", self.swing)] {
            if let Some(angle) = angle.filter(|angle| angle.is_nan() || angle.abs() >= 90.0) {
                bail!("{name} is {angle} degrees; it must be between -90 and 90");
            }
        }
        for (name, value, unit) in [("--focus-distance", self.focus_distance, " m"), ("--f-number", self.f_number, "")]
        {
            if let Some(value) = value.filter(|value| value.is_nan() || *value <= 0.0) {
                bail!("{name} is {value}{unit}; it must be positive (inf will do)");
            }
        }
        if self.focus == Some(FocusWish::Ground) && self.focus_pixel.is_some() {
            bail!("--focus ground takes the whole ground; leave out --focus-pixel");
        }
        if let Some(plane) = self.focus_plane.filter(|plane| plane.0 == 0.0 || plane.0.abs() > 90.0) {
            bail!("--focus-plane has an angle of {} degrees; it must be between -90 and 90, and not 0", plane.0);
        }
        Ok(())
    }

    /// Whether any lens was asked for.
    pub(crate) fn is_given(&self) -> bool {
        let Self { f_number, aperture_radius, tilt, swing, hinge_distance, focus_distance, .. } = self;
        [f_number, aperture_radius, tilt, swing, hinge_distance, focus_distance].iter().any(|value| value.is_some())
            || self.focus_pixel.is_some()
            || self.focus_points.is_some()
            || self.focus_plane.is_some()
            || self.focus_band.is_some()
            || self.focus.is_some()
            || self.lens_preset.is_some()
            || self.blades.is_some()
            || self.anamorphic.is_some()
            || self.cat_eye.is_some()
            || self.upright_iris
    }

    /// Whether any focus was asked for.
    pub(crate) fn is_focused(&self) -> bool {
        self.focus_distance.is_some()
            || self.focus_pixel.is_some()
            || self.focus_points.is_some()
            || self.focus_plane.is_some()
            || self.focus_band.is_some()
            || self.focus.is_some()
    }

    /// The camera with this lens on a picture, of which `seen` tells the depths in metres.
    ///
    /// `film` is held: focusing does not change what the picture shows. Focal length and depths in metres inside.
    pub(crate) fn camera(
        &self,
        pose: Pose,
        film: Film,
        focal_length_mm: Option<f64>,
        metres_per_unit: f64,
        seen: &dyn Seen,
    ) -> anyhow::Result<Chosen> {
        let focal_length_mm = focal_length_mm.ok_or_else(|| {
            anyhow!("the focal length of the lens is not known; give --focal-length (or --fov with --sensor-width)")
        })?;
        let lens = self.lens(film, focal_length_mm * 1e-3, seen)?;
        let shape = match self.blades {
            Some(blades) => ApertureShape::polygon(blades, self.blade_rotation.to_radians())?,
            None => ApertureShape::Disc,
        };

        // The window tells the shift
        let centre = 0.5 * (film.min() + film.max());
        let lens = lens.shifted(centre * lens.image_distance())?;

        // From metres to the scene's unit
        let in_units = lens.scaled(1.0 / metres_per_unit).context("metres per unit of depth")?;
        let iris = if self.upright_iris { in_units.upright_iris(shape) } else { in_units.iris(shape) };
        let iris = iris.squeezed(self.anamorphic.unwrap_or(1.0))?;
        let camera = in_units.camera(pose, film, iris)?.with_cat_eye(self.cat_eye.unwrap_or(0.0))?;
        Ok(Chosen { camera, lens })
    }

    /// The lens in metres.
    fn lens(&self, film: Film, focal_length: f64, seen: &dyn Seen) -> anyhow::Result<ThinLens> {
        let f_number = match (self.f_number, self.aperture_radius, self.lens_preset) {
            (Some(f_number), ..) => Some(f_number),
            (None, Some(radius), _) => Some(0.5e3 * focal_length / radius),
            (None, None, Some(preset)) if self.focus_band.is_none() => Some(preset.widest_f_number),
            _ => None,
        };
        if f_number.is_none() && self.focus_band.is_none() {
            bail!("the aperture is not known; give --f-number or --aperture-radius");
        }

        // A whole plane of focus fixes tilt and swing
        if let Some(focus) = self.plane(&film, seen)? {
            return Ok(ThinLens::of_focal_length(&focus, focal_length, f_number.unwrap_or(f64::INFINITY))?);
        }

        // Else the lens stands as asked and focuses on a depth
        let tilt = match self.hinge_distance {
            Some(distance) => ThinLens::tilt_for_hinge(focal_length, distance.abs())?.copysign(distance),
            None => self.tilt.unwrap_or(0.0).to_radians(),
        };
        let swing = self.swing.unwrap_or(0.0).to_radians();
        let lens = ThinLens::new(focal_length, f_number.unwrap_or(f64::INFINITY), focal_length)?.tilted(tilt, swing)?;
        if let Some(band) = self.focus_band {
            return band.focused(lens, &film, seen, f_number.is_none());
        }
        match (self.focus_distance, self.focus_pixel) {
            (Some(distance), _) => Ok(lens.focused_at(DVec2::ZERO, distance)?),
            (None, Some(pixel)) => Ok(lens.focused_at(film.q_from_pixel(pixel.center()), seen.depth_at(pixel)?)?),
            (None, None) => {
                bail!(
                    "the focus is not known; give --focus-distance, --focus-pixel, --focus-points, --focus-plane, --focus-band or \
                     --focus"
                )
            }
        }
    }

    /// The plane of focus where the options give all of it.
    fn plane(&self, film: &Film, seen: &dyn Seen) -> anyhow::Result<Option<Focus>> {
        if let Some(Pair(theta, distance)) = self.focus_plane {
            return Ok(Some(Nakane::new(theta.to_radians(), distance)?.focus()?));
        }
        if let Some(wish) = self.focus {
            return ground_plane(wish, self.focus_pixel, film, seen).map(Some);
        }
        let Some(points) = &self.focus_points else { return Ok(None) };
        let pick = |pixel: Pixel| anyhow::Ok((film.q_from_pixel(pixel.center()), seen.depth_at(pixel)?));
        match *points.as_slice() {
            [a, b] => Ok(Some(Focus::through_two_pixels([pick(a)?, pick(b)?])?)),
            [a, b, c] => Ok(Some(Focus::through_pixels([pick(a)?, pick(b)?, pick(c)?])?)),
            _ => bail!("--focus-points takes two pixels or three"),
        }
    }
}

//! The thin lens: focal length, f-number, image distance, tilt, swing and shift.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{ApertureShape, Camera, Film, Focus, Iris, OpticsError, Pose, error::in_range};

/// A thin lens on a camera with movements; all lengths in one unit, angles in radians.
///
/// It is a way to say what a [`Camera`] should be, and to read what one is; the camera itself holds only what rays need.
///
/// ```
/// use optics::{ApertureShape, Pose, ThinLens};
///
/// // 50 mm f/2.8, 51.5 mm from the sensor, tilted 5 degrees down; lengths in millimetres
/// let lens = ThinLens::new(50.0, 2.8, 51.5)?.tilted(5f64.to_radians(), 0.0)?;
/// let focus = lens.focus();
/// assert!((focus.depth(glam::DVec2::ZERO).unwrap() - 1974.652).abs() < 1e-3);
/// assert!((focus.hinge_distance() - 573.686).abs() < 1e-3);
/// assert!((focus.angle_from_sensor().to_degrees() - 73.800).abs() < 1e-3);
///
/// // The camera behind it: a full-frame sensor of 1920 x 1280 pixels, an iris of nine blades
/// let film = lens.film([36.0, 24.0], 1920, 1280)?;
/// let camera = lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::polygon(9, 0.0)?))?;
/// assert!((camera.image_distance().unwrap() - 51.5).abs() < 1e-9);
/// # Ok::<(), optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Settings", into = "Settings")]
pub struct ThinLens {
    focal_length: f64,
    f_number: f64,
    image_distance: f64,
    tilt: f64,
    swing: f64,
    shift: DVec2,
}

impl ThinLens {
    /// An untilted, unshifted lens: focal length F, f-number N (`+inf` is a pinhole), image distance v.
    ///
    /// Lengths must lie in 1e-12 to 1e12 of their unit, f-numbers in 1e-6 to `+inf`.
    pub fn new(focal_length: f64, f_number: f64, image_distance: f64) -> Result<Self, OpticsError> {
        Self { focal_length, f_number, image_distance, tilt: 0.0, swing: 0.0, shift: DVec2::ZERO }.checked()
    }

    /// The same lens with its axis turned down by `tilt`, then right by `swing`; radians, each less than a right angle.
    pub fn tilted(self, tilt: f64, swing: f64) -> Result<Self, OpticsError> {
        Self { tilt, swing, ..self }.checked()
    }

    /// The same lens with the picture's window moved by `shift` (right, rise), in the lens's unit.
    pub fn shifted(self, shift: DVec2) -> Result<Self, OpticsError> {
        Self { shift, ..self }.checked()
    }

    /// The same lens stopped to another f-number; `+inf` is a pinhole.
    pub fn with_f_number(self, f_number: f64) -> Result<Self, OpticsError> {
        Self { f_number, ..self }.checked()
    }

    /// The same lens opened to an aperture radius R = F/(2N); 0 is a pinhole.
    pub fn with_aperture_radius(self, radius: f64) -> Result<Self, OpticsError> {
        in_range("aperture radius", radius, "0 (pinhole) or positive", |r| r >= 0.0)?;
        self.with_f_number(self.focal_length / (2.0 * radius.abs()))
    }

    /// The same lens at another image distance.
    pub fn with_image_distance(self, image_distance: f64) -> Result<Self, OpticsError> {
        Self { image_distance, ..self }.checked()
    }

    /// The same lens with all lengths multiplied by `factor`, to change the unit.
    pub fn scaled(self, factor: f64) -> Result<Self, OpticsError> {
        let [focal_length, image_distance] = [self.focal_length, self.image_distance].map(|length| length * factor);
        Self { focal_length, image_distance, shift: self.shift * factor, ..self }.checked()
    }

    fn checked(self) -> Result<Self, OpticsError> {
        const LENGTH: &str = "positive, 1e-12 to 1e12";
        let is_length = |x: f64| (1e-12..=1e12).contains(&x);
        let is_turn = |x: f64| x.abs() < FRAC_PI_2;
        in_range("focal length", self.focal_length, LENGTH, is_length)?;
        in_range("image distance", self.image_distance, LENGTH, is_length)?;
        in_range("tilt in radians", self.tilt, "between -pi/2 and pi/2", is_turn)?;
        in_range("swing in radians", self.swing, "between -pi/2 and pi/2", is_turn)?;
        in_range("shift to the right", self.shift.x, "finite", |_| true)?;
        in_range("shift upwards", self.shift.y, "finite", |_| true)?;
        // Infinity is an f-number: that of a pinhole
        if self.f_number.is_nan() || self.f_number < 1e-6 {
            let (what, wanted) = ("f-number", "positive, at least 1e-6 (infinity is a pinhole)");
            return Err(OpticsError::OutOfRange { what, value: self.f_number, wanted });
        }
        Ok(self)
    }

    /// Focal length F.
    #[must_use]
    pub fn focal_length(&self) -> f64 {
        self.focal_length
    }

    /// f-number N = F/(2R); `+inf` for a pinhole.
    #[must_use]
    pub fn f_number(&self) -> f64 {
        self.f_number
    }

    /// Image distance v: from the lens centre to the sensor, along the sensor's normal.
    #[must_use]
    pub fn image_distance(&self) -> f64 {
        self.image_distance
    }

    /// Tilt, radians; positive turns the lens axis down.
    #[must_use]
    pub fn tilt(&self) -> f64 {
        self.tilt
    }

    /// Swing, radians; positive turns the lens axis right.
    #[must_use]
    pub fn swing(&self) -> f64 {
        self.swing
    }

    /// Shift (right, rise).
    #[must_use]
    pub fn shift(&self) -> DVec2 {
        self.shift
    }

    /// The lens axis n = (sin s cos t, -sin t, cos s cos t): a unit vector, n.z > 0.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        let ((sin_t, cos_t), (sin_s, cos_s)) = (self.tilt.sin_cos(), self.swing.sin_cos());
        DVec3::new(sin_s * cos_t, -sin_t, cos_s * cos_t)
    }

    /// Total tilt, acos n.z: the angle between the lens axis and the sensor's normal, radians.
    #[must_use]
    pub fn total_tilt(&self) -> f64 {
        let n = self.axis();
        n.truncate().length().atan2(n.z)
    }

    /// Aperture radius R = F/(2N); 0 for a pinhole.
    #[must_use]
    pub fn aperture_radius(&self) -> f64 {
        self.focal_length / (2.0 * self.f_number)
    }

    /// Effective f-number N v/F: what the sensor sees at close focus.
    #[must_use]
    pub fn effective_f_number(&self) -> f64 {
        self.f_number * self.image_distance / self.focal_length
    }

    /// Focus distance from which on everything up to infinity blurs to at most a *diameter* `coc` on the sensor, for
    /// the untilted lens: F + F^2/(N c).
    #[must_use]
    pub fn hyperfocal_distance(&self, coc: f64) -> f64 {
        self.focal_length * (1.0 + self.focal_length / (self.f_number * coc))
    }

    /// The plane of sharp focus, w = n/F - z/v (DESIGN eq. 1; the thin-lens equation measured along n).
    #[must_use]
    pub fn focus(&self) -> Focus {
        Focus::from_finite(self.axis() / self.focal_length - DVec3::Z / self.image_distance)
    }

    /// The iris in the plane of the lens.
    #[must_use]
    pub fn iris(&self, shape: ApertureShape) -> Iris {
        Iris::across(self.axis(), self.aperture_radius(), shape)
    }

    /// An iris of the same radius that stays parallel to the sensor: only the plane of focus tilts.
    #[must_use]
    pub fn upright_iris(&self, shape: ApertureShape) -> Iris {
        Iris::across(DVec3::Z, self.aperture_radius(), shape)
    }

    /// What a sensor of this size (width, height, in the lens's unit) shows: its window over v, moved by shift over v.
    pub fn film(&self, sensor_size: [f64; 2], width: u32, height: u32) -> Result<Film, OpticsError> {
        let half = 0.5 * DVec2::from_array(sensor_size);
        in_range("sensor width", half.x, "positive", |x| x > 0.0)?;
        in_range("sensor height", half.y, "positive", |x| x > 0.0)?;
        let v = self.image_distance;
        Film::new((self.shift - half) / v, (self.shift + half) / v, width, height)
    }

    /// The camera behind this lens, all lengths in scene units; `film` from [`Self::film`], or a fixed window.
    ///
    /// Fails with [`OpticsError::EdgeOn`] if a pixel of the film would look at the lens from its edge.
    pub fn camera(&self, pose: Pose, film: Film, iris: Iris) -> Result<Camera, OpticsError> {
        // n . (q, 1) is affine in q, so that a corner is the worst pixel
        for q in film.corners() {
            self.facing(q)?;
        }
        Ok(Camera { pose, film, focus: self.focus(), iris })
    }

    /// n . (q, 1), which must be positive.
    pub(crate) fn facing(&self, q: DVec2) -> Result<f64, OpticsError> {
        let facing = self.axis().dot(q.extend(1.0));
        if facing > 0.0 {
            return Ok(facing);
        }
        Err(OpticsError::EdgeOn { qx: q.x, qy: q.y, total_tilt: self.total_tilt() })
    }
}

/// The lens as it stands in a file; checked before it becomes one.
#[derive(Serialize, Deserialize)]
#[serde(rename = "ThinLens", deny_unknown_fields)]
struct Settings {
    focal_length: f64,
    /// None is a pinhole: JSON has no infinity.
    f_number: Option<f64>,
    image_distance: f64,
    #[serde(default)]
    tilt: f64,
    #[serde(default)]
    swing: f64,
    #[serde(default)]
    shift: DVec2,
}

impl TryFrom<Settings> for ThinLens {
    type Error = OpticsError;

    fn try_from(s: Settings) -> Result<Self, OpticsError> {
        Self::new(s.focal_length, s.f_number.unwrap_or(f64::INFINITY), s.image_distance)?
            .tilted(s.tilt, s.swing)?
            .shifted(s.shift)
    }
}

impl From<ThinLens> for Settings {
    fn from(lens: ThinLens) -> Self {
        Self {
            focal_length: lens.focal_length,
            f_number: lens.f_number.is_finite().then_some(lens.f_number),
            image_distance: lens.image_distance,
            tilt: lens.tilt,
            swing: lens.swing,
            shift: lens.shift,
        }
    }
}

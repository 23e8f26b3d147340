//! The iris: the flat, open shape through which every ray passes.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Opening, OpticsError, error::in_range};

/// The outline of the opening, for a radius of 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ApertureShape {
    /// A full disc.
    #[default]
    Disc,
    /// A regular polygon whose corners lie on the unit circle.
    Polygon {
        /// Number of blades, 3 to 32.
        blades: u32,
        /// Direction of the first corner, radians from e1 towards e2.
        rotation: f64,
    },
}

impl ApertureShape {
    /// A regular polygon with 3 to 32 blades, its first corner at `rotation` radians from e1 towards e2.
    pub fn polygon(blades: u32, rotation: f64) -> Result<Self, OpticsError> {
        let shape = Self::Polygon { blades, rotation };
        shape.check()?;
        Ok(shape)
    }

    fn check(&self) -> Result<(), OpticsError> {
        if let Self::Polygon { blades, rotation } = *self {
            in_range("number of aperture blades", f64::from(blades), "3 to 32", |n| (3.0..=32.0).contains(&n))?;
            in_range("rotation of the aperture in radians", rotation, "finite", |_| true)?;
        }
        Ok(())
    }

    /// A point of the opening for a point of the unit square; uniform in area, continuous and of low distortion.
    #[must_use]
    pub fn sample(&self, u: DVec2) -> DVec2 {
        match *self {
            Self::Disc => concentric_disc(u),
            Self::Polygon { blades, rotation } => polygon_point(u, blades, rotation),
        }
    }

    /// Whether a point lies in the opening.
    #[must_use]
    pub fn contains(&self, p: DVec2) -> bool {
        match *self {
            Self::Disc => p.length_squared() <= 1.0,
            Self::Polygon { blades, rotation } => {
                let wedge = std::f64::consts::TAU / f64::from(blades);
                let angle = (p.y.atan2(p.x) - rotation).rem_euclid(wedge) - 0.5 * wedge;
                p.length() * angle.cos() <= (0.5 * wedge).cos()
            }
        }
    }

    /// Corners of a polygon on the unit circle, in order; none for a disc.
    pub fn corners(&self) -> impl Iterator<Item = DVec2> + use<> {
        let (blades, rotation) = match *self {
            Self::Disc => (0, 0.0),
            Self::Polygon { blades, rotation } => (blades, rotation),
        };
        let wedge = std::f64::consts::TAU / f64::from(blades);
        (0..blades).map(move |k| DVec2::from_angle(rotation + wedge * f64::from(k)))
    }

    /// Area of the opening; pi for a disc.
    #[must_use]
    pub fn area(&self) -> f64 {
        match *self {
            Self::Disc => std::f64::consts::PI,
            Self::Polygon { blades, .. } => {
                let n = f64::from(blades);
                0.5 * n * (std::f64::consts::TAU / n).sin()
            }
        }
    }

    /// Variance of a uniform point of the opening along any axis; 1/4 for a disc.
    #[must_use]
    pub fn variance(&self) -> f64 {
        match *self {
            Self::Disc => 0.25,
            Self::Polygon { blades, .. } => (2.0 + (std::f64::consts::TAU / f64::from(blades)).cos()) / 12.0,
        }
    }
}

/// Shirley and Chiu's concentric map of the square onto the disc.
fn concentric_disc(u: DVec2) -> DVec2 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let s = 2.0 * u - 1.0;
    if s == DVec2::ZERO {
        return s;
    }
    let (r, angle) =
        if s.x.abs() > s.y.abs() { (s.x, FRAC_PI_4 * s.y / s.x) } else { (s.y, FRAC_PI_2 - FRAC_PI_4 * s.x / s.y) };
    r * DVec2::new(angle.cos(), angle.sin())
}

/// The concentric disc's angle and radius, with each ring pressed onto the polygon's outline.
fn polygon_point(u: DVec2, blades: u32, rotation: f64) -> DVec2 {
    let on_disc = concentric_disc(u);
    let (radius, turn) = (on_disc.length(), on_disc.y.atan2(on_disc.x).rem_euclid(std::f64::consts::TAU));
    // Equal angles are equal areas of the disc; equal lengths along the outline are equal areas of the polygon
    let wedge = std::f64::consts::TAU / f64::from(blades);
    let along = turn / wedge;
    let first = along.floor();
    let corner = |k: f64| DVec2::from_angle(rotation + wedge * k);
    radius * corner(first).lerp(corner(first + 1.0), along - first)
}

/// Where the iris stands and how wide it opens.
///
/// e1, e2 and the normal m are perpendicular unit vectors in camera space; m.z > 0. A radius of 0 is a pinhole.
///
/// An anamorphic lens sees its iris [squeezed](Self::squeezed): the opening's outline, blades and all, is narrower along e1
/// (or lower along e2), and the radius is the longer half axis of what was the unit circle. A lens that is a tube shows a
/// [cat's eye](Self::with_cat_eye) towards the border; it is squeezed as the rest.
///
/// ```
/// use optics::{ApertureShape, Iris};
///
/// // A 2x anamorphic lens: points of light out of focus become ovals twice as tall as wide
/// let iris = Iris::upright(0.01, ApertureShape::Disc)?.squeezed(2.0)?;
/// assert_eq!(iris.half_sizes(), glam::DVec2::new(0.005, 0.01));
///
/// // A tube that covers a part of it at an angle: a cat's eye. 45 degrees off the axis 39 % of the lens are open
/// let iris = Iris::upright(0.01, ApertureShape::Disc)?.with_cat_eye(1.0)?;
/// assert!((iris.opening(glam::DVec2::X).share() - 0.391).abs() < 1e-3);
/// # Ok::<(), optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Iris {
    e1: DVec3,
    e2: DVec3,
    m: DVec3,
    radius: f64,
    /// Height over width.
    #[serde(skip_serializing_if = "is_one")]
    squeeze: f64,
    /// By how many radii the second rim moves for a tangent of 1.
    #[serde(skip_serializing_if = "is_zero")]
    cat_eye: f64,
    shape: ApertureShape,
}

impl Iris {
    /// An iris across `normal` (camera space, any length, z > 0) with `radius` in scene units.
    ///
    /// e1 lies in the x-z plane and e2 points up: both are x and y where the normal is z.
    pub fn new(normal: DVec3, radius: f64, shape: ApertureShape) -> Result<Self, OpticsError> {
        in_range("aperture radius", radius, "0 (pinhole) or positive", |r| r >= 0.0)?;
        shape.check()?;
        let m = normal.try_normalize().unwrap_or(DVec3::NAN);
        in_range("z of the iris normal", m.z, "positive: the iris must face the scene", |z| z > 0.0)?;
        Ok(Self::across(m, radius, shape))
    }

    /// The same, of numbers that are right by construction.
    pub(crate) fn across(m: DVec3, radius: f64, shape: ApertureShape) -> Self {
        let e1 = DVec3::new(m.z, 0.0, -m.x).normalize();
        Self { e1, e2: m.cross(e1), m, radius, squeeze: 1.0, cat_eye: 0.0, shape }
    }

    /// An iris parallel to the sensor.
    pub fn upright(radius: f64, shape: ApertureShape) -> Result<Self, OpticsError> {
        Self::new(DVec3::Z, radius, shape)
    }

    /// The iris that lets only chief rays pass.
    #[must_use]
    pub fn pinhole() -> Self {
        let (e1, e2, m) = (DVec3::X, DVec3::Y, DVec3::Z);
        Self { e1, e2, m, radius: 0.0, squeeze: 1.0, cat_eye: 0.0, shape: ApertureShape::Disc }
    }

    /// The same iris opened to another radius.
    pub fn with_radius(self, radius: f64) -> Result<Self, OpticsError> {
        in_range("aperture radius", radius, "0 (pinhole) or positive", |r| r >= 0.0)?;
        Ok(Self { radius, ..self })
    }

    /// The same iris as an anamorphic lens sees it: `squeeze` (0.25 to 4) times as tall as wide, 1 for a spherical lens.
    ///
    /// The radius stays that of the longer half axis: 2 halves the width along e1, 0.5 the height along e2. So it is in
    /// Cycles (Blender's "aperture ratio") for ratios above 1.
    pub fn squeezed(self, squeeze: f64) -> Result<Self, OpticsError> {
        in_range("anamorphic squeeze (height of the iris over its width)", squeeze, "0.25 to 4", |ratio| {
            (0.25..=4.0).contains(&ratio)
        })?;
        Ok(Self { squeeze, ..self })
    }

    /// The same iris in a tube: a second rim, as wide as the unit circle, covers a part of it at an angle.
    ///
    /// `cat_eye` (0 to 1e6; 0 for none) is by how many radii the rim moves for a direction whose tangent to the axis is 1:
    /// the length of the tube over the radius. [`Camera::with_cat_eye`](crate::Camera::with_cat_eye) takes it from the shift
    /// at a corner of the picture.
    pub fn with_cat_eye(self, cat_eye: f64) -> Result<Self, OpticsError> {
        in_range("cat's eye (length of the tube over the aperture radius)", cat_eye, "0 to 1e6", |length| {
            (0.0..=1e6).contains(&length)
        })?;
        Ok(Self { cat_eye, ..self })
    }

    /// First axis of the opening.
    #[must_use]
    pub fn e1(&self) -> DVec3 {
        self.e1
    }

    /// Second axis of the opening.
    #[must_use]
    pub fn e2(&self) -> DVec3 {
        self.e2
    }

    /// Unit normal.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.m
    }

    /// Radius in scene units, along the longer axis if it is squeezed; 0 for a pinhole.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// How many times as tall (along e2) as wide (along e1) it is; 1 unless it is [squeezed](Self::squeezed).
    #[must_use]
    pub fn squeeze(&self) -> f64 {
        self.squeeze
    }

    /// By how many radii the second rim moves for a tangent of 1; 0 without a [cat's eye](Self::with_cat_eye).
    #[must_use]
    pub fn cat_eye(&self) -> f64 {
        self.cat_eye
    }

    /// What pixel direction q sees open of it.
    ///
    /// The rim stands before the iris, so that it moves against q: what is open at the right of the picture is the left.
    #[must_use]
    pub fn opening(&self, q: DVec2) -> Opening {
        let q1 = q.extend(1.0);
        let tangent = DVec2::new(self.e1.dot(q1), self.e2.dot(q1)) / self.m.dot(q1).max(1e-9);
        let rim = (-self.cat_eye * tangent).clamp_length_max(Opening::LARGEST_SHIFT);
        Opening { shape: self.shape, rim: if self.cat_eye == 0.0 { DVec2::ZERO } else { rim } }
    }

    /// Half width along e1 and half height along e2 of an opening of radius 1; the longer one is 1.
    #[must_use]
    pub fn proportions(&self) -> DVec2 {
        DVec2::new(self.squeeze.recip(), self.squeeze).min(DVec2::ONE)
    }

    /// Half width along e1 and half height along e2 in scene units; the longer one is the radius.
    #[must_use]
    pub fn half_sizes(&self) -> DVec2 {
        self.radius * self.proportions()
    }

    /// Outline, before it is squeezed.
    #[must_use]
    pub fn shape(&self) -> ApertureShape {
        self.shape
    }

    /// The point of the whole iris for a point of the unit square, uniform in area; camera space.
    #[must_use]
    pub fn point(&self, u: DVec2) -> DVec3 {
        if self.radius == 0.0 {
            return DVec3::ZERO;
        }
        self.placed(self.shape.sample(u))
    }

    /// The same if it is open for pixel direction q.
    #[must_use]
    pub fn open_point(&self, q: DVec2, u: DVec2) -> Option<DVec3> {
        if self.radius == 0.0 || self.cat_eye == 0.0 {
            return Some(self.point(u));
        }
        let p = self.shape.sample(u);
        self.opening(q).is_within_rim(p).then(|| self.placed(p))
    }

    /// A point of the unit opening in camera space.
    fn placed(&self, p: DVec2) -> DVec3 {
        let p = self.half_sizes() * p;
        self.e1 * p.x + self.e2 * p.y
    }
}

/// The iris as it stands in a file; checked before it becomes one.
#[derive(Deserialize)]
struct Written {
    e1: DVec3,
    e2: DVec3,
    m: DVec3,
    radius: f64,
    #[serde(default = "one")]
    squeeze: f64,
    #[serde(default)]
    cat_eye: f64,
    shape: ApertureShape,
}

/// What files that say nothing of a squeeze mean.
fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one(squeeze: &f64) -> bool {
    *squeeze == 1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(cat_eye: &f64) -> bool {
    *cat_eye == 0.0
}

impl TryFrom<Written> for Iris {
    type Error = OpticsError;

    fn try_from(Written { e1, e2, m, radius, squeeze, cat_eye, shape }: Written) -> Result<Self, OpticsError> {
        const LOOSE: f64 = 1e-6; // what a file with floats may be off by
        // A frame that is orthonormal and right is kept to the bit; its first axis may be turned, the normal not
        Self::new(m, radius, shape)?.squeezed(squeeze)?.with_cat_eye(cat_eye)?;
        let is_unit = |axis: DVec3| (axis.length() - 1.0).abs() <= LOOSE;
        if !(is_unit(e1) && is_unit(m) && e1.dot(m).abs() <= LOOSE && e2.distance(m.cross(e1)) <= LOOSE) {
            return Err(OpticsError::NotAFrame("e1, e2 and m of the iris are no right-handed frame"));
        }
        Ok(Self { e1, e2, m, radius, squeeze, cat_eye, shape })
    }
}

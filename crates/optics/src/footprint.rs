//! Where a scene point lands (DESIGN eq. 5): the set of offsets between a pixel and what it sees through the iris.

use glam::{DMat2, DVec2, DVec3};

use crate::{ApertureShape, Camera, Film, Moments};

/// Which of the two pixels is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The receiving pixel q is held; offsets are p - q, to the points p that it sees.
    Gather,
    /// The source p is held; offsets are q - p, to the pixels q that see it.
    Scatter,
}

/// The footprint of one pixel and one inverse depth: the offset of each point u of the unit opening,
/// `spread u / (1 - lean . u)`.
///
/// This is eq. (5) exactly, in either reading. In a [`Reading::Gather`] through an upright iris `lean` is 0 and `spread`
/// a multiple of the identity: an exact disc (of a squeezed iris: an exact oval, twice as tall as wide for a squeeze of 2;
/// what is said of the disc model below is said of this oval). A cat's eye is not regarded: it leaves a part of this. Offsets are in q, or in pixels after [`Self::in_pixels`]; pixel rows go
/// down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    shape: ApertureShape,
    /// The disc model: offsets of an iris that stands parallel to the sensor.
    disc: DMat2,
    spread: DMat2,
    lean: DVec2,
}

impl Footprint {
    /// The footprint at pixel `at` for what lies at `inverse_depth`: `at` is q in a gather, p in a scatter.
    #[must_use]
    pub fn new(camera: &Camera, reading: Reading, at: DVec2, inverse_depth: f64) -> Self {
        let (iris, w) = (&camera.iris, camera.focus.w());
        let (e1, e2, radius, narrowed) = (iris.e1(), iris.e2(), iris.radius(), iris.proportions());
        let axes_z = DVec2::new(e1.z, e2.z);
        let defocus = camera.focus.defocus(at, inverse_depth);
        // l - l_z q is A(q) R u; the denominator is 1 - lean . u
        let narrow = DMat2::from_diagonal(narrowed);
        let foreshortened = DMat2::from_cols(e1.truncate() - e1.z * at, e2.truncate() - e2.z * at) * narrow;
        let (size, lean) = match reading {
            Reading::Gather => (radius * defocus, radius * camera.focus.inverse_depth(at) * axes_z),
            Reading::Scatter => (-radius * defocus, radius * (DVec2::new(w.dot(e1), w.dot(e2)) + defocus * axes_z)),
        };
        Self { shape: iris.shape(), disc: narrow * size, spread: foreshortened * size, lean: narrowed * lean }
    }

    /// The same footprint with its offsets in pixels of a film: x right, y down.
    #[must_use]
    pub fn in_pixels(self, film: &Film) -> Self {
        let scale = film.pixels_per_q();
        let pixels_from_q = DMat2::from_diagonal(DVec2::new(scale.x, -scale.y));
        Self { disc: pixels_from_q * self.disc, spread: pixels_from_q * self.spread, ..self }
    }

    /// The exact offset of a point of the unit opening; `None` if a ray through it leaves the scene sideways.
    #[must_use]
    pub fn offset(&self, u: DVec2) -> Option<DVec2> {
        let denominator = 1.0 - self.lean.dot(u);
        (denominator > 0.0).then(|| self.spread * u / denominator)
    }

    /// The offset of the disc model, which knows neither foreshortening nor skew.
    #[must_use]
    pub fn disc_offset(&self, u: DVec2) -> DVec2 {
        self.disc * u
    }

    /// The offset of the ellipse model, which knows no skew: the foreshortened iris A(q).
    #[must_use]
    pub fn ellipse_offset(&self, u: DVec2) -> DVec2 {
        self.spread * u
    }

    /// Offsets of the axes of the opening in the ellipse model.
    #[must_use]
    pub fn spread(&self) -> DMat2 {
        self.spread
    }

    /// The skew: what the denominator `1 - lean . u` takes away across the opening.
    #[must_use]
    pub fn lean(&self) -> DVec2 {
        self.lean
    }

    /// Radius of the disc model; along the wider axis in pixels.
    #[must_use]
    pub fn disc_radius(&self) -> f64 {
        self.disc.x_axis.length().max(self.disc.y_axis.length())
    }

    /// The farthest exact offset along `direction`: max of direction . offset(u) over the opening. `+inf` where a part
    /// of it leaves the scene sideways.
    #[must_use]
    pub fn support(&self, direction: DVec2) -> f64 {
        let (along, lean) = (self.spread.transpose() * direction, self.lean);
        match self.shape {
            ApertureShape::Disc => {
                // The least t with (along + t lean) . u <= t on the unit disc, i.e. |along + t lean| <= t
                let rest = 1.0 - lean.length_squared();
                if rest <= 0.0 {
                    return f64::INFINITY;
                }
                let half = along.dot(lean);
                (half + (half * half + rest * along.length_squared()).sqrt()) / rest
            }
            // A map that keeps lines straight takes its extremes at corners
            ApertureShape::Polygon { .. } => self
                .shape
                .corners()
                .map(|u| self.offset(u).map_or(f64::INFINITY, |offset| direction.dot(offset)))
                .fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Centroid and covariance of the exact offsets of lens points uniform in iris area. `None` where a part of the
    /// opening leaves the scene sideways.
    #[must_use]
    pub fn moments(&self) -> Option<Moments> {
        Some(Moments::of_opening(self.shape, self.lean)?.mapped(self.spread))
    }

    /// How far the ellipse model may be from the disc model, in the unit of the offsets; at most
    /// r (|q| sin a + 1 - cos a) for a blur of radius r and an iris tilted by a.
    #[must_use]
    pub fn foreshortening(&self) -> f64 {
        if self.disc_radius() == 0.0 {
            return 0.0;
        }
        let foreshortened = self.disc.inverse() * self.spread;
        // A disc looks the same however it is turned, so that only the stretch of A = stretch x turn counts
        let a = match self.shape {
            ApertureShape::Disc => stretch(foreshortened),
            ApertureShape::Polygon { .. } => foreshortened,
        };
        largest_stretch(self.disc * (a - DMat2::IDENTITY))
    }

    /// How far the exact footprint may be from the ellipse model, in the unit of the offsets: r |lean| for a blur of
    /// radius r, where |lean| = R sin a |w(q)| in a gather and R sin a |1/v - D| in a scatter. `+inf` where a part of
    /// the opening leaves the scene sideways.
    #[must_use]
    pub fn skew(&self) -> f64 {
        let lean = self.lean.length();
        if lean >= 1.0 {
            return f64::INFINITY;
        }
        largest_stretch(self.spread) * lean / (1.0 - lean)
    }
}

impl Camera {
    /// The pixel direction p of the point at `inverse_depth` that pixel q sees through the lens point L (camera space):
    /// p - q = (1/z - w(q)) (l - l_z q) / (1 - l_z w(q)), eq. (5) as a gather.
    ///
    /// `None` if no ray gets there: it would leave backwards, or the point does not lie on its way.
    #[must_use]
    pub fn seen_through(&self, q: DVec2, inverse_depth: f64, lens_point: DVec3) -> Option<DVec2> {
        let (l, l_z, w) = (lens_point.truncate(), lens_point.z, self.focus.inverse_depth(q));
        let slope = 1.0 - l_z * w;
        let leaves_forward = self.iris.normal().dot(q.extend(1.0)) > 0.0;
        // The point lies on the ray's way if it is beyond L exactly where the ray runs away from the sensor
        let is_on_the_way = (1.0 - l_z * inverse_depth) * slope > 0.0;
        (leaves_forward && is_on_the_way).then(|| q + (inverse_depth - w) * (l - l_z * q) / slope)
    }

    /// The pixel q that sees the point at `inverse_depth` in direction p through the lens point L (camera space):
    /// q - p = -D (l - l_z p) / (1 - w.L - D l_z), eq. (5) as a scatter.
    ///
    /// `None` if no pixel does.
    #[must_use]
    pub fn lands_at(&self, p: DVec2, inverse_depth: f64, lens_point: DVec3) -> Option<DVec2> {
        let (l, l_z) = (lens_point.truncate(), lens_point.z);
        let defocus = self.focus.defocus(p, inverse_depth);
        let side = 1.0 - self.focus.w().dot(lens_point);
        let denominator = side - defocus * l_z;
        if side * denominator <= 0.0 {
            return None;
        }
        let q = p - defocus * (l - l_z * p) / denominator;
        (self.iris.normal().dot(q.extend(1.0)) > 0.0).then_some(q)
    }
}

/// The symmetric factor P of the polar decomposition A = P U: the square root of A A^T.
fn stretch(a: DMat2) -> DMat2 {
    let squared = a * a.transpose();
    let root = squared.determinant().max(0.0).sqrt();
    let trace = squared.x_axis.x + squared.y_axis.y;
    (squared + DMat2::IDENTITY * root) * (trace + 2.0 * root).sqrt().recip()
}

/// The largest singular value: by how much a matrix stretches at most.
fn largest_stretch(a: DMat2) -> f64 {
    let squared = a.transpose() * a;
    let (half, difference) = (0.5 * (squared.x_axis.x + squared.y_axis.y), 0.5 * (squared.x_axis.x - squared.y_axis.y));
    (half + difference.hypot(squared.x_axis.y)).sqrt()
}

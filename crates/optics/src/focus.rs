//! The plane of sharp focus as one vector: w . P = 1.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    Film, OpticsError, Pose,
    error::{in_range, positive_depth},
};

/// The plane of sharp focus `w . P = 1` in camera space, in 1 / scene units.
///
/// A pixel q is sharp at depth `1 / w(q)` with `w(q) = w . (q, 1)`: positive in front of the camera, zero at infinity,
/// negative behind the camera (nothing is sharp, and the blur grows on).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Focus {
    w: DVec3,
}

impl Focus {
    /// A raw w; each part must be finite.
    pub fn new(w: DVec3) -> Result<Self, OpticsError> {
        for part in w.to_array() {
            in_range("inverse depth of focus w", part, "finite", |_| true)?;
        }
        Ok(Self { w })
    }

    /// A plane parallel to the sensor at `depth`; `+inf` focuses at infinity.
    pub fn at_depth(depth: f64) -> Result<Self, OpticsError> {
        positive_depth("depth of focus", depth)?;
        Self::new(DVec3::new(0.0, 0.0, 1.0 / depth))
    }

    /// The plane through a world point with a world normal.
    pub fn from_world_plane(pose: &Pose, point: DVec3, normal: DVec3) -> Result<Self, OpticsError> {
        let n_camera = pose.direction_to_camera(normal);
        let height = n_camera.dot(pose.point_to_camera(point));
        in_range("distance of the plane of focus from the lens centre", height, "not zero", |h| h != 0.0)?;
        Self::new(n_camera / height)
    }

    /// The plane through three pixels at their depths (`+inf` for the sky): [(q_i, 1)] w = 1/z_i.
    ///
    /// Fails with [`OpticsError::CollinearPixels`] where the pixels lie on one line: where their triangle is lower than
    /// 1e-9 of its longest side, far less than a pixel.
    pub fn through_pixels(picks: [(DVec2, f64); 3]) -> Result<Self, OpticsError> {
        const FLAT: f64 = 1e-9;
        for (_, depth) in picks {
            positive_depth("depth of a picked pixel", depth)?;
        }
        let [(q0, z0), (q1, z1), (q2, z2)] = picks;
        let (a, b) = (q1 - q0, q2 - q0);
        let longest = a.length_squared().max(b.length_squared()).max((b - a).length_squared());
        let doubled_area = a.perp_dot(b);
        in_range("direction of a picked pixel", longest, "finite", |_| true)?;
        if doubled_area.abs() <= FLAT * longest {
            return Err(OpticsError::CollinearPixels);
        }
        // Cramer's rule for the slope over the picture, then the offset at q = 0
        let (da, db) = (z1.recip() - z0.recip(), z2.recip() - z0.recip());
        let slope = DVec2::new(da * b.y - db * a.y, db * a.x - da * b.x) / doubled_area;
        Self::new(slope.extend(z0.recip() - slope.dot(q0)))
    }

    /// The plane through two pixels at their depths (`+inf` for the sky) that a lens without swing can hold sharp: w_x = 0.
    ///
    /// Fails with [`OpticsError::SameHeight`] where the pixels are level, within 1e-9 of their distance from each other.
    pub fn through_two_pixels(picks: [(DVec2, f64); 2]) -> Result<Self, OpticsError> {
        const LEVEL: f64 = 1e-9;
        for (_, depth) in picks {
            positive_depth("depth of a picked pixel", depth)?;
        }
        let [(q0, z0), (q1, z1)] = picks;
        let rise = q1.y - q0.y;
        in_range("direction of a picked pixel", rise, "finite", |_| true)?;
        if rise.abs() <= LEVEL * (q1 - q0).length() {
            return Err(OpticsError::SameHeight);
        }
        let slope = (z1.recip() - z0.recip()) / rise;
        Self::new(DVec3::new(0.0, slope, z0.recip() - slope * q0.y))
    }

    /// A w that is finite by construction.
    pub(crate) fn from_finite(w: DVec3) -> Self {
        debug_assert!(w.is_finite());
        Self { w }
    }

    /// The vector itself.
    #[must_use]
    pub fn w(&self) -> DVec3 {
        self.w
    }

    /// Inverse depth of focus of a pixel.
    #[must_use]
    pub fn inverse_depth(&self, q: DVec2) -> f64 {
        self.w.dot(q.extend(1.0))
    }

    /// Signed defocus D = 1/z - w(p) of a point at `inverse_depth` seen by pixel q; positive on the lens's side.
    #[must_use]
    pub fn defocus(&self, q: DVec2, inverse_depth: f64) -> f64 {
        inverse_depth - self.inverse_depth(q)
    }

    /// Depth at which a pixel is sharp; `+inf` where w(q) = 0, `None` where the plane of focus is behind the camera.
    #[must_use]
    pub fn depth(&self, q: DVec2) -> Option<f64> {
        let w = self.inverse_depth(q);
        (w >= 0.0).then(|| w.abs().recip())
    }

    /// Distance of the plane of focus from the lens centre, 1/|w|; `+inf` where it is at infinity.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.w.length().recip()
    }

    /// Angle between the plane of focus and the sensor, radians in 0 to pi/2; 0 for a plane at infinity.
    #[must_use]
    pub fn angle_from_sensor(&self) -> f64 {
        self.w.truncate().length().atan2(self.w.z.abs())
    }

    /// The plane in the world: its point nearest to the lens, and its unit normal, away from the lens. `None` for a
    /// plane at infinity.
    #[must_use]
    pub fn to_world_plane(&self, pose: &Pose) -> Option<(DVec3, DVec3)> {
        let normal = pose.direction_to_world(self.w.try_normalize()?);
        Some((pose.position + normal * self.distance(), normal))
    }

    /// Least and greatest inverse depth of focus over the window; both ends are taken at corners.
    #[must_use]
    pub fn inverse_depth_range(&self, film: &Film) -> [f64; 2] {
        let w = film.corners().map(|q| self.inverse_depth(q));
        w.iter().fold([w[0]; 2], |[least, most], &x| [least.min(x), most.max(x)])
    }
}

/// The plane as it stands in a file; checked before it becomes one.
#[derive(Deserialize)]
struct Written {
    w: DVec3,
}

impl TryFrom<Written> for Focus {
    type Error = OpticsError;

    fn try_from(written: Written) -> Result<Self, OpticsError> {
        Self::new(written.w)
    }
}

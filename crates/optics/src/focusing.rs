//! Focusing: from what should be sharp to the lens that does it.

use glam::{DVec2, DVec3};

use crate::{Camera, Focus, OpticsError, ThinLens, error::positive_depth};

impl ThinLens {
    /// The lens at image distance v whose plane of focus is `focus`: n/F = w + z/v (DESIGN eq. 3).
    ///
    /// Focal length, tilt and swing are the result. Fails with [`OpticsError::FacesAway`] where w_z <= -1/v.
    pub fn at_image_distance(focus: &Focus, image_distance: f64, f_number: f64) -> Result<Self, OpticsError> {
        // Check the numbers by building a lens of any focal length
        let lens = Self::new(image_distance, f_number, image_distance)?;
        let n_over_f = focus.w() + DVec3::Z / image_distance;
        if n_over_f.z <= 0.0 {
            return Err(OpticsError::FacesAway { w_z: focus.w().z, image_distance });
        }
        Self::new(n_over_f.length().recip(), lens.f_number(), image_distance)?.with_axis(n_over_f)
    }

    /// The lens of focal length F whose plane of focus is `focus`: 1/v = -w_z + sqrt(1/F^2 - w_x^2 - w_y^2)
    /// (DESIGN eq. 4).
    ///
    /// Image distance, tilt and swing are the result. Fails with [`OpticsError::HingeTooNear`] where J <= F, and with
    /// [`OpticsError::PlaneTooNear`] where w_z > 0 and 1/|w| <= F.
    pub fn of_focal_length(focus: &Focus, focal_length: f64, f_number: f64) -> Result<Self, OpticsError> {
        let lens = Self::new(focal_length, f_number, focal_length)?;
        // The lens axis has the length 1/F; what the hinge takes of it is not left for z
        let w = focus.w();
        let hinge = w.truncate().length();
        let n_z_squared = (focal_length.recip() - hinge) * (focal_length.recip() + hinge);
        if n_z_squared <= 0.0 {
            return Err(OpticsError::HingeTooNear { hinge_distance: hinge.recip(), focal_length });
        }
        let n_z_over_f = n_z_squared.sqrt();
        let inverse_v = n_z_over_f - w.z;
        if inverse_v <= 0.0 {
            return Err(OpticsError::PlaneTooNear { distance: w.length().recip(), focal_length });
        }
        lens.with_image_distance(inverse_v.recip())?.with_axis(w.truncate().extend(n_z_over_f))
    }

    /// The same lens, moved along the sensor's normal until pixel `q` is sharp at `depth` (`+inf` will do):
    /// 1/v = n.(q, 1)/F - 1/z0. `q` = 0 is the optical axis. The window of q is held.
    pub fn focused_at(self, q: DVec2, depth: f64) -> Result<Self, OpticsError> {
        positive_depth("depth of focus", depth)?;
        let nearest = self.focal_length() / self.facing(q)?;
        let inverse_v = nearest.recip() - depth.recip();
        if inverse_v <= 0.0 {
            return Err(OpticsError::DepthTooNear { depth, nearest });
        }
        self.with_image_distance(inverse_v.recip())
    }

    /// The same, with the sensor held instead of the window of q: `point` is a place in the picture, from the sensor's
    /// centre to the right and up, in the lens's unit; q = (point + shift)/v moves as the lens moves (breathing).
    pub fn focused_at_sensor_point(self, point: DVec2, depth: f64) -> Result<Self, OpticsError> {
        positive_depth("depth of focus", depth)?;
        // n.z/F + n.xy.x/(F v) - 1/v = 1/z0, linear in 1/v
        let (n, x) = (self.axis(), point + self.shift());
        let nearest = self.focal_length() / n.z;
        let lean = n.truncate().dot(x) / self.focal_length();
        let inverse_v = (nearest.recip() - depth.recip()) / (1.0 - lean);
        if lean >= 1.0 && (inverse_v <= 0.0 || !inverse_v.is_finite()) {
            let (what, wanted) = ("offset of the point along the tilted axis in focal lengths", "less than 1");
            return Err(OpticsError::OutOfRange { what, value: lean, wanted });
        }
        if inverse_v <= 0.0 {
            return Err(OpticsError::DepthTooNear { depth, nearest });
        }
        let lens = self.with_image_distance(inverse_v.recip())?;
        lens.facing(x * inverse_v)?;
        Ok(lens)
    }

    /// The total tilt that puts the hinge at `hinge_distance`, radians: asin(F/J) (Merklinger 1993).
    pub fn tilt_for_hinge(focal_length: f64, hinge_distance: f64) -> Result<f64, OpticsError> {
        positive_depth("focal length", focal_length)?;
        positive_depth("hinge distance", hinge_distance)?;
        if hinge_distance <= focal_length {
            return Err(OpticsError::HingeTooNear { hinge_distance, focal_length });
        }
        Ok((focal_length / hinge_distance).asin())
    }

    /// The same lens with its axis along `axis` (any length, z > 0).
    fn with_axis(self, axis: DVec3) -> Result<Self, OpticsError> {
        let tilt = (-axis.y).atan2(axis.x.hypot(axis.z));
        self.tilted(tilt, axis.x.atan2(axis.z))
    }
}

impl Camera {
    /// The image distance v, where the camera alone tells it: where the lens is tilted, and its iris with it.
    ///
    /// Then n = m, F = |m_xy|/|w_xy| and 1/v = m_z/F - w_z. `None` for an untilted lens, where every v gives the same
    /// rays, and for an iris that is upright or stands otherwise than the lens.
    #[must_use]
    pub fn image_distance(&self) -> Option<f64> {
        const ROUNDING: f64 = 1e-9; // far above that of f64, far below any tilt that can be set
        let (m, w) = (self.iris.normal(), self.focus.w());
        let (m_xy, w_xy) = (m.truncate(), w.truncate());
        let product = m_xy.length() * w_xy.length();
        if product == 0.0 || (m_xy.dot(w_xy) - product).abs() + m_xy.perp_dot(w_xy).abs() > ROUNDING * product {
            return None;
        }
        let inverse_v = m.z * w_xy.length() / m_xy.length() - w.z;
        (inverse_v > 0.0 && inverse_v.is_finite()).then(|| inverse_v.recip())
    }

    /// The thin lens at image distance v that makes this camera's plane of focus, aperture radius and window.
    ///
    /// Fails as [`ThinLens::at_image_distance`]. The stand of the iris has no part in it.
    pub fn thin_lens(&self, image_distance: f64) -> Result<ThinLens, OpticsError> {
        let centre = 0.5 * (self.film.min() + self.film.max());
        ThinLens::at_image_distance(&self.focus, image_distance, f64::INFINITY)?
            .shifted(centre * image_distance)?
            .with_aperture_radius(self.iris.radius())
    }

    /// Width and height of the sensor at image distance v, in scene units.
    #[must_use]
    pub fn sensor_size(&self, image_distance: f64) -> [f64; 2] {
        ((self.film.max() - self.film.min()) * image_distance).to_array()
    }
}

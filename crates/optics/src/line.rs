//! Lines that a tilted lens draws: the hinge, the Scheimpflug line, and the vanishing line of the plane of focus.

use glam::{DVec2, DVec3};

use crate::{Film, Focus, ThinLens};

/// A line in camera space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceLine {
    /// A point of it: the one nearest to the z axis.
    pub point: DVec3,
    /// Where it runs, a unit vector; to the right for a lens that is tilted only, and tilted down.
    pub direction: DVec3,
}

/// A line in the picture, in q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelLine {
    /// Its point nearest to q = 0.
    pub point: DVec2,
    /// Where it runs, a unit vector.
    pub direction: DVec2,
}

impl SpaceLine {
    /// Distance from the lens centre.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.point.cross(self.direction).length()
    }
}

impl PixelLine {
    /// The part inside the window, from end to end; `None` if the line misses it.
    #[must_use]
    pub fn clipped(&self, film: &Film) -> Option<[DVec2; 2]> {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in [0, 1] {
            let (at, along) = (self.point[axis], self.direction[axis]);
            let (low, high) = (film.min()[axis], film.max()[axis]);
            if along == 0.0 {
                if at < low || at > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - at) / along, (high - at) / along);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then(|| [enter, leave].map(|t| self.point + t * self.direction))
    }
}

impl Focus {
    /// The hinge: where the plane of focus meets the plane z = 0 through the lens centre, parallel to the sensor.
    ///
    /// `None` for an untilted plane of focus. The hinge is never in the picture.
    #[must_use]
    pub fn hinge(&self) -> Option<SpaceLine> {
        let w_xy = self.w().truncate();
        let towards = w_xy.try_normalize()?;
        Some(SpaceLine {
            point: (towards / w_xy.length()).extend(0.0),
            direction: DVec3::new(-towards.y, towards.x, 0.0),
        })
    }

    /// Hinge distance J = 1/|(w_x, w_y)|, which is F/sin(total tilt) (Merklinger 1993); `+inf` if untilted.
    #[must_use]
    pub fn hinge_distance(&self) -> f64 {
        self.w().truncate().length().recip()
    }

    /// The vanishing line w(q) = 0 of the plane of focus: there focus is at infinity, past it behind the camera.
    ///
    /// `None` for an untilted plane of focus.
    #[must_use]
    pub fn vanishing_line(&self) -> Option<PixelLine> {
        let w_xy = self.w().truncate();
        let towards = w_xy.try_normalize()?;
        Some(PixelLine { point: -towards * (self.w().z / w_xy.length()), direction: DVec2::new(-towards.y, towards.x) })
    }
}

impl ThinLens {
    /// The Scheimpflug line, where the planes of the sensor (z = -v), of the lens (n.P = 0) and of focus meet.
    ///
    /// `None` for an untilted lens: the three are parallel.
    #[must_use]
    pub fn scheimpflug_line(&self) -> Option<SpaceLine> {
        let n = self.axis();
        let n_xy = n.truncate();
        let towards = n_xy.try_normalize()?;
        let v = self.image_distance();
        Some(SpaceLine {
            point: (towards * (v * n.z / n_xy.length())).extend(-v),
            direction: DVec3::new(-towards.y, towards.x, 0.0),
        })
    }
}

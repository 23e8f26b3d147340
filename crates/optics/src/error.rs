//! What cannot be asked of a lens, each request with its reason.

use thiserror::Error;

/// A request that no lens or camera can fulfil. Lengths are in the unit of the request.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A number is outside its range.
    #[error("{what} is {value}; it must be {wanted}")]
    OutOfRange {
        /// What the number stands for, with its unit.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// The range that would do.
        wanted: &'static str,
    },
    /// The three axes of a pose or of an iris are not an orthonormal frame.
    #[error("axes are not perpendicular unit vectors: {0}")]
    NotAFrame(&'static str),
    /// w_z <= -1/v: the lens would have to face away from the scene.
    #[error(
        "no lens {image_distance} in front of the sensor has this plane of focus: its inverse depth on the optical axis \
         is {w_z}, and it must be more than -1/{image_distance}; use a smaller image distance, or focus farther away"
    )]
    FacesAway {
        /// Inverse depth of focus on the optical axis.
        w_z: f64,
        /// Image distance.
        image_distance: f64,
    },
    /// A pixel sees the lens from its edge, or from behind.
    #[error(
        "the pixel in direction ({qx:.4}, {qy:.4}) looks at the lens edge-on, because the lens is tilted by {:.2} degrees \
         in total; use less tilt, swing or shift, or a narrower field of view", total_tilt.to_degrees()
    )]
    EdgeOn {
        /// Right part of the chief-ray direction.
        qx: f64,
        /// Up part of the chief-ray direction.
        qy: f64,
        /// Angle between the lens axis and the optical axis, radians.
        total_tilt: f64,
    },
    /// J <= F: no tilt brings the hinge this near.
    #[error(
        "the hinge is {hinge_distance} from the lens centre, and a focal length of {focal_length} puts it farther away \
         than that at any tilt; use a focal length shorter than {hinge_distance}, or a hinge farther away"
    )]
    HingeTooNear {
        /// Distance of the hinge from the lens centre.
        hinge_distance: f64,
        /// Focal length.
        focal_length: f64,
    },
    /// The whole plane of focus lies within the focal length in front of the lens.
    #[error(
        "the plane of focus passes {distance} in front of the lens centre, and a focal length of {focal_length} cannot \
         focus that near; use a focal length shorter than {distance}, or a plane of focus farther away"
    )]
    PlaneTooNear {
        /// Distance of the plane of focus from the lens centre.
        distance: f64,
        /// Focal length.
        focal_length: f64,
    },
    /// The depth to focus at is within the focal length.
    #[error("the lens cannot focus at depth {depth} in that direction; it must be more than {nearest}")]
    DepthTooNear {
        /// Wanted depth.
        depth: f64,
        /// What it must exceed.
        nearest: f64,
    },
    /// Three picked pixels lie on one line, so that many planes pass through them.
    #[error("the three picked pixels lie on one line and determine no plane of focus; move one of them off that line")]
    CollinearPixels,
    /// Two picked pixels at one height, which tell nothing of the tilt.
    #[error(
        "the two picked pixels are at the same height, where tilt makes no difference; take one higher up, or a third"
    )]
    SameHeight,
}

/// `value` if it is finite and `accept`s it, else an error that says what it should be.
pub(crate) fn in_range(
    what: &'static str,
    value: f64,
    wanted: &'static str,
    accept: impl Fn(f64) -> bool,
) -> Result<f64, OpticsError> {
    if value.is_finite() && accept(value) {
        return Ok(value);
    }
    Err(OpticsError::OutOfRange { what, value, wanted })
}

/// `depth` if it is positive; `+inf` is a depth.
pub(crate) fn positive_depth(what: &'static str, depth: f64) -> Result<f64, OpticsError> {
    if depth > 0.0 {
        return Ok(depth);
    }
    Err(OpticsError::OutOfRange { what, value: depth, wanted: "positive (infinity will do)" })
}

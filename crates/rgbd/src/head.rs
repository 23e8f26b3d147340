//! What a file says of a picture besides its pixels.

use optics::Camera;

use crate::{Frame, PixelWindow, Primaries};

/// Everything that a picture shares with the frame it was made from, besides pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// The picture proper; the data may cover more (overscan) or less.
    pub display: PixelWindow,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// What R, G and B mean.
    pub primaries: Primaries,
    /// Metres in one unit of depth, where known.
    pub metres_per_unit: Option<f64>,
    /// The camera, where known.
    pub camera: Option<Camera>,
}

impl Head {
    /// Square pixels and Rec. 709; unit and camera unknown.
    #[must_use]
    pub fn new(display: PixelWindow) -> Self {
        Self { display, pixel_aspect: 1.0, primaries: Primaries::REC709, metres_per_unit: None, camera: None }
    }

    /// The same head with a camera.
    #[must_use]
    pub fn with_camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }
}

impl From<&Frame> for Head {
    fn from(frame: &Frame) -> Self {
        Self {
            display: frame.display,
            pixel_aspect: frame.pixel_aspect,
            primaries: frame.primaries,
            metres_per_unit: frame.metres_per_unit,
            camera: frame.camera,
        }
    }
}

//! What the standard attributes of an OpenEXR header say of the lens and the sensor.

use glam::DVec2;
use optics::Film;

/// OpenEXR's standard camera attributes, each where the file has it.
///
/// They are what other programs read and write; a [`crate::Frame`]'s own camera does not come from them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensAttributes {
    /// `effectiveFocalLength`: focal length F in millimetres.
    pub focal_length_mm: Option<f32>,
    /// `pinholeFocalLength`: image distance v in millimetres.
    pub image_distance_mm: Option<f32>,
    /// `aperture`: f-number.
    pub f_number: Option<f32>,
    /// `focus`: focus distance in metres.
    pub focus_distance_m: Option<f32>,
    /// `sensorOverallDimensions`: width and height of the sensor in millimetres.
    pub sensor_mm: Option<[f32; 2]>,
    /// `sensorCenterOffset` in microns; positive shows more of the right and of the bottom.
    pub sensor_offset_um: Option<[f32; 2]>,
    /// `fieldOfViewHorizontal`: full angle in degrees.
    pub horizontal_fov_deg: Option<f32>,
    /// `near`: near clipping plane in scene units.
    pub near: Option<f32>,
    /// `far`: far clipping plane in scene units.
    pub far: Option<f32>,
    /// `worldToCamera`, for row vectors: element `4 * row + column`, translation in the last row.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`, for row vectors: (0, 0) is the top left corner of the display window, (1, 1) the bottom right.
    pub world_to_ndc: Option<[f32; 16]>,
}

impl LensAttributes {
    /// What a picture of `width` x `height` pixels of `pixel_aspect` shows by the field of view, or by focal length and sensor.
    #[must_use]
    pub fn film(&self, width: u32, height: u32, pixel_aspect: f32) -> Option<Film> {
        let by_fov = self.horizontal_fov_deg.map(|degrees| (0.5 * f64::from(degrees).to_radians()).tan());
        let by_sensor = || Some(0.5 * f64::from(self.sensor_mm?[0]) / f64::from(self.focal_length_mm?));
        let x = by_fov.or_else(by_sensor)?;
        let half = DVec2::new(x, x * f64::from(height) / f64::from(width) / f64::from(pixel_aspect));
        Film::new(-half, half, width, height).ok()
    }

    /// Whether the header said nothing at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

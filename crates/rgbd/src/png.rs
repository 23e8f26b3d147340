//! Pictures to look at: 8-bit PNG with the sRGB transfer.

use std::path::Path;
use std::sync::LazyLock;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::replace::replace_file;
use crate::{Picture, WriteError};

/// Writes the picture's whole window as an 8-bit RGB PNG; see [`encode_png`]. It stands whole or not at all.
pub fn write_png(path: &Path, picture: &Picture, exposure_stops: f32) -> Result<(), WriteError> {
    let window = picture.window();
    if window.is_empty() {
        return Err(WriteError::BadWindow { path: path.into(), what: "data", window });
    }
    let bytes = encode_png(picture, exposure_stops)
        .map_err(|error| WriteError::Encoding { path: path.into(), reason: error.to_string() })?;
    replace_file(path, &bytes).map_err(|source| WriteError::Io { path: path.into(), source })
}

/// The bytes of an 8-bit RGB PNG of the picture's whole window, `2^exposure_stops` times as bright.
///
/// Colours are taken as linear with the primaries of sRGB, laid over black (they are premultiplied, so alpha drops
/// out), clipped to [0, 1], encoded with the sRGB transfer (IEC 61966-2-1) and rounded to nearest. NaN becomes black.
/// An empty picture is an error.
pub fn encode_png(picture: &Picture, exposure_stops: f32) -> Result<Vec<u8>, image::ImageError> {
    let gain = exposure_stops.exp2();
    let [red, green, blue, _] = picture.planes();
    let mut pixels = Vec::with_capacity(3 * red.values().len());
    for ((&r, &g), &b) in red.values().iter().zip(green.values()).zip(blue.values()) {
        pixels.extend([r, g, b].map(|linear| srgb_byte(gain * linear)));
    }
    let window = picture.window();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive).write_image(
        &pixels,
        window.width,
        window.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The sRGB byte nearest to a linear value; below 0 and NaN give 0, above 1 gives 255.
#[must_use]
pub fn srgb_byte(linear: f32) -> u8 {
    // One step up for each border passed; NaN passes none
    BORDERS.partition_point(|&border| linear >= border) as u8
}

/// The linear values at which the rounded byte steps up: (i + 1/2) / 255 decoded.
static BORDERS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let encoded = (i as f64 + 0.5) / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

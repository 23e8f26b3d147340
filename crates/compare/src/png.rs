//! Pictures as PNG data URIs.

use base64::Engine;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use rgbd::Picture;

use crate::{CompareError, transfer::srgb_from_linear};

/// The picture as 8-bit sRGB, exposed by `stops`, in a `data:` URI.
pub(crate) fn data_uri(picture: &Picture, stops: f32) -> Result<String, CompareError> {
    let (window, factor) = (picture.window(), f64::from(stops).exp2());
    let [r, g, b, _] = picture.planes();
    let encode = |value: f32| (255.0 * srgb_from_linear(factor * f64::from(value))).round() as u8;
    let colors = r.values().iter().zip(g.values()).zip(b.values());
    let bytes: Vec<u8> = colors.flat_map(|((&r, &g), &b)| [r, g, b].map(encode)).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&bytes, window.width, window.height, ExtendedColorType::Rgb8)
        .map_err(|error| CompareError::Png(error.to_string()))?;
    Ok(format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png)))
}

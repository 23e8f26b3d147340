//! Pictures as PNG data URIs.

use base64::Engine;
use rgbd::{Picture, encode_png};

use crate::CompareError;

/// The picture as 8-bit sRGB, exposed by `stops`, in a `data:` URI.
pub(crate) fn data_uri(picture: &Picture, stops: f32) -> Result<String, CompareError> {
    let png = encode_png(picture, stops).map_err(|error| CompareError::Png(error.to_string()))?;
    Ok(format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png)))
}

//! Linear pictures as photos.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, tiff::TiffEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult, Rgb};
use rayon::prelude::*;

use super::pfm::encode_pfm;
use super::{Encoding, PhotoFormat, SampleDepth};
use crate::replace::replace_file;
use crate::{Picture, WriteError};

/// Quality of a JPEG: no blocks are seen, even where a blurred sky fades.
const JPEG_QUALITY: u8 = 95;

/// Writes the picture's whole window, `2^exposure_stops` times as bright, stored as `encoding` says. Its colours must be in
/// the primaries of the encoding. It stands whole or not at all.
///
/// Where the format holds no alpha the picture is laid over black; where it holds no light above white it is clipped.
pub fn write_photo(path: &Path, picture: &Picture, encoding: &Encoding, exposure_stops: f32) -> Result<(), WriteError> {
    let window = picture.window();
    if window.is_empty() {
        return Err(WriteError::BadWindow { path: path.into(), what: "data", window });
    }
    let bytes = encode(picture, encoding, exposure_stops.exp2())
        .map_err(|error| WriteError::Encoding { path: path.into(), reason: error.to_string() })?;
    replace_file(path, &bytes).map_err(|source| WriteError::Io { path: path.into(), source })
}

fn encode(picture: &Picture, encoding: &Encoding, gain: f32) -> ImageResult<Vec<u8>> {
    let (width, height) = (picture.window().width, picture.window().height);
    let transfer = &encoding.transfer;
    let mut bytes = Vec::new();
    match (encoding.format, encoding.depth) {
        // Light itself
        (PhotoFormat::Pfm, _) => bytes = encode_pfm(width, height, &interleaved(picture, false, gain, |_, x| x)),
        (PhotoFormat::Hdr, _) => {
            let finite = |_, x: f32| if x > 0.0 { x.min(f32::MAX) } else { 0.0 };
            let numbers = interleaved(picture, false, gain, finite);
            let pixels: Vec<Rgb<f32>> = numbers.chunks_exact(3).map(|p| Rgb([p[0], p[1], p[2]])).collect();
            HdrEncoder::new(&mut bytes).encode(&pixels, width as usize, height as usize)?;
        }
        (_, SampleDepth::Float) => {
            let numbers = interleaved(picture, encoding.has_alpha, gain, |_, x| x);
            let pixels: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
            let kind = if encoding.has_alpha { ExtendedColorType::Rgba32F } else { ExtendedColorType::Rgb32F };
            write_image(&mut bytes, encoding, &pixels, [width, height], kind)?;
        }
        // Numbers of a display
        (_, SampleDepth::Sixteen) => {
            let words = interleaved(picture, encoding.has_alpha, gain, |c, x| match c {
                3 => (65535.0 * x).round() as u16,
                c => transfer.word(c, x),
            });
            let pixels: Vec<u8> = words.iter().flat_map(|word| word.to_ne_bytes()).collect();
            let kind = if encoding.has_alpha { ExtendedColorType::Rgba16 } else { ExtendedColorType::Rgb16 };
            write_image(&mut bytes, encoding, &pixels, [width, height], kind)?;
        }
        (_, SampleDepth::Eight) => {
            let pixels = interleaved(picture, encoding.has_alpha, gain, |c, x| match c {
                3 => (255.0 * x).round() as u8,
                c => transfer.byte(c, x),
            });
            let kind = if encoding.has_alpha { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 };
            write_image(&mut bytes, encoding, &pixels, [width, height], kind)?;
        }
    }
    Ok(bytes)
}

/// Channels side by side, each stored as `store` makes it of (channel, value); colour is not premultiplied beside alpha.
fn interleaved<T: Send + Copy + Default>(
    picture: &Picture,
    with_alpha: bool,
    gain: f32,
    store: impl Fn(usize, f32) -> T + Sync,
) -> Vec<T> {
    let [r, g, b, a] = picture.planes();
    let channels = if with_alpha { 4 } else { 3 };
    let mut stored = vec![T::default(); channels * a.values().len()];
    stored.par_chunks_exact_mut(channels).enumerate().for_each(|(i, pixel)| {
        let alpha = a.values()[i];
        let share = if with_alpha && alpha > 0.0 { gain / alpha } else { gain };
        for (c, plane) in [r, g, b].into_iter().enumerate() {
            pixel[c] = store(c, share * plane.values()[i]);
        }
        if with_alpha {
            pixel[3] = store(3, alpha);
        }
    });
    stored
}

fn write_image(
    bytes: &mut Vec<u8>,
    encoding: &Encoding,
    pixels: &[u8],
    [width, height]: [u32; 2],
    kind: ExtendedColorType,
) -> ImageResult<()> {
    // A profile that the encoder cannot take is missed by nobody but a colour manager
    let profile = encoding.profile.as_ref().map(|profile| profile.to_vec());
    match encoding.format {
        PhotoFormat::Jpeg => {
            let mut encoder = JpegEncoder::new_with_quality(bytes, JPEG_QUALITY);
            if let Some(profile) = profile {
                let _ = encoder.set_icc_profile(profile);
            }
            encoder.write_image(pixels, width, height, kind)
        }
        PhotoFormat::Tiff => {
            let mut encoder = TiffEncoder::new(std::io::Cursor::new(bytes));
            if let Some(profile) = profile {
                let _ = encoder.set_icc_profile(profile);
            }
            encoder.write_image(pixels, width, height, kind)
        }
        _ => {
            let mut encoder = PngEncoder::new_with_quality(bytes, CompressionType::Fast, FilterType::Adaptive);
            if let Some(profile) = profile {
                let _ = encoder.set_icc_profile(profile);
            }
            encoder.write_image(pixels, width, height, kind)
        }
    }
}

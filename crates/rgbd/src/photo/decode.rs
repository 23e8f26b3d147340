//! The stored numbers of a photo, as they stand in the file.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use image::codecs::{hdr::HdrDecoder, jpeg::JpegDecoder, png::PngDecoder, tiff::TiffDecoder};
use image::{DynamicImage, ImageDecoder, ImageResult, Limits, metadata::Orientation};

use super::PhotoFormat;
use super::pfm::{decode_pfm, pfm_size};
use super::profile::tiff_profile;
use crate::ReadError;

/// Stored numbers, channels interleaved, top row first, upright.
pub(crate) struct Decoded {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha.
    pub(crate) channels: usize,
    pub(crate) samples: Samples,
    /// The ICC profile.
    pub(crate) profile: Option<Vec<u8>>,
    /// The EXIF block.
    pub(crate) exif: Option<Vec<u8>>,
}

/// Numbers as a file keeps them.
pub(crate) enum Samples {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
    Float(Vec<f32>),
}

/// Decodes a file of this format; more than `max_pixels` are refused before anything is allocated for them.
pub(crate) fn decode(path: &Path, format: PhotoFormat, max_pixels: u64) -> Result<Decoded, ReadError> {
    let bytes = std::fs::read(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    let refused = |reason: String| ReadError::Undecodable { path: path.into(), format, reason };
    let (width, height) = size_of(&bytes, format).map_err(refused)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > max_pixels {
        return Err(ReadError::TooLarge { path: path.into(), what: "header".into(), pixels, limit: max_pixels });
    }
    if pixels == 0 {
        return Err(refused("it has no pixel".into()));
    }
    match format {
        PhotoFormat::Pfm => decode_pfm(&bytes).map_err(refused),
        _ => {
            let decoded = guarded(|| with_decoder(&bytes, format, max_pixels, Pixels)).map_err(refused)?;
            let profile = decoded.profile.or_else(|| tiff_profile(&bytes));
            Ok(Decoded { profile, ..decoded })
        }
    }
}

/// Width and height as the header claims them, upright.
pub(super) fn size_of(bytes: &[u8], format: PhotoFormat) -> Result<(u32, u32), String> {
    match format {
        PhotoFormat::Pfm => pfm_size(bytes).map(|(width, height, _)| (width, height)),
        _ => guarded(|| with_decoder(bytes, format, u64::MAX, Size)),
    }
}

/// Runs a decoder; its error, or a panic in it, is a reason.
fn guarded<T>(work: impl FnOnce() -> ImageResult<T>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|error| error.to_string()),
        Err(_) => Err("it holds nothing that can be decoded".into()),
    }
}

/// Something to do with a decoder of any format.
trait Task {
    type Made;
    fn run(self, decoder: impl ImageDecoder) -> ImageResult<Self::Made>;
}

fn with_decoder<T: Task>(bytes: &[u8], format: PhotoFormat, max_pixels: u64, task: T) -> ImageResult<T::Made> {
    // Room for 16 bytes a pixel, and what the decoder keeps beside them
    const BESIDE: u64 = 64 << 20;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(max_pixels.saturating_mul(16).saturating_add(BESIDE));
    let cursor = Cursor::new(bytes);
    match format {
        PhotoFormat::Png => task.run(PngDecoder::with_limits(cursor, limits)?),
        PhotoFormat::Jpeg => task.run(JpegDecoder::new(cursor)?),
        PhotoFormat::Tiff => {
            let mut decoder = TiffDecoder::new(cursor)?;
            decoder.set_limits(limits)?;
            task.run(decoder)
        }
        PhotoFormat::Hdr | PhotoFormat::Pfm => task.run(HdrDecoder::new(cursor)?),
    }
}

struct Size;

impl Task for Size {
    type Made = (u32, u32);

    fn run(self, mut decoder: impl ImageDecoder) -> ImageResult<(u32, u32)> {
        let (width, height) = decoder.dimensions();
        Ok(if is_on_its_side(decoder.orientation()?) { (height, width) } else { (width, height) })
    }
}

fn is_on_its_side(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
}

struct Pixels;

impl Task for Pixels {
    type Made = Decoded;

    fn run(self, mut decoder: impl ImageDecoder) -> ImageResult<Decoded> {
        let (profile, orientation) = (decoder.icc_profile()?, decoder.orientation()?);
        let exif = decoder.exif_metadata().ok().flatten();
        let mut image = DynamicImage::from_decoder(decoder)?;
        image.apply_orientation(orientation);
        let (width, height, channels) = (image.width(), image.height(), usize::from(image.color().channel_count()));
        let samples = match image {
            DynamicImage::ImageLuma8(image) => Samples::Eight(image.into_raw()),
            DynamicImage::ImageLumaA8(image) => Samples::Eight(image.into_raw()),
            DynamicImage::ImageRgb8(image) => Samples::Eight(image.into_raw()),
            DynamicImage::ImageRgba8(image) => Samples::Eight(image.into_raw()),
            DynamicImage::ImageLuma16(image) => Samples::Sixteen(image.into_raw()),
            DynamicImage::ImageLumaA16(image) => Samples::Sixteen(image.into_raw()),
            DynamicImage::ImageRgb16(image) => Samples::Sixteen(image.into_raw()),
            DynamicImage::ImageRgba16(image) => Samples::Sixteen(image.into_raw()),
            DynamicImage::ImageRgb32F(image) => Samples::Float(image.into_raw()),
            DynamicImage::ImageRgba32F(image) => Samples::Float(image.into_raw()),
            other => Samples::Eight(other.into_rgba8().into_raw()),
        };
        Ok(Decoded { width, height, channels, samples, profile, exif })
    }
}

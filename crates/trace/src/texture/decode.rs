//! Textures out of PNG and JPEG files.

use std::io::Cursor;
use std::sync::LazyLock;

use image::{ImageReader, Limits};
use thiserror::Error;

use super::Texture;

/// Largest width and height.
const MOST_SIDE: u32 = 16_384;
/// Most texels: 8 bytes each, and a third more for the halvings.
const MOST_TEXELS: u64 = 1 << 26;

/// What the numbers of a file stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours, sRGB.
    Color,
    /// Linear values: roughness, normals.
    Data,
}

/// Why a picture is no texture.
#[derive(Debug, Error)]
pub enum TextureError {
    /// It is too large.
    #[error("it has {0} x {1} pixels; at most {MOST_SIDE} a side and {MOST_TEXELS} in all will do")]
    TooLarge(u32, u32),
    /// It is no PNG or JPEG, or damaged.
    #[error("it is no readable PNG or JPEG: {0}")]
    Decode(#[from] image::ImageError),
}

/// Linear values of sRGB, both in 16 bits.
static LINEAR: LazyLock<Vec<u16>> = LazyLock::new(|| {
    let most = f64::from(u16::MAX);
    let linear = |code: u32| {
        let x = f64::from(code) / most;
        let y = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
        (y * most + 0.5) as u16
    };
    (0..=u32::from(u16::MAX)).map(linear).collect()
});

/// Reads a PNG or JPEG.
pub(crate) fn decode(bytes: &[u8], encoding: Encoding) -> Result<Texture, TextureError> {
    // Ask for its size before anything is allocated
    let reader = || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(image::ImageError::IoError);
    let (width, height) = reader()?.into_dimensions()?;
    let is_small = width <= MOST_SIDE && height <= MOST_SIDE && u64::from(width) * u64::from(height) <= MOST_TEXELS;
    if !is_small || width == 0 || height == 0 {
        return Err(TextureError::TooLarge(width, height));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_SIDE);
    limits.max_image_height = Some(MOST_SIDE);
    limits.max_alloc = Some(1 << 30);
    let mut reader = reader()?;
    reader.limits(limits);
    let picture = reader.decode()?.into_rgba16();

    // Keep alpha as it is
    let texel = |pixel: &image::Rgba<u16>| match encoding {
        Encoding::Data => pixel.0,
        Encoding::Color => {
            let [r, g, b, a] = pixel.0;
            let [r, g, b] = [r, g, b].map(|code| LINEAR[usize::from(code)]);
            [r, g, b, a]
        }
    };
    Ok(Texture::new(width as usize, height as usize, picture.pixels().map(texel).collect()))
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, ImageFormat, RgbImage};

    use super::*;
    use crate::Wrap;

    fn coded(format: ImageFormat) -> Vec<u8> {
        let picture =
            RgbImage::from_fn(16, 8, |x, _| if x < 8 { image::Rgb([255, 128, 0]) } else { image::Rgb([0; 3]) });
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::ImageRgb8(picture).write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn srgb_becomes_linear_and_data_stays() {
        let at = |texture: &Texture| texture.sample(glam::Vec2::new(0.2, 0.5), [Wrap::Clamp; 2], 0.0);
        // IEC 61966-2-1: code 128 of 255 is 0.21586
        let color = at(&decode(&coded(ImageFormat::Png), Encoding::Color).unwrap());
        assert!((color.y - 0.215_86).abs() < 2e-5 && color.x == 1.0 && color.z == 0.0 && color.w == 1.0, "{color}");
        let data = at(&decode(&coded(ImageFormat::Png), Encoding::Data).unwrap());
        assert!((data.y - 128.0 / 255.0).abs() < 2e-5);
        // JPEG is lossy: a few steps of 255
        let lossy = at(&decode(&coded(ImageFormat::Jpeg), Encoding::Color).unwrap());
        assert!((lossy - color).abs().max_element() < 0.03, "{lossy}");
    }

    #[test]
    fn damaged_files_are_refused() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let bytes = coded(format);
            for length in 0..bytes.len().min(60) {
                assert!(decode(&bytes[..length], Encoding::Color).is_err());
            }
            for place in 0..bytes.len() {
                let mut changed = bytes.clone();
                changed[place] ^= 0x5a;
                // Anything but a panic will do
                let _ = decode(&changed, Encoding::Color);
            }
        }
        assert!(decode(b"no picture", Encoding::Color).is_err());
    }
}

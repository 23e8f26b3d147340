//! Photos as linear pictures.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::PhotoFormat;
use super::decode::{Decoded, Samples, decode, size_of};
use super::exif::lens as exif_lens;
use super::profile::understand;
use super::transfer::Transfer;
use crate::{LensAttributes, Picture, PixelWindow, Plane, Primaries, ReadError};

/// A photo: light, and how it was stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Linear, premultiplied, upright, in the primaries of its encoding; opaque where the file has no alpha.
    pub picture: Picture,
    /// How it was stored, to store a result the same way.
    pub encoding: Encoding,
    /// What its camera notes (EXIF): focal length, f-number, and the field of view where it tells the equivalent focal length.
    pub lens: LensAttributes,
}

/// How a photo is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoding {
    /// The format of the file.
    pub format: PhotoFormat,
    /// How fine its numbers are.
    pub depth: SampleDepth,
    /// What its red, green and blue mean.
    pub primaries: Primaries,
    /// Whether it has alpha.
    pub has_alpha: bool,
    /// Its transfer and colours, in a few words.
    pub described: &'static str,
    pub(super) transfer: Transfer,
    /// The ICC profile that goes back into the file; only one that is understood.
    pub(super) profile: Option<Arc<Vec<u8>>>,
}

/// How fine the numbers of a photo are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleDepth {
    /// 8 bit.
    Eight,
    /// 16 bit.
    Sixteen,
    /// 32-bit floats.
    Float,
}

impl Encoding {
    /// 8-bit sRGB without alpha, or light itself where the format holds that.
    #[must_use]
    pub fn plain(format: PhotoFormat) -> Self {
        let linear = format.is_linear();
        Self {
            format,
            depth: if linear { SampleDepth::Float } else { SampleDepth::Eight },
            primaries: Primaries::REC709,
            has_alpha: false,
            described: if linear { "linear" } else { "sRGB" },
            transfer: if linear { Transfer::Linear } else { Transfer::Srgb },
            profile: None,
        }
    }

    /// The same transfer and colours in another format, as fine as that holds.
    #[must_use]
    pub fn in_format(&self, format: PhotoFormat) -> Self {
        let was_linear = self.transfer == Transfer::Linear;
        if format.is_linear() || (was_linear && format != self.format) {
            return Self { primaries: self.primaries, ..Self::plain(format) };
        }
        let depth = if format == PhotoFormat::Jpeg { SampleDepth::Eight } else { self.depth };
        Self { format, depth, has_alpha: self.has_alpha && format != PhotoFormat::Jpeg, ..self.clone() }
    }
}

/// Width and height of a photo, upright; only its header is understood.
pub fn photo_size(path: &Path, format: PhotoFormat) -> Result<(u32, u32), ReadError> {
    let bytes = std::fs::read(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    size_of(&bytes, format).map_err(|reason| ReadError::Undecodable { path: path.into(), format, reason })
}

/// Reads a photo of this format as light: by its ICC profile where that has three curves and three primaries, else by sRGB;
/// floats are light already.
pub fn read_photo(path: &Path, format: PhotoFormat, max_pixels: u64) -> Result<Photo, ReadError> {
    let decoded = decode(path, format, max_pixels)?;
    let Decoded { width, height, channels, ref samples, ref profile, ref exif } = decoded;
    let lens = exif.as_ref().map_or_else(LensAttributes::default, |exif| exif_lens(exif, [width, height]));
    let has_alpha = channels % 2 == 0;

    // Find out what the numbers mean
    let mut encoding = Encoding { has_alpha, ..Encoding::plain(format) };
    encoding.depth = match samples {
        Samples::Eight(_) => SampleDepth::Eight,
        Samples::Sixteen(_) => SampleDepth::Sixteen,
        Samples::Float(_) => SampleDepth::Float,
    };
    if encoding.depth == SampleDepth::Float {
        (encoding.transfer, encoding.described) = (Transfer::Linear, "linear");
    } else if let Some(profile) = profile {
        match understand(profile).filter(|_| channels >= 3) {
            Some(understood) => {
                encoding.described =
                    if understood.transfer == Transfer::Srgb { "sRGB, as its profile says" } else { "its ICC profile" };
                encoding.transfer = understood.transfer;
                encoding.primaries = understood.primaries;
                encoding.profile = Some(Arc::new(profile.clone()));
            }
            None => encoding.described = "sRGB, since its ICC profile is of a kind that is not understood",
        }
    } else {
        encoding.described = "sRGB, since it has no profile";
    }

    // Make light of them
    let window = PixelWindow::of_size(width, height);
    let alpha = has_alpha.then(|| channel(samples, channels, channels - 1, &Transfer::Linear, 0));
    let mut planes = [0, 1, 2].map(|c| {
        let stored = if channels < 3 { 0 } else { c };
        let mut values = channel(samples, channels, stored, &encoding.transfer, c);
        if let Some(alpha) = &alpha {
            values.iter_mut().zip(alpha).for_each(|(value, alpha)| *value *= alpha);
        }
        values
    });
    drop(decoded);
    let [r, g, b] = [0, 1, 2].map(|c| std::mem::take(&mut planes[c]));
    let alpha = alpha.unwrap_or_else(|| vec![1.0; window.area()]);
    let plane = |values| Plane::from_values(window, values).expect("a number for each pixel");
    let picture = Picture::from_planes([r, g, b, alpha].map(plane)).expect("planes of one window");
    Ok(Photo { picture, encoding, lens })
}

/// One channel of interleaved samples as light, by the transfer of colour `c`.
fn channel(samples: &Samples, channels: usize, at: usize, transfer: &Transfer, c: usize) -> Vec<f32> {
    match samples {
        Samples::Eight(bytes) => {
            let table = transfer.table(c, 1 << 8);
            bytes.par_chunks_exact(channels).map(|pixel| table[usize::from(pixel[at])]).collect()
        }
        Samples::Sixteen(words) => {
            let table = transfer.table(c, 1 << 16);
            words.par_chunks_exact(channels).map(|pixel| table[usize::from(pixel[at])]).collect()
        }
        Samples::Float(numbers) => numbers.par_chunks_exact(channels).map(|pixel| pixel[at]).collect(),
    }
}

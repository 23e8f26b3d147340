//! What a camera notes beside its photos: focal length and f-number.

use crate::LensAttributes;

const EXIF_DIRECTORY: u64 = 0x8769;
const F_NUMBER: u64 = 0x829d;
const FOCAL_LENGTH: u64 = 0x920a;
const FOCAL_LENGTH_35MM: u64 = 0xa405;

/// Diagonal of 24 x 36 mm, to which the equivalent focal length refers (CIPA DCG-001).
const DIAGONAL_35MM: f64 = 43.266_615;

/// Lens and field of view of a photo of this size in pixels, as its EXIF block tells them.
pub(super) fn lens(exif: &[u8], [width, height]: [u32; 2]) -> LensAttributes {
    let Some(block) = Block::new(exif) else { return LensAttributes::default() };
    let number = |tag| block.exif_number(tag).filter(|number| *number > 0.0 && number.is_finite());
    let equivalent = number(FOCAL_LENGTH_35MM);
    let (width, height) = (f64::from(width), f64::from(height));
    let half_width = equivalent.map(|focal| 0.5 * DIAGONAL_35MM * width / width.hypot(height) / focal);
    LensAttributes {
        focal_length_mm: number(FOCAL_LENGTH).map(|mm| mm as f32),
        f_number: number(F_NUMBER).map(|n| n as f32),
        horizontal_fov_deg: half_width.map(|half| (2.0 * half.atan()).to_degrees() as f32),
        ..LensAttributes::default()
    }
}

/// A block of directories, as TIFF has them.
struct Block<'a> {
    bytes: &'a [u8],
    is_little_endian: bool,
}

impl<'a> Block<'a> {
    fn new(bytes: &'a [u8]) -> Option<Self> {
        let is_little_endian = bytes.starts_with(b"II*\0");
        (is_little_endian || bytes.starts_with(b"MM\0*")).then_some(Self { bytes, is_little_endian })
    }

    fn number(&self, at: usize, size: usize) -> Option<u64> {
        let digits = self.bytes.get(at..at.checked_add(size)?)?.iter().map(|&byte| u64::from(byte));
        let append = |number: u64, byte: u64| number << 8 | byte;
        Some(if self.is_little_endian { digits.rev().fold(0, append) } else { digits.fold(0, append) })
    }

    /// Where the entry of a tag starts in a directory.
    fn entry(&self, directory: usize, tag: u64) -> Option<usize> {
        let count = self.number(directory, 2)? as usize;
        (0..count).map(|i| directory + 2 + 12 * i).find(|&at| self.number(at, 2) == Some(tag))
    }

    /// The number of a tag in the EXIF directory: short, long or a fraction.
    fn exif_number(&self, tag: u64) -> Option<f64> {
        let first = self.number(4, 4)? as usize;
        let exif = self.number(self.entry(first, EXIF_DIRECTORY)? + 8, 4)? as usize;
        let entry = self.entry(exif, tag)?;
        match self.number(entry + 2, 2)? {
            3 => Some(self.number(entry + 8, 2)? as f64),
            4 => Some(self.number(entry + 8, 4)? as f64),
            5 => {
                let at = self.number(entry + 8, 4)? as usize;
                Some(self.number(at, 4)? as f64 / self.number(at.checked_add(4)?, 4)? as f64)
            }
            _ => None,
        }
    }
}

//! Which format a photo is in.

use std::io::Read;
use std::path::Path;

use crate::ReadError;

/// A format of pictures besides OpenEXR.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PhotoFormat {
    /// 8 or 16 bit.
    Png,
    /// 8 bit, and not exact.
    Jpeg,
    /// 8 or 16 bit, or float.
    Tiff,
    /// Radiance: linear, with a shared exponent.
    Hdr,
    /// Portable float map: linear.
    Pfm,
}

impl PhotoFormat {
    /// The format that a file's first bytes tell; `None` for all others, OpenEXR among them.
    pub fn of_file(path: &Path) -> Result<Option<Self>, ReadError> {
        let io = |source| ReadError::Io { path: path.into(), source };
        let mut start = Vec::new();
        std::fs::File::open(path).map_err(io)?.take(16).read_to_end(&mut start).map_err(io)?;
        Ok(Self::of_bytes(&start))
    }

    fn of_bytes(start: &[u8]) -> Option<Self> {
        const STARTS: [(&[u8], PhotoFormat); 8] = [
            (b"\x89PNG\r\n\x1a\n", PhotoFormat::Png),
            (b"\xff\xd8\xff", PhotoFormat::Jpeg),
            (b"II*\0", PhotoFormat::Tiff),
            (b"MM\0*", PhotoFormat::Tiff),
            (b"II+\0", PhotoFormat::Tiff),
            (b"MM\0+", PhotoFormat::Tiff),
            (b"#?RADIANCE", PhotoFormat::Hdr),
            (b"#?RGBE", PhotoFormat::Hdr),
        ];
        // A word and any white space
        if let [b'P', b'F' | b'f', space, ..] = start
            && space.is_ascii_whitespace()
        {
            return Some(Self::Pfm);
        }
        STARTS.into_iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, format)| format)
    }

    /// The format that a name's ending asks for.
    #[must_use]
    pub fn of_name(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "tif" | "tiff" => Some(Self::Tiff),
            "hdr" => Some(Self::Hdr),
            "pfm" => Some(Self::Pfm),
            _ => None,
        }
    }

    /// Whether its numbers are light itself, without a transfer.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Hdr | Self::Pfm)
    }
}

impl std::fmt::Display for PhotoFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::Hdr => "Radiance HDR",
            Self::Pfm => "PFM",
        })
    }
}

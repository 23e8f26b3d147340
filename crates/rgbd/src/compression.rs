//! How the pixels of a written file are packed.

/// Lossless compressions of an OpenEXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Not at all: the fastest, and the largest.
    None,
    /// Run lengths of bytes: about as fast as none, smaller where the picture has flat parts.
    #[default]
    Rle,
    /// Deflate, line by line.
    Zips,
    /// Deflate, 16 lines at a time: small and very slow to write.
    Zip,
    /// Wavelets: for noisy pictures; slow to read and to write.
    Piz,
}

impl From<Compression> for exr::compression::Compression {
    fn from(compression: Compression) -> Self {
        match compression {
            Compression::None => Self::Uncompressed,
            Compression::Rle => Self::RLE,
            Compression::Zips => Self::ZIP1,
            Compression::Zip => Self::ZIP16,
            Compression::Piz => Self::PIZ,
        }
    }
}

//! Photos: pictures that were made for a display, and linear ones of other formats than OpenEXR.

mod decode;
mod exif;
mod format;
mod pfm;
mod profile;
mod read;
mod transfer;
mod write;

pub(crate) use decode::{Decoded, Samples, decode};
pub use format::PhotoFormat;
pub use read::{Encoding, Photo, SampleDepth, photo_size, read_photo};
pub use write::write_photo;

//! A block of deep pixels, unpacked.

use exr::compression::Compression;
use exr::error::{Error, Result};
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType};
use exr::meta::header::Header;

use super::chunks::PackedBlock;
use crate::PixelWindow;

/// The samples of a few lines or of a tile.
pub(crate) struct DeepBlock {
    /// Its pixels, counted from the top left one of the data window.
    pub(crate) place: PixelWindow,
    /// For each pixel, row by row, how many samples its line has up to and with it.
    ends: Vec<u32>,
    /// Where the bytes of each row start.
    rows: Vec<usize>,
    /// Row by row, channel by channel, sample by sample, little-endian.
    bytes: Vec<u8>,
}

/// Where the numbers of a channel stand among those of all channels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelPlace {
    /// Bytes that one sample has of all channels before it.
    before: usize,
    kind: SampleType,
}

impl ChannelPlace {
    /// The place of channel `index` of a part.
    pub(crate) fn of(header: &Header, index: usize) -> Self {
        let list = &header.channels.list;
        let before = list[..index].iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
        Self { before, kind: list[index].sample_type }
    }
}

impl DeepBlock {
    /// Unpacks a chunk. An error if counts fall along a line, or do not fit the number of bytes.
    pub(crate) fn unpack(header: &Header, packed: PackedBlock) -> Result<Self> {
        let place = packed.place;
        let width = place.width as usize;
        let counts = unpack(header.compression, packed.counts, 4 * place.area())?;
        let ends: Vec<u32> =
            counts.chunks_exact(4).map(|end| u32::from_le_bytes([end[0], end[1], end[2], end[3]])).collect();

        // Each line starts to count anew
        let mut rows = Vec::with_capacity(place.height as usize);
        let mut end = 0_usize;
        for line in ends.chunks_exact(width) {
            if !line.is_sorted() {
                return Err(invalid("counts of deep samples"));
            }
            rows.push(end);
            let samples = line.last().map_or(0, |&last| last as usize);
            let bytes = samples.checked_mul(header.channels.bytes_per_pixel);
            end = bytes.and_then(|bytes| end.checked_add(bytes)).ok_or_else(|| invalid("counts of deep samples"))?;
        }
        if end != packed.unpacked {
            return Err(invalid("counts of deep samples"));
        }
        let bytes = unpack(header.compression, packed.samples, end)?;
        Ok(Self { place, ends, rows, bytes })
    }

    /// Which samples of its line are those of the pixel at a row and column of the block.
    pub(crate) fn samples(&self, row: usize, column: usize) -> std::ops::Range<usize> {
        let at = row * self.place.width as usize + column;
        let start = if column == 0 { 0 } else { self.ends[at - 1] };
        start as usize..self.ends[at] as usize
    }

    /// The number that a channel has in a sample of a line.
    pub(crate) fn value(&self, row: usize, sample: usize, channel: ChannelPlace) -> f32 {
        let width = self.place.width as usize;
        let samples = self.ends[(row + 1) * width - 1] as usize;
        let at = self.rows[row] + samples * channel.before + sample * channel.kind.bytes_per_sample();
        let bytes = &self.bytes[at..];
        match channel.kind {
            SampleType::F16 => exr::prelude::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32(),
            SampleType::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            SampleType::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
        }
    }
}

/// Unpacks bytes that a deep chunk holds.
///
/// What the compressions of deep parts do knows no pixels, only bytes: one line of half floats stands for them.
fn unpack(compression: Compression, packed: Vec<u8>, length: usize) -> Result<Vec<u8>> {
    if length == 0 {
        return if packed.is_empty() { Ok(packed) } else { Err(invalid("bytes of no deep sample")) };
    }
    let halves = ChannelDescription::named("Y", SampleType::F16);
    let line = Vec2(length / 2, 1);
    let header = Header::new("".into(), line, std::iter::once(halves).collect());
    let header = header.with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing);
    let bounds = IntegerBounds::new(Vec2(0, 0), line);
    let bytes = compression.decompress_image_section_from_le(&header, packed, bounds, false)?;
    if bytes.len() != length {
        return Err(invalid("size of a deep block"));
    }
    // The decoder gives numbers in the order of this machine
    let halves = bytes.chunks_exact(2).map(|half| u16::from_ne_bytes([half[0], half[1]]).to_le_bytes());
    Ok(if cfg!(target_endian = "little") { bytes } else { halves.flatten().collect() })
}

fn invalid(what: &'static str) -> Error {
    Error::Invalid(what.into())
}

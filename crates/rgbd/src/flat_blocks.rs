//! Parts with one value for each pixel and channel, decoded chunk by chunk.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{Compression, SampleType};
use rayon::prelude::*;

use crate::Plane;
use crate::exr_file::ExrFile;
use crate::guard::guarded;
use crate::offset_table::chunk_offsets;

/// Decodes the chunks of some flat parts, a batch at a time on all threads, and copies the lines of the channels that
/// have a plane, by part and channel. Only full size is decoded, not the smaller levels of mip and rip maps.
pub(crate) fn decode_parts(
    file: &ExrFile,
    parts: &BTreeSet<usize>,
    planes: &mut BTreeMap<(usize, usize), Plane>,
) -> exr::error::UnitResult {
    const BATCH: usize = 64; // chunks; is enough for all cores
    const BATCH_BYTES: usize = 64 << 20; // bounds the memory where chunks are large
    let headers = &file.meta().headers;
    let largest = parts.iter().map(|&part| headers[part].max_block_byte_size()).max().unwrap_or(1);
    let batch = (BATCH_BYTES / largest.max(1)).clamp(1, BATCH);
    let meta = file.meta();
    let mut chunks = chunks(file, parts)?;
    loop {
        let batch: Vec<Chunk> = chunks.by_ref().take(batch).collect::<exr::error::Result<_>>()?;
        if batch.is_empty() {
            return Ok(());
        }
        let blocks: Vec<_> = batch
            .into_par_iter()
            .map(|chunk| {
                check_dwa_sizes(&chunk, meta)?;
                guarded(|| UncompressedBlock::decompress_chunk(chunk, meta, false))
            })
            .collect::<exr::error::Result<_>>()?;
        for block in &blocks {
            copy_lines(block, meta, planes);
        }
    }
}

/// The full-size chunks of some flat parts.
fn chunks<'a>(
    file: &'a ExrFile,
    parts: &'a BTreeSet<usize>,
) -> exr::error::Result<Box<dyn Iterator<Item = exr::error::Result<Chunk>> + 'a>> {
    let mut bytes = BufReader::new(File::open(file.path())?);
    let meta = file.meta();
    if !meta.headers.iter().any(|header| header.deep) {
        let is_wanted = |block: BlockIndex| parts.contains(&block.layer) && block.level == Vec2(0, 0);
        let wanted = guarded(|| exr::block::read(bytes, false)?.filter_chunks(true, |_, _, block| is_wanted(block)))?;
        return Ok(Box::new(wanted));
    }

    // The decoder opens no file with a deep part
    let mut offsets = Vec::new();
    for &part in parts {
        offsets.extend(chunk_offsets(file, part)?.into_iter().map(|(_, offset)| offset));
    }
    Ok(Box::new(offsets.into_iter().map(move |offset| {
        bytes.seek(SeekFrom::Start(offset))?;
        let chunk = Chunk::read(&mut bytes, meta)?;
        if parts.contains(&chunk.layer_index) { Ok(chunk) } else { Err(Error::Invalid("part of a chunk".into())) }
    })))
}

/// Refuses a DWA chunk that claims to unpack to far more than its pixels.
///
/// The decoder (exr 1.74) allocates what the chunk's first eleven u64 claim, and one changed bit there can be 2^53 bytes.
fn check_dwa_sizes(chunk: &Chunk, meta: &MetaData) -> exr::error::UnitResult {
    let Some(header) = meta.headers.get(chunk.layer_index) else { return Ok(()) };
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    // A chunk that would not shrink is stored as it is, without sizes
    let place = header.get_absolute_block_pixel_coordinates(header.get_block_data_indices(&chunk.compressed_block)?)?;
    if bytes.len() == place.size.area() * header.channels.bytes_per_pixel {
        return Ok(());
    }
    // Blocks of 8 x 8 may stand out at two sides, and halves become floats
    let most = 4 * (place.size.width() + 8) * (place.size.height() + 8) * header.channels.bytes_per_pixel;
    let sizes = bytes.chunks_exact(8).take(10).skip(1).map(|size| {
        let size: [u8; 8] = size.try_into().unwrap_or_default();
        u64::from_le_bytes(size)
    });
    if sizes.max().is_some_and(|size| size > most as u64) {
        return Err(Error::Invalid("sizes in a DWA chunk".into()));
    }
    Ok(())
}

/// Copies the lines of the wanted channels out of a block.
fn copy_lines(block: &UncompressedBlock, meta: &MetaData, planes: &mut BTreeMap<(usize, usize), Plane>) {
    let channels = &meta.headers[block.index.layer].channels;
    for line in block.lines(channels) {
        let at = line.location;
        let Some(plane) = planes.get_mut(&(at.layer, at.channel)) else { continue };
        let start = at.position.y() * plane.window().width as usize + at.position.x();
        let target = plane.values_mut()[start..start + at.sample_count].iter_mut();
        match channels.list[at.channel].sample_type {
            SampleType::F32 => {
                for (value, bytes) in target.zip(line.value.chunks_exact(4)) {
                    *value = f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                }
            }
            SampleType::F16 => {
                for (value, bytes) in target.zip(line.value.chunks_exact(2)) {
                    *value = exr::prelude::f16::from_ne_bytes([bytes[0], bytes[1]]).to_f32();
                }
            }
            SampleType::U32 => {
                for (value, bytes) in target.zip(line.value.chunks_exact(4)) {
                    *value = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32;
                }
            }
        }
    }
}

//! Where the chunks of a part lie in a file, for files that the decoder does not open as a whole.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

use exr::block::chunk::TileCoordinates;
use exr::error::Result;
use exr::math::Vec2;

use crate::exr_file::ExrFile;

/// The full-size chunks of a part with their offsets, in the order of the file; an error if the part's header makes no
/// sense. [`ExrFile::open`] has seen to it that the file can hold the table.
pub(crate) fn chunk_offsets(file: &ExrFile, part: usize) -> Result<Vec<(TileCoordinates, u64)>> {
    let meta = file.meta();
    let header = &meta.headers[part];
    header.validate(meta.requirements.has_multiple_layers, &mut false, false)?;
    let mut bytes = BufReader::new(File::open(file.path())?);
    let before: u64 = meta.headers[..part].iter().map(|header| header.chunk_count as u64).sum();
    bytes.seek(SeekFrom::Start(file.tables_at() + 8 * before))?;

    let mut offsets = Vec::with_capacity(header.chunk_count);
    for block in header.blocks_increasing_y_order() {
        let mut offset = [0; 8];
        bytes.read_exact(&mut offset)?;
        let offset = u64::from_le_bytes(offset);
        if offset < file.tables_at() || offset >= file.length() {
            return Err(exr::error::Error::Invalid("offset of a chunk".into()));
        }
        if block.location.level_index == Vec2(0, 0) {
            offsets.push((block.location, offset));
        }
    }
    offsets.sort_by_key(|&(_, offset)| offset);
    Ok(offsets)
}

//! The chunks of a deep part as they lie in the file.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

use exr::block::chunk::TileCoordinates;
use exr::meta::BlockDescription;
use exr::meta::header::Header;

use crate::exr_file::{ExrFile, refusal};
use crate::offset_table::chunk_offsets;
use crate::{PixelWindow, ReadError};

/// The most bytes that a block may unpack to. A scan line of 4096 pixels with 1000 samples of 24 bytes has 98 MB.
const LARGEST_BLOCK: u64 = 1 << 27;

/// No compression that deep parts allow packs more bytes than this into one (Deflate 1032, run lengths 64), short blocks
/// aside.
const DENSEST: u64 = 1100;

/// A chunk, still packed. Sizes are checked: what is packed is in the file, what it unpacks to is bounded.
pub(crate) struct PackedBlock {
    /// Its pixels, counted from the top left one of the data window.
    pub(crate) place: PixelWindow,
    /// Running sums of the samples of each line, packed.
    pub(crate) counts: Vec<u8>,
    /// The samples, packed.
    pub(crate) samples: Vec<u8>,
    /// How many bytes the samples are.
    pub(crate) unpacked: usize,
}

/// Reads the chunks of one deep part.
pub(crate) struct Chunks<'a> {
    file: &'a ExrFile,
    part: usize,
    bytes: BufReader<File>,
    /// The place of each full-size block in the picture and in the file.
    places: std::vec::IntoIter<(TileCoordinates, u64)>,
}

impl<'a> Chunks<'a> {
    /// Reads the part's table of offsets.
    pub(crate) fn of(file: &'a ExrFile, part: usize) -> Result<Self, ReadError> {
        let refused = |error| refusal(file.path(), error);
        let bytes = File::open(file.path()).map_err(|source| refused(source.into()))?;
        let places = chunk_offsets(file, part).map_err(refused)?.into_iter();
        Ok(Self { file, part, bytes: BufReader::new(bytes), places })
    }

    fn header(&self) -> &'a Header {
        &self.file.meta().headers[self.part]
    }

    fn damaged(&self, reason: String) -> ReadError {
        ReadError::Damaged { path: self.file.path().into(), reason }
    }

    /// One chunk, and nothing allocated before its sizes are found possible.
    fn read(&mut self, location: TileCoordinates, offset: u64) -> Result<PackedBlock, ReadError> {
        let path = self.file.path();
        let io = |source| refusal(path, exr::error::Error::from(source));
        let header = self.header();
        let place = header.get_absolute_block_pixel_coordinates(location).map_err(|error| refusal(path, error))?;
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let (x, y) = (place.position.x(), place.position.y());
        let place = PixelWindow { x, y, width: size(place.size.width()), height: size(place.size.height()) };

        // Its own word for where it belongs
        self.bytes.seek(SeekFrom::Start(offset)).map_err(io)?;
        let mut head = 0;
        if self.file.meta().requirements.has_multiple_layers {
            head += 4;
            if read_i32(&mut self.bytes).map_err(io)? != i32::try_from(self.part).unwrap_or(-1) {
                return Err(self.damaged(format!("the deep block at row {y} is of another part")));
            }
        }
        let wanted = match header.blocks {
            BlockDescription::ScanLines => vec![i64::from(header.own_attributes.layer_position.y()) + i64::from(y)],
            BlockDescription::Tiles(_) => {
                let TileCoordinates { tile_index: tile, level_index: level } = location;
                [tile.x(), tile.y(), level.x(), level.y()].map(|index| index as i64).to_vec()
            }
        };
        for wanted in wanted {
            head += 4;
            if i64::from(read_i32(&mut self.bytes).map_err(io)?) != wanted {
                return Err(self.damaged(format!("the deep block at row {y} is of another place")));
            }
        }

        // How much there is of it
        let mut sizes = [0; 3];
        for size in &mut sizes {
            *size = read_u64(&mut self.bytes).map_err(io)?;
        }
        let [counts, packed, unpacked] = sizes;
        let left = self.file.length().saturating_sub(offset + head + 24);
        if counts.saturating_add(packed) > left {
            return Err(self.damaged(format!("the deep block at row {y} goes on beyond the end of the file")));
        }
        let table = 4 * place.area() as u64;
        let possible = unpacked <= packed.saturating_mul(DENSEST).saturating_add(64)
            && packed <= unpacked
            && counts <= table
            && table <= counts.saturating_mul(DENSEST).saturating_add(64);
        if !possible {
            return Err(self.damaged(format!("the sizes of the deep block at row {y} make no sense")));
        }
        if unpacked > LARGEST_BLOCK || table > LARGEST_BLOCK {
            return Err(ReadError::Unsupported {
                path: path.into(),
                what: format!("a deep block of {} MB at row {y}", unpacked.max(table) >> 20),
                remedy: "write it with fewer samples, at most 128 MB in a block",
            });
        }

        let mut take = |length: u64| {
            let mut bytes = vec![0; length as usize];
            self.bytes.read_exact(&mut bytes).map(|()| bytes)
        };
        let (counts, samples) = (take(counts).map_err(io)?, take(packed).map_err(io)?);
        Ok(PackedBlock { place, counts, samples, unpacked: unpacked as usize })
    }
}

impl Iterator for Chunks<'_> {
    type Item = Result<PackedBlock, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (location, offset) = self.places.next()?;
        Some(self.read(location, offset))
    }
}

fn read_i32(bytes: &mut impl Read) -> std::io::Result<i32> {
    let mut number = [0; 4];
    bytes.read_exact(&mut number).map(|()| i32::from_le_bytes(number))
}

fn read_u64(bytes: &mut impl Read) -> std::io::Result<u64> {
    let mut number = [0; 8];
    bytes.read_exact(&mut number).map(|()| u64::from_le_bytes(number))
}

//! An OpenEXR file whose header is read and found sane, and the planes that are picked from it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{Compression, SampleType};
use rayon::prelude::*;

use crate::survey::ChannelIndex;
use crate::{PixelWindow, Plane, ReadError, SampleKind, Survey};

/// A file whose header claims nothing absurd.
pub(crate) struct ExrFile {
    path: PathBuf,
    meta: MetaData,
    survey: Survey,
}

impl ExrFile {
    /// Reads the header only; refuses windows of more than `max_pixels` before anything is allocated for them.
    pub(crate) fn open(path: &Path, max_pixels: u64) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: path.into(), source };
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let meta = MetaData::read_from_buffered(BufReader::new(file), false).map_err(|error| refusal(path, error))?;
        let damaged = |reason: &str| ReadError::Damaged { path: path.into(), reason: reason.into() };
        if meta.headers.is_empty() {
            return Err(damaged("it has no part"));
        }
        let survey = Survey::of(&meta);

        // Refuse what would not fit, and what the file is too short to hold
        let windows = std::iter::once(("display window".to_owned(), survey.display));
        let parts = survey.parts.iter().enumerate().map(|(i, part)| {
            let name = part.name.clone().unwrap_or_else(|| i.to_string());
            (format!("data window of part {name}"), part.window)
        });
        for (what, window) in windows.chain(parts) {
            let pixels = u64::from(window.width) * u64::from(window.height);
            if pixels > max_pixels {
                return Err(ReadError::TooLarge { path: path.into(), what, pixels, limit: max_pixels });
            }
            if pixels == 0 {
                return Err(damaged(&format!("its {what} is empty")));
            }
        }
        // Each chunk has its 8 bytes in the table of offsets
        let chunks = meta.headers.iter().fold(0_u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
        if chunks.saturating_mul(8) > length {
            return Err(damaged("it is shorter than its own table of contents"));
        }
        Ok(Self { path: path.into(), meta, survey })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn meta(&self) -> &MetaData {
        &self.meta
    }

    pub(crate) fn survey(&self) -> &Survey {
        &self.survey
    }

    /// The window of the part that a channel is in.
    pub(crate) fn window(&self, at: ChannelIndex) -> PixelWindow {
        self.survey.parts[at.part].window
    }

    /// How a channel stores a number.
    pub(crate) fn kind(&self, at: ChannelIndex) -> SampleKind {
        self.survey.parts[at.part].channels[at.channel].kind
    }

    /// The pixels of these channels, each in the window of its part, in the order asked for.
    ///
    /// Half and uint become f32. A file that ends early or packs nonsense is an error.
    pub(crate) fn planes(&self, wanted: &[ChannelIndex]) -> Result<Vec<Plane>, ReadError> {
        self.refuse_deep()?;
        self.refuse_subsampled(wanted)?;
        let mut planes: BTreeMap<(usize, usize), Plane> =
            wanted.iter().map(|at| ((at.part, at.channel), Plane::filled(self.window(*at), 0.0))).collect();
        self.fill(&mut planes).map_err(|error| refusal(&self.path, error))?;
        // A channel may be asked for twice, as colour and as depth
        let is_last = |i: usize| !wanted[i + 1..].contains(&wanted[i]);
        let take = |(i, at): (usize, &ChannelIndex)| {
            let key = (at.part, at.channel);
            let plane = if is_last(i) { planes.remove(&key) } else { planes.get(&key).cloned() };
            plane.expect("each wanted channel has its plane")
        };
        Ok(wanted.iter().enumerate().map(take).collect())
    }

    /// Refuses deep files by name: the decoder reads no part of a file that has a deep one.
    pub(crate) fn refuse_deep(&self) -> Result<(), ReadError> {
        if !self.survey.parts.iter().any(|part| part.deep) {
            return Ok(());
        }
        let (what, remedy) = ("deep data".into(), "flatten it to one sample a pixel");
        Err(ReadError::Unsupported { path: self.path.clone(), what, remedy })
    }

    /// Refuses by name parts with subsampled channels, which the decoder does not know.
    fn refuse_subsampled(&self, wanted: &[ChannelIndex]) -> Result<(), ReadError> {
        let mut channels = wanted.iter().flat_map(|at| &self.survey.parts[at.part].channels);
        let Some(channel) = channels.find(|channel| channel.subsampled) else { return Ok(()) };
        let what = format!("subsampled channels ({})", channel.name);
        Err(ReadError::Unsupported { path: self.path.clone(), what, remedy: "write all channels in full size" })
    }

    /// Decodes the chunks of the wanted parts, a batch at a time on all threads, and copies the wanted lines.
    fn fill(&self, planes: &mut BTreeMap<(usize, usize), Plane>) -> exr::error::UnitResult {
        const BATCH: usize = 64; // chunks; bounds the memory and is enough for all cores
        let file = BufReader::new(File::open(&self.path)?);
        let parts: Vec<usize> = planes.keys().map(|key| key.0).collect();
        let mut chunks = exr::block::read(file, false)?
            .filter_chunks(true, |_, _, block| parts.contains(&block.layer) && block.level == Vec2(0, 0))?;
        loop {
            let batch: Vec<Chunk> = chunks.by_ref().take(BATCH).collect::<exr::error::Result<_>>()?;
            if batch.is_empty() {
                return Ok(());
            }
            let meta = chunks.meta_data();
            let blocks: Vec<_> = batch
                .into_par_iter()
                .map(|chunk| {
                    check_dwa_sizes(&chunk, meta)?;
                    UncompressedBlock::decompress_chunk(chunk, meta, false)
                })
                .collect::<exr::error::Result<_>>()?;
            for block in &blocks {
                copy_lines(block, meta, planes);
            }
        }
    }
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
        return Err(exr::error::Error::Invalid("sizes in a DWA chunk".into()));
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

/// The decoder's error as ours.
fn refusal(path: &Path, error: exr::error::Error) -> ReadError {
    match error {
        exr::error::Error::Io(source) => ReadError::Io { path: path.into(), source },
        exr::error::Error::NotSupported(what) => ReadError::Unsupported {
            path: path.into(),
            what: what.into_owned(),
            remedy: "write it as a flat OpenEXR 2 file",
        },
        error => ReadError::Damaged { path: path.into(), reason: error.to_string() },
    }
}

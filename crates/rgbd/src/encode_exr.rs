//! One OpenEXR part from planes: the same planes give the same bytes.

use std::io::Cursor;
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Chromaticities, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes};

use crate::attributes::own_attributes;
use crate::{Head, PixelWindow, Plane, WriteError, WriteOptions};

/// What a file of ours holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// A frame with this many layers.
    Frame { layers: usize },
    /// Colour only.
    Picture,
    /// Two halves with these sample counts.
    Truth { samples: [u32; 2] },
}

/// What goes into the header besides the head.
pub(crate) struct Labels<'a> {
    pub(crate) kind: FileKind,
    pub(crate) options: &'a WriteOptions,
}

/// The bytes of a single-part scan line file with these channels, which all have one window.
pub(crate) fn encode(
    path: &Path,
    head: &Head,
    mut channels: Vec<(String, &Plane)>,
    labels: &Labels<'_>,
) -> Result<Vec<u8>, WriteError> {
    // OpenEXR wants channels in the order of their bytes
    channels.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
    check_names(path, &channels)?;
    let data = channels.first().map_or(head.display, |(_, plane)| plane.window());
    let display_bounds = bounds(path, "display", head.display)?;
    bounds(path, "data", data)?;
    if !(head.pixel_aspect >= 1e-6 && head.pixel_aspect <= 1e6) {
        let value = f64::from(head.pixel_aspect);
        return Err(WriteError::BadNumber {
            path: path.into(),
            what: "the pixel aspect",
            value,
            wanted: "1e-6 to 1e6",
        });
    }

    // Describe the part
    let list = channels.iter().map(|(name, _)| ChannelDescription {
        name: text(name),
        sample_type: SampleType::F32,
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    });
    let mut own = own_attributes(path, head, labels)?;
    own.layer_position = Vec2(data.x, data.y);
    let [red, green, blue, white] =
        [head.primaries.red, head.primaries.green, head.primaries.blue, head.primaries.white].map(|[x, y]| Vec2(x, y));
    let header = Header::new(text(""), Vec2(data.width as usize, data.height as usize), list.collect())
        .with_encoding(labels.options.compression.into(), BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(own)
        .with_shared_attributes(ImageAttributes {
            pixel_aspect: head.pixel_aspect,
            chromaticities: Some(Chromaticities { red, green, blue, white }),
            ..ImageAttributes::new(display_bounds)
        });

    // Pack the pixels, in the order of the lines
    let mut bytes = Vec::new();
    exr::block::write(Cursor::new(&mut bytes), std::iter::once(header).collect(), true, |meta, writer| {
        let list = &meta.headers[0].channels;
        let blocks = meta.collect_ordered_blocks(|index| {
            UncompressedBlock::from_lines(list, index, |line| {
                let plane = channels[line.location.channel].1;
                let row = plane.row(data.y + line.location.position.y() as i32);
                for (target, value) in line.value.chunks_exact_mut(4).zip(row) {
                    target.copy_from_slice(&value.to_ne_bytes());
                }
            })
        });
        writer.on_progress(|_| {}).compress_all_blocks_parallel(&meta, blocks)
    })
    .map_err(|error| WriteError::Encoding { path: path.into(), reason: error.to_string() })?;
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Text of UTF-8 bytes, as other programs write it.
pub(crate) fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// The window as OpenEXR has it.
fn bounds(path: &Path, what: &'static str, window: PixelWindow) -> Result<IntegerBounds, WriteError> {
    const FARTHEST: i32 = 1 << 30;
    let near = |x: i32| (-FARTHEST + 2..=FARTHEST - 2).contains(&x);
    if window.is_empty() || ![window.x, window.y, window.x_end(), window.y_end()].into_iter().all(near) {
        return Err(WriteError::BadWindow { path: path.into(), what, window });
    }
    Ok(IntegerBounds::new(Vec2(window.x, window.y), Vec2(window.width as usize, window.height as usize)))
}

/// Refuses channel names that are empty, too long, or there twice.
fn check_names(path: &Path, channels: &[(String, &Plane)]) -> Result<(), WriteError> {
    let bad = |name: &str, why| WriteError::BadName { path: path.into(), what: "plane", name: name.into(), why };
    for (name, _) in channels {
        if let Some(why) = name_fault(name, 255) {
            return Err(bad(name, why));
        }
    }
    match channels.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(bad(&pair[0].0, "is the name of a layer's own channel; give the plane another")),
        None => Ok(()),
    }
}

/// What is wrong with a name, if anything.
pub(crate) fn name_fault(name: &str, longest: usize) -> Option<&'static str> {
    if name.is_empty() {
        Some("is empty")
    } else if name.len() > longest {
        Some("is too long")
    } else if name.contains('\0') {
        Some("holds a NUL")
    } else {
        None
    }
}

/// Puts the attributes of a single-part header into the order of their names.
///
/// The encoder keeps them in a hash map and writes them in an order that differs from run to run. Moving them changes
/// no length, so that the offsets behind them hold.
fn sort_attributes(bytes: &mut [u8]) {
    // Magic number and version, then `name NUL type NUL size value` until an empty name
    const START: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = START;
    while bytes.get(at).is_some_and(|&byte| byte != 0) {
        let Some(end) = attribute_end(bytes, at) else { return };
        attributes.push(&bytes[at..end]);
        at = end;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes[START..at].copy_from_slice(&sorted);
}

/// One past the attribute that starts at `start`.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let after_nul = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
    let size_at = after_nul(after_nul(start)?)?;
    let size = u32::from_le_bytes(bytes.get(size_at..size_at + 4)?.try_into().ok()?);
    let end = size_at + 4 + size as usize;
    (end <= bytes.len()).then_some(end)
}

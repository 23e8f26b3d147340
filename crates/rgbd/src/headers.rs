//! The headers of a file, and where they end.

use std::io::{BufReader, Read, Seek};

use exr::error::Result;
use exr::io::Tracking;
use exr::meta::MetaData;

use crate::guard::guarded;

/// The headers of all parts, and the byte behind them, where the tables of offsets start.
pub(crate) fn read_headers(mut file: impl Read + Seek) -> Result<(MetaData, u64)> {
    let parsed = parse(BufReader::new(&mut file));
    if parsed.is_ok() {
        return parsed;
    }

    // Try once more with what the decoder needlessly refuses set right
    const LARGEST_HEADER: u64 = 1 << 20;
    let mut head = Vec::new();
    file.rewind()?;
    file.take(LARGEST_HEADER).read_to_end(&mut head)?;
    if forget_unknown_sample_counts(&mut head) { parse(head.as_slice()) } else { parsed }
}

fn parse(bytes: impl Read) -> Result<(MetaData, u64)> {
    let mut bytes = Tracking::new(bytes);
    let meta = guarded(|| MetaData::read_from_buffered(&mut bytes, false))?;
    Ok((meta, bytes.byte_position() as u64))
}

/// Sets `maxSamplesPerPixel` of deep parts to 0 where it is negative: some programs write -1 for a number that they do not
/// know yet, which the decoder (exr 1.74) takes for damage. Nothing here reads it. Says whether there was something to do.
fn forget_unknown_sample_counts(head: &mut [u8]) -> bool {
    const NAME: &[u8] = b"maxSamplesPerPixel\0int\0\x04\0\0\0";
    let mut is_changed = false;
    for start in 0..head.len().saturating_sub(NAME.len() + 4) {
        let value = start + NAME.len()..start + NAME.len() + 4;
        if head[start..].starts_with(NAME) && head[value.end - 1] >= 0x80 {
            head[value].fill(0);
            is_changed = true;
        }
    }
    is_changed
}

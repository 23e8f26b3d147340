//! Portable float maps: a line of three words, then rows of f32 from the bottom up.

use super::decode::{Decoded, Samples};

/// Largest header that is looked through; real ones have some 20 bytes.
const LONGEST_HEADER: usize = 256;

/// Width, height and channels (1 or 3) that a header claims.
pub(super) fn pfm_size(bytes: &[u8]) -> Result<(u32, u32, usize), String> {
    header(bytes).map(|header| (header.width, header.height, header.channels))
}

struct Header {
    width: u32,
    height: u32,
    channels: usize,
    is_little_endian: bool,
    /// Where the pixels start.
    end: usize,
}

fn header(bytes: &[u8]) -> Result<Header, String> {
    // Four words, each followed by one white space
    let mut words = Vec::new();
    let mut start = None;
    let mut end = 0;
    for (i, &byte) in bytes.iter().take(LONGEST_HEADER).enumerate() {
        match (byte.is_ascii_whitespace(), start) {
            (false, None) => start = Some(i),
            (true, Some(from)) => {
                words.push(String::from_utf8_lossy(&bytes[from..i]).into_owned());
                start = None;
                end = i + 1;
            }
            _ => {}
        }
        if words.len() == 4 {
            break;
        }
    }
    let [kind, width, height, scale] = words.as_slice() else { return Err("its header is not whole".into()) };
    let channels = match kind.as_str() {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err("it does not start like one".into()),
    };
    let side = |word: &str| word.parse::<u32>().ok().filter(|&side| side > 0).ok_or("its size is no size".to_owned());
    let scale: f32 = scale.parse().map_err(|_| "its scale is no number".to_owned())?;
    Ok(Header { width: side(width)?, height: side(height)?, channels, is_little_endian: scale < 0.0, end })
}

/// The pixels of a PFM, top row first.
pub(super) fn decode_pfm(bytes: &[u8]) -> Result<Decoded, String> {
    let Header { width, height, channels, is_little_endian, end } = header(bytes)?;
    let row = width as usize * channels * 4;
    let pixels = row.checked_mul(height as usize).and_then(|size| bytes.get(end..end.checked_add(size)?));
    let pixels = pixels.ok_or("it ends too early")?;
    let number = |four: &[u8]| {
        let four = [four[0], four[1], four[2], four[3]];
        if is_little_endian { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }
    };
    let samples = pixels.chunks_exact(row).rev().flat_map(|row| row.chunks_exact(4).map(number)).collect();
    Ok(Decoded { width, height, channels, samples: Samples::Float(samples), profile: None, exif: None })
}

/// A PFM of three interleaved channels, top row first.
pub(super) fn encode_pfm(width: u32, height: u32, rgb: &[f32]) -> Vec<u8> {
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for row in rgb.chunks_exact(3 * width as usize).rev() {
        bytes.extend(row.iter().flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

//! Deep OpenEXR files, written from their specification alone (*OpenEXR File Layout*), to be read back.

use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::Header;

/// One sample of a pixel: a number for each channel, in the order of the file's channels.
pub(crate) type Sample = Vec<f32>;

/// A deep part, and how it is stored.
#[derive(Clone)]
pub(crate) struct DeepFile {
    pub(crate) packing: Compression,
    /// Size of its tiles, if it has some.
    pub(crate) tile: Option<i32>,
    /// First column and row, number of columns and rows.
    pub(crate) data: [i32; 4],
    /// As wide and high as this from (0, 0).
    pub(crate) display: [i32; 2],
    /// In the order of their names.
    pub(crate) channels: Vec<(&'static str, SampleType)>,
    /// Whether the file says that it has many parts, of which this is the only one.
    pub(crate) many_parts: bool,
}

impl DeepFile {
    /// A B G R Z of floats, in scan lines.
    pub(crate) fn of_floats(packing: Compression, data: [i32; 4]) -> Self {
        let channels = ["A", "B", "G", "R", "Z"].map(|name| (name, SampleType::F32)).to_vec();
        Self { packing, tile: None, data, display: [data[0] + data[2], data[1] + data[3]], channels, many_parts: false }
    }

    /// The bytes of a file with these samples, a list for each pixel (x, y).
    pub(crate) fn bytes(&self, samples: impl Fn(i32, i32) -> Vec<Sample>) -> Vec<u8> {
        let blocks = self.blocks();
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01];
        let flags = 0x800 | if self.many_parts { 0x1000 } else { 0 };
        bytes.extend((2 | flags as u32).to_le_bytes());
        self.header(blocks.len() as i32, &mut bytes);
        if self.many_parts {
            bytes.push(0);
        }

        // The table of offsets, then what it points at
        let table = bytes.len();
        bytes.resize(table + 8 * blocks.len(), 0);
        for (i, block) in blocks.iter().enumerate() {
            let offset = bytes.len() as u64;
            bytes[table + 8 * i..table + 8 * i + 8].copy_from_slice(&offset.to_le_bytes());
            self.block(*block, &samples, &mut bytes);
        }
        bytes
    }

    /// Column, row, width and height of each block, counted from the first pixel, with its tile's indices.
    fn blocks(&self) -> Vec<[i32; 6]> {
        let [_, _, width, height] = self.data;
        let Some(side) = self.tile else { return (0..height).map(|y| [0, y, width, 1, 0, y]).collect() };
        let tiles = |length: i32| (length + side - 1) / side;
        let places = (0..tiles(height)).flat_map(|j| (0..tiles(width)).map(move |i| (i, j)));
        places
            .map(|(i, j)| [i * side, j * side, side.min(width - i * side), side.min(height - j * side), i, j])
            .collect()
    }

    fn header(&self, chunks: i32, bytes: &mut Vec<u8>) {
        let mut put = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        };
        let ints = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
        let mut list = Vec::new();
        for (name, kind) in &self.channels {
            let kind = match kind {
                SampleType::U32 => 0,
                SampleType::F16 => 1,
                SampleType::F32 => 2,
            };
            list.extend([name.as_bytes(), b"\0", &ints(&[kind, 0, 1, 1])].concat());
        }
        list.push(0);
        let [x, y, width, height] = self.data;
        put("channels", "chlist", &list);
        let packing = match self.packing {
            Compression::Uncompressed => 0,
            Compression::RLE => 1,
            Compression::ZIP1 => 2,
            other => panic!("deep parts know no {other}"),
        };
        put("compression", "compression", &[packing]);
        put("dataWindow", "box2i", &ints(&[x, y, x + width - 1, y + height - 1]));
        put("displayWindow", "box2i", &ints(&[0, 0, self.display[0] - 1, self.display[1] - 1]));
        put("lineOrder", "lineOrder", &[0]);
        put("pixelAspectRatio", "float", &1_f32.to_le_bytes());
        put("screenWindowCenter", "v2f", &[0; 8]);
        put("screenWindowWidth", "float", &1_f32.to_le_bytes());
        put("name", "string", b"deep");
        put("type", "string", if self.tile.is_some() { b"deeptile" } else { b"deepscanline" });
        put("version", "int", &ints(&[1]));
        put("chunkCount", "int", &ints(&[chunks]));
        put("maxSamplesPerPixel", "int", &ints(&[100]));
        if let Some(side) = self.tile {
            put("tiles", "tiledesc", &[ints(&[side, side]), vec![0]].concat());
        }
        bytes.push(0);
    }

    fn block(
        &self,
        [x, y, width, height, i, j]: [i32; 6],
        samples: &impl Fn(i32, i32) -> Vec<Sample>,
        to: &mut Vec<u8>,
    ) {
        let (mut counts, mut numbers) = (Vec::new(), Vec::new());
        for row in y..y + height {
            let line: Vec<Vec<Sample>> =
                (x..x + width).map(|column| samples(self.data[0] + column, self.data[1] + row)).collect();
            let mut sum = 0_u32;
            for pixel in &line {
                sum += pixel.len() as u32;
                counts.extend(sum.to_le_bytes());
            }
            for (channel, (_, kind)) in self.channels.iter().enumerate() {
                for sample in line.iter().flatten() {
                    match kind {
                        SampleType::F16 => numbers.extend(exr::prelude::f16::from_f32(sample[channel]).to_le_bytes()),
                        SampleType::F32 => numbers.extend(sample[channel].to_le_bytes()),
                        SampleType::U32 => numbers.extend((sample[channel] as u32).to_le_bytes()),
                    }
                }
            }
        }
        if self.many_parts {
            to.extend(0_i32.to_le_bytes());
        }
        let place = if self.tile.is_some() { vec![i, j, 0, 0] } else { vec![self.data[1] + y] };
        to.extend(place.iter().flat_map(|n| n.to_le_bytes()));
        let unpacked = numbers.len() as u64;
        let (counts, numbers) = (packed(self.packing, counts), packed(self.packing, numbers));
        for size in [counts.len() as u64, numbers.len() as u64, unpacked] {
            to.extend(size.to_le_bytes());
        }
        to.extend(counts);
        to.extend(numbers);
    }
}

/// A file with a deep part `deep` (one half open sample of grey 0.5 a pixel) before a flat one `flat`, of 3 x 2 pixels and
/// not compressed, and what the flat one shows.
#[allow(dead_code, reason = "not all tests that write deep files need it")]
pub(crate) fn beside_a_flat_part() -> (Vec<u8>, impl Fn(i32, i32) -> f32) {
    let value = |x: i32, y: i32| (1 + x + 3 * y) as f32;
    let deep = DeepFile { many_parts: true, ..DeepFile::of_floats(Compression::Uncompressed, [0, 0, 3, 2]) };
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01];
    bytes.extend((2_u32 | 0x1800).to_le_bytes());
    deep.header(2, &mut bytes);

    // The flat header is the deep one with another name and type
    let mut header = Vec::new();
    deep.header(2, &mut header);
    for (from, to) in [
        (&b"name\0string\0\x04\0\0\0deep"[..], &b"name\0string\0\x04\0\0\0flat"[..]),
        (b"type\0string\0\x0c\0\0\0deepscanline", b"type\0string\0\x0d\0\0\0scanlineimage"),
    ] {
        let at = header.windows(from.len()).position(|part| part == from).expect("the attribute");
        header.splice(at..at + from.len(), to.iter().copied());
    }
    bytes.extend(header);
    bytes.push(0);

    let table = bytes.len();
    bytes.resize(table + 8 * 4, 0);
    for row in 0..4_i32 {
        let offset = bytes.len() as u64;
        let at = table + 8 * row as usize;
        bytes[at..at + 8].copy_from_slice(&offset.to_le_bytes());
        if row < 2 {
            deep.block([0, row, 3, 1, 0, row], &|_, _| vec![vec![0.5, 0.25, 0.25, 0.25, 2.0]], &mut bytes);
        } else {
            let line = (0..5).flat_map(|_| (0..3).flat_map(|x| value(x, row - 2).to_le_bytes())).collect::<Vec<u8>>();
            for number in [1, row - 2, line.len() as i32] {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend(line);
        }
    }
    (bytes, value)
}

/// Bytes as a compression packs them, which is as one line of halves; as they are where that is no shorter.
fn packed(packing: Compression, bytes: Vec<u8>) -> Vec<u8> {
    if bytes.is_empty() {
        return bytes;
    }
    let line = Vec2(bytes.len() / 2, 1);
    let halves = ChannelDescription::named("Y", SampleType::F16);
    let header = Header::new(Text::from(""), line, std::iter::once(halves).collect());
    let header = header.with_encoding(packing, BlockDescription::ScanLines, LineOrder::Increasing);
    packing.compress_image_section_to_le(&header, bytes, IntegerBounds::new(Vec2(0, 0), line)).expect("bytes to pack")
}

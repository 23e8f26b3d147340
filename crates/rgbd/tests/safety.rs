//! Whatever the bytes, a reader returns, soon, and without much memory: valid files of many kinds, spoilt by chance.
#![allow(unsafe_code)] // an allocator that hands everything to the system's, and only counts; tests alone use it

mod support {
    pub(crate) mod deep_file;
}

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use exr::prelude::*;
use rgbd::{
    Frame, MapMeaning, PhotoFormat, Picture, PixelWindow, ReadError, ReadOptions, SampleDepth, fit_to_picture, inspect,
    read_depth_map, read_frame, read_photo, read_picture, read_truth, write_photo,
};
use support::deep_file::DeepFile;

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: both calls go to the system's allocator as they came
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(NOW.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: as the caller promises
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// What a reader may take beside three times the picture.
const BESIDE: usize = 256 << 20;

/// How often each kind of file is spoilt; `TILTSHIFT_MUTATIONS` sets another number for a longer hunt.
fn rounds() -> u64 {
    std::env::var("TILTSHIFT_MUTATIONS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(120)
}

/// A sequence of numbers that look like chance, always the same (SplitMix64, Steele et al. 2014).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

const SIZE: (usize, usize) = (19, 35);

fn channels() -> AnyChannels<FlatSamples> {
    let count = SIZE.0 * SIZE.1;
    let half =
        |name: &str| AnyChannel::new(name, FlatSamples::F16((0..count).map(|i| f16::from_f32(i as f32)).collect()));
    let depth = AnyChannel::new("Z", FlatSamples::F32((0..count).map(|i| i as f32).collect()));
    let id = AnyChannel::new("id", FlatSamples::U32((0..count as u32).collect()));
    AnyChannels::sort(SmallVec::from_vec(vec![half("A"), half("B"), half("G"), half("R"), depth, id]))
}

/// A small valid file of each kind, with a name; seeds for `tests/fuzz`, if `TILTSHIFT_SEEDS` names a folder for them.
fn kinds() -> Vec<(String, Vec<u8>)> {
    let mut kinds = Vec::new();
    let written = |image: Image<Layers<AnyChannels<FlatSamples>>>| {
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let part = |name: &str, compression, blocks| {
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        Layer::new(SIZE, LayerAttributes::named(name), encoding, channels())
    };
    let attributes = || ImageAttributes::new(IntegerBounds::new(Vec2(-1, 2), SIZE));
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ] {
        let blocks = if kinds.len() % 2 == 0 { Blocks::ScanLines } else { Blocks::Tiles(Vec2(8, 16)) };
        let bytes = written(Image::from_layers(attributes(), Layers::from(vec![part("one", compression, blocks)])));
        kinds.push((format!("{compression}, {blocks:?}"), bytes));
    }
    let parts = vec![
        part("rgba", Compression::ZIP16, Blocks::ScanLines),
        part("depth", Compression::PIZ, Blocks::Tiles(Vec2(8, 8))),
    ];
    kinds.push(("two parts".into(), written(Image::from_layers(attributes(), Layers::from(parts)))));

    // Deep ones, with 0 to 3 samples a pixel
    let samples =
        |x: i32, y: i32| (0..(x + y).rem_euclid(4)).map(|i| vec![0.5, 0.2, 0.3, 0.4, (i + x) as f32]).collect();
    for (packing, tile, many_parts) in [
        (Compression::Uncompressed, None, false),
        (Compression::RLE, Some(8), false),
        (Compression::ZIP1, None, true),
        (Compression::ZIP1, Some(16), true),
    ] {
        let file = DeepFile { tile, many_parts, ..DeepFile::of_floats(packing, [-2, 3, 17, 21]) };
        kinds.push((format!("deep, {packing}, tiles {tile:?}, many parts {many_parts}"), file.bytes(samples)));
    }
    kinds
}

/// Spoils a few places: bytes, numbers that become extreme, pieces that are cut out, doubled or moved, an early end.
fn spoilt(bytes: &[u8], chance: &mut Chance) -> Vec<u8> {
    const EXTREME: [u64; 8] =
        [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, 0x0000_0001_0000_0000];
    let mut bytes = bytes.to_vec();
    for _ in 0..=chance.below(4) {
        // Headers and tables are small, and most can be wrong there
        let within = if chance.below(2) == 0 { bytes.len().min(900) } else { bytes.len() };
        if within < 32 {
            break;
        }
        let at = chance.below(within - 16);
        match chance.below(7) {
            0 => bytes[at] = chance.next() as u8,
            1 => bytes[at] ^= 1 << chance.below(8),
            2 => bytes[at..at + 4].copy_from_slice(&(EXTREME[chance.below(8)] as u32).to_le_bytes()),
            3 => bytes[at..at + 8].copy_from_slice(&EXTREME[chance.below(8)].to_le_bytes()),
            4 => {
                bytes.drain(at..at + 1 + chance.below(8));
            }
            5 => {
                let piece = bytes[at..at + 1 + chance.below(15)].to_vec();
                let to = chance.below(within);
                bytes.splice(to..to, piece);
            }
            _ => bytes.truncate(bytes.len() - chance.below(bytes.len() / 2)),
        }
    }
    bytes
}

/// Reads a file in every way; gives the peak of memory, and whether it made a frame.
fn read_in_every_way(path: &Path, options: &ReadOptions) -> (usize, bool) {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let is_frame = read_frame(path, options).is_ok();
    let _ = read_picture(path, options);
    let _ = read_truth(path, options.max_pixels);
    let _ = inspect(path, options);
    (PEAK.load(Relaxed) - before, is_frame)
}

/// One test, because the allocator counts for all threads together.
#[test]
fn spoilt_files_and_claims_of_terabytes_are_read_or_refused_within_their_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spoilt.exr");
    let options = ReadOptions { max_pixels: 1 << 20, ..ReadOptions::default() };
    // 24 bytes a pixel: red, green, blue, alpha, depth and an identity
    let most = 3 * 24 * (1 << 20) + BESIDE;
    let mut chance = Chance(1);
    let (mut read, mut refused) = (0, 0);
    for (i, (kind, bytes)) in kinds().into_iter().enumerate() {
        if let Ok(folder) = std::env::var("TILTSHIFT_SEEDS") {
            std::fs::write(Path::new(&folder).join(format!("kind{i}")), &bytes).unwrap();
        }
        std::fs::write(&path, &bytes).unwrap();
        let (peak, is_frame) = read_in_every_way(&path, &options);
        assert!(is_frame && peak < BESIDE, "{kind}: {peak} bytes; {:?}", read_frame(&path, &options).err());
        for round in 0..rounds() {
            let bytes = spoilt(&bytes, &mut chance);
            std::fs::write(&path, &bytes).unwrap();
            let (peak, is_frame) = read_in_every_way(&path, &options);
            assert!(peak < most, "{kind}, round {round}: {peak} bytes");
            if is_frame { read += 1 } else { refused += 1 }
        }
    }
    assert!(refused > read && read > 50, "{read} read, {refused} refused: spoilt too little or too much");
    claims_of_terabytes(&path);
    a_large_picture(&path);
    a_large_photo_with_its_map(folder.path());
}

/// Windows as large as the format allows, in files of a few hundred bytes.
fn claims_of_terabytes(path: &Path) {
    for (kind, bytes) in kinds() {
        let name = b"dataWindow\0box2i\0";
        let starts: Vec<usize> = (0..bytes.len() - name.len()).filter(|&at| bytes[at..].starts_with(name)).collect();
        for corner in [1_000_000_i32, 100_000] {
            let mut bytes = bytes.clone();
            for start in &starts {
                let at = start + name.len() + 4;
                for (i, value) in [0, 0, corner, corner].into_iter().enumerate() {
                    bytes[at + 4 * i..at + 4 * i + 4].copy_from_slice(&value.to_le_bytes());
                }
            }
            std::fs::write(path, &bytes).unwrap();
            let (peak, _) = read_in_every_way(path, &ReadOptions::default());
            assert!(peak < 1 << 20, "{kind}: {peak} bytes for a claim");
            let error = read_frame(path, &ReadOptions::default()).unwrap_err();
            assert!(matches!(error, ReadError::TooLarge { .. } | ReadError::Damaged { .. }), "{kind}: {error}");
        }
    }
}

/// Half colour and float depth: the most that f32 planes are larger than what is declared.
fn a_large_picture(path: &Path) {
    let size = (2000, 1000);
    let half = |name: &str| AnyChannel::new(name, FlatSamples::F16(vec![f16::from_f32(0.5); size.0 * size.1]));
    let list = ["A", "B", "G", "R", "Z"].map(half);
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(SmallVec::from_vec(list.into())),
    );
    Image::from_layer(layer).write().to_file(path).unwrap();
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let frame = read_frame(path, &ReadOptions::default()).unwrap();
    let peak = PEAK.load(Relaxed) - before;
    drop(frame);
    let declared = 5 * 2 * size.0 * size.1;
    // A chunk of each thread is small beside that
    assert!(peak < 3 * declared + (8 << 20), "{peak} bytes for {declared} declared");
}

/// A photo of 16 bits and a map of floats, 10 bytes a pixel: with 24 million of them 720 MB and not 976 are enough.
fn a_large_photo_with_its_map(folder: &Path) {
    let window = PixelWindow::of_size(2000, 1000);
    let picture = Picture::from_fn(window, |x, y| [(x % 7) as f32 * 0.1, (y % 5) as f32 * 0.2, 0.5, 1.0]);
    let [photo, map] = ["photo.png", "map.pfm"].map(|name| folder.join(name));
    let mut encoding = rgbd::Encoding::plain(PhotoFormat::Png);
    encoding.depth = SampleDepth::Sixteen;
    write_photo(&photo, &picture, &encoding, 0.0).unwrap();
    let numbers = (0..window.area()).flat_map(|i| (2.0 + (i % 100) as f32).to_le_bytes());
    std::fs::write(&map, [b"Pf\n2000 1000\n-1.0\n".to_vec(), numbers.collect()].concat()).unwrap();
    drop(picture);

    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let max_pixels = ReadOptions::MAX_PIXELS;
    let picture = read_photo(&photo, PhotoFormat::Png, max_pixels).unwrap().picture;
    let map = read_depth_map(&map, None, max_pixels).unwrap();
    let (largest, meaning) = (map.largest, MapMeaning::default());
    let depth = fit_to_picture(map.into_planar(&meaning, None), &picture, largest, &meaning);
    let frame = Frame::new(window, vec![rgbd::Layer::from_raw_depth(picture, depth)]).unwrap();
    let peak = PEAK.load(Relaxed) - before;
    drop(frame);
    let declared = (3 * 2 + 4) * window.area();
    assert!(peak < 3 * declared, "{peak} bytes for {declared} declared");
}

//! Photos and depth maps of any bytes, PFM among them: read or refused. Good seeds are small files of every format
//! (`crates/rgbd/tests/photos.rs` writes some).
#![no_main]

mod watch;

use std::io::Write;

use rgbd::{DepthConvention, MapMeaning, PhotoFormat};

const MAX_PIXELS: u64 = 1 << 20;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    if let Ok(Some(format)) = PhotoFormat::of_file(file.path()) {
        let _ = rgbd::photo_size(file.path(), format);
        let _ = rgbd::read_photo(file.path(), format, MAX_PIXELS);
    }
    if let Ok(map) = rgbd::read_depth_map(file.path(), None, MAX_PIXELS) {
        for convention in [DepthConvention::Planar, DepthConvention::Inverse] {
            let depth = map.planar(&MapMeaning { convention, range: Some([0.5, 10.0]), background: None }, None);
            assert!(depth.values().iter().all(|&z| z.is_nan() || z > 0.0), "depth is positive or not known");
        }
    }
});

//! The pixels of any bytes, flat and deep: read or refused. Good seeds are small valid files of every kind
//! (`crates/rgbd/tests/safety.rs` writes some), without B44: the fuzzer ends at panics of the decoder that the reader would
//! have caught.
#![no_main]

use std::io::Write;

use rgbd::ReadOptions;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    let options = ReadOptions { max_pixels: 1 << 20, ..ReadOptions::default() };
    let _ = rgbd::read_frame(file.path(), &options);
    let _ = rgbd::inspect(file.path(), &options);
});

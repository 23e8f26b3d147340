//! The header of any bytes: surveyed or refused.
#![no_main]

use std::io::Write;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    let _ = rgbd::survey_file(file.path(), 1 << 20);
});

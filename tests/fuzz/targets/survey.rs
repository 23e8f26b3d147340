//! The header of any bytes: surveyed or refused.
#![no_main]

mod watch;

use std::io::Write;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    let _ = rgbd::survey_file(file.path(), 1 << 20);
});

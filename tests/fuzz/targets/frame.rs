//! The pixels of any bytes, flat and deep: read or refused, within their memory. Good seeds are small valid files of every kind
//! (`TILTSHIFT_SEEDS=FOLDER cargo test -p rgbd --test safety` writes some).
#![no_main]

mod watch;

use std::io::Write;

use rgbd::{ReadOptions, SampleKind};

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    let options = ReadOptions { max_pixels: 1 << 20, ..ReadOptions::default() };
    let Ok(survey) = rgbd::survey_file(file.path(), options.max_pixels) else { return };

    // Layers of deep parts are floats, however few samples there are
    let declared = survey.parts.iter().map(|part| {
        let of_pixel = |kind| if kind == SampleKind::Half { 2 } else { 4 };
        let flat = part.channels.iter().map(|channel| of_pixel(channel.kind)).sum::<usize>();
        part.window.area() * if part.deep { 8 * 20 } else { flat }
    });
    watch::within_memory(declared.sum(), || {
        let _ = rgbd::read_frame(file.path(), &options);
        let _ = rgbd::read_picture(file.path(), &options);
        let _ = rgbd::inspect(file.path(), &options);
    });
});

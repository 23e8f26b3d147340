//! Deep pixels of any bytes: what is read is a frame of layers, nearest first. Files without a deep part are not kept. Good seeds
//! are small deep files (`TILTSHIFT_SEEDS=FOLDER cargo test -p rgbd --test safety` writes some).
#![no_main]

mod watch;

use std::io::Write;

use libfuzzer_sys::Corpus;
use rgbd::ReadOptions;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| -> Corpus {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    let options = ReadOptions { max_pixels: 1 << 20, ..ReadOptions::default() };
    let survey = rgbd::survey_file(file.path(), options.max_pixels);
    let Some(survey) = survey.ok().filter(|survey| survey.parts.iter().any(|part| part.deep)) else {
        return Corpus::Reject;
    };
    let pixels: usize = survey.parts.iter().map(|part| part.window.area()).sum();
    let read = watch::within_memory(8 * 20 * pixels, || rgbd::read_frame(file.path(), &options));
    if let Ok(read) = read {
        let layers = read.value.layers();
        for [front, back] in layers.windows(2).filter_map(|pair| pair.first_chunk()) {
            for (x, y) in back.window().pixels().filter(|&(x, y)| back.color.at(x, y)[3] > 0.0 && back.known.at(x, y)) {
                let in_front = front.depth.get(x, y).filter(|_| front.known.at(x, y));
                assert!(in_front.is_none_or(|z| z <= back.depth.at(x, y)), "layers stand in order at ({x}, {y})");
            }
        }
        assert!(layers.len() <= 8, "{} layers", layers.len());
    }
    Corpus::Keep
});

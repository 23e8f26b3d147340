//! Float maps of any bytes: the first byte chooses colour or grey, the rest follows the word `PF` or `Pf`. What is read comes back
//! after it was written.
#![no_main]

mod watch;

use std::io::Write;

use rgbd::{DepthConvention, Encoding, MapMeaning, PhotoFormat};

const MAX_PIXELS: u64 = 1 << 20;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(if kind % 2 == 0 { b"PF" } else { b"Pf" }).expect("room for two bytes");
    file.write_all(bytes).expect("room for a small file");
    if let Ok(photo) = rgbd::read_photo(file.path(), PhotoFormat::Pfm, MAX_PIXELS) {
        let again = tempfile::NamedTempFile::new().expect("a folder for temporary files");
        let encoding = Encoding::plain(PhotoFormat::Pfm);
        rgbd::write_photo(again.path(), &photo.picture, &encoding, 0.0).expect("a picture of some pixels");
        let back = rgbd::read_photo(again.path(), PhotoFormat::Pfm, MAX_PIXELS).expect("a file of our own");
        let numbers = |picture: &rgbd::Picture| {
            let planes = picture.planes()[..3].iter().flat_map(|plane| plane.values().to_vec());
            planes.map(|x| if x.is_nan() { u32::MAX } else { x.to_bits() }).collect::<Vec<_>>()
        };
        assert!(numbers(&back.picture) == numbers(&photo.picture), "other numbers came back");
    }
    if let Ok(map) = rgbd::read_depth_map(file.path(), None, MAX_PIXELS) {
        for convention in [DepthConvention::Planar, DepthConvention::Inverse] {
            for range in [None, Some([0.5, 10.0])] {
                let depth = map.planar(&MapMeaning { convention, range, background: None }, None);
                assert!(depth.values().iter().all(|&z| z.is_nan() || z > 0.0), "depth is positive or not known");
            }
        }
    }
});

//! Whatever the bytes, a reader returns.

use std::path::Path;

use rgbd::{
    Compression, Frame, Layer, Picture, PixelWindow, Plane, ReadError, ReadOptions, WriteOptions, read_frame,
    read_picture, read_truth, survey_file, write_frame,
};

const WINDOW: PixelWindow = PixelWindow { x: -2, y: 3, width: 9, height: 37 };

fn bytes_of(path: &Path, compression: Compression) -> Vec<u8> {
    let color = Picture::from_fn(WINDOW, |x, y| [0.1 * x as f32, 0.01 * (y * y) as f32, 0.5, 1.0]);
    let layer = Layer::from_raw_depth(color, Plane::from_fn(WINDOW, |x, y| (x * y) as f32));
    let frame = Frame::new(WINDOW, vec![layer]).unwrap();
    write_frame(path, &frame, &WriteOptions { compression, ..WriteOptions::default() }).unwrap();
    std::fs::read(path).unwrap()
}

const COMPRESSIONS: [Compression; 5] =
    [Compression::None, Compression::Rle, Compression::Zips, Compression::Zip, Compression::Piz];

/// Where the value of a window attribute stands: four i32, x and y of the first pixel, then of the last.
fn window_at(bytes: &[u8], attribute: &str) -> usize {
    let name = format!("{attribute}\0box2i\0");
    bytes.windows(name.len()).position(|part| part == name.as_bytes()).unwrap() + name.len() + 4
}

#[test]
fn a_file_cut_short_anywhere_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.exr");
    for compression in COMPRESSIONS {
        let bytes = bytes_of(&path, compression);
        for length in (0..bytes.len()).step_by(13).chain([bytes.len() - 1]) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let error = read_frame(&path, &ReadOptions::default()).unwrap_err();
            assert!(matches!(error, ReadError::Damaged { .. }), "{compression:?} cut to {length}: {error}");
        }
    }
}

/// Header, table of offsets, chunk headers and pixels alike; what is still a picture may be read as one.
#[test]
fn a_file_with_any_byte_changed_is_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.exr");
    for compression in COMPRESSIONS {
        let bytes = bytes_of(&path, compression);
        let mut refused = 0;
        for at in (0..bytes.len().min(3000)).step_by(11) {
            let mut changed = bytes.clone();
            // Small numbers become large or negative, names others, sizes wrong
            changed[at] ^= [0x80, 0xff, 0x01, 0x7f][at / 11 % 4];
            std::fs::write(&path, &changed).unwrap();
            let options = ReadOptions { max_pixels: 1 << 20, ..ReadOptions::default() };
            refused += usize::from(read_frame(&path, &options).is_err());
            let _ = read_truth(&path, options.max_pixels);
        }
        assert!(refused > 20, "{compression:?}: only {refused} refused");
    }
}

#[test]
fn a_window_beyond_the_limit_is_refused_before_its_pixels_are_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.exr");
    for attribute in ["dataWindow", "displayWindow"] {
        let mut bytes = bytes_of(&path, Compression::Zip);
        let at = window_at(&bytes, attribute);
        for (i, corner) in [0_i32, 0, 499_999_999, 499_999_999].into_iter().enumerate() {
            bytes[at + 4 * i..at + 4 * i + 4].copy_from_slice(&corner.to_le_bytes());
        }
        std::fs::write(&path, &bytes).unwrap();
        // 2.5e17 pixels of 20 bytes: an attempt to allocate them would end the test
        for error in [
            survey_file(&path, ReadOptions::MAX_PIXELS).unwrap_err(),
            read_picture(&path, &ReadOptions::default()).unwrap_err(),
        ] {
            assert!(matches!(error, ReadError::TooLarge { pixels: 250_000_000_000_000_000, .. }), "{error}");
        }
    }

    // Without a limit the file is still too short for what it claims
    let mut bytes = bytes_of(&path, Compression::Zip);
    let at = window_at(&bytes, "dataWindow");
    bytes[at + 8..at + 12].copy_from_slice(&499_999_999_i32.to_le_bytes());
    bytes[at + 12..at + 16].copy_from_slice(&499_999_999_i32.to_le_bytes());
    std::fs::write(&path, &bytes).unwrap();
    let error = read_picture(&path, &ReadOptions { max_pixels: u64::MAX, ..ReadOptions::default() }).unwrap_err();
    assert!(matches!(error, ReadError::Damaged { .. }), "{error}");
}

#[test]
fn a_picture_at_the_limit_is_read_and_one_beyond_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limit.exr");
    bytes_of(&path, Compression::Rle);
    let limit = WINDOW.area() as u64;
    assert!(read_frame(&path, &ReadOptions { max_pixels: limit, ..ReadOptions::default() }).is_ok());
    let error = read_frame(&path, &ReadOptions { max_pixels: limit - 1, ..ReadOptions::default() }).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { pixels: 333, limit: 332, .. }), "{error}");
}

#[test]
fn a_file_that_is_no_exr_or_is_not_there_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text.exr");
    std::fs::write(&path, "this is no picture").unwrap();
    let error = read_picture(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("text.exr\" is damaged or no OpenEXR file"), "{error}");
    let missing = read_picture(&folder.path().join("missing.exr"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(missing, ReadError::Io { .. }), "{missing}");
    assert!(read_picture(folder.path(), &ReadOptions::default()).is_err());
}

#[test]
fn a_camera_that_no_constructor_would_make_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.exr");
    let film = optics::Film::from_fov(1.0, 9, 37).unwrap();
    let camera = optics::Camera {
        pose: optics::Pose::IDENTITY,
        film,
        focus: optics::Focus::at_depth(3.0).unwrap(),
        iris: optics::Iris::upright(0.25, optics::ApertureShape::Disc).unwrap(),
    };
    let head = rgbd::Head::new(WINDOW).with_camera(camera);
    rgbd::write_picture(&path, &Picture::filled(WINDOW, [0.5; 4]), &head, &WriteOptions::default()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for (good, bad) in [
        ("\"radius\":0.25", "\"radius\":-.25"),
        ("\"radius\":0.25", "\"radius\":-2.5"),
        ("\"width\":9,", "\"width\":0,"),
    ] {
        let at = bytes.windows(good.len()).position(|part| part == good.as_bytes()).unwrap();
        let mut changed = bytes.clone();
        changed[at..at + good.len()].copy_from_slice(bad.as_bytes());
        std::fs::write(&path, &changed).unwrap();
        let error = read_picture(&path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, ReadError::BadAttribute { .. }), "{error}");
    }
}

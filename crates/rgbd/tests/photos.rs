//! Photos: what stored numbers are in light, that they come back, and that no file does harm.

use std::path::{Path, PathBuf};

use image::codecs::{jpeg::JpegEncoder, png::PngEncoder, tiff::TiffEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rgbd::{
    Encoding, Photo, PhotoFormat, Picture, PixelWindow, Primaries, ReadError, ReadOptions, SampleDepth, photo_size,
    read_photo, write_photo,
};
use tempfile::TempDir;

const MAX_PIXELS: u64 = ReadOptions::MAX_PIXELS;

/// A file of these bytes.
fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn read(path: &Path) -> Photo {
    let format = PhotoFormat::of_file(path).unwrap().expect("a photo");
    read_photo(path, format, MAX_PIXELS).unwrap()
}

/// 256 x 2 pixels with every byte in red, falling in green, and a mixture in blue.
fn bytes_of_all() -> Vec<u8> {
    let pixel = |i: usize| [i as u8, 255 - i as u8, (i * 7) as u8];
    (0..512).flat_map(|i| pixel(i % 256)).collect()
}

/// The same idea with 16 bits.
fn words_of_many() -> Vec<u8> {
    (0..512_u32).flat_map(|i| [i * 128, 65535 - i * 97, i * i % 65536]).flat_map(|x| (x as u16).to_ne_bytes()).collect()
}

/// A file of `pixels` in a lossless format.
fn encoded(format: PhotoFormat, kind: ExtendedColorType, pixels: &[u8], profile: Option<Vec<u8>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    if format == PhotoFormat::Png {
        let mut encoder = PngEncoder::new(&mut bytes);
        if let Some(profile) = profile {
            encoder.set_icc_profile(profile).unwrap();
        }
        encoder.write_image(pixels, 256, 2, kind).unwrap();
    } else {
        let mut encoder = TiffEncoder::new(std::io::Cursor::new(&mut bytes));
        if let Some(profile) = profile {
            encoder.set_icc_profile(profile).unwrap();
        }
        encoder.write_image(pixels, 256, 2, kind).unwrap();
    }
    bytes
}

#[test]
fn every_stored_number_comes_back() {
    let folder = TempDir::new().unwrap();
    let p3 = moxcms::ColorProfile::new_display_p3().encode().unwrap();
    let adobe = moxcms::ColorProfile::new_adobe_rgb().encode().unwrap();
    for format in [PhotoFormat::Png, PhotoFormat::Tiff] {
        for profile in [None, Some(p3.clone()), Some(adobe.clone())] {
            for (kind, pixels, depth) in [
                (ExtendedColorType::Rgb8, bytes_of_all(), SampleDepth::Eight),
                (ExtendedColorType::Rgb16, words_of_many(), SampleDepth::Sixteen),
            ] {
                let original = file(&folder, "a", &encoded(format, kind, &pixels, profile.clone()));
                let photo = read(&original);
                assert_eq!(photo.encoding.depth, depth);
                let again = folder.path().join("b");
                write_photo(&again, &photo.picture, &photo.encoding, 0.0).unwrap();
                let [a, b] = [&original, &again].map(|path| {
                    let reader = image::ImageReader::open(path).unwrap().with_guessed_format().unwrap();
                    reader.decode().unwrap().into_bytes()
                });
                assert_eq!(a, b, "{format} {kind:?}, profile: {}", photo.encoding.described);
                assert_eq!(read(&again).encoding, photo.encoding, "the profile goes along");
                let is_srgb = photo.encoding.primaries == Primaries::REC709;
                assert_eq!(is_srgb, profile.is_none(), "{format}: {}", photo.encoding.described);
            }
        }
    }
}

#[test]
fn numbers_become_the_light_that_their_profile_says() {
    let folder = TempDir::new().unwrap();
    let srgb =
        read(&file(&folder, "a.png", &encoded(PhotoFormat::Png, ExtendedColorType::Rgb8, &bytes_of_all(), None)));
    // IEC 61966-2-1: byte 188 is half the light, 10 lies on the straight part; exact to the digits written here
    assert!((srgb.picture.at(188, 0)[0] - 0.502_887).abs() < 1e-6);
    assert!((srgb.picture.at(10, 0)[0] - 10.0 / 255.0 / 12.92).abs() < 1e-8);
    assert_eq!(srgb.encoding.primaries, Primaries::REC709);

    // Display P3's red is (1.2249, -0.0420, -0.0196) in sRGB's primaries (Apple; W3C CSS Color 4), to the digits printed
    let p3 = moxcms::ColorProfile::new_display_p3().encode().unwrap();
    let bytes = encoded(PhotoFormat::Png, ExtendedColorType::Rgb8, &[255, 0, 0].repeat(512), Some(p3));
    let photo = read(&file(&folder, "b.png", &bytes));
    let red = photo.picture.to_rec709(&photo.encoding.primaries).at(0, 0);
    for (found, printed) in red.iter().zip([1.2249, -0.0420, -0.0196]) {
        const PRINTED: f32 = 1e-3; // primaries are rounded in the profile
        assert!((found - printed).abs() < PRINTED, "{red:?}");
    }

    // A profile that says sRGB is no other than none
    let profile = moxcms::ColorProfile::new_srgb().encode().unwrap();
    let bytes = encoded(PhotoFormat::Png, ExtendedColorType::Rgb8, &bytes_of_all(), Some(profile));
    assert_eq!(read(&file(&folder, "c.png", &bytes)).picture, srgb.picture);
}

#[test]
fn a_photo_on_its_side_is_turned_upright() {
    let folder = TempDir::new().unwrap();
    // Orientation 6: shown turned clockwise by 90 degrees
    let exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 100);
    encoder.set_exif_metadata(exif).unwrap();
    // Dark at the left, which becomes the top
    let pixels: Vec<u8> = (0..16 * 32).flat_map(|i| [if i % 32 < 16 { 20 } else { 220 }; 3]).collect();
    encoder.write_image(&pixels, 32, 16, ExtendedColorType::Rgb8).unwrap();
    let path = file(&folder, "a.jpg", &bytes);
    assert_eq!(photo_size(&path, PhotoFormat::Jpeg).unwrap(), (16, 32));
    let picture = read(&path).picture;
    assert_eq!((picture.window().width, picture.window().height), (16, 32));
    assert!(picture.at(8, 4)[0] < 0.1 && picture.at(8, 28)[0] > 0.5);
}

#[test]
fn a_camera_tells_its_lens_and_what_it_sees() {
    let folder = TempDir::new().unwrap();
    // EXIF of a phone: 4.25 mm (425/100), f/1.8 (18/10), 26 mm on 24 x 36 mm
    let entry = |tag: u16, kind: u16, value: u32| {
        let value = if kind == 3 { value << 16 } else { value };
        [&tag.to_be_bytes()[..], &kind.to_be_bytes(), &1_u32.to_be_bytes(), &value.to_be_bytes()].concat()
    };
    let first = [&b"MM\0*\0\0\0\x08\0\x01"[..], &entry(0x8769, 4, 26), &[0; 4]].concat();
    let entries = [entry(0x829d, 5, 68), entry(0x920a, 5, 76), entry(0xa405, 3, 26)].concat();
    let fractions = [18_u32, 10, 425, 100].map(u32::to_be_bytes).concat();
    let exif = [&first[..], &[0, 3], &entries, &[0; 4], &fractions].concat();
    let write = |exif: Vec<u8>| {
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 90);
        encoder.set_exif_metadata(exif).unwrap();
        encoder.write_image(&[90; 40 * 30 * 3], 40, 30, ExtendedColorType::Rgb8).unwrap();
        read(&file(&folder, "a.jpg", &bytes)).lens
    };
    let lens = write(exif.clone());
    assert_eq!((lens.focal_length_mm, lens.f_number), (Some(4.25), Some(1.8)));
    // Four fifths of the diagonal of 43.27 mm lie across: 34.61 mm at 26 mm
    let wanted = 2.0 * (0.5_f32 * 0.8 * 43.266_615 / 26.0).atan().to_degrees();
    assert!((lens.horizontal_fov_deg.unwrap() - wanted).abs() < 1e-3, "{lens:?}");
    // Cut anywhere it tells less, and never panics
    for length in 8..exif.len() {
        write(exif[..length].to_vec());
    }
}

#[test]
fn alpha_and_light_above_white_come_back_where_the_format_holds_them() {
    let folder = TempDir::new().unwrap();
    let window = PixelWindow::of_size(8, 4);
    let light = Picture::from_fn(window, |x, y| [0.25 * x as f32, 1.5, 0.125 * y as f32, 1.0]);
    for (name, format) in [("a.pfm", PhotoFormat::Pfm), ("a.hdr", PhotoFormat::Hdr)] {
        let path = folder.path().join(name);
        write_photo(&path, &light, &Encoding::plain(format), 0.0).unwrap();
        let back = read(&path).picture;
        // A shared exponent keeps 8 bits of the brightest
        let loss = if format == PhotoFormat::Hdr { 2.0 / 256.0 } else { 0.0 };
        for (x, y) in window.pixels() {
            let near = light.at(x, y).iter().zip(back.at(x, y)).all(|(a, b)| (a - b).abs() <= loss);
            assert!(near, "{name} ({x}, {y}): {:?} became {:?}", light.at(x, y), back.at(x, y));
        }
    }

    // Half transparent: colour is premultiplied here, and not in the file
    let pixels: Vec<u8> = (0..512).flat_map(|_| [188, 188, 188, 51]).collect();
    let path = file(&folder, "b.png", &encoded(PhotoFormat::Png, ExtendedColorType::Rgba8, &pixels, None));
    let photo = read(&path);
    let [r, _, _, a] = photo.picture.at(3, 0);
    assert!((a - 0.2).abs() < 1e-6 && (r - 0.2 * 0.502_887).abs() < 1e-6);
    let again = folder.path().join("c.png");
    write_photo(&again, &photo.picture, &photo.encoding, 0.0).unwrap();
    assert_eq!(read(&again), photo);
}

#[test]
fn a_pfm_of_either_byte_order_stands_on_its_feet() {
    let folder = TempDir::new().unwrap();
    for (scale, bytes) in [("-1", [1.0_f32, 2.0].map(f32::to_le_bytes)), ("1.0", [1.0, 2.0].map(f32::to_be_bytes))] {
        let whole = [format!("Pf\n1 2\n{scale}\n").into_bytes(), bytes.concat()].concat();
        let picture = read(&file(&folder, "a.pfm", &whole)).picture;
        assert_eq!([picture.at(0, 0)[0], picture.at(0, 1)[0]], [2.0, 1.0], "the first row of the file is the lowest");
    }
}

#[test]
fn headers_that_claim_too_much_are_refused() {
    let folder = TempDir::new().unwrap();
    let pfm = file(&folder, "a.pfm", b"PF\n4000000000 4000000000\n-1\n");
    let mut png = encoded(PhotoFormat::Png, ExtendedColorType::Rgb8, &bytes_of_all(), None);
    png[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let crc = crc32fast::hash(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let png = file(&folder, "a.png", &png);
    for (path, format) in [(pfm, PhotoFormat::Pfm), (png, PhotoFormat::Png)] {
        let error = read_photo(&path, format, MAX_PIXELS).unwrap_err();
        assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
    }
}

#[test]
fn spoilt_photos_are_errors() {
    let folder = TempDir::new().unwrap();
    let picture = Picture::from_fn(PixelWindow::of_size(24, 16), |x, y| [0.04 * x as f32, 0.5, 0.06 * y as f32, 1.0]);
    for (name, format) in [
        ("a.png", PhotoFormat::Png),
        ("a.jpg", PhotoFormat::Jpeg),
        ("a.tif", PhotoFormat::Tiff),
        ("a.hdr", PhotoFormat::Hdr),
        ("a.pfm", PhotoFormat::Pfm),
    ] {
        let path = folder.path().join(name);
        write_photo(&path, &picture, &Encoding::plain(format), 0.0).unwrap();
        let whole = std::fs::read(&path).unwrap();

        // Cut anywhere, it never panics; cut in its header, it is an error
        for length in (0..whole.len()).step_by(1 + whole.len() / 97) {
            let cut = file(&folder, "cut", &whole[..length]);
            let read = read_photo(&cut, format, MAX_PIXELS);
            assert!(length > 16 || read.is_err(), "{name} cut to {length} bytes");
        }

        // Bytes changed by a generator of Knuth's (MMIX)
        let mut state = 1_u64;
        for _ in 0..300 {
            let mut spoilt = whole.clone();
            for _ in 0..3 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % spoilt.len();
                spoilt[at] = (state >> 20) as u8;
            }
            let _ = read_photo(&file(&folder, "spoilt", &spoilt), format, 1 << 20);
        }
    }
}

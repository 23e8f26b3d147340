//! Files of kinds that are not read, known by how they start, so that a refusal can say what they are.

/// What a file is, and what would do.
pub(crate) fn foreign_start(start: &[u8]) -> Option<(&'static str, &'static str)> {
    const FLOATS: &str = "save its numbers as PFM, OpenEXR or TIFF of floats";
    const PNG: &str = "convert it to PNG or TIFF of 16 bits";
    const STARTS: [(usize, &[u8], &str, &str); 20] = [
        (0, b"\x93NUMPY", "a NumPy array (.npy)", FLOATS),
        (0, b"PK\x03\x04", "a ZIP archive (.npz?)", FLOATS),
        (0, b"PIEH", "a flow or depth file of Sintel (.flo, .dpt)", FLOATS),
        (0, b"\x89HDF\r\n\x1a\n", "HDF5 (.h5, .mat)", FLOATS),
        (0, b"MATLAB", "a MATLAB file (.mat)", FLOATS),
        (0, b"P5", "a PGM picture", PNG),
        (0, b"P6", "a PPM picture", PNG),
        (0, b"P2", "a PGM picture", PNG),
        (0, b"P7", "a PAM picture", PNG),
        (0, b"BM", "a BMP picture", PNG),
        (0, b"GIF8", "a GIF picture", PNG),
        (8, b"WEBP", "a WebP picture", PNG),
        (4, b"ftyphe", "a HEIC photo", "export it as JPEG or PNG, its depth map (of a portrait) as PNG"),
        (4, b"ftypmi", "a HEIF photo", "export it as JPEG or PNG, its depth map (of a portrait) as PNG"),
        (4, b"ftypavif", "an AVIF picture", PNG),
        (4, b"JXL ", "a JPEG XL picture", PNG),
        (4, b"jP  ", "a JPEG 2000 picture", PNG),
        (0, b"8BPS", "a Photoshop document", PNG),
        (0, b"SDPX", "a DPX picture", "convert it to OpenEXR or TIFF"),
        (0, b"XPDS", "a DPX picture", "convert it to OpenEXR or TIFF"),
    ];
    let is_one = |(at, magic, ..): &&(usize, &[u8], &str, &str)| start.get(*at..).is_some_and(|s| s.starts_with(magic));
    STARTS.iter().find(is_one).map(|&(_, _, what, remedy)| (what, remedy))
}

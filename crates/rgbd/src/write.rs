//! Frames, pictures and truths into OpenEXR files that give them back bit for bit.

use std::collections::BTreeMap;
use std::path::Path;

use crate::encode_exr::{FileKind, Labels, encode};
use crate::replace::replace_file;
use crate::{Compression, Frame, Head, Layer, LensAttributes, Picture, Plane, Truth, WriteError};

/// Free text by name: whatever is needed to make the picture again.
pub type Notes = BTreeMap<String, String>;

/// How a file is written, and what it says besides pixels and camera.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WriteOptions {
    /// How pixels are packed; never loses a bit.
    pub compression: Compression,
    /// Standard attributes for other programs; the matrices are taken from the camera where there is one.
    pub lens: LensAttributes,
    /// Free text; names of 1 to 200 bytes without NUL.
    pub notes: Notes,
}

/// Writes a frame: `R G B A Z` for the nearest layer, `L2.R` ... `L2.Z` and on for hidden ones, further planes by name.
///
/// All f32. Depth is written as it is, `+inf` for the sky and NaN where it is not known. The file stands whole or not
/// at all: an older one is replaced only when the new one is complete.
pub fn write_frame(path: &Path, frame: &Frame, options: &WriteOptions) -> Result<(), WriteError> {
    let depths: Vec<Plane> = frame.layers().iter().map(depth_with_nan).collect();
    let mut channels = Vec::new();
    for (i, (layer, depth)) in frame.layers().iter().zip(&depths).enumerate() {
        let prefix = layer_prefix(i);
        push_color(&mut channels, &prefix, &layer.color);
        channels.push((format!("{prefix}Z"), depth));
    }
    for (name, plane) in &frame.planes {
        channels.push((name.clone(), plane));
    }
    let labels = Labels { kind: FileKind::Frame { layers: frame.layers().len() }, options };
    let bytes = encode(path, &Head::from(frame), channels, &labels)?;
    replace(path, &bytes)
}

/// Writes a picture as `R G B A`, all f32; the file stands whole or not at all.
pub fn write_picture(path: &Path, picture: &Picture, head: &Head, options: &WriteOptions) -> Result<(), WriteError> {
    write_picture_with(path, picture, &[], head, options)
}

/// Writes a picture as `R G B A` with further planes by name, all f32 and of the picture's window; the file stands whole or
/// not at all.
pub fn write_picture_with(
    path: &Path,
    picture: &Picture,
    planes: &[(&str, &Plane)],
    head: &Head,
    options: &WriteOptions,
) -> Result<(), WriteError> {
    let mut channels = Vec::new();
    push_color(&mut channels, "", picture);
    channels.extend(planes.iter().map(|&(name, plane)| (name.to_owned(), plane)));
    let bytes = encode(path, head, channels, &Labels { kind: FileKind::Picture, options })?;
    replace(path, &bytes)
}

/// Writes a truth: the mean as `R G B A`, the halves as `half0.R` ... `half1.A`; the file stands whole or not at all.
///
/// The halves come back bit for bit with their sample counts; the mean is for other programs.
pub fn write_truth(path: &Path, truth: &Truth, options: &WriteOptions) -> Result<(), WriteError> {
    let mean = truth.picture();
    let mut channels = Vec::new();
    push_color(&mut channels, "", &mean);
    for (i, half) in truth.halves.iter().enumerate() {
        push_color(&mut channels, &half_prefix(i), half);
    }
    let head = Head { camera: truth.camera, ..Head::new(truth.display) };
    let labels = Labels { kind: FileKind::Truth { samples: truth.samples }, options };
    let bytes = encode(path, &head, channels, &labels)?;
    replace(path, &bytes)
}

/// What stands before the channel names of a layer: nothing, then `L2.`, `L3.` and on.
pub(crate) fn layer_prefix(layer: usize) -> String {
    if layer == 0 { String::new() } else { format!("L{}.", layer + 1) }
}

/// What stands before the channel names of a half.
pub(crate) fn half_prefix(half: usize) -> String {
    format!("half{half}.")
}

fn push_color<'a>(channels: &mut Vec<(String, &'a Plane)>, prefix: &str, color: &'a Picture) {
    for (name, plane) in ["R", "G", "B", "A"].into_iter().zip(color.planes()) {
        channels.push((format!("{prefix}{name}"), plane));
    }
}

/// Depth as a file holds it: NaN where it is not known.
fn depth_with_nan(layer: &Layer) -> Plane {
    let mut depth = layer.depth.clone();
    for (z, &known) in depth.values_mut().iter_mut().zip(layer.known.bits()) {
        if !known {
            *z = f32::NAN;
        }
    }
    depth
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    replace_file(path, bytes).map_err(|source| WriteError::Io { path: path.into(), source })
}

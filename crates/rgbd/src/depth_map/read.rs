//! A map as it is stored.

use std::path::Path;

use crate::choose::choose;
use crate::convert::{check_copies, fitted};
use crate::exr_file::ExrFile;
use crate::photo::{Decoded, Samples, decode};
use crate::survey::ChannelIndex;
use crate::{PhotoFormat, PixelWindow, Plane, ReadError, ReadOptions};

/// A map of one number for each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    /// The numbers as they are stored.
    pub stored: Plane,
    /// The largest number that the format can store, where these are whole numbers (255 or 65535).
    pub largest: Option<f32>,
    /// Whether the file names it as depth, as renderers do.
    pub is_named: bool,
    /// Where in the file it was found, in a few words.
    pub found: String,
}

/// How far red, green and blue of a grey map may be apart in the mean, over the largest number: JPEG keeps colour apart from
/// brightness, and both roundly. False colours are apart by half of it.
const GREY: f64 = 0.02;

/// Reads a map of any format: a grey picture, or of an OpenEXR file the depth channel (that named `channel`, where given),
/// red, green and blue that are the same, or the only channel.
pub fn read_depth_map(path: &Path, channel: Option<&str>, max_pixels: u64) -> Result<DepthMap, ReadError> {
    match PhotoFormat::of_file(path)? {
        Some(format) => {
            let decoded = decode(path, format, max_pixels)?;
            grey(decoded).ok_or_else(|| ReadError::Unsupported {
                path: path.into(),
                what: "a depth map in colours".into(),
                remedy: "export it in shades of grey",
            })
        }
        None => of_exr(path, channel, max_pixels),
    }
}

/// The map of a grey picture; `None` of one in colours.
fn grey(decoded: Decoded) -> Option<DepthMap> {
    let (stored, largest) = match decoded.samples {
        Samples::Eight(bytes) => (one_channel(&bytes, decoded.channels, 255.0)?, Some(255.0)),
        Samples::Sixteen(words) => (one_channel(&words, decoded.channels, 65535.0)?, Some(65535.0)),
        Samples::Float(numbers) if decoded.channels == 1 => (numbers, None),
        Samples::Float(numbers) => {
            let largest = numbers.iter().filter(|number| number.is_finite()).fold(0.0_f32, |a, &b| a.max(b.abs()));
            (one_channel(&numbers, decoded.channels, largest)?, None)
        }
    };
    let stored = Plane::from_values(PixelWindow::of_size(decoded.width, decoded.height), stored)?;
    let found = match largest {
        Some(255.0) => "8-bit grey",
        Some(_) => "16-bit grey",
        None => "floats",
    };
    Some(DepthMap { stored, largest, is_named: false, found: found.into() })
}

/// The brightness of interleaved samples (Rec. 601, as JPEG has it); `None` unless all are grey.
fn one_channel<T: Copy + Into<f32>>(samples: &[T], channels: usize, largest: f32) -> Option<Vec<f32>> {
    let pixels = samples.chunks_exact(channels);
    if channels < 3 {
        return Some(pixels.map(|pixel| pixel[0].into()).collect());
    }
    let mut spreads = 0.0;
    let brightness = |pixel: &[T]| {
        let [r, g, b]: [f32; 3] = [pixel[0].into(), pixel[1].into(), pixel[2].into()];
        if (r == g && g == b) || r.is_nan() {
            return r;
        }
        spreads += f64::from((r.max(g).max(b) - r.min(g).min(b)) / largest);
        0.299 * r + 0.587 * g + 0.114 * b
    };
    let brightness: Vec<f32> = pixels.map(brightness).collect();
    (spreads <= GREY * brightness.len() as f64).then_some(brightness)
}

fn of_exr(path: &Path, channel: Option<&str>, max_pixels: u64) -> Result<DepthMap, ReadError> {
    let file = ExrFile::open(path, max_pixels)?;
    let survey = file.survey();
    let options = ReadOptions { depth: channel.map(str::to_owned), max_pixels, ..ReadOptions::default() };
    let all: Vec<ChannelIndex> = survey.channels().collect();

    // A depth channel, else a grey picture, else the only channel
    let (at, is_named) = match (choose(path, survey, &options, true), &all[..]) {
        (Ok(plan), _) => {
            let depth = plan.depth.expect("a plan with depth");
            let mut planes = file.planes(&[&[depth], &plan.depth_copies[..]].concat())?;
            let copies = planes.split_off(1);
            check_copies(&file, &plan, &planes[0], &copies)?;
            (depth, true)
        }
        (_, &[only]) => (only, survey.label(only).rsplit('.').next().is_some_and(|base| base == "Z")),
        (Err(ReadError::NoDepth { .. }), _) => {
            let plan = choose(path, survey, &options, false)?;
            let planes = file.planes(&plan.color.rgb)?;
            let same =
                |a: &Plane, b: &Plane| a.values().iter().zip(b.values()).all(|(a, b)| a.to_bits() == b.to_bits());
            if !(same(&planes[0], &planes[1]) && same(&planes[0], &planes[2])) {
                return Err(ReadError::NoDepth { path: path.into(), available: survey.channel_names() });
            }
            (plan.color.rgb[0], false)
        }
        (Err(error), _) => {
            // One channel called Z, beside others that are no picture
            let mut zs = all.iter().filter(|&&at| survey.label(at) == "Z");
            match (zs.next(), zs.next(), channel) {
                (Some(&z), None, None) => (z, true),
                _ => return Err(error),
            }
        }
    };
    let plane = fitted(file.planes(&[at])?.swap_remove(0), survey.display, f32::NAN);
    let window = PixelWindow::of_size(survey.display.width, survey.display.height);
    let stored = Plane::from_values(window, plane.into_values()).expect("a number for each pixel");
    let found = if is_named { survey.label(at) } else { format!("{}, three times the same", survey.label(at)) };
    Ok(DepthMap { stored, largest: None, is_named, found })
}

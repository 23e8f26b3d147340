//! What a photo or a depth map holds.

use anyhow::Context;
use rgbd::{DepthMap, DepthVerdict, Photo, PhotoFormat, SampleDepth, read_depth_map, read_photo};
use serde_json::json;

use super::Options;
use super::json::verdict;
use crate::console;
use crate::failure::Outcome;

/// Says what there is.
pub(super) fn run(options: &Options, format: PhotoFormat) -> Outcome {
    let Photo { picture, encoding, .. } = read_photo(&options.file, format, options.read.max_pixels())?;
    let window = picture.window();
    drop(picture);
    let bits = match encoding.depth {
        SampleDepth::Eight => "8 bit",
        SampleDepth::Sixteen => "16 bit",
        SampleDepth::Float => "float",
    };
    // A grey picture may be a map
    let map = read_depth_map(&options.file, None, options.read.max_pixels()).ok();
    let range = map.as_ref().and_then(stored_range);
    let told = map.as_ref().filter(|_| range.is_some()).map(|map| {
        let window = map.window();
        let film = options.film(window.width, window.height, 1.0);
        DepthVerdict::of(&map.stored, window, film.as_ref())
    });
    if options.json {
        let report = json!({
            "file": options.file.display().to_string(),
            "format": format.to_string(),
            "size_px": [window.width, window.height],
            "numbers": bits,
            "alpha": encoding.has_alpha,
            "linearised_by": encoding.described,
            "grey_from_to": range,
            "as_depth": told.as_ref().map(verdict),
        });
        console::print(serde_json::to_string_pretty(&report).context("the report makes no JSON")?);
        return Ok(());
    }
    console::print(options.file.display());
    console::print(format_args!("  format         {format}, {bits}"));
    console::print(format_args!("  size           {} x {} px, upright", window.width, window.height));
    console::print(format_args!("  colour         linearised by {}", encoding.described));
    console::print(format_args!("  alpha          {}", if encoding.has_alpha { "yes" } else { "none" }));
    match range {
        Some([least, most]) => {
            console::print(format_args!("  as a depth map grey, numbers from {least} to {most}"));
            console::print("                 (filter takes it with --depth FILE, --depth-as and --depth-range)");
            if let Some(told) = told {
                console::print(format_args!("  flat surfaces  {told}"));
            }
        }
        None => console::print("  as a photo     filter takes it with a depth map: --depth FILE"),
    }
    Ok(())
}

/// Least and greatest finite number of a map.
fn stored_range(map: &DepthMap) -> Option<[f32; 2]> {
    let finite = || map.stored.values().iter().copied().filter(|number| number.is_finite());
    Some([finite().reduce(f32::min)?, finite().reduce(f32::max)?])
}

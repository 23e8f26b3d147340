//! What comes out, into its file.

use ::filter::{Filtered, Method};
use anyhow::bail;
use optics::{Camera, ThinLens};
use rgbd::{Encoding, Head, PhotoFormat, Plane, Primaries, write_photo, write_picture_with, write_png};

use super::job::{Job, Say};
use super::overlay::overlay;
use super::{Options, sensor_mm};
use crate::files::{notes, write_options};

/// What was made of a picture.
pub(super) struct Made<'a> {
    /// What the picture shares with what it was made from.
    pub(super) head: Head,
    pub(super) camera: &'a Camera,
    pub(super) lens: Option<&'a ThinLens>,
    /// How the picture was stored, where it is a photo.
    pub(super) encoding: Option<Encoding>,
    pub(super) filtered: Filtered,
    pub(super) coc: Option<Plane>,
    pub(super) method: Method,
}

/// Fails if the result's format cannot hold what is asked for.
pub(super) fn check_output(job: &Job, options: &Options) -> anyhow::Result<()> {
    // What is named otherwise than it is misleads whoever opens it
    for (option, path) in [("--png", &job.png), ("--overlay", &job.overlay)] {
        if let Some(path) =
            path.as_ref().filter(|path| PhotoFormat::of_name(path).is_some_and(|f| f != PhotoFormat::Png))
        {
            bail!("{option} writes a PNG; {path:?} should be named .png");
        }
    }
    const NOT_WRITTEN: [&str; 12] =
        ["webp", "gif", "bmp", "avif", "heic", "heif", "jxl", "tga", "psd", "dng", "jp2", "dpx"];
    let ending = job.output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    if let Some(ending) = ending.filter(|ending| NOT_WRITTEN.contains(&ending.as_str())) {
        bail!("{:?}: {ending} is not written; name it .exr, .png, .jpg, .tif, .hdr or .pfm", job.output);
    }
    let Some(format) = PhotoFormat::of_name(&job.output) else { return Ok(()) };
    for (name, is_asked) in [("--coc", options.coc), ("--predicted-error", options.predicted_error)] {
        if is_asked {
            bail!("{:?} would be {format}, which holds no further channels; name it .exr for {name}", job.output);
        }
    }
    Ok(())
}

/// Writes the result in the format that its name asks for, and the PNG.
pub(super) fn write(job: &Job, options: &Options, made: Made<'_>, say: Say<'_>) -> anyhow::Result<()> {
    let Made { head, camera, lens, encoding, filtered, coc, method } = made;
    match PhotoFormat::of_name(&job.output) {
        None => {
            let head = Head { camera: Some(*camera), ..head };
            let kernel = ("kernel", filtered.kernel.to_string());
            let input = ("input", job.input.display().to_string());
            let notes = notes([("method", method.name().to_owned()), kernel, input]);
            let sensor_mm = lens.map(|lens| sensor_mm(camera, lens));
            let error = filtered.predicted_error.as_ref().filter(|_| options.predicted_error).map(|error| &error.total);
            let planes = [("coc", coc.as_ref().filter(|_| options.coc)), ("predicted_error", error)];
            let planes: Vec<_> = planes.into_iter().filter_map(|(name, plane)| Some((name, plane?))).collect();
            let written = write_options(options.compression, lens, sensor_mm, notes);
            write_picture_with(&job.output, &filtered.picture, &planes, &head, &written)?;
        }
        Some(format) => {
            // A photo goes back as it came; a render becomes what a display shows
            let encoding = match encoding {
                Some(encoding) => encoding.in_format(format),
                None => Encoding::plain(format),
            };
            if encoding.primaries == head.primaries || format.is_linear() {
                write_photo(&job.output, &filtered.picture, &encoding, options.exposure)?;
            } else {
                write_photo(&job.output, &filtered.picture.to_rec709(&head.primaries), &encoding, options.exposure)?;
            }
            if head.primaries != Primaries::REC709 && format.is_linear() {
                say(format_args!(
                    "  {format} cannot say that its primaries are other than Rec. 709: they are the input's"
                ));
            }
        }
    }
    say(format_args!("wrote {}", job.output.display()));
    if let (Some(path), Some(coc)) = (&job.overlay, &coc) {
        let shown =
            filtered.picture.to_rec709(&head.primaries).map(|rgba| rgba.map(|value| value * options.exposure.exp2()));
        write_png(path, &overlay(&shown, coc), 0.0)?;
        say(format_args!("wrote {}", path.display()));
    }
    if let Some(png) = &job.png {
        write_png(png, &filtered.picture.to_rec709(&head.primaries), options.exposure)?;
        say(format_args!("wrote {}", png.display()));
    }
    Ok(())
}

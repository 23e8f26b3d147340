//! Where results go, and what they say about how they were made.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::ValueEnum;
use optics::ThinLens;
use rgbd::{Compression, LensAttributes, Notes, WriteOptions};

/// How EXR files are packed; none of these loses a bit.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum Packing {
    /// Not at all: fastest.
    None,
    /// Run lengths: nearly as fast.
    #[default]
    Rle,
    /// Deflate, line by line.
    Zips,
    /// Deflate, 16 lines at a time: smallest, slow to write.
    Zip,
}

impl From<Packing> for Compression {
    fn from(packing: Packing) -> Self {
        match packing {
            Packing::None => Self::None,
            Packing::Rle => Self::Rle,
            Packing::Zips => Self::Zips,
            Packing::Zip => Self::Zip,
        }
    }
}

/// Makes the folder that a file shall stand in.
pub(crate) fn make_folder_of(path: &Path) -> anyhow::Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => make_folder(folder),
        _ => Ok(()),
    }
}

/// Makes a folder and those above it.
pub(crate) fn make_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {folder:?}"))
}

/// Writes text beside its place and renames it into it.
pub(crate) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    make_folder_of(path)?;
    rgbd::replace_file(path, text.as_bytes()).with_context(|| format!("cannot write {path:?}"))
}

/// Fails if a command would write over what it reads, or over another of its results.
pub(crate) fn refuse_overwriting(inputs: &[&Path], outputs: &[&Path]) -> anyhow::Result<()> {
    for (i, output) in outputs.iter().enumerate() {
        if inputs.iter().any(|input| same_place(input, output)) {
            bail!("{output:?} is the input; give another name to write to");
        }
        if outputs[..i].iter().any(|earlier| same_place(earlier, output)) {
            bail!("{output:?} is named for two results; give each its own name");
        }
    }
    Ok(())
}

/// The name of one frame's file: its number in place of the last `####` of the name, as wide, or `_0001` before the ending.
pub(crate) fn numbered(path: &Path, frame: i64) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let number = |width: usize| if frame < 0 { format!("-{:0width$}", -frame) } else { format!("{frame:0width$}") };
    let name = if let Some(end) = name.rfind('#') {
        let start =
            name[..end].rfind(|c| c != '#').map_or(0, |at| at + name[at..].chars().next().map_or(1, char::len_utf8));
        format!("{}{}{}", &name[..start], number(end + 1 - start), &name[end + 1..])
    } else {
        let (stem, ending) =
            name.rsplit_once('.').map_or((name.as_str(), String::new()), |(s, e)| (s, format!(".{e}")));
        format!("{stem}_{}{ending}", number(4))
    };
    path.with_file_name(name)
}

/// Fails if an EXR would get another kind of file's name.
pub(crate) fn expect_exr(output: &Path) -> anyhow::Result<()> {
    let ending = output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("png" | "jpg" | "jpeg" | "tif" | "tiff" | "hdr") => {
            bail!("{output:?} would hold OpenEXR; name it .exr (--png writes a PNG beside it)")
        }
        _ => Ok(()),
    }
}

/// Whether two paths name one file, existing or not.
fn same_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        path.canonicalize().ok().or_else(|| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(folder.canonicalize().ok()?.join(path.file_name()?))
        })
    };
    a == b || place(a).is_some_and(|a| place(b) == Some(a))
}

/// What a file says of its making: the program, the command line, and the given extra notes.
pub(crate) fn notes(extra: impl IntoIterator<Item = (&'static str, String)>) -> Notes {
    let made = [("software", format!("tiltshift {}", env!("CARGO_PKG_VERSION"))), ("command", command_line())];
    made.into_iter().chain(extra).map(|(name, text)| (name.to_owned(), text)).collect()
}

/// The command line as typed, arguments with spaces in quotes; the program by its bare name.
pub(crate) fn command_line() -> String {
    let quoted = |argument: String| if argument.contains([' ', '"']) { format!("{argument:?}") } else { argument };
    let arguments = std::env::args_os().skip(1).map(|argument| quoted(argument.to_string_lossy().into_owned()));
    std::iter::once("tiltshift".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// How a file is written that was made with a lens; the lens in metres.
pub(crate) fn write_options(
    packing: Packing,
    lens: Option<&ThinLens>,
    sensor_mm: Option<[f64; 2]>,
    notes: Notes,
) -> WriteOptions {
    let mut attributes =
        LensAttributes { sensor_mm: sensor_mm.map(|size| size.map(|mm| mm as f32)), ..Default::default() };
    if let Some(lens) = lens {
        let mm = |metres: f64| (metres * 1e3) as f32;
        attributes.focal_length_mm = Some(mm(lens.focal_length()));
        attributes.image_distance_mm = Some(mm(lens.image_distance()));
        attributes.f_number = lens.f_number().is_finite().then_some(lens.f_number() as f32);
        attributes.focus_distance_m = lens.focus().depth(glam::DVec2::ZERO).map(|depth| depth as f32);
        // OpenEXR counts the offset in microns, positive for more of the right and of the bottom
        let shift = lens.shift();
        attributes.sensor_offset_um = Some([(shift.x * 1e6) as f32, (-shift.y * 1e6) as f32]);
    }
    WriteOptions { compression: packing.into(), lens: attributes, notes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered() {
        let name = |path: &str, frame| numbered(Path::new(path), frame).to_string_lossy().into_owned();
        assert_eq!(name("out/a.exr", 7), "out/a_0007.exr");
        assert_eq!(name("a", 12345), "a_12345");
        assert_eq!(name("shot.###.exr", 7), "shot.007.exr");
        assert_eq!(name("é##.exr", -7), "é-07.exr");
        assert_eq!(name("####", 3), "0003");
    }
}

//! An OpenEXR file whose header is read and found sane, and the planes that are picked from it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;

use crate::flat_blocks::decode_parts;
use crate::foreign_start::foreign_start;
use crate::headers::read_headers;
use crate::survey::ChannelIndex;
use crate::{PartSurvey, PixelWindow, Plane, ReadError, SampleKind, Survey};

/// A file whose header claims nothing absurd.
pub(crate) struct ExrFile {
    path: PathBuf,
    length: u64,
    /// Where the tables of offsets start, behind the headers.
    tables_at: u64,
    meta: MetaData,
    survey: Survey,
}

impl ExrFile {
    /// Reads the header only; refuses windows of more than `max_pixels` before anything is allocated for them.
    pub(crate) fn open(path: &Path, max_pixels: u64) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: path.into(), source };
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let (meta, tables_at) = read_headers(&file).map_err(|error| named(path, &file, error))?;
        let damaged = |reason: &str| ReadError::Damaged { path: path.into(), reason: reason.into() };
        if meta.headers.is_empty() {
            return Err(damaged("it has no part"));
        }
        let survey = Survey::of(&meta);

        // Refuse what would not fit, and what the file is too short to hold
        let windows = std::iter::once(("display window".to_owned(), survey.display));
        let parts = survey.parts.iter().enumerate().map(|(i, part)| {
            let name = part.name.clone().unwrap_or_else(|| i.to_string());
            (format!("data window of part {name}"), part.window)
        });
        for (what, window) in windows.chain(parts) {
            let pixels = u64::from(window.width) * u64::from(window.height);
            if pixels > max_pixels {
                return Err(ReadError::TooLarge { path: path.into(), what, pixels, limit: max_pixels });
            }
            if pixels == 0 {
                return Err(damaged(&format!("its {what} is empty")));
            }
        }
        // Each chunk has its 8 bytes in the table of offsets
        let chunks = meta.headers.iter().fold(0_u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
        if chunks.saturating_mul(8) > length {
            return Err(damaged("it is shorter than its own table of contents"));
        }
        Ok(Self { path: path.into(), length, tables_at, meta, survey })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Its size in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// Where the tables of offsets start, in bytes.
    pub(crate) fn tables_at(&self) -> u64 {
        self.tables_at
    }

    pub(crate) fn meta(&self) -> &MetaData {
        &self.meta
    }

    pub(crate) fn survey(&self) -> &Survey {
        &self.survey
    }

    /// The window of the part that a channel is in.
    pub(crate) fn window(&self, at: ChannelIndex) -> PixelWindow {
        self.survey.parts[at.part].window
    }

    /// How a channel stores a number.
    pub(crate) fn kind(&self, at: ChannelIndex) -> SampleKind {
        self.survey.parts[at.part].channels[at.channel].kind
    }

    /// Whether pixels of the part of a channel hold any number of samples.
    pub(crate) fn is_deep(&self, at: ChannelIndex) -> bool {
        self.survey.parts[at.part].deep
    }

    /// The pixels of these channels, each in the window of its part, in the order asked for.
    ///
    /// Half and uint become f32. A file that ends early or packs nonsense is an error.
    pub(crate) fn planes(&self, wanted: &[ChannelIndex]) -> Result<Vec<Plane>, ReadError> {
        self.decode(wanted, wanted.iter().map(|at| at.part).collect())
    }

    /// The same, but all parts that can be are decoded, to find out whether they are whole.
    pub(crate) fn planes_of_whole_file(&self, wanted: &[ChannelIndex]) -> Result<Vec<Plane>, ReadError> {
        let is_readable = |part: &&PartSurvey| !part.deep && !part.channels.iter().any(|channel| channel.subsampled);
        let parts = self.survey.parts.iter().enumerate().filter(|(_, part)| is_readable(part)).map(|(i, _)| i);
        self.decode(wanted, parts.collect())
    }

    /// The pixels of these channels, all chunks of `parts` decoded.
    fn decode(&self, wanted: &[ChannelIndex], parts: BTreeSet<usize>) -> Result<Vec<Plane>, ReadError> {
        self.refuse_deep(wanted)?;
        self.refuse_subsampled(wanted)?;
        let mut planes: BTreeMap<(usize, usize), Plane> =
            wanted.iter().map(|at| ((at.part, at.channel), Plane::filled(self.window(*at), 0.0))).collect();
        if parts.is_empty() {
            return Ok(Vec::new());
        }
        decode_parts(self, &parts, &mut planes).map_err(|error| refusal(&self.path, error))?;
        // A channel may be asked for twice, as colour and as depth
        let is_last = |i: usize| !wanted[i + 1..].contains(&wanted[i]);
        let take = |(i, at): (usize, &ChannelIndex)| {
            let key = (at.part, at.channel);
            let plane = if is_last(i) { planes.remove(&key) } else { planes.get(&key).cloned() };
            plane.expect("each wanted channel has its plane")
        };
        Ok(wanted.iter().enumerate().map(take).collect())
    }

    /// Refuses by name channels of deep parts, which have no one value for a pixel.
    fn refuse_deep(&self, wanted: &[ChannelIndex]) -> Result<(), ReadError> {
        let Some(&deep) = wanted.iter().find(|at| self.is_deep(**at)) else { return Ok(()) };
        let what =
            format!("{} with many samples for each pixel beside a channel that has one", self.survey.label(deep));
        let remedy = "take colour and depth from one part (--color, --depth)";
        Err(ReadError::Unsupported { path: self.path.clone(), what, remedy })
    }

    /// Refuses by name parts with subsampled channels, which the decoder does not know.
    fn refuse_subsampled(&self, wanted: &[ChannelIndex]) -> Result<(), ReadError> {
        let mut channels = wanted.iter().flat_map(|at| &self.survey.parts[at.part].channels);
        let Some(channel) = channels.find(|channel| channel.subsampled) else { return Ok(()) };
        let what = format!("subsampled channels ({})", channel.name);
        Err(ReadError::Unsupported { path: self.path.clone(), what, remedy: "write all channels in full size" })
    }
}

/// The error of a file whose header is none; one of a known kind is called by its name.
fn named(path: &Path, mut file: &File, error: exr::error::Error) -> ReadError {
    let mut start = [0; 16];
    let is_read = file.rewind().and_then(|()| file.read(&mut start)).is_ok();
    match foreign_start(&start).filter(|_| is_read) {
        Some((what, remedy)) => ReadError::Unsupported { path: path.into(), what: what.into(), remedy },
        None => refusal(path, error),
    }
}

/// The decoder's error as ours.
pub(crate) fn refusal(path: &Path, error: exr::error::Error) -> ReadError {
    match error {
        exr::error::Error::Io(source) => ReadError::Io { path: path.into(), source },
        exr::error::Error::NotSupported(what) => ReadError::Unsupported {
            path: path.into(),
            what: what.into_owned(),
            remedy: "write it as a flat OpenEXR 2 file",
        },
        exr::error::Error::Invalid(what) => {
            let reason = match what.as_ref() {
                "reference to missing bytes" => "it ends too early".to_owned(),
                "file identifier missing" => {
                    "it does not start like one, nor like PNG, JPEG, TIFF, Radiance HDR or PFM".to_owned()
                }
                "nothing that can be decoded" => "what it packs cannot be unpacked".to_owned(),
                what => format!("invalid {what}"),
            };
            ReadError::Damaged { path: path.into(), reason }
        }
        error => ReadError::Damaged { path: path.into(), reason: error.to_string() },
    }
}

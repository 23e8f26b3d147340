//! What there is in a file, before any pixel is read.

use exr::compression::Compression as Packing;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::{BlockDescription, MetaData};

use crate::PixelWindow;
use crate::attributes::{string, window};

/// How a channel stores a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    /// 16-bit float.
    Half,
    /// 32-bit float.
    Float,
    /// 32-bit unsigned integer.
    Uint,
}

impl std::fmt::Display for SampleKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Half => "half",
            Self::Float => "float",
            Self::Uint => "uint",
        })
    }
}

/// A channel of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelSurvey {
    /// Its full name, layer and view included.
    pub name: String,
    /// How it stores a number.
    pub kind: SampleKind,
    /// Whether it has fewer samples than the window has pixels.
    pub subsampled: bool,
}

/// A part of a file; most files have one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartSurvey {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// Its view (eye), where it has one.
    pub view: Option<String>,
    /// Its data window.
    pub window: PixelWindow,
    /// Whether pixels hold any number of samples.
    pub deep: bool,
    /// How its pixels are packed, as OpenEXR names it: `none`, `RLE`, `ZIPS`, ...
    pub compression: &'static str,
    /// Width and height of its tiles in pixels, where it is not stored in scan lines.
    pub tile: Option<[u32; 2]>,
    /// Whether it holds smaller versions of itself (mip or rip maps), which are not read.
    pub has_levels: bool,
    /// Its channels, in the order of their names.
    pub channels: Vec<ChannelSurvey>,
}

/// What there is in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The picture proper.
    pub display: PixelWindow,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Its views (eyes), the default one first; empty where it names none.
    pub views: Vec<String>,
    /// Its parts, in the order of the file.
    pub parts: Vec<PartSurvey>,
}

/// Where a channel stands in a survey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct ChannelIndex {
    pub(crate) part: usize,
    pub(crate) channel: usize,
}

impl Survey {
    pub(crate) fn of(meta: &MetaData) -> Self {
        let parts: Vec<PartSurvey> = meta.headers.iter().map(PartSurvey::of).collect();

        // One part names its views in a list, many parts each their own
        let listed = meta.headers.iter().find_map(|header| header.own_attributes.multi_view_names.as_ref());
        let named = parts.iter().filter_map(|part| part.view.clone());
        let mut views: Vec<String> = Vec::new();
        for view in listed.into_iter().flatten().map(string).chain(named) {
            if !views.contains(&view) {
                views.push(view);
            }
        }
        let shared = &meta.headers[0].shared_attributes;
        Self { display: window(&shared.display_window), pixel_aspect: shared.pixel_aspect, views, parts }
    }

    /// What to call a channel: its name, and its part's before a slash where there are several parts.
    pub(crate) fn label(&self, at: ChannelIndex) -> String {
        let part = &self.parts[at.part];
        let name = &part.channels[at.channel].name;
        match &part.name {
            Some(part) if self.parts.len() > 1 => format!("{part}/{name}"),
            _ => name.clone(),
        }
    }

    /// All channels of the file.
    pub(crate) fn channels(&self) -> impl Iterator<Item = ChannelIndex> + '_ {
        let parts = self.parts.iter().enumerate();
        parts.flat_map(|(part, survey)| (0..survey.channels.len()).map(move |channel| ChannelIndex { part, channel }))
    }

    /// The channel of that name in the first part.
    pub(crate) fn named(&self, name: &str) -> Option<ChannelIndex> {
        let channel = self.parts[0].channels.iter().position(|channel| channel.name == name)?;
        Some(ChannelIndex { part: 0, channel })
    }

    /// Its channels for a message, the first few by name.
    #[must_use]
    pub fn channel_names(&self) -> String {
        const ENOUGH: usize = 16;
        let names: Vec<String> = self.channels().map(|at| self.label(at)).collect();
        match names.len().checked_sub(ENOUGH) {
            None | Some(0) => names.join(", "),
            Some(more) => format!("{} and {more} more", names[..ENOUGH].join(", ")),
        }
    }
}

impl PartSurvey {
    fn of(header: &exr::meta::header::Header) -> Self {
        let channels = header.channels.list.iter().map(|channel| ChannelSurvey {
            name: string(&channel.name),
            kind: match channel.sample_type {
                SampleType::F16 => SampleKind::Half,
                SampleType::F32 => SampleKind::Float,
                SampleType::U32 => SampleKind::Uint,
            },
            subsampled: channel.sampling.x() != 1 || channel.sampling.y() != 1,
        });
        let own = &header.own_attributes;
        let tiles = match header.blocks {
            BlockDescription::ScanLines => None,
            BlockDescription::Tiles(tiles) => Some(tiles),
        };
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Self {
            name: own.layer_name.as_ref().map(string).filter(|name| !name.is_empty()),
            view: own.view_name.as_ref().map(string).filter(|view| !view.is_empty()),
            window: window(&header.data_window()),
            deep: header.deep,
            compression: compression_name(header.compression),
            tile: tiles.map(|tiles| [size(tiles.tile_size.width()), size(tiles.tile_size.height())]),
            has_levels: tiles.is_some_and(|tiles| tiles.level_mode != LevelMode::Singular),
            channels: channels.collect(),
        }
    }
}

/// What OpenEXR calls a compression.
fn compression_name(packing: Packing) -> &'static str {
    match packing {
        Packing::Uncompressed => "none",
        Packing::RLE => "RLE",
        Packing::ZIP1 => "ZIPS",
        Packing::ZIP16 => "ZIP",
        Packing::PIZ => "PIZ",
        Packing::PXR24 => "PXR24",
        Packing::B44 => "B44",
        Packing::B44A => "B44A",
        Packing::DWAA(_) => "DWAA",
        Packing::DWAB(_) => "DWAB",
        Packing::HTJ2K32 => "HTJ2K32",
        Packing::HTJ2K256 => "HTJ2K256",
    }
}

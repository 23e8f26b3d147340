//! Which layer is the picture.

use std::path::Path;

use crate::channel_name::{ChannelName, last_piece};
use crate::choose_depth::names_depth;
use crate::survey::ChannelIndex;
use crate::{ReadError, ReadOptions, Survey};

/// A layer with red, green and blue, and perhaps alpha.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ColorGroup {
    pub(crate) part: usize,
    pub(crate) layer: String,
    pub(crate) rgb: [ChannelIndex; 3],
    pub(crate) alpha: Option<ChannelIndex>,
}

impl ColorGroup {
    /// Red, green, blue and, where there is one, alpha.
    pub(crate) fn channels(&self) -> impl Iterator<Item = ChannelIndex> + '_ {
        self.rgb.into_iter().chain(self.alpha)
    }

    /// Whether one channel stands for all three.
    fn is_grey(&self) -> bool {
        self.rgb[0] == self.rgb[1]
    }

    /// What to call it in a message.
    fn label(&self, survey: &Survey) -> String {
        let red = survey.label(self.rgb[0]);
        // All of the name before the last piece
        let end = red.rfind(['.', '/']).unwrap_or(0);
        if end == 0 { "the unnamed layer".into() } else { red[..end].into() }
    }
}

/// All layers with red, green and blue, or with luminance alone, in the order of the file; ids of objects in the guise of colours left out.
pub(crate) fn color_groups(names: &[ChannelName]) -> Vec<ColorGroup> {
    type Key<'a> = (usize, &'a str, Option<&'a str>);
    let mut found: Vec<(Key<'_>, [Option<ChannelIndex>; 4])> = Vec::new();
    for name in names {
        // Luminance makes a layer too
        let index = name.color_index();
        if index.is_none() && name.base != "Y" {
            continue;
        }
        if last_piece(&name.layer).to_ascii_lowercase().starts_with("crypto") {
            continue;
        }
        let key = (name.at.part, name.layer.as_str(), name.view.as_deref());
        let place = found.iter().position(|group| group.0 == key).unwrap_or_else(|| {
            found.push((key, [None; 4]));
            found.len() - 1
        });
        if let Some(index) = index {
            found[place].1[index].get_or_insert(name.at);
        }
    }
    let groups = found.into_iter().filter_map(|((part, layer, view), [r, g, b, alpha])| {
        let grey = luminance(names, (part, layer, view));
        Some(ColorGroup { part, layer: layer.to_owned(), rgb: [r.or(grey)?, g.or(grey)?, b.or(grey)?], alpha })
    });
    groups.collect()
}

/// Alpha that stands alone in a part that is named as a picture, for colour that has none in its own: some programs write
/// `R G B` and `A` as two parts.
pub(crate) fn alpha_alone(survey: &Survey, names: &[ChannelName], color: &ColorGroup) -> Option<ChannelIndex> {
    let is_alone = |name: &&ChannelName| {
        let part = &survey.parts[name.at.part];
        name.color_index() == Some(3) && part.channels.len() == 1 && !part.deep
    };
    let mut found = names.iter().filter(is_alone).filter(|name| beauty_rank(&name.layer) <= 1);
    match (color.alpha, found.next(), found.next()) {
        (None, Some(alpha), None) if !survey.parts[color.part].deep => Some(alpha.at),
        _ => None,
    }
}

/// The luminance of a layer that has no colour beside it: no red, green or blue, no chroma, and no X of a vector.
fn luminance(names: &[ChannelName], (part, layer, view): (usize, &str, Option<&str>)) -> Option<ChannelIndex> {
    let mut grey = None;
    let same = |name: &&ChannelName| name.at.part == part && name.layer == layer && name.view.as_deref() == view;
    for name in names.iter().filter(same) {
        match (name.base.as_str(), name.color_index()) {
            ("Y", _) => grey = Some(name.at),
            ("X" | "RY" | "BY", _) | (_, Some(0..=2)) => return None,
            _ => {}
        }
    }
    grey
}

/// The layer that is the picture, and why.
pub(crate) fn choose_color(
    path: &Path,
    survey: &Survey,
    options: &ReadOptions,
    groups: &[ColorGroup],
) -> Result<(ColorGroup, String), ReadError> {
    if groups.is_empty() {
        return Err(no_color(path, survey));
    }
    if let Some(wanted) = &options.color {
        return named_color(path, survey, groups, wanted);
    }

    // Depth written as a grey picture is none, where there is another
    let is_depth = |group: &&ColorGroup| names_depth(&group.layer);
    let pictures: Vec<&ColorGroup> = groups.iter().filter(|group| !is_depth(group)).collect();
    let groups: Vec<&ColorGroup> = if pictures.is_empty() { groups.iter().collect() } else { pictures };

    // Take the most picture-like names; of several with one name, the one with alpha
    let best = groups.iter().map(|group| beauty_rank(&group.layer)).min().unwrap_or(0);
    let mut equals: Vec<&ColorGroup> = groups.into_iter().filter(|group| beauty_rank(&group.layer) == best).collect();
    let with_alpha = equals.iter().filter(|group| group.alpha.is_some()).count();
    let mut passed_over = String::new();
    if equals.len() > 1 && with_alpha == 1 && best < LAST_RANK {
        let (taken, others): (Vec<_>, Vec<_>) = equals.into_iter().partition(|group| group.alpha.is_some());
        let others: Vec<String> = others.iter().map(|group| group.label(survey)).collect();
        passed_over = format!(" and has alpha, {} has not", others.join(", "));
        equals = taken;
    }
    let [group] = equals[..] else {
        let candidates = equals.iter().map(|group| group.label(survey)).collect::<Vec<_>>().join(", ");
        return Err(ReadError::Ambiguous { path: path.into(), what: "colour", candidates, option: "--color" });
    };
    let reason = match best {
        _ if group.is_grey() => format!("{} is a grey picture", survey.label(group.rgb[0])),
        0 => "R, G, B of the unnamed layer are the picture".to_owned(),
        LAST_RANK => format!("{} is the only layer with R, G and B", group.label(survey)),
        _ => format!("{} is named as a picture{passed_over}", group.label(survey)),
    };
    Ok((group.clone(), reason))
}

const LAST_RANK: u8 = 3;

/// 0 for the unnamed layer, up to 3 for a name that says nothing of a finished picture.
fn beauty_rank(layer: &str) -> u8 {
    let name = last_piece(layer).to_ascii_lowercase();
    match name.as_str() {
        "" => 0,
        "rgba" | "rgb" | "combined" | "beauty" | "main" | "color" | "colour" | "image" | "final" => 1,
        _ if ["rgb", "beauty", "combined"].iter().any(|word| name.contains(word)) => 2,
        _ => LAST_RANK,
    }
}

/// The layer that was asked for: by its path, by its name as written in the file, or by its part.
fn named_color(
    path: &Path,
    survey: &Survey,
    groups: &[ColorGroup],
    wanted: &str,
) -> Result<(ColorGroup, String), ReadError> {
    let is_named = |group: &&ColorGroup| {
        group.layer == wanted
            || group.label(survey) == wanted
            || (survey.parts.len() > 1 && survey.parts[group.part].name.as_deref() == Some(wanted))
    };
    let found: Vec<&ColorGroup> = groups.iter().filter(is_named).collect();
    let list = |groups: &[&ColorGroup]| groups.iter().map(|group| group.label(survey)).collect::<Vec<_>>().join(", ");
    match found[..] {
        [group] => Ok((group.clone(), "colour as asked for".into())),
        [] => {
            let available = format!("layers with R, G and B: {}", list(&groups.iter().collect::<Vec<_>>()));
            Err(ReadError::NotFound { path: path.into(), what: "colour layer", name: wanted.into(), available })
        }
        _ => Err(ReadError::Ambiguous {
            path: path.into(),
            what: "colour",
            candidates: list(&found),
            option: "--color PART/LAYER",
        }),
    }
}

/// Why there is no colour: perhaps it is there as luminance and chroma.
fn no_color(path: &Path, survey: &Survey) -> ReadError {
    let is_chroma = |name: &str| matches!(name.rsplit('.').next(), Some("RY" | "BY"));
    let mut channels = survey.parts.iter().flat_map(|part| &part.channels);
    if channels.any(|channel| is_chroma(&channel.name)) {
        return ReadError::Unsupported {
            path: path.into(),
            what: "luminance and chroma (Y, RY, BY)".into(),
            remedy: "write it with R, G and B",
        };
    }
    ReadError::NoColor { path: path.into(), available: survey.channel_names() }
}

/// Whether a layer is called `L2`, `L3`, ...
pub(crate) fn is_hidden_layer(layer: &str) -> bool {
    layer.strip_prefix('L').and_then(|number| number.parse::<u32>().ok()).is_some_and(|number| number >= 2)
}

/// Hidden layers `L2`, `L3`, ... with R, G, B and Z, beside colour of the unnamed layer.
pub(crate) fn hidden_groups(
    names: &[ChannelName],
    groups: &[ColorGroup],
    color: &ColorGroup,
) -> Vec<(ColorGroup, ChannelIndex)> {
    if !color.layer.is_empty() {
        return Vec::new();
    }
    let layer = |number: usize| {
        let wanted = format!("L{number}");
        let group = groups.iter().find(|group| group.layer == wanted && group.part == color.part)?;
        let depth = names.iter().find(|name| name.layer == wanted && name.at.part == color.part && name.is_z())?;
        Some((group.clone(), depth.at))
    };
    (2..).map_while(layer).collect()
}

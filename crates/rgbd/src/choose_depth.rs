//! Which channel is depth.

use std::path::Path;

use crate::channel_name::{ChannelName, last_piece, parent};
use crate::choose_color::{ColorGroup, is_hidden_layer};
use crate::survey::ChannelIndex;
use crate::{ReadError, ReadOptions, Survey};

/// The channel that is depth.
pub(crate) struct FoundDepth {
    pub(crate) channel: ChannelIndex,
    /// Green and blue of a layer that holds depth as a grey picture: they must be the same.
    pub(crate) copies: Vec<ChannelIndex>,
    /// Why, in a few words.
    pub(crate) why: String,
}

/// The depth that belongs to a colour layer, and why.
pub(crate) fn choose_depth(
    path: &Path,
    survey: &Survey,
    options: &ReadOptions,
    names: &[ChannelName],
    color: &ColorGroup,
) -> Result<FoundDepth, ReadError> {
    if let Some(wanted) = &options.depth {
        return named_depth(path, survey, names, wanted);
    }
    let ranked: Vec<(u8, &ChannelName)> =
        names.iter().filter_map(|name| Some((depth_rank(names, name, color)?, name))).collect();
    let Some(best) = ranked.iter().map(|&(rank, _)| rank).min() else {
        return Err(ReadError::NoDepth { path: path.into(), available: survey.channel_names() });
    };
    let (equals, others): (Vec<_>, Vec<_>) = ranked.iter().copied().partition(|&(rank, _)| rank == best);
    let labels = |names: &[(u8, &ChannelName)]| {
        names.iter().map(|(_, name)| survey.label(name.at)).collect::<Vec<_>>().join(", ")
    };
    let [(_, depth)] = equals[..] else {
        let candidates = labels(&equals);
        return Err(ReadError::Ambiguous { path: path.into(), what: "depth", candidates, option: "--depth" });
    };

    // Say what decided, and what else is called Z
    let label = survey.label(depth.at);
    let copies = copies(names, depth);
    let mut reason = match best {
        0 => format!("{label} stands beside them"),
        _ if !copies.is_empty() => format!("{label} is named as depth, three times the same"),
        _ => format!("{label} is named as depth"),
    };
    if !others.is_empty() {
        reason = format!("{reason}, nearer to the picture than {}", labels(&others));
    }
    let is_other = |name: &&ChannelName| {
        name.is_z() && !is_hidden_layer(&name.layer) && !ranked.iter().any(|(_, ranked)| ranked.at == name.at)
    };
    let rest: Vec<String> = names.iter().filter(is_other).map(|name| survey.label(name.at)).collect();
    if !rest.is_empty() {
        reason = format!("{reason}, unlike {}", rest.join(", "));
    }
    Ok(FoundDepth { channel: depth.at, copies, why: reason })
}

/// Green and blue beside a red that is alone with them, and perhaps alpha, in its layer; none where it is another channel.
fn copies(names: &[ChannelName], red: &ChannelName) -> Vec<ChannelIndex> {
    let same_layer: Vec<&ChannelName> =
        names.iter().filter(|other| other.at.part == red.at.part && other.layer == red.layer).collect();
    let named = |index: usize| same_layer.iter().find(|name| name.color_index() == Some(index)).map(|name| name.at);
    let is_picture = same_layer.iter().all(|name| name.color_index().is_some());
    match (named(1), named(2)) {
        (Some(green), Some(blue)) if is_picture && red.color_index() == Some(0) => vec![green, blue],
        _ => Vec::new(),
    }
}

/// How surely a channel is the depth of a colour layer, 0 the surest; `None` if it is not at all.
fn depth_rank(names: &[ChannelName], name: &ChannelName, color: &ColorGroup) -> Option<u8> {
    // The unnamed layer of one part is not that of another
    let same_layer = |other: &ChannelName| other.at.part == name.at.part && other.layer == name.layer;
    let has = |base: &str| names.iter().any(|other| same_layer(other) && other.base.eq_ignore_ascii_case(base));
    let names_depth = names_depth(&name.layer);

    // Z beside X and Y is a vector's
    if (name.is_z() && has("x") && has("y")) || (is_called(name, "pz") && has("px") && has("py")) {
        return None;
    }
    // What is told about depth is none
    const ABOUT: [&str; 5] = ["error", "variance", "confidence", "mask", "normal"];
    let full = format!("{}.{}", last_piece(&name.layer), name.base).to_ascii_lowercase();
    if ABOUT.iter().any(|word| full.contains(word)) {
        return None;
    }
    if name.is_z() && name.at.part == color.part && name.layer == color.layer {
        return Some(0);
    }
    let lonely = names.iter().filter(|other| same_layer(other)).count() == 1;
    let base_names_depth = name.is_z() || is_called(name, "depth");
    if names_depth && (base_names_depth || lonely || !copies(names, name).is_empty()) {
        let beside = parent(&name.layer) == parent(&color.layer) || parent(&name.layer).is_empty();
        return Some(if beside { 1 } else { 2 });
    }
    // Z or depth of no layer in particular
    if base_names_depth && name.layer.is_empty() {
        return Some(1);
    }
    // VRayZDepth, zDepth, Pz ... of no layer
    if name.layer.is_empty() && (is_called(name, "pz") || name.base.to_ascii_lowercase().contains("depth")) {
        return Some(2);
    }
    None
}

/// Whether that is all it is called within its layer.
fn is_called(name: &ChannelName, base: &str) -> bool {
    name.base.eq_ignore_ascii_case(base)
}

/// Whether a layer is called depth.
pub(crate) fn names_depth(layer: &str) -> bool {
    let name = last_piece(layer).to_ascii_lowercase();
    name.contains("depth") || name == "z"
}

/// The channel that was asked for: by its label, its name in the file, or by its layer or
/// part if it is alone or called Z there.
fn named_depth(path: &Path, survey: &Survey, names: &[ChannelName], wanted: &str) -> Result<FoundDepth, ReadError> {
    let raw = |name: &ChannelName| survey.parts[name.at.part].channels[name.at.channel].name.as_str();
    let lonely = |name: &ChannelName| {
        names.iter().filter(|other| other.at.part == name.at.part && other.layer == name.layer).count() == 1
    };
    let alone_in_part = |name: &ChannelName| {
        let part = &survey.parts[name.at.part];
        part.name.as_deref() == Some(wanted) && part.channels.len() == 1
    };
    let tests: [&dyn Fn(&ChannelName) -> bool; 4] = [
        &|name| survey.label(name.at) == wanted,
        &|name| raw(name) == wanted || format!("{}.{}", name.layer, name.base) == wanted,
        &|name| name.layer == wanted && (name.is_z() || lonely(name) || !copies(names, name).is_empty()),
        &alone_in_part,
    ];
    for test in tests {
        let found: Vec<&ChannelName> = names.iter().filter(|name| test(name)).collect();
        match found[..] {
            [] => {}
            [name] => {
                // One that was named by itself need not be like its neighbours
                let copies = if name.layer == wanted { copies(names, name) } else { Vec::new() };
                return Ok(FoundDepth { channel: name.at, copies, why: "depth as asked for".into() });
            }
            _ => {
                let candidates = found.iter().map(|name| survey.label(name.at)).collect::<Vec<_>>().join(", ");
                return Err(ReadError::Ambiguous { path: path.into(), what: "depth", candidates, option: "--depth" });
            }
        }
    }
    let available = format!("channels: {}", survey.channel_names());
    Err(ReadError::NotFound { path: path.into(), what: "depth channel", name: wanted.into(), available })
}

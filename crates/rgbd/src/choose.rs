//! Which channels of another program's file are colour and which depth.

use std::path::Path;

use crate::channel_name::ChannelName;
use crate::choose_color::{ColorGroup, alpha_alone, choose_color, color_groups, hidden_groups};
use crate::choose_depth::choose_depth;
use crate::survey::ChannelIndex;
use crate::{Choice, ReadError, ReadOptions, Survey};

/// The channels to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Plan {
    pub(crate) color: ColorGroup,
    pub(crate) depth: Option<ChannelIndex>,
    /// Channels that must repeat it, pixel for pixel.
    pub(crate) depth_copies: Vec<ChannelIndex>,
    /// Hidden layers, each with its depth.
    pub(crate) hidden: Vec<(ColorGroup, ChannelIndex)>,
    pub(crate) choice: Choice,
}

/// Makes the choice for a frame (`with_depth`) or a picture; an error where names leave it open.
pub(crate) fn choose(path: &Path, survey: &Survey, options: &ReadOptions, with_depth: bool) -> Result<Plan, ReadError> {
    // Keep to one view
    let view = choose_view(path, survey, options)?;
    let names: Vec<ChannelName> = survey.channels().map(|at| ChannelName::of(survey, at)).collect();
    let names: Vec<ChannelName> = names.into_iter().filter(|name| name.is_in_view(view.as_deref())).collect();

    // Choose colour, then the depth that belongs to it
    let groups = color_groups(&names);
    let (mut color, mut reason) = choose_color(path, survey, options, &groups)?;
    if let Some(alpha) = alpha_alone(survey, &names, &color) {
        color.alpha = Some(alpha);
        reason = format!("{reason}, {} is its alpha", survey.label(alpha));
    }
    let mut depth = None;
    let mut depth_copies = Vec::new();
    let mut hidden = Vec::new();
    // Deep colour is flattened in the order of depth
    if with_depth || survey.parts[color.part].deep {
        let found = choose_depth(path, survey, options, &names, &color)?;
        depth = Some(found.channel);
        depth_copies = found.copies;
        hidden = hidden_groups(&names, &groups, &color);
        reason = format!("{reason}; {}, taken as {}", found.why, options.convention);
    }
    let choice = Choice {
        view,
        color: color.channels().map(|at| survey.label(at)).collect(),
        depth: depth.map(|at| survey.label(at)),
        hidden: hidden.iter().map(|(group, _)| group.layer.clone()).collect(),
        is_stated: false,
        reason,
    };
    Ok(Plan { color, depth, depth_copies, hidden, choice })
}

/// The view asked for, or the file's first.
fn choose_view(path: &Path, survey: &Survey, options: &ReadOptions) -> Result<Option<String>, ReadError> {
    let Some(wanted) = &options.view else { return Ok(survey.views.first().cloned()) };
    if survey.views.contains(wanted) {
        return Ok(Some(wanted.clone()));
    }
    let available = if survey.views.is_empty() { "it names none".into() } else { survey.views.join(", ") };
    Err(ReadError::NotFound { path: path.into(), what: "view", name: wanted.clone(), available })
}

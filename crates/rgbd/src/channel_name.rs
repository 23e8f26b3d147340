//! What the name of a channel says: layer, view, and what it is within the layer.

use crate::Survey;
use crate::survey::ChannelIndex;

/// A channel's name taken apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChannelName {
    pub(crate) at: ChannelIndex,
    /// Layer path without the view; empty for the unnamed layer.
    pub(crate) layer: String,
    /// The view it belongs to; `None` if to all.
    pub(crate) view: Option<String>,
    /// What it is within the layer: `R`, `Z`, ...
    pub(crate) base: String,
}

impl ChannelName {
    /// Takes a name apart by OpenEXR's rules.
    ///
    /// In a file of one part with a list of views, `left.Z` and `depth.left.Z` belong to the left view, `Z` to the first
    /// one, `depth.Z` to none. In a file of many parts the part says the view, and its name is the layer of channels
    /// without one: `Z` of part `depth.main` with view `main` is of layer `depth`.
    pub(crate) fn of(survey: &Survey, at: ChannelIndex) -> Self {
        let part = &survey.parts[at.part];
        let name = &part.channels[at.channel].name;
        let (mut layer, base) = match name.rsplit_once('.') {
            Some((layer, base)) => (layer.to_owned(), base.to_owned()),
            None => (String::new(), name.clone()),
        };
        let mut view = part.view.clone();
        if view.is_none() && survey.parts.len() == 1 && layer.is_empty() {
            view = survey.views.first().cloned();
        }

        // A view as the last piece of the layer is no layer
        let last = last_piece(&layer);
        if survey.views.iter().any(|view| view == last) {
            view = Some(last.to_owned());
            layer = parent(&layer).to_owned();
        }

        // The part's name is a layer's where the channel names none
        if layer.is_empty() && survey.parts.len() > 1 {
            let name = part.name.as_deref().unwrap_or("");
            let stem = view.as_deref().and_then(|view| name.strip_suffix(view)).unwrap_or(name);
            layer = if stem.len() < name.len() { stem.trim_end_matches(['.', '_', '-', ' ']) } else { name }.to_owned();
        }
        Self { at, layer, view, base }
    }

    /// Whether it belongs to a view, or to all.
    pub(crate) fn is_in_view(&self, view: Option<&str>) -> bool {
        self.view.is_none() || view.is_none() || self.view.as_deref() == view
    }

    /// 0 to 3 for red, green, blue, alpha.
    pub(crate) fn color_index(&self) -> Option<usize> {
        match self.base.to_ascii_lowercase().as_str() {
            "r" | "red" => Some(0),
            "g" | "green" => Some(1),
            "b" | "blue" => Some(2),
            "a" | "alpha" => Some(3),
            _ => None,
        }
    }

    /// Whether `Z` is all it is called within its layer.
    pub(crate) fn is_z(&self) -> bool {
        self.base.eq_ignore_ascii_case("z")
    }
}

/// The last piece of a layer path: `Depth` of `ViewLayer.Depth`.
pub(crate) fn last_piece(layer: &str) -> &str {
    layer.rsplit('.').next().unwrap_or("")
}

/// All but the last piece of a layer path.
pub(crate) fn parent(layer: &str) -> &str {
    layer.rsplit_once('.').map_or("", |(parent, _)| parent)
}

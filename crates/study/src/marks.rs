//! How families of methods are told apart on paper: a shape and a class of the style sheet each.

use maud::{Markup, html};

use crate::Family;

impl Family {
    /// The class of the style sheet that colours it.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::OwnCoc => "own-coc",
            Self::Gather => "gather",
            Self::Merged => "merged",
            Self::LensRays => "lens-rays",
            Self::Hybrid => "hybrid",
            Self::Trace => "trace",
            Self::Candidate => "candidate",
        }
    }

    /// Its outline around (0, 0), as a path of SVG.
    fn outline(self) -> &'static str {
        match self {
            Self::Pinhole => "M-4.5 0A4.5 4.5 0 1 0 4.5 0A4.5 4.5 0 1 0 -4.5 0Z",
            Self::OwnCoc => "M-4.2 -4.2H4.2V4.2H-4.2Z",
            Self::Gather => "M0 -5.4L5 3.8H-5Z",
            Self::Merged => "M0 -6L6 0L0 6L-6 0Z",
            Self::LensRays => "M0 5.4L5 -3.8H-5Z",
            Self::Hybrid => "M0 -5.6L5.3 -1.7L3.3 4.5H-3.3L-5.3 -1.7Z",
            Self::Trace => "M-3.4 0A3.4 3.4 0 1 0 3.4 0A3.4 3.4 0 1 0 -3.4 0Z",
            Self::Candidate => "M-1.7 -5.5H1.7V-1.7H5.5V1.7H1.7V5.5H-1.7V1.7H-5.5V-1.7H-1.7Z",
        }
    }
}

/// The mark of a family at a place in pixels; hollow where it is not `full`.
pub(crate) fn mark(family: Family, is_full: bool, (x, y): (f64, f64)) -> Markup {
    let fill = if is_full { "full" } else { "hollow" };
    html! {
        path class={ "mark " (family.class()) " " (fill) } d=(family.outline())
            transform={ "translate(" (px(x)) " " (px(y)) ")" } {}
    }
}

/// A length in pixels for SVG, to a hundredth.
pub(crate) fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

//! The pictures of a report: each stands in the page once; the before/after viewer borrows them.

use maud::{Markup, html};

use crate::{CompareError, Entry, HeatKind, Ramp, Report, png::data_uri};

/// What can be put under the slider: element id and name.
fn choices(report: &Report<'_>) -> Vec<(String, String)> {
    let mut list = vec![("picture-reference".to_owned(), format!("{} (reference)", report.reference_name))];
    list.extend(report.entries().enumerate().map(|(i, entry)| (format!("picture-{i}"), entry.name.clone())));
    for (i, entry) in report.entries().enumerate() {
        list.push((format!("picture-{i}-signed"), format!("{}: signed difference", entry.name)));
    }
    list
}

/// The before/after slider, at first between the reference and the first candidate. A range input moves the seam, so
/// keys, fingers and mice all do.
pub(crate) fn viewer(report: &Report<'_>) -> Markup {
    let choices = choices(report);
    let window = report.reference.display();
    let select = |id: &str, label: &str, chosen: &str| {
        html! {
            label { (label) " "
                select id=(id) {
                    @for (value, name) in &choices {
                        option value=(value) selected[value == chosen] { (name) }
                    }
                }
            }
        }
    };
    html! {
        section.viewer id="viewer" hidden {
            div.choices {
                (select("left", "Left", "picture-reference"))
                (select("right", "Right", "picture-0"))
            }
            div.stage id="stage" style={ "aspect-ratio:" (window.width) "/" (window.height) } {
                img id="under" alt="left picture";
                img id="over" alt="right picture";
                div.seam {}
            }
            label.slider { span { "Seam" }
                input id="cut" type="range" min="0" max="100" step="0.5" value="50"
                    aria-label="Where the left picture ends, per cent of the width";
            }
        }
    }
}

/// All pictures and maps, each once.
pub(crate) fn gallery(report: &Report<'_>) -> Result<Markup, CompareError> {
    let scales = HeatKind::EVERY.map(|kind| (kind, report.scale_of(kind)));
    let reference = data_uri(&report.reference.picture(), report.exposure_stops)?;
    let mut parts = Vec::new();
    for (i, entry) in report.entries().enumerate() {
        parts.push(entry_pictures(report, entry, i, &scales)?);
    }
    Ok(html! {
        section {
            h2 { "Pictures" }
            div.gallery {
                figure.wide {
                    img id="picture-reference" src=(reference) alt={ "Reference: " (report.reference_name) };
                    figcaption { b { (report.reference_name) } " · reference" }
                }
            }
            @for part in &parts { (part) }
        }
    })
}

fn entry_pictures(
    report: &Report<'_>,
    entry: &Entry,
    index: usize,
    scales: &[(HeatKind, f32); 3],
) -> Result<Markup, CompareError> {
    let picture = data_uri(&entry.comparison.candidate, report.exposure_stops)?;
    let mut maps = Vec::new();
    for &(kind, scale) in scales {
        let values = kind.values(report.reference, &entry.comparison);
        maps.push((kind, scale, data_uri(&kind.draw(&values, scale), 0.0)?));
    }
    Ok(html! {
        h3 { (entry.name) }
        @if !entry.note.is_empty() { p.about { (entry.note) } }
        div.gallery {
            figure {
                img id={ "picture-" (index) } src=(picture) alt=(entry.name);
                figcaption { b { (entry.name) } }
            }
            @for (kind, scale, uri) in &maps {
                figure {
                    img id={ "picture-" (index) "-" (map_id(*kind)) } src=(uri)
                        alt={ (map_name(*kind)) " of " (entry.name) };
                    figcaption { b { (map_name(*kind)) } (legend(*kind, *scale)) }
                }
            }
        }
    })
}

fn map_id(kind: HeatKind) -> &'static str {
    match kind {
        HeatKind::Signed => "signed",
        HeatKind::Absolute => "absolute",
        HeatKind::Flip => "flip",
    }
}

fn map_name(kind: HeatKind) -> &'static str {
    match kind {
        HeatKind::Signed => "Signed difference",
        HeatKind::Absolute => "Absolute difference",
        HeatKind::Flip => "HDR-FLIP",
    }
}

/// The ramp with the numbers at its ends.
fn legend(kind: HeatKind, scale: f32) -> Markup {
    let (low, from) = match kind.ramp() {
        Ramp::Diverging => (-1.0, format!("−{scale} too dark")),
        Ramp::Sequential => (0.0, "0".to_owned()),
    };
    let to = if kind.ramp() == Ramp::Diverging { format!("+{scale} too bright") } else { format!("≥ {scale}") };
    let stops: Vec<String> = (0..=16).map(|i| kind.ramp().css(low + (1.0 - low) * i as f32 / 16.0)).collect();
    html! {
        span.legend {
            span { (from) }
            span.ramp style={ "background:linear-gradient(to right," (stops.join(",")) ")" } {}
            span { (to) }
        }
    }
}

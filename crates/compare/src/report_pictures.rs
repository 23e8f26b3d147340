//! The pictures of a report: each stands in the page once; the viewer borrows them.

use maud::{Markup, html};

use crate::{CompareError, Entry, HeatKind, Ramp, Report, png::data_uri};

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
                    (picture("picture-reference", &reference, &format!("Reference: {}", report.reference_name)))
                    figcaption { b { (report.reference_name) } " · reference" (value_of("picture-reference")) }
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
    let id = format!("picture-{index}");
    let uri = data_uri(&entry.comparison.candidate, report.exposure_stops)?;
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
                (picture(&id, &uri, &entry.name))
                figcaption { b { (entry.name) } (value_of(&id)) }
            }
            @for (kind, scale, uri) in &maps {
                @let id = format!("{id}-{}", map_id(*kind));
                figure {
                    (picture(&id, uri, &format!("{} of {}", map_name(*kind), entry.name)))
                    figcaption { b { (map_name(*kind)) } (legend(*kind, *scale)) (value_of(&id)) }
                }
            }
        }
    })
}

/// A picture in the frame that it is zoomed in.
fn picture(id: &str, uri: &str, alt: &str) -> Markup {
    html! { div.frame { img id=(id) src=(uri) alt=(alt); } }
}

/// Where the 8-bit values of a picture are read out.
fn value_of(id: &str) -> Markup {
    html! { span.value data-of=(id) {} }
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

//! The viewer of a report: two of its pictures with a seam between them, the zoom of all pictures, and what their pixels
//! hold.

use maud::{Markup, html};

use crate::Report;

/// What can be read out: element id and name of the reference, of the candidates and of the unfiltered picture.
fn pictures(report: &Report<'_>) -> Vec<(String, String)> {
    let mut list = vec![("picture-reference".to_owned(), format!("{} (reference)", report.reference_name))];
    list.extend(report.entries().enumerate().map(|(i, entry)| (format!("picture-{i}"), entry.name.clone())));
    list
}

/// What can be put under the slider: the pictures, then a map of each.
fn choices(report: &Report<'_>) -> Vec<(String, String)> {
    let map = |(i, name): (usize, &str)| (format!("picture-{i}-signed"), format!("{name}: signed difference"));
    let names = report.entries().map(|entry| entry.name.as_str());
    pictures(report).into_iter().chain(names.enumerate().map(map)).collect()
}

/// The before/after slider, at first between the reference and the first candidate. A range input moves the seam and
/// buttons zoom, so keys, fingers and mice all do. Without a script there is no viewer, and no picture is missed.
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
        section.viewer id="viewer" aria-label="Before and after" hidden
            style={ "--width:" (window.width) ";--height:" (window.height) } {
            div.choices {
                (select("left", "Left", "picture-reference"))
                (select("right", "Right", "picture-0"))
            }
            div.frame.stage id="stage" role="group" aria-label="Both pictures" aria-describedby="hint" {
                img id="under" alt="left picture";
                div.over { img id="over" alt="right picture"; }
                div.seam {}
            }
            div.controls {
                label.slider { span { "Seam" }
                    input id="cut" type="range" min="0" max="100" step="0.5" value="50"
                        aria-label="Where the left picture ends, per cent of the width";
                }
                div.zoom role="group" aria-label="Zoom of all pictures" {
                    button id="farther" type="button" aria-label="Zoom out" { "−" }
                    output id="zoom" aria-label="Zoom" {}
                    button id="closer" type="button" aria-label="Zoom in" { "+" }
                    button id="whole" type="button" aria-label="Show the whole picture" { "whole" }
                }
            }
            (readout(report))
            p.small id="hint" {
                "Click any picture, or tab to the one above: then the wheel, a pinch, " kbd { "+" } " and " kbd { "−" }
                " zoom all pictures, dragging moves them, the arrow keys go from pixel to pixel (with Shift, farther), and "
                kbd { "0" } " shows the whole again. With Ctrl, the wheel zooms without a click."
            }
        }
    }
}

/// The pixel under the pointer, in every picture.
fn readout(report: &Report<'_>) -> Markup {
    html! {
        dl.readout {
            div { dt { "Pixel (8-bit R G B)" } dd { output id="position" aria-label="Position of the pixel" { "under the pointer" } } }
            @for (id, name) in pictures(report) {
                div { dt { (name) } dd { span.value data-of=(id) {} } }
            }
        }
    }
}

//! The report as one HTML page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::{
    CompareError, MaskKind, PIXELS_PER_DEGREE, Report, psnr_db, report_pictures::gallery, report_tables::tables,
    report_viewer::viewer,
};

const STYLE: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// Nothing may be fetched: pictures are in the page, and so are style and script.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The whole page.
pub(crate) fn page(report: &Report<'_>) -> Result<String, CompareError> {
    let gallery = gallery(report)?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (report.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (report.title) }
                    @if !report.about.is_empty() { p.about { (report.about) } }
                    (facts(report))
                }
                main {
                    (viewer(report))
                    (tables(report))
                    (gallery)
                    (reproduce(report))
                }
                script id="report-data" type="application/json" { (PreEscaped(embedded_json(report))) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    Ok(page.into_string())
}

/// What the figures rest on, in a few lines.
fn facts(report: &Report<'_>) -> Markup {
    let window = report.reference.display();
    let lost: Vec<_> = report.entries().filter(|entry| entry.comparison.non_finite > 0).collect();
    html! {
        dl.facts {
            div { dt { "Picture" } dd { (window.width) " × " (window.height) " px" } }
            div { dt { "Reference" } dd { (report.reference_name) } }
            div { dt { "Its own noise" } dd { (noise(report)) } }
            @if let (Some(radius), Some(reach)) = (report.masks.largest_coc_radius_px(), report.masks.reach_px()) {
                div { dt { "Largest blur" } dd { (format!("{radius:.1} px radius")) } }
                div { dt { "Edges" } dd { "within " (format!("{reach:.0} px")) " of a jump in blur, "
                    (percent(report.masks.share(MaskKind::Edges))) } }
            }
            div { dt { "Shown at" } dd { (format!("{:+.2} stops", report.exposure_stops)) } }
        }
        @for entry in lost {
            p.warning { (entry.name) ": " (entry.comparison.non_finite)
                " pixels hold no finite number; they are taken as black." }
        }
        @if report.reference.non_finite() > 0 {
            p.warning { "The reference: " (report.reference.non_finite())
                " pixels hold no finite number; they are taken as black." }
        }
    }
}

/// The noise of the reference in words.
fn noise(report: &Report<'_>) -> String {
    let source = if report.reference.has_halves() { "from its two halves" } else { "as given" };
    match report.reference.noise_mse(report.masks, MaskKind::All) {
        Some(mse) if mse > 0.0 => format!("RMSE {:.5} ({:.1} dB), {source}", mse.sqrt(), psnr_db(mse)),
        Some(_) => format!("none, {source}"),
        None => "unknown: the figures hold it".to_owned(),
    }
}

/// A share as a percentage.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// All that is needed to do it again.
fn reproduce(report: &Report<'_>) -> Markup {
    let exposures = report.entries().next().map(|entry| entry.comparison.exposures);
    html! {
        section {
            h2 { "To reproduce" }
            @for command in &report.commands { pre { code { (command) } } }
            div.scroll {
                table.parameters {
                    tbody {
                        @for parameter in &report.parameters {
                            tr { th scope="row" { (parameter.key) } td { (parameter.value) } }
                        }
                        tr { th scope="row" { "FLIP, pixels per degree" } td { (format!("{PIXELS_PER_DEGREE:.2}")) } }
                        @if let Some(e) = exposures {
                            tr { th scope="row" { "HDR-FLIP exposures" }
                                td { (e.count) " from " (format!("{:+.2} to {:+.2}", e.start, e.stop)) " stops" } }
                        }
                        tr { th scope="row" { "Made with" }
                            td { "tiltshift " (env!("CARGO_PKG_VERSION")) } }
                    }
                }
            }
            p.small { "All figures are in this file for machines too: " code { "script#report-data" } ", JSON." }
        }
    }
}

/// The figures as JSON that cannot end the script element it stands in.
fn embedded_json(report: &Report<'_>) -> String {
    report.to_json().to_string().replace('<', "\\u003c")
}

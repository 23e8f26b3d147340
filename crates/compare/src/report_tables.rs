//! The figures of a report: one table a mask, one row a picture.

use maud::{Markup, html};

use crate::{CorrectedError, Entry, Figures, IN_FOCUS_PX, Interval, MaskKind, Report, psnr_db, report_page::percent};

/// All tables, with what their columns mean.
pub(crate) fn tables(report: &Report<'_>) -> Markup {
    html! {
        section {
            h2 { "Figures" }
            @for mask in report.masks.kinds() { (table(report, mask)) }
            p.small {
                "Linear values, peak 1, means over R, G and B. " b { "PSNR" } " is without the reference's own noise; "
                b { "raw" } " still holds it. “Below noise” means that the error cannot be told from that noise; the "
                "figure beside it is what the PSNR very probably exceeds. relMSE: mean of d² / (R² + 0.01). Bias: "
                "candidate minus reference. SSIM: higher is better, all errors: lower is better. FLIP: 0 to 1, LDR at "
                "exposure 0, HDR the worst over all exposures. In brackets: 95 % confidence, from the scatter between tiles of "
                "16 × 16 pixels. Zones: near, in focus (blur radius up to " (format!("{IN_FOCUS_PX:.0}")) " px) and far; "
                "highlights: reference brighter than white."
            }
        }
    }
}

fn table(report: &Report<'_>, mask: MaskKind) -> Markup {
    let noise = report.reference.noise_mse(report.masks, mask).filter(|&mse| mse > 0.0);
    html! {
        h3 id={ "mask-" (mask.name()) } {
            (mask.name().replace('_', " ")) span.small {
                " · " (percent(report.masks.share(mask))) " of the pixels"
                @if let Some(noise) = noise { " · noise of the reference " (format!("{:.1} dB", psnr_db(noise))) }
            }
        }
        div.scroll tabindex="0" role="region" aria-labelledby={ "mask-" (mask.name()) } {
            table.figures {
                thead {
                    tr {
                        th scope="col" { "picture" }
                        @for name in ["PSNR", "raw", "RMSE", "MAE", "bias", "relMSE", "SSIM", "LDR-FLIP", "HDR-FLIP"] {
                            th scope="col" { (name) }
                        }
                    }
                }
                tbody {
                    @for entry in &report.candidates { (row(entry, mask, "")) }
                    @if let Some(entry) = &report.unfiltered { (row(entry, mask, "unfiltered")) }
                }
            }
        }
    }
}

fn row(entry: &Entry, mask: MaskKind, class: &str) -> Markup {
    let Some(figures) = entry.comparison.within(mask) else { return html! {} };
    let sure = figures.intervals;
    html! {
        tr class=(class) {
            th scope="row" { (entry.name) }
            td.key { (corrected_psnr(figures)) (interval(psnr_interval(figures), |db| format!("{db:.1}"))) }
            td { (plain_psnr(figures)) }
            td { (number(figures.rmse())) }
            @for (value, of) in [(figures.mae, sure.mae), (figures.bias, sure.bias), (figures.rel_mse, sure.rel_mse)] {
                td { (number(value)) (interval(of, number)) }
            }
            @for (value, of) in
                [(figures.ssim, sure.ssim), (figures.flip_ldr, sure.flip_ldr), (figures.flip_hdr, sure.flip_hdr)]
            {
                td { (format!("{value:.4}")) (interval(of, |value| format!("{value:.4}"))) }
            }
        }
    }
}

/// An interval below its figure.
fn interval(interval: Option<Interval>, text: impl Fn(f64) -> String) -> Markup {
    html! { @if let Some(Interval { low, high }) = interval { span.interval { "[" (text(low)) ", " (text(high)) "]" } } }
}

/// The interval of the PSNR without the noise, in dB.
fn psnr_interval(figures: &Figures) -> Option<Interval> {
    figures.intervals.corrected_mse.map(|mse| Interval { low: psnr_db(mse.high), high: psnr_db(mse.low) })
}

/// PSNR without the noise, or why there is none.
fn corrected_psnr(figures: &Figures) -> Markup {
    match figures.corrected {
        CorrectedError::Above { mse, .. } if mse > 0.0 => html! { (format!("{:.2} dB", psnr_db(mse))) },
        CorrectedError::Above { .. } => html! { "no error" },
        CorrectedError::BelowNoise { at_most } => html! {
            "below noise " span.small { "(> " (format!("{:.1} dB", psnr_db(at_most))) ")" }
        },
        CorrectedError::UnknownNoise => html! { (plain_psnr(figures)) span.small { " noise unknown" } },
    }
}

fn plain_psnr(figures: &Figures) -> String {
    if figures.mse > 0.0 { format!("{:.2} dB", figures.psnr_db()) } else { "no error".to_owned() }
}

/// An error with three digits that count.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e3).contains(&size) {
        format!("{value:.4}")
    } else {
        format!("{value:.2e}")
    }
}

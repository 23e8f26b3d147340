//! The causes of a view as a page, a map and JSON.

use base64::Engine;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use rgbd::{Picture, encode_png};
use serde_json::{Value, json};

use crate::{Causes, CausesSettings, Machine, Shares, StudyError, Verdict};

/// The version of the JSON that [`CausesReport::to_json`] writes.
pub const CAUSES_FORMAT: u32 = 1;

const STYLE: &str = include_str!("causes.css");

/// Colours of what no single cause explains: sRGB.
const SEVERAL: [u8; 3] = [150, 150, 155];
const UNEXPLAINED: [u8; 3] = [255, 255, 255];

/// Share of the pixels that are drawn as bright as can be.
const BRIGHTEST: f64 = 0.02;

/// All that a page about causes shows.
#[derive(Debug, Clone)]
pub struct CausesReport<'a> {
    /// What was taken, such as scene and shot.
    pub subject: String,
    /// The command line that made it.
    pub command: String,
    /// Mean squared noise of the reference, which is in none of the errors.
    pub noise_mse: f64,
    /// Samples per pixel of the reference, mean.
    pub truth_samples: u32,
    /// How far the experiments went.
    pub settings: CausesSettings,
    /// The filter with one layer, and with two.
    pub causes: &'a [Causes],
}

impl Verdict {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cause(cause) => cause.name(),
            Self::Several => "several together",
            Self::Unexplained => "unexplained",
        }
    }

    fn color(self) -> [u8; 3] {
        match self {
            Self::Cause(cause) => cause.color(),
            Self::Several => SEVERAL,
            Self::Unexplained => UNEXPLAINED,
        }
    }
}

impl Shares {
    /// Each pixel in the colour of its verdict, the brighter the larger its error; in linear light, to be encoded at
    /// exposure 0.
    #[must_use]
    pub fn draw(&self) -> Picture {
        let mut errors: Vec<f32> = self.map.iter().map(|(error, _)| error.sqrt()).collect();
        errors.sort_unstable_by(f32::total_cmp);
        let brightest = errors[((1.0 - BRIGHTEST) * (errors.len() - 1) as f64) as usize].max(f32::MIN_POSITIVE);
        let window = self.window();
        Picture::from_fn(window, |x, y| {
            let (error, verdict) = self.map[window.index(x, y)];
            let share = (error.sqrt() / brightest).min(1.0);
            let [r, g, b] = verdict.color().map(|byte| share * (f32::from(byte) / 255.0).powf(2.2));
            [r, g, b, 1.0]
        })
    }
}

impl CausesReport<'_> {
    /// All figures; `format` says which version of this structure it is. Shares are parts of the squared error.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let of_filter = |causes: &Causes| {
            let ranges: serde_json::Map<String, Value> = causes
                .shares
                .causes
                .iter()
                .map(|share| (json!(share.cause).as_str().unwrap_or_default().to_owned(), json!(share.range())))
                .collect();
            json!({
                "layers": causes.layers,
                "kernel": format!("{:?}", causes.kernel).to_lowercase(),
                "rmse": causes.shares.mse.max(0.0).sqrt(),
                "shares": causes.shares,
                "ranges": ranges,
            })
        };
        json!({
            "format": CAUSES_FORMAT,
            "subject": self.subject,
            "command": self.command,
            "machine": Machine::this(),
            "reference": { "noise_mse": self.noise_mse, "samples": self.truth_samples },
            "color_samples": self.settings.color_samples,
            "margin_px": self.settings.margin,
            "layers_at_most": self.settings.most_layers,
            "finer_pixels": self.settings.fine,
            "lens_rays_of_a_finer_pixel": self.settings.lens_samples,
            "filters": self.causes.iter().map(of_filter).collect::<Vec<_>>(),
        })
    }

    /// One HTML file with everything in it; the only error is a map that cannot be encoded.
    pub fn to_html(&self) -> Result<String, StudyError> {
        let maps = self.causes.iter().map(|causes| data_uri(&causes.shares.draw())).collect::<Result<Vec<_>, _>>()?;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { "Causes: " (self.subject) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "Why the filter is wrong: " (self.subject) }
                    p { "A share is the drop of the squared error when one more cause is switched off, in the chain and in the "
                        "chain reversed; it may be negative. The reference's noise (RMSE "
                        (format!("{:.5}", self.noise_mse.sqrt())) ", " (self.truth_samples) " samples) is in none of them." }
                    @for (causes, map) in self.causes.iter().zip(&maps) { (section(causes, map)) }
                    h2 { "To reproduce" }
                    pre { code { (self.command) } }
                }
            }
        };
        Ok(page.into_string())
    }
}

fn section(causes: &Causes, map: &str) -> Markup {
    let shares = &causes.shares;
    let layers = if causes.layers == 1 { "one layer" } else { "two layers" };
    let rmse = shares.mse.max(0.0).sqrt();
    html! {
        section {
            h2 { "The filter with " (layers) }
            p { "RMSE " (format!("{rmse:.5}")) " (" (format!("{:.2}", compare::psnr_db(rmse * rmse))) " dB); all experiments together leave "
                (percent(shares.rest)) " of the squared error." }
            img src=(map) alt={ "What leads where, " (layers) };
            p.small { "Each pixel in the colour of what leads there, the brighter the larger its error." }
            div.scroll {
                table {
                    thead { tr { th { "cause" } th { "chain" } th { "reversed" } th { "explains" } th { "switched off by" } } }
                    tbody {
                        @for share in &shares.causes {
                            tr {
                                th scope="row" { (swatch(share.cause.color())) (share.cause.name()) }
                                td { (percent(share.forward)) " ± " (percent(share.standard_error)) }
                                td { (percent(share.reversed)) }
                                td { (percent(share.explains)) }
                                td.text { (share.cause.experiment()) }
                            }
                        }
                        (outcome(Verdict::Several, None, shares.several, "no experiment alone removes half of what is left"))
                        (outcome(Verdict::Unexplained, Some(shares.rest), shares.unexplained, "not even all of them remove half"))
                    }
                }
            }
        }
    }
}

fn outcome(verdict: Verdict, rest: Option<f64>, part: f64, text: &str) -> Markup {
    let rest = rest.map(percent).unwrap_or_default();
    html! {
        tr.outcome {
            th scope="row" { (swatch(verdict.color())) (verdict.name()) }
            td { (rest) } td { (rest) } td { (percent(part)) } td.text { (text) }
        }
    }
}

fn swatch([r, g, b]: [u8; 3]) -> Markup {
    html! { span.swatch style=(format!("background:rgb({r},{g},{b})")) {} }
}

/// A share in per cent.
fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn data_uri(picture: &Picture) -> Result<String, StudyError> {
    let png = encode_png(picture, 0.0).map_err(|error| StudyError::Png(error.to_string()))?;
    Ok(format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png)))
}

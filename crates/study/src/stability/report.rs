//! All figures of the suite: as text, CSV, JSON and SVG.

use serde::Serialize;

use super::{Flickers, Quality, Refusal, Sensitivity, Spoilt, SweepFigures, panels};
use crate::{Family, Machine};

/// The version of the JSON that [`Stability::to_json`] writes.
pub const STABILITY_FORMAT: u32 = 1;

/// What the figures rest on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StabilityConditions {
    /// Scene and shot.
    pub subject: String,
    /// Width and height of the pictures in pixels.
    pub size: [u32; 2],
    /// Steps of a sweep.
    pub steps: usize,
    /// How well truths and frames are traced.
    pub quality: Quality,
    /// Where it ran.
    pub machine: Machine,
    /// The command line that made it.
    pub command: String,
}

/// All figures of the suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stability {
    format: u32,
    conditions: StabilityConditions,
    sweeps: Vec<SweepFigures>,
    flickers: Vec<Flickers>,
    sensitivity: Vec<Sensitivity>,
    refusals: Vec<Refusal>,
}

/// A criterion that is not held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failed {
    /// The mode, the clip or the request.
    pub place: String,
    /// The method; empty where none has part in it.
    pub method: String,
    /// What is broken, and by how much.
    pub what: String,
}

impl Stability {
    /// The figures of some sweeps and clips.
    #[must_use]
    pub fn new(
        conditions: StabilityConditions,
        sweeps: Vec<SweepFigures>,
        flickers: Vec<Flickers>,
        sensitivity: Vec<Sensitivity>,
        refusals: Vec<Refusal>,
    ) -> Self {
        Self { format: STABILITY_FORMAT, conditions, sweeps, flickers, sensitivity, refusals }
    }

    /// What the figures rest on.
    #[must_use]
    pub fn conditions(&self) -> &StabilityConditions {
        &self.conditions
    }

    /// The sweeps.
    #[must_use]
    pub fn sweeps(&self) -> &[SweepFigures] {
        &self.sweeps
    }

    /// The clips.
    #[must_use]
    pub fn flickers(&self) -> &[Flickers] {
        &self.flickers
    }

    /// What doubtful depth costs.
    #[must_use]
    pub fn sensitivity(&self) -> &[Sensitivity] {
        &self.sensitivity
    }

    /// Names and families of the methods, in their order.
    #[must_use]
    pub fn methods(&self) -> Vec<(String, Family)> {
        let of_sweeps =
            self.sweeps.first().map(|sweep| sweep.curves.iter().map(|c| (c.name.clone(), c.family)).collect());
        let of_clips =
            || self.flickers.first().map(|clip| clip.methods.iter().map(|m| (m.name.clone(), m.family)).collect());
        of_sweeps.or_else(of_clips).unwrap_or_default()
    }

    /// Every criterion that is not held, the modes first.
    #[must_use]
    pub fn failed(&self) -> Vec<Failed> {
        let of_sweeps = self.sweeps.iter().flat_map(|sweep| {
            sweep.curves.iter().filter_map(|curve| {
                let what = curve.verdict.broken()?;
                Some(Failed { place: sweep.mode.name().to_owned(), method: curve.name.clone(), what })
            })
        });
        let of_clips = self.flickers.iter().flat_map(|clip| {
            clip.methods.iter().filter(|method| method.is_too_much()).map(|method| Failed {
                place: clip.clip.name().to_owned(),
                method: method.name.clone(),
                what: format!("flicker {:.2}", method.index),
            })
        });
        let of_requests = self.refusals.iter().filter(|refusal| !refusal.is_documented).map(|refusal| Failed {
            place: refusal.request.to_owned(),
            method: String::new(),
            what: refusal.said.clone().unwrap_or_else(|| "accepted".to_owned()),
        });
        of_sweeps.chain(of_clips).chain(of_requests).collect()
    }

    /// All figures as JSON; `format` says which version of this structure it is.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    /// One line for each mode, method and step under a heading; RMS errors and changes of linear values. A first step has no
    /// change.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut csv = "mode,method,at,rmse,rmse_unfiltered,change_rms,change_peak,truth_change_rms,truth_change_peak,\
                       truth_noise_rms,truth_noise_peak\n"
            .to_owned();
        for sweep in &self.sweeps {
            for curve in &sweep.curves {
                for (i, at) in sweep.at.iter().enumerate() {
                    csv += &format!("{},{},{at}", sweep.mode.name(), curve.name);
                    csv += &format!(",{},{}", curve.error[i].rmse(), sweep.unfiltered[i].rmse());
                    match i.checked_sub(1).map(|k| (curve.change_rms[k], curve.change_peak[k], sweep.truth_change[k])) {
                        Some((rms, peak, truth)) => {
                            csv += &format!(",{rms},{peak},{},{}", truth.rms, truth.peak);
                            csv += &format!(",{},{}\n", truth.noise_rms, truth.noise_peak);
                        }
                        None => csv += ",,,,,,\n",
                    }
                }
            }
        }
        csv
    }

    /// The table of modes by methods, then flicker, then sensitivity, as aligned text. A cell of a mode is the worst of
    /// change, peak change and error over what is allowed: held up to 1.00.
    #[must_use]
    pub fn to_text(&self) -> String {
        let methods = self.methods();
        let mut rows = Vec::new();
        let names =
            |first: &str| [first.to_owned()].into_iter().chain(methods.iter().map(|(name, _)| short(name))).collect();
        if !self.sweeps.is_empty() {
            rows.push(names("worst over allowed"));
        }
        for sweep in &self.sweeps {
            let cells = sweep.curves.iter().map(|curve| worst_text(curve.verdict));
            rows.push([sweep.mode.name().to_owned()].into_iter().chain(cells).collect());
        }
        if !self.flickers.is_empty() {
            rows.push(names("flicker index"));
        }
        for clip in &self.flickers {
            let cells = clip.methods.iter().map(|method| format!("{:.2}", method.index));
            rows.push([clip.clip.name().to_owned()].into_iter().chain(cells).collect());
        }
        if !self.sensitivity.is_empty() {
            rows.push(names("error over clean depth's"));
            for spoilt in Spoilt::EVERY {
                let cells = self.sensitivity.iter().map(|method| match spoilt {
                    Spoilt::Clean => format!("({:.4})", method.error[0].rmse()),
                    _ => format!("{:.2}", method.growth(spoilt)),
                });
                rows.push([spoilt.name().to_owned()].into_iter().chain(cells).collect());
            }
        }
        aligned(&rows)
    }

    /// Error and change per step over each sweep as small multiples in one SVG file, which follows the reader's light or
    /// dark scheme.
    #[must_use]
    pub fn to_svg(&self) -> String {
        panels::draw(self)
    }
}

/// The worst ratio of all criteria, and a letter for the one that is broken.
fn worst_text(verdict: super::SweepVerdict) -> String {
    if verdict.non_finite > 0 {
        return "NaN".to_owned();
    }
    let criteria = [("c", verdict.change_rms), ("p", verdict.change_peak), ("e", verdict.error)];
    let (letter, worst) =
        criteria.into_iter().max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio)).expect("three criteria");
    if worst.holds() { format!("{:.2}", worst.ratio) } else { format!("{:.2} {letter}", worst.ratio) }
}

/// `merged 2 layers` as `merged 2`.
pub(super) fn short(name: &str) -> String {
    name.replace(" layers", "").replace(" layer", "")
}

/// Rows whose first column stands left, all others right.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells =
            cells.map(|(i, (cell, &width))| if i == 0 { format!("{cell:width$}") } else { format!("{cell:>width$}") });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

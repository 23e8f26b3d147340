//! The error report: what was compared, how far off it is, and all that is needed to do it again.

use serde_json::{Value, json};

use crate::{
    CompareError, Comparison, CorrectedError, Figures, HeatKind, MaskKind, Masks, PIXELS_PER_DEGREE, Reference,
    report_page::page, round_scale,
};

/// One compared picture of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its name, short enough for a table.
    pub name: String,
    /// How it was made, in a sentence; may be empty.
    pub note: String,
    /// How it differs from the reference.
    pub comparison: Comparison,
}

/// A named value that is needed to reproduce the report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// What it is, with its unit.
    pub key: String,
    /// Its value.
    pub value: String,
}

impl Parameter {
    /// A key with a value.
    pub fn new(key: impl Into<String>, value: impl ToString) -> Self {
        Self { key: key.into(), value: value.to_string() }
    }
}

/// All that a report page shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Report<'a> {
    /// Heading of the page.
    pub title: String,
    /// What was asked, in a sentence or two; may be empty.
    pub about: String,
    /// What the reference is called.
    pub reference_name: String,
    /// The reference.
    pub reference: &'a Reference,
    /// The masks over which the figures were taken.
    pub masks: &'a Masks,
    /// The picture without any depth of field, beside which all figures stand.
    pub unfiltered: Option<Entry>,
    /// The pictures in question.
    pub candidates: Vec<Entry>,
    /// Exposure of the pictures (not of the figures and maps), in stops.
    pub exposure_stops: f32,
    /// What is needed to reproduce it.
    pub parameters: Vec<Parameter>,
    /// The command lines that made it.
    pub commands: Vec<String>,
}

impl Report<'_> {
    /// One HTML file with everything in it: no other file, no network.
    ///
    /// The only error is a picture that cannot be encoded.
    pub fn to_html(&self) -> Result<String, CompareError> {
        page(self)
    }

    /// The same figures for machines; an infinite PSNR (no error at all) and one below the noise are `null`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let window = self.reference.display();
        let per_mask = |value: &dyn Fn(MaskKind) -> Value| -> Value {
            self.masks.kinds().into_iter().map(|kind| (kind.name().to_owned(), value(kind))).collect()
        };
        let source = match (self.reference.has_halves(), self.reference.noise_mse(self.masks, MaskKind::All)) {
            (true, _) => "difference of two independent halves",
            (false, Some(_)) => "given",
            (false, None) => "unknown",
        };
        let scales: serde_json::Map<String, Value> = HeatKind::EVERY
            .into_iter()
            .map(|kind| (format!("{kind:?}").to_lowercase(), json!(self.scale_of(kind))))
            .collect();
        json!({
            "format": 1,
            "title": self.title,
            "about": self.about,
            "display_window": { "x": window.x, "y": window.y, "width": window.width, "height": window.height },
            "exposure_stops": self.exposure_stops,
            "reference": {
                "name": self.reference_name,
                "non_finite_pixels": self.reference.non_finite(),
                "noise_source": source,
                "noise_mse": per_mask(&|kind| json!(self.reference.noise_mse(self.masks, kind))),
            },
            "masks": {
                "reach_px": self.masks.reach_px(),
                "largest_coc_radius_px": self.masks.largest_coc_radius_px(),
                "share": per_mask(&|kind| json!(self.masks.share(kind))),
            },
            "flip_pixels_per_degree": PIXELS_PER_DEGREE,
            "heat_map_scales": scales,
            "unfiltered": self.unfiltered.as_ref().map(entry_json),
            "candidates": self.candidates.iter().map(entry_json).collect::<Vec<_>>(),
            "parameters": self.parameters.iter().map(|p| json!({ "key": p.key, "value": p.value })).collect::<Vec<_>>(),
            "commands": self.commands,
        })
    }

    /// The candidates, then the unfiltered picture, if there is one.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.candidates.iter().chain(&self.unfiltered)
    }

    /// One scale for all maps of a kind, from the candidates: the unfiltered picture's errors would dwarf them.
    pub(crate) fn scale_of(&self, kind: HeatKind) -> f32 {
        let values = |entry: &Entry| kind.values(self.reference, &entry.comparison);
        let mut planes: Vec<_> = self.candidates.iter().map(values).collect();
        if planes.is_empty() {
            planes = self.unfiltered.iter().map(values).collect();
        }
        round_scale(&planes.iter().collect::<Vec<_>>())
    }
}

fn entry_json(entry: &Entry) -> Value {
    json!({
        "name": entry.name,
        "note": entry.note,
        "non_finite_pixels": entry.comparison.non_finite,
        "hdr_flip_exposures": entry.comparison.exposures,
        "figures": entry.comparison.figures.iter().map(figures_json).collect::<Vec<_>>(),
    })
}

fn figures_json(figures: &Figures) -> Value {
    let mut value = json!(figures);
    value["rmse"] = json!(figures.rmse());
    value["psnr_db"] = json!(Some(figures.psnr_db()).filter(|psnr| psnr.is_finite()));
    value["corrected_psnr_db"] = json!(figures.corrected.psnr_db());
    value["below_noise"] = json!(matches!(figures.corrected, CorrectedError::BelowNoise { .. }));
    value
}

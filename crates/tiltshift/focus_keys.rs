//! Focus, tilt and aperture that change from frame to frame, from a table of keys.
//!
//! What is interpolated is what blur is linear in: inverse distance of focus and inverse f-number, so that neither infinity
//! nor a wide opening makes a jump. Smooth curves are monotone cubics (Fritsch and Carlson 1980): they never leave the range
//! of two neighbouring keys.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use clap::ValueEnum;

use crate::lens_options::LensOptions;

/// How frames between two keys are made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Between {
    /// In a straight line.
    Linear,
    /// In a curve without corners that does not overshoot.
    #[default]
    Smooth,
}

/// What a column of the table sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    FocusDistance,
    Tilt,
    Swing,
    FNumber,
    HingeDistance,
}

const COLUMNS: [(&str, Column); 5] = [
    ("focus-distance", Column::FocusDistance),
    ("tilt", Column::Tilt),
    ("swing", Column::Swing),
    ("f-number", Column::FNumber),
    ("hinge-distance", Column::HingeDistance),
];

/// A table of keys.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FocusKeys {
    between: Between,
    /// Each column's keys (frame, value) in the order of frames; inverse where that is what is interpolated.
    columns: Vec<(Column, Vec<(f64, f64)>)>,
}

impl Column {
    /// Whether its inverse is interpolated.
    fn is_inverse(self) -> bool {
        matches!(self, Self::FocusDistance | Self::FNumber | Self::HingeDistance)
    }

    fn is_given(self, lens: &LensOptions) -> bool {
        match self {
            Self::FocusDistance => {
                lens.focus_distance.is_some()
                    || lens.focus_pixel.is_some()
                    || lens.focus_points.is_some()
                    || lens.focus_plane.is_some()
                    || lens.focus_band.is_some()
                    || lens.focus.is_some()
            }
            Self::Tilt => lens.tilt.is_some() || lens.hinge_distance.is_some(),
            Self::HingeDistance => lens.hinge_distance.is_some() || lens.tilt.is_some(),
            Self::Swing => lens.swing.is_some(),
            Self::FNumber => lens.f_number.is_some() || lens.aperture_radius.is_some(),
        }
    }
}

impl FocusKeys {
    /// Reads a table: commas between columns, the first line names them, the first column is the frame; an empty cell is no key.
    pub(crate) fn read(path: &PathBuf, between: Between) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {path:?}"))?;
        Self::parse(&text, path, between)
    }

    fn parse(text: &str, path: &Path, between: Between) -> anyhow::Result<Self> {
        // Leave out empty lines and remarks, and name the columns
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let mut lines = lines.by_ref().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let (_, head) = lines.next().ok_or_else(|| anyhow!("{path:?} is empty; its first line names the columns"))?;
        let mut names = head.split(',').map(|name| name.trim().to_ascii_lowercase().replace(['_', ' '], "-"));
        if names.next().as_deref() != Some("frame") {
            bail!("the first column of {path:?} must be \"frame\"");
        }
        let mut columns: Vec<(Column, Vec<(f64, f64)>)> = Vec::new();
        for name in names {
            let Some((_, column)) = COLUMNS.into_iter().find(|(known, _)| *known == name) else {
                let known = COLUMNS.map(|(known, _)| known).join(", ");
                bail!("{path:?} has a column {name:?}; known are frame, {known}");
            };
            if columns.iter().any(|(other, _)| *other == column) {
                bail!("{path:?} has two columns {name:?}");
            }
            columns.push((column, Vec::new()));
        }

        // Read the keys
        for (number, line) in lines {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != columns.len() + 1 {
                bail!("line {number} of {path:?} has {} cells, its head {}", cells.len(), columns.len() + 1);
            }
            let value = |cell: &str| cell.parse::<f64>().ok().filter(|value| !value.is_nan());
            let wrong = |cell: &str| anyhow!("line {number} of {path:?} has {cell:?} where a number should be");
            let frame = value(cells[0]).filter(|frame| frame.is_finite()).ok_or_else(|| wrong(cells[0]))?;
            for ((column, keys), cell) in columns.iter_mut().zip(&cells[1..]).filter(|(_, cell)| !cell.is_empty()) {
                let value = value(cell).ok_or_else(|| wrong(cell))?;
                let must_be_positive = matches!(column, Column::FocusDistance | Column::FNumber);
                let is_good = match column {
                    Column::Tilt | Column::Swing => value.abs() < 90.0,
                    _ => value != 0.0 && (value > 0.0 || !must_be_positive),
                };
                if !is_good {
                    return Err(wrong(cell));
                }
                keys.push((frame, if column.is_inverse() { value.recip() } else { value }));
            }
        }
        columns.retain(|(_, keys)| !keys.is_empty());
        for (_, keys) in &mut columns {
            keys.sort_by(|a, b| a.0.total_cmp(&b.0));
            if let Some(pair) = keys.windows(2).find(|pair| pair[0].0 == pair[1].0) {
                bail!("{path:?} has two keys for frame {}", pair[0].0);
            }
        }
        if columns.is_empty() {
            bail!("{path:?} holds no key");
        }
        Ok(Self { between, columns })
    }

    /// Fails where the options give what the table gives.
    pub(crate) fn check(&self, lens: &LensOptions) -> anyhow::Result<()> {
        match self.columns.iter().find(|(column, _)| column.is_given(lens)) {
            None => Ok(()),
            Some((column, _)) => {
                let name = COLUMNS.iter().find(|(_, known)| known == column).map_or("", |(name, _)| name);
                bail!("{name} is in the table of --focus-keys and among the options; give it once")
            }
        }
    }

    /// The options of a frame.
    pub(crate) fn at(&self, frame: i64, lens: &LensOptions) -> LensOptions {
        let mut lens = lens.clone();
        for (column, keys) in &self.columns {
            let value = between(keys, frame as f64, self.between);
            let value = if column.is_inverse() { value.recip() } else { value };
            match column {
                Column::FocusDistance => lens.focus_distance = Some(value),
                Column::Tilt => lens.tilt = Some(value),
                Column::Swing => lens.swing = Some(value),
                Column::FNumber => lens.f_number = Some(value),
                // A hinge at infinity is no tilt
                Column::HingeDistance if value.is_infinite() => lens.tilt = Some(0.0),
                Column::HingeDistance => lens.hinge_distance = Some(value),
            }
        }
        lens
    }
}

/// The value at a frame: of the nearest key beyond the ends, exactly a key's on its frame.
fn between(keys: &[(f64, f64)], frame: f64, how: Between) -> f64 {
    let next = keys.partition_point(|&(key, _)| key <= frame);
    if next == 0 {
        return keys[0].1;
    }
    let (Some(&(x1, y1)), (x0, y0)) = (keys.get(next), keys[next - 1]) else { return keys[next - 1].1 };
    let (t, span) = ((frame - x0) / (x1 - x0), x1 - x0);
    if t == 0.0 || how == Between::Linear {
        return y0 + t * (y1 - y0);
    }
    // Cubic Hermite, with slopes that keep it monotone
    let (m0, m1) = (slope(keys, next - 1), slope(keys, next));
    let (a, b) = (1.0 - t, t);
    let value = y0 * a * a * (1.0 + 2.0 * b) + y1 * b * b * (1.0 + 2.0 * a) + span * a * b * (m0 * a - m1 * b);
    value.clamp(y0.min(y1), y0.max(y1))
}

/// The slope at a key: the weighted harmonic mean of both sides' (Fritsch and Butland 1984), 0 at turning points and ends.
fn slope(keys: &[(f64, f64)], i: usize) -> f64 {
    if i == 0 || i + 1 == keys.len() {
        return 0.0;
    }
    let ((x0, y0), (x1, y1), (x2, y2)) = (keys[i - 1], keys[i], keys[i + 1]);
    let (h0, h1) = (x1 - x0, x2 - x1);
    let (d0, d1) = ((y1 - y0) / h0, (y2 - y1) / h1);
    if d0 * d1 <= 0.0 {
        return 0.0;
    }
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / d0 + w1 / d1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str, between: Between) -> anyhow::Result<FocusKeys> {
        FocusKeys::parse(text, Path::new("keys.csv"), between)
    }

    const TABLE: &str = "frame, focus_distance, tilt\n# a rack\n10, 2, 0\n20, inf,\n40, 4, 8\n";

    #[test]
    fn keys_are_met_and_held_beyond_the_ends() {
        for between in [Between::Linear, Between::Smooth] {
            let keys = keys(TABLE, between).unwrap();
            let at = |frame| keys.at(frame, &LensOptions::default());
            assert_eq!(at(10).focus_distance, Some(2.0));
            assert_eq!(at(20).focus_distance, Some(f64::INFINITY));
            assert_eq!((at(40).focus_distance, at(40).tilt), (Some(4.0), Some(8.0)));
            assert_eq!((at(-5).focus_distance, at(99).tilt), (Some(2.0), Some(8.0)));
        }
        let keys = keys(TABLE, Between::Linear).unwrap();
        let at = |frame| keys.at(frame, &LensOptions::default());
        // Half of 1/2 per metre; tilt has no key at 20
        assert_eq!((at(15).focus_distance, at(25).tilt), (Some(4.0), Some(4.0)));
    }

    #[test]
    fn smooth_keys_neither_pop_nor_overshoot() {
        let keys = keys("frame,tilt\n0,0\n10,1\n12,8\n50,8\n60,-3\n", Between::Smooth).unwrap();
        let tilts: Vec<f64> = (0..=60).map(|frame| keys.at(frame, &LensOptions::default()).tilt.unwrap()).collect();
        assert!(tilts.iter().all(|tilt| (-3.0..=8.0).contains(tilt)), "{tilts:?}");
        assert!(tilts[12..=50].iter().all(|&tilt| tilt == 8.0), "flat between equal keys");
        // The steepest cubic between two keys has 3 times their slope: 3.5 a frame here at most three times
        assert!(tilts.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 3.0 * 3.5), "{tilts:?}");
    }

    #[test]
    fn wrong_tables_say_where() {
        for (text, word) in [
            ("", "empty"),
            ("tilt,frame\n", "frame"),
            ("frame,tlit\n1,2\n", "tlit"),
            ("frame,tilt\n1,2,3\n", "line 2"),
            ("frame,tilt\n1,nan\n", "nan"),
            ("frame,tilt\n1,2\n1,3\n", "two keys"),
            ("frame,focus-distance\n1,0\n", "\"0\""),
            ("frame,tilt\n1,\n", "no key"),
            ("frame,tilt,tilt\n1,2,2\n", "two columns"),
        ] {
            let said = keys(text, Between::Linear).unwrap_err().to_string();
            assert!(said.contains(word), "{text:?}: {said}");
        }
    }
}

//! A public benchmark: which shots, what their truths cost, how noisy they are, and what bits they have.

use std::path::{Path, PathBuf};

use compare::{Comparison, Masks, Reference};
use rgbd::{Frame, Picture, PixelWindow, Truth};
use serde::{Deserialize, Serialize};

use crate::{PointError, StudyError};

/// The version of [`Benchmark`]'s file and of [`Score`]s.
pub const BENCHMARK_FORMAT: u32 = 1;

/// All cases, as their file tells them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Benchmark {
    format: u32,
    /// What it is for.
    pub description: String,
    /// What is to be taken.
    #[serde(rename = "case")]
    pub cases: Vec<Case>,
}

/// One picture to make.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name, that of its files.
    pub name: String,
    /// The scene file, from the folder of the benchmark's own.
    pub scene: PathBuf,
    /// The shot.
    pub shot: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel of the truth.
    pub samples: u32,
    /// Root mean square noise of the truth.
    pub noise: f64,
    /// [`checksum`] of the truth's picture.
    pub checksum: String,
}

/// How wrong a picture of one case is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// The case.
    pub case: String,
    /// Within each mask, the truth's noise taken off; and HDR-FLIP.
    pub error: PointError,
}

impl Benchmark {
    /// Reads a benchmark's file (TOML).
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let bad = |why: String| StudyError::Benchmark { why: why.trim_end().to_owned() };
        let benchmark: Self = toml::from_str(text).map_err(|error| bad(error.to_string()))?;
        if benchmark.format != BENCHMARK_FORMAT {
            return Err(bad(format!(
                "format {} is not known; this program reads {BENCHMARK_FORMAT}",
                benchmark.format
            )));
        }
        for (i, case) in benchmark.cases.iter().enumerate() {
            let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
            if case.name.is_empty() || !case.name.chars().all(is_plain) {
                return Err(bad(format!("the name {:?} must be letters, digits, _ and - alone", case.name)));
            }
            if benchmark.cases[..i].iter().any(|other| other.name == case.name) {
                return Err(bad(format!("two cases are named {:?}", case.name)));
            }
        }
        Ok(benchmark)
    }
}

/// The CRC-32 (ISO 3309) of a picture's pixels over a window: R, G, B of each, row by row, as little-endian 32-bit floats; as
/// eight hexadecimal digits.
#[must_use]
pub fn checksum(picture: &Picture, window: PixelWindow) -> String {
    let mut crc = crc32fast::Hasher::new();
    for (x, y) in window.pixels() {
        for value in &picture.at(x, y)[..3] {
            crc.update(&value.to_le_bytes());
        }
    }
    format!("{:08x}", crc.finalize())
}

/// Holds a picture of a case against its truth; the frame tells where edges are.
pub fn score(case: &Case, truth: &Truth, frame: &Frame, picture: &Picture) -> Result<Score, StudyError> {
    let camera = frame.camera.or(truth.camera).ok_or(StudyError::NoCamera)?;
    let reference = Reference::from_truth(truth)?;
    let masks = Masks::from_frame(frame, &camera, None)?;
    let error = PointError::from(&Comparison::new(&reference, picture, &masks)?);
    Ok(Score { case: case.name.clone(), error })
}

impl Case {
    /// The scene's file, where the benchmark's own lies at `benchmark`.
    #[must_use]
    pub fn scene_file(&self, benchmark: &Path) -> PathBuf {
        benchmark.parent().unwrap_or(Path::new("")).join(&self.scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: &str = r#"
        [[case]]
        name = "a"
        scene = "../scenes/simple.toml"
        shot = "tilt"
        size = [32, 18]
        samples = 4
        noise = 0.1
        checksum = "00000000"
    "#;

    #[test]
    fn a_benchmark_is_read_or_refused() {
        let head = "format = 1\ndescription = \"\"\n";
        let read = Benchmark::parse(&format!("{head}{CASE}")).unwrap();
        assert_eq!(read.cases[0].size, [32, 18]);
        assert_eq!(
            read.cases[0].scene_file(Path::new("data/benchmark/benchmark.toml")),
            Path::new("data/benchmark/../scenes/simple.toml")
        );
        for text in [
            String::new(),
            format!("format = 2\ndescription = \"\"\n{CASE}"),
            format!("{head}{CASE}{CASE}"),
            format!("{head}{}", CASE.replace("\"a\"", "\"../a\"")),
            format!("{head}{CASE}more = 1"),
        ] {
            assert!(matches!(Benchmark::parse(&text), Err(StudyError::Benchmark { .. })), "{text}");
        }
    }

    #[test]
    fn the_checksum_is_that_of_the_bits() {
        // `python3 -c "import struct, zlib; print('%08x' % zlib.crc32(struct.pack('<6f', 0.5, 1, 2, 0.5, 1, 2)))"`
        let window = PixelWindow::of_size(2, 1);
        assert_eq!(checksum(&Picture::filled(window, [0.5, 1.0, 2.0, 1.0]), window), "65fbe85e");
        let other = Picture::filled(window, [0.5, 1.0, f32::from_bits(2.0_f32.to_bits() + 1), 1.0]);
        assert_ne!(checksum(&other, window), "65fbe85e");
    }
}

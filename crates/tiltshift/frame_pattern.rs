//! Names of the frames of a sequence: `shot.####.exr`, `shot.%04d.exr`, `shot.*.exr`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// A name with a place for a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FramePattern {
    folder: PathBuf,
    before: String,
    /// At least so many digits.
    width: usize,
    after: String,
}

impl FramePattern {
    /// The pattern of a path whose name holds `####` or `%04d`; `None` of a plain one.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let made = |before: &str, width: usize, after: &str| {
            Some(Self { folder: folder.clone(), before: before.to_owned(), width, after: after.to_owned() })
        };
        if let Some(end) = name.rfind('#') {
            let before = name[..end].trim_end_matches('#');
            return made(before, end + 1 - before.len(), &name[end + 1..]);
        }
        // %d, %4d or %04d
        let start = name.rfind('%')?;
        let (digits, after) = name[start + 1..].split_once('d')?;
        if digits.len() > 2 || !digits.chars().all(|digit| digit.is_ascii_digit()) {
            return None;
        }
        made(&name[..start], digits.parse().unwrap_or(1), after)
    }

    /// The file of a frame.
    pub(crate) fn path(&self, frame: i64) -> PathBuf {
        let Self { folder, before, width, after } = self;
        let number = if frame < 0 { format!("-{:0width$}", -frame) } else { format!("{frame:0width$}") };
        folder.join(format!("{before}{number}{after}"))
    }

    /// The number of a name that fits the pattern.
    fn number(&self, name: &str) -> Option<i64> {
        let digits = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let (is_negative, digits) = digits.strip_prefix('-').map_or((false, digits), |digits| (true, digits));
        let is_number = digits.len() >= self.width.max(1) && digits.len() <= 9;
        if !is_number || !digits.chars().all(|digit| digit.is_ascii_digit()) {
            return None;
        }
        // More digits than asked for only where they are needed
        if digits.len() > self.width.max(1) && digits.starts_with('0') {
            return None;
        }
        digits.parse::<i64>().ok().map(|number| if is_negative { -number } else { number })
    }

    /// The frames that are there.
    pub(crate) fn found(&self) -> anyhow::Result<BTreeMap<i64, PathBuf>> {
        let names = names_in(&self.folder)?;
        Ok(names.iter().filter_map(|name| Some((self.number(name)?, self.folder.join(name)))).collect())
    }
}

/// Whether a name holds `*` or `?`.
pub(crate) fn is_glob(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains(['*', '?'])) && !path.exists()
}

/// The files whose names fit a pattern of `*` (anything) and `?` (one character), in the order of their names.
pub(crate) fn globbed(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let pattern = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let pattern: Vec<char> = pattern.chars().collect();
    let fits = |name: &&String| fits(&pattern, &name.chars().collect::<Vec<_>>());
    Ok(names_in(&folder)?.iter().filter(fits).map(|name| folder.join(name)).collect())
}

/// Whether a name fits, in time of the product of both lengths at most.
fn fits(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => (p, n) = (p + 1, n + 1),
            // Let the last star take one more
            _ => match star {
                Some((at, from)) => {
                    star = Some((at, from + 1));
                    (p, n) = (at + 1, from + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

/// The number that a file's name ends with, before its ending: 17 of `shot.0017.exr`.
pub(crate) fn last_number(path: &Path) -> Option<i64> {
    let stem = path.file_stem()?.to_str()?;
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| at + 1);
    // The dash may belong to the name: shot-0017
    stem.get(start..end).filter(|digits| digits.len() <= 9)?.parse().ok()
}

/// The names of the files in a folder, sorted; hidden ones are not looked at.
fn names_in(folder: &Path) -> anyhow::Result<Vec<String>> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot look into the folder {folder:?}"))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.with_context(|| format!("cannot look into the folder {folder:?}"))?;
        names.extend(entry.file_name().into_string().ok().filter(|name| !name.starts_with('.')));
    }
    names.sort();
    Ok(names)
}

/// Frames in words: `1, 3-5, 9`.
pub(crate) fn in_words(frames: &[i64]) -> String {
    let mut runs: Vec<[i64; 2]> = Vec::new();
    for &frame in frames {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == frame => run[1] = frame,
            _ => runs.push([frame; 2]),
        }
    }
    let word = |&[first, last]: &[i64; 2]| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first}-{last}"),
    };
    const MOST: usize = 20;
    let words: Vec<String> = runs.iter().take(MOST).map(word).collect();
    let more = if runs.len() > MOST { ", ..." } else { "" };
    format!("{}{more}", words.join(", "))
}

/// The pattern of a result: with a place for the number, or the number put before the ending.
pub(crate) fn numbered(path: &Path, frame: i64) -> PathBuf {
    match FramePattern::of(path) {
        Some(pattern) => pattern.path(frame),
        None => crate::files::numbered(path, frame),
    }
}

/// Fails for a pattern that no file can fit.
pub(crate) fn expect_some<T>(path: &Path, found: &BTreeMap<i64, T>) -> anyhow::Result<()> {
    if found.is_empty() {
        bail!("no file fits {path:?}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_name_frames_and_find_them_again() {
        for (text, frame, name) in [
            ("a/shot.####.exr", 17, "a/shot.0017.exr"),
            ("shot_%04d.png", 17, "shot_0017.png"),
            ("%d.exr", 12345, "12345.exr"),
            ("v2_##", 123, "v2_123"),
            ("s.####.exr", -3, "s.-0003.exr"),
        ] {
            let pattern = FramePattern::of(Path::new(text)).unwrap();
            let path = pattern.path(frame);
            assert_eq!(path, Path::new(name));
            assert_eq!(pattern.number(&path.file_name().unwrap().to_string_lossy()), Some(frame), "{text}");
        }
        let pattern = FramePattern::of(Path::new("shot.####.exr")).unwrap();
        for other in ["shot.017.exr", "shot.00017.exr", "shot.abcd.exr", "shot.0017.exr.bak", "shoot.0017.exr"] {
            assert_eq!(pattern.number(other), None, "{other}");
        }
        assert_eq!(FramePattern::of(Path::new("100%.exr")), None);
        assert_eq!(FramePattern::of(Path::new("shot.exr")), None);
    }

    #[test]
    fn stars_and_question_marks_fit_what_they_say() {
        let fits = |pattern: &str, name: &str| {
            super::fits(&pattern.chars().collect::<Vec<_>>(), &name.chars().collect::<Vec<_>>())
        };
        assert!(fits("shot.*.exr", "shot.0017.exr") && fits("*", "") && fits("a?c*", "abc") && fits("*b*b", "abcb"));
        assert!(!fits("shot.*.exr", "shot.exr") && !fits("a?c", "ac") && !fits("*b", "abc"));
        // No name makes it slow
        assert!(!fits(&"*a".repeat(20), &"a".repeat(2000).replace('a', "b")));
        assert_eq!(last_number(Path::new("v2/shot-0017.exr")), Some(17));
        assert_eq!(last_number(Path::new("shot.exr")), None);
    }

    #[test]
    fn frames_are_told_in_runs() {
        assert_eq!(in_words(&[1, 3, 4, 5, 9, 10]), "1, 3-5, 9, 10");
    }
}

//! Values that options are made of.

use std::str::FromStr;

use anyhow::{anyhow, bail};
use glam::DVec2;

/// A pixel of the picture: column from the left, row from the top of the display window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pixel {
    pub(crate) x: i32,
    pub(crate) y: i32,
}

impl Pixel {
    /// Its centre as a continuous coordinate.
    pub(crate) fn center(self) -> DVec2 {
        DVec2::new(f64::from(self.x) + 0.5, f64::from(self.y) + 0.5)
    }
}

impl FromStr for Pixel {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (x, y) = halves(text, ',')?;
        let whole = |part: &str| part.parse().map_err(|_| anyhow!("{part:?} is not a whole number of pixels"));
        Ok(Self { x: whole(x)?, y: whole(y)? })
    }
}

impl std::fmt::Display for Pixel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// Two numbers with a comma between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair(pub(crate) f64, pub(crate) f64);

impl FromStr for Pair {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (a, b) = halves(text, ',')?;
        Ok(Self(finite(a)?, finite(b)?))
    }
}

/// Two distances in metres, `0.5,10`, which may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ends(pub(crate) [f32; 2]);

impl FromStr for Ends {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (a, b) = halves(text, ',')?;
        let distance = |part: &str| match part.parse::<f32>() {
            Ok(distance) if distance >= 0.0 => Ok(distance),
            _ => bail!("{part:?} is no distance: a number that is 0 or more, or inf"),
        };
        let ends = [distance(a)?, distance(b)?];
        if ends[0] == ends[1] { bail!("black and white stand for the same distance") } else { Ok(Self(ends)) }
    }
}

/// Width and height in pixels, `1280x720`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl FromStr for Size {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (width, height) = halves(text, 'x')?;
        let side = |part: &str| match part.parse() {
            Ok(side) if (1..=65536).contains(&side) => Ok(side),
            _ => bail!("{part:?} is not a number of pixels from 1 to 65536"),
        };
        Ok(Self { width: side(width)?, height: side(height)? })
    }
}

/// Samples of each pixel, `128..256`: from the first to before the second, both even (one for each half).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SampleRange(pub(crate) [u32; 2]);

impl FromStr for SampleRange {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (first, end) = text.split_once("..").ok_or_else(|| anyhow!("two numbers with \"..\" between, please"))?;
        let even = |part: &str| match part.trim().parse::<u32>() {
            Ok(number) if number % 2 == 0 && number <= 2 * trace::MAX_SAMPLES => Ok(number),
            _ => bail!("{part:?} is not an even number from 0 to {}", 2 * trace::MAX_SAMPLES),
        };
        let range = [even(first)?, even(end)?];
        if range[0] < range[1] { Ok(Self(range)) } else { bail!("there is no sample in it") }
    }
}

/// Frames, `1..48`: first and last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Frames(pub(crate) [i64; 2]);

impl FromStr for Frames {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (first, last) = text.split_once("..").ok_or_else(|| anyhow!("two numbers with \"..\" between, please"))?;
        let whole = |part: &str| match part.trim().parse::<i64>() {
            Ok(number) if number.abs() <= 1_000_000 => Ok(number),
            _ => bail!("{part:?} is not a whole number from -1000000 to 1000000"),
        };
        let frames = [whole(first)?, whole(last)?];
        if frames[0] <= frames[1] { Ok(Self(frames)) } else { bail!("there is no frame in it") }
    }
}

/// Pixels of the picture, `100,50,640x360`: left column, top row, width and height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Crop(pub(crate) rgbd::PixelWindow);

impl FromStr for Crop {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let (place, size) =
            text.rsplit_once(',').ok_or_else(|| anyhow!("left, top and size please, like 100,50,640x360"))?;
        let (Pixel { x, y }, Size { width, height }) = (place.parse()?, size.parse()?);
        Ok(Self(rgbd::PixelWindow { x, y, width, height }))
    }
}

/// A number that is 0 or more.
pub(crate) fn not_negative(text: &str) -> anyhow::Result<f64> {
    let number = finite(text)?;
    if number >= 0.0 { Ok(number) } else { bail!("it must be 0 or more") }
}

fn halves(text: &str, separator: char) -> anyhow::Result<(&str, &str)> {
    let (a, b) =
        text.split_once(separator).ok_or_else(|| anyhow!("two numbers with a {separator:?} between, please"))?;
    Ok((a.trim(), b.trim()))
}

/// A finite number.
pub(crate) fn finite(text: &str) -> anyhow::Result<f64> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => bail!("{text:?} is not a finite number"),
    }
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> anyhow::Result<f64> {
    let number = finite(text)?;
    if number > 0.0 { Ok(number) } else { bail!("it must be above 0") }
}

/// An exposure in stops.
pub(crate) fn stops(text: &str) -> anyhow::Result<f32> {
    let stops = finite(text)?;
    if stops.abs() <= 100.0 { Ok(stops as f32) } else { bail!("it must be between -100 and 100") }
}

/// A size of memory: a number, alone for bytes or with KiB, MiB, GiB or TiB.
pub(crate) fn bytes(text: &str) -> anyhow::Result<u64> {
    const UNITS: [(&str, u32); 4] = [("KiB", 10), ("MiB", 20), ("GiB", 30), ("TiB", 40)];
    let unit = UNITS.into_iter().find_map(|(unit, power)| Some((text.strip_suffix(unit)?, power)));
    let (number, power) = unit.unwrap_or((text, 0));
    match number.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok((number * 2f64.powi(power as i32)) as u64),
        _ => bail!("{text:?} is no size of memory; write bytes, or a number with KiB, MiB or GiB"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_memory_are_bytes_or_have_a_unit() {
        for (text, wanted) in
            [("512", 512), ("1.5KiB", 1536), ("64 MiB", 64 << 20), ("4GiB", 4 << 30), ("1TiB", 1 << 40)]
        {
            assert_eq!(bytes(text).unwrap(), wanted, "{text}");
        }
        for text in ["", "GiB", "0", "-1GiB", "4GB", "nanMiB", "infKiB"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }
}

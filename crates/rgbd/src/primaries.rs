//! The colours that R, G and B stand for.

use glam::{DMat3, DVec3};

/// CIE xy chromaticities of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Red x, y.
    pub red: [f32; 2],
    /// Green x, y.
    pub green: [f32; 2],
    /// Blue x, y.
    pub blue: [f32; 2],
    /// White x, y.
    pub white: [f32; 2],
}

/// To the responses of cones (Bradford; Lam 1985).
const CONES_FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    0.8951, -0.7502, 0.0389, //
    0.2664, 1.7135, -0.0685, //
    -0.1614, 0.0367, 1.0296,
]);

impl Primaries {
    /// Rec. 709 / sRGB primaries with D65 white, OpenEXR's default.
    pub const REC709: Self = Self { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };

    /// The linear map of colours with these primaries to those of Rec. 709, row by row; white becomes white.
    ///
    /// Whites that differ are adapted to each other by Bradford's cone responses, as ICC profiles do; but CIE XYZ itself
    /// (red 1, 0; green 0, 1; blue 0, 0) is measured light, whose white is none to adapt. `None` if the primaries span no
    /// colours (three on a line, a white without brightness, numbers that are none).
    #[must_use]
    pub fn to_rec709(&self) -> Option<[[f32; 3]; 3]> {
        let (from, to) = (self.xyz_from_rgb()?, Self::REC709.xyz_from_rgb()?);
        let cones = |white: [f32; 2]| Some(CONES_FROM_XYZ * (xyz(white) / positive(f64::from(white[1]))?));
        let gain = cones(Self::REC709.white)? / cones(self.white)?;
        let is_measured = [self.red, self.green, self.blue] == [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
        let adapted = match is_measured {
            true => DMat3::IDENTITY,
            false => CONES_FROM_XYZ.inverse() * DMat3::from_diagonal(gain) * CONES_FROM_XYZ,
        };
        let map = to.inverse() * adapted * from;
        map.is_finite().then(|| map.transpose().to_cols_array_2d().map(|row| row.map(|x| x as f32)))
    }

    /// CIE XYZ of red, green and blue, so that their sum is white of brightness 1 (SMPTE RP 177).
    fn xyz_from_rgb(&self) -> Option<DMat3> {
        let primaries = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        positive(primaries.determinant().abs())?;
        let white = xyz(self.white) / positive(f64::from(self.white[1]))?;
        Some(primaries * DMat3::from_diagonal(primaries.inverse() * white))
    }
}

/// x, y and what is left of 1.
fn xyz([x, y]: [f32; 2]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), 1.0 - f64::from(x) - f64::from(y))
}

/// The number, unless it is none that can be divided by.
fn positive(number: f64) -> Option<f64> {
    (number > 1e-6 && number.is_finite()).then_some(number)
}

impl Default for Primaries {
    fn default() -> Self {
        Self::REC709
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mapped(primaries: Primaries, rgb: [f32; 3]) -> [f32; 3] {
        primaries.to_rec709().unwrap().map(|row| row.iter().zip(rgb).map(|(m, c)| m * c).sum())
    }

    #[test]
    fn rec709_stays_as_it_is_and_white_white() {
        const ROUNDING: f32 = 1e-6;
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < ROUNDING);
        assert!(near(mapped(Primaries::REC709, [0.2, 0.5, 0.7]), [0.2, 0.5, 0.7]));
        // ACES (SMPTE ST 2065-1)
        let aces =
            Primaries { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.077], white: [0.32168, 0.33767] };
        assert!(near(mapped(aces, [0.5; 3]), [0.5; 3]));
    }

    #[test]
    fn aces_red_is_the_published_one() {
        // First column of the matrix from ACES 2065-1 to Rec. 709 with Bradford, as published with ACES 1.0
        let aces =
            Primaries { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.077], white: [0.32168, 0.33767] };
        let [r, g, b] = mapped(aces, [1.0, 0.0, 0.0]);
        const PRINTED: f32 = 2e-3; // another adaptation, or digits cut off
        assert!(
            (r - 2.5217).abs() < PRINTED && (g + 0.2766).abs() < PRINTED && (b + 0.0154).abs() < PRINTED,
            "{r} {g} {b}"
        );
    }

    #[test]
    fn primaries_on_a_line_or_of_nonsense_have_no_map() {
        for bad in [
            Primaries { blue: [0.47, 0.465], ..Primaries::REC709 },
            Primaries { white: [0.3, 0.0], ..Primaries::REC709 },
            Primaries { red: [f32::NAN, 0.3], ..Primaries::REC709 },
        ] {
            assert_eq!(bad.to_rec709(), None, "{bad:?}");
        }
    }
}

//! Lenses and sensors by their names.

use std::fmt;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use optics::ThinLens;
use serde::Serialize;

/// A tilt-shift lens as its maker describes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct LensPreset {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// Its name in the shop.
    pub(crate) lens: &'static str,
    pub(crate) focal_length_mm: f64,
    pub(crate) widest_f_number: f64,
    /// Largest tilt or swing, in degrees either way.
    pub(crate) tilt_deg: f64,
    /// Largest shift in mm either way.
    pub(crate) shift_mm: f64,
}

const fn lens(name: &'static str, lens: &'static str, [focal, widest, tilt, shift]: [f64; 4]) -> LensPreset {
    LensPreset { name, lens, focal_length_mm: focal, widest_f_number: widest, tilt_deg: tilt, shift_mm: shift }
}

/// Focal length, widest f-number, tilt and shift, as the makers state them.
pub(crate) const LENSES: [LensPreset; 15] = [
    lens("canon-ts-e-17", "Canon TS-E 17mm f/4L", [17.0, 4.0, 6.5, 12.0]),
    lens("canon-ts-e-24", "Canon TS-E 24mm f/3.5L", [24.0, 3.5, 8.0, 11.0]),
    lens("canon-ts-e-24-ii", "Canon TS-E 24mm f/3.5L II", [24.0, 3.5, 8.5, 12.0]),
    lens("canon-ts-e-45", "Canon TS-E 45mm f/2.8", [45.0, 2.8, 8.0, 11.0]),
    lens("canon-ts-e-50", "Canon TS-E 50mm f/2.8L Macro", [50.0, 2.8, 8.5, 12.0]),
    lens("canon-ts-e-90", "Canon TS-E 90mm f/2.8", [90.0, 2.8, 8.0, 11.0]),
    lens("canon-ts-e-90-macro", "Canon TS-E 90mm f/2.8L Macro", [90.0, 2.8, 10.0, 12.0]),
    lens("canon-ts-e-135", "Canon TS-E 135mm f/4L Macro", [135.0, 4.0, 10.0, 12.0]),
    lens("nikon-pc-19", "Nikon PC Nikkor 19mm f/4E ED", [19.0, 4.0, 7.5, 12.0]),
    lens("nikon-pc-e-24", "Nikon PC-E Nikkor 24mm f/3.5D ED", [24.0, 3.5, 8.5, 11.5]),
    lens("nikon-pc-e-45", "Nikon PC-E Micro Nikkor 45mm f/2.8D ED", [45.0, 2.8, 8.5, 11.5]),
    lens("nikon-pc-e-85", "Nikon PC-E Micro Nikkor 85mm f/2.8D", [85.0, 2.8, 8.5, 11.5]),
    lens("fujifilm-gf-30-ts", "Fujifilm GF 30mm f/5.6 T/S", [30.0, 5.6, 8.5, 15.0]),
    lens("fujifilm-gf-110-ts", "Fujifilm GF 110mm f/5.6 T/S Macro", [110.0, 5.6, 10.0, 15.0]),
    lens("samyang-ts-24", "Samyang T-S 24mm f/3.5 ED AS UMC", [24.0, 3.5, 8.5, 12.0]),
];

impl ValueEnum for LensPreset {
    fn value_variants<'a>() -> &'a [Self] {
        &LENSES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name))
    }
}

impl LensPreset {
    /// What of a setting the real lens cannot do, in sentences; the lens in metres.
    pub(crate) fn beyond(&self, lens: &ThinLens) -> Vec<String> {
        /// What rounding makes of a limit that was typed.
        const ROUNDING: f64 = 1.001;
        let mut said = Vec::new();
        let name = self.lens;
        if lens.f_number() * ROUNDING < self.widest_f_number {
            said.push(format!(
                "the {name} opens to f/{} at most, not to f/{:.2}",
                self.widest_f_number,
                lens.f_number()
            ));
        }
        let tilt = lens.total_tilt().to_degrees();
        if tilt > self.tilt_deg * ROUNDING {
            said.push(format!("the {name} tilts by {}° at most, not by {tilt:.2}°", self.tilt_deg));
        }
        let shift = lens.shift().length() * 1e3;
        if shift > self.shift_mm * ROUNDING {
            said.push(format!("the {name} shifts by {} mm at most, not by {shift:.1} mm", self.shift_mm));
        }
        said
    }
}

/// A sensor by the name of its format.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct SensorFormat {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// Long and short side in mm.
    pub(crate) sides_mm: [f64; 2],
}

const fn sensor(name: &'static str, long: f64, short: f64) -> SensorFormat {
    SensorFormat { name, sides_mm: [long, short] }
}

/// As cameras have them; makers differ by some tenths of a millimetre.
pub(crate) const SENSORS: [SensorFormat; 8] = [
    sensor("full-frame", 36.0, 24.0),
    sensor("aps-c", 23.5, 15.6),
    sensor("aps-c-canon", 22.3, 14.9),
    sensor("mft", 17.3, 13.0),
    sensor("one-inch", 13.2, 8.8),
    sensor("super-35", 24.89, 18.66),
    sensor("medium-44x33", 43.8, 32.9),
    sensor("medium-54x40", 53.4, 40.0),
];

impl ValueEnum for SensorFormat {
    fn value_variants<'a>() -> &'a [Self] {
        &SENSORS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name))
    }
}

impl SensorFormat {
    /// What of its width a picture of this size in square pixels shows: its long side lies along the picture's.
    pub(crate) fn width_mm(&self, width: f64, height: f64) -> f64 {
        let [long, _] = self.sides_mm;
        if width >= height { long } else { long * width / height }
    }
}

/// All presets, as a table.
pub(crate) struct Table;

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Lenses (--lens-preset)")?;
        for preset in LENSES {
            let LensPreset { name, lens, widest_f_number: n, tilt_deg: tilt, shift_mm: shift, .. } = preset;
            let tilt = format!("±{tilt}°");
            writeln!(f, "  {name:<20} {lens:<38} f/{n:<4} tilt {tilt:<6} shift ±{shift} mm")?;
        }
        write!(f, "\nSensors (--sensor)")?;
        for SensorFormat { name, sides_mm: [long, short] } in SENSORS {
            write!(f, "\n  {name:<20} {long} x {short} mm")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_beyond_the_real_lens_is_named() {
        let preset = LENSES.into_iter().find(|preset| preset.name == "canon-ts-e-24-ii").unwrap();
        let lens = |n: f64, tilt: f64| ThinLens::new(0.024, n, 0.024).unwrap().tilted(tilt.to_radians(), 0.0).unwrap();
        assert!(preset.beyond(&lens(3.5, 8.5)).is_empty(), "its limits are within its limits");
        assert!(preset.beyond(&lens(2.8, 0.0))[0].contains("f/3.5"));
        assert!(preset.beyond(&lens(4.0, -9.0))[0].contains("8.5°"));
        let shifted = lens(4.0, 0.0).shifted(glam::DVec2::new(10.0, 10.0) * 1e-3).unwrap();
        assert!(preset.beyond(&shifted)[0].contains("12 mm"));
    }

    #[test]
    fn a_sensor_stands_upright_with_the_picture() {
        let full = SENSORS[0];
        assert_eq!(full.width_mm(3000.0, 2000.0), 36.0);
        assert_eq!(full.width_mm(2000.0, 3000.0), 24.0);
        assert_eq!(full.width_mm(1920.0, 1080.0), 36.0);
    }
}

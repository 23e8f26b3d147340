//! How the cost of each method grows with the size of the picture or of the blur.

use serde::Serialize;

use crate::{Family, Machine, Measured, Rung, Timing, growth_exponent, series_svg};

/// The version of the JSON that [`Series::to_json`] writes.
pub const SERIES_FORMAT: u32 = 1;

/// What grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// The picture; in millions of pixels.
    Megapixels,
    /// The blur; largest diameter of the circle of confusion in pixels.
    BlurDiameterPx,
}

impl Over {
    /// What stands below the axis.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Megapixels => "million pixels",
            Self::BlurDiameterPx => "largest blur diameter, px",
        }
    }
}

/// What a method took at one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// How large picture or blur were, above 0; [`Over`] tells the unit.
    pub at: f64,
    /// Seconds of the filter or tracer alone.
    pub kernel: Timing,
    /// Seconds of the whole command with its files.
    pub command: Timing,
}

/// A method at all steps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Growth {
    /// Its name.
    pub name: String,
    /// What it is drawn as.
    pub family: Family,
    /// Its times, in the order of the steps.
    pub places: Vec<Place>,
    /// The power with which the time of filter or tracer alone grows; `None` from one step alone.
    pub exponent: Option<f64>,
}

/// The cost of methods as something grows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    format: u32,
    subject: String,
    over: Over,
    runs: usize,
    machine: Machine,
    command: String,
    methods: Vec<Growth>,
}

impl Series {
    /// The series of some steps, each with how large it was and with the same rungs in the same order.
    #[must_use]
    pub fn new(subject: String, over: Over, command: String, steps: &[(f64, Vec<Measured>)]) -> Self {
        let rungs: Vec<Rung> = steps.first().map_or(&[][..], |(_, measured)| measured).iter().map(|m| m.rung).collect();
        let growth = |(i, rung): (usize, &Rung)| {
            let place = |(at, measured): &(f64, Vec<Measured>)| {
                let Measured { kernel, command, .. } = &measured[i];
                Place { at: *at, kernel: kernel.clone(), command: command.clone() }
            };
            let places: Vec<Place> = steps.iter().map(place).collect();
            let medians: Vec<(f64, f64)> = places.iter().map(|place| (place.at, place.kernel.median())).collect();
            Growth { name: rung.name(), family: rung.family(), places, exponent: growth_exponent(&medians) }
        };
        let runs = steps.first().and_then(|(_, measured)| measured.first()).map_or(0, |m| m.kernel.runs().len());
        let methods = rungs.iter().enumerate().map(growth).collect();
        Self { format: SERIES_FORMAT, subject, over, runs, machine: Machine::this(), command, methods }
    }

    /// What was taken.
    #[must_use]
    pub fn subject(&self) -> &str {
        &self.subject
    }

    /// What grows.
    #[must_use]
    pub fn over(&self) -> Over {
        self.over
    }

    /// How often each method ran at each step.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.runs
    }

    /// Where.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The methods, in the order given.
    #[must_use]
    pub fn methods(&self) -> &[Growth] {
        &self.methods
    }

    /// All figures as JSON; `format` says which version of this structure it is.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    /// One line for each method and step under a heading, times in seconds.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let over = serde_json::json!(self.over);
        let over = over.as_str().unwrap_or_default();
        let mut csv = format!("method,{over},kernel_s,kernel_low_s,kernel_high_s,command_s,exponent\n");
        for Growth { name, places, exponent, .. } in &self.methods {
            let exponent = exponent.map(|exponent| exponent.to_string()).unwrap_or_default();
            for Place { at, kernel, command } in places {
                let [median, low, high] = [kernel.median(), kernel.low(), kernel.high()];
                csv += &format!("{name},{at},{median},{low},{high},{},{exponent}\n", command.median());
            }
        }
        csv
    }

    /// Time against what grows as SVG, both axes logarithmic, with the middle half of the runs as error bars.
    #[must_use]
    pub fn to_svg(&self) -> String {
        series_svg::draw(self)
    }
}

#[cfg(test)]
mod tests {
    use filter::Method;
    use rgbd::{Picture, PixelWindow};

    use super::*;

    #[test]
    fn a_method_that_takes_four_times_as_long_for_twice_as_much_grows_with_the_square() {
        let measured = |seconds: f64| Measured {
            rung: Rung::Filter(Method::Pinhole),
            picture: Picture::filled(PixelWindow::of_size(1, 1), [0.0; 4]),
            kernel: Timing::new(vec![seconds]).unwrap(),
            command: Timing::new(vec![1.0]).unwrap(),
        };
        let steps = [(1.0, vec![measured(0.1)]), (2.0, vec![measured(0.4)]), (4.0, vec![measured(1.6)])];
        let series = Series::new("a, b".to_owned(), Over::BlurDiameterPx, "tiltshift chart".to_owned(), &steps);
        let [growth] = series.methods() else { panic!("one method") };
        assert!((growth.exponent.unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(series.to_csv().lines().count(), 1 + 3);
        assert_eq!(series.to_json()["over"], "blur_diameter_px");
        let svg = series.to_svg();
        assert!(svg.contains("pinhole") && svg.contains("largest blur diameter, px"), "{svg}");
    }
}

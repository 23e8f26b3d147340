//! Time against error: all that a chart shows, for machines as CSV and JSON, for eyes as SVG.

use compare::{Comparison, CorrectedError, Figures, MaskKind};
use serde::Serialize;

use crate::{Family, Machine, Measured, Timing, Tradeoff, chart_svg, dominated_by};

/// The version of the JSON that [`Chart::to_json`] writes.
pub const CHART_FORMAT: u32 = 1;

/// Which time a chart is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// The filter or the tracer alone, everything in memory.
    Kernel,
    /// The whole command with its files.
    Command,
}

/// A root mean square error over R, G and B of linear values with the truth's noise taken off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RmsError {
    /// The error; where it cannot be told from the truth's noise, what it very probably does not exceed.
    pub rmse: f64,
    /// One standard error below; 0 where the error cannot be told from noise.
    pub low: f64,
    /// One standard error above.
    pub high: f64,
    /// Whether it cannot be told from the truth's noise.
    pub below_noise: bool,
}

impl RmsError {
    fn new(figures: &Figures) -> Self {
        match figures.corrected {
            CorrectedError::Above { mse, uncertainty } => {
                let [low, rmse, high] = [mse - uncertainty, mse, mse + uncertainty].map(|mse| mse.max(0.0).sqrt());
                Self { rmse, low, high, below_noise: false }
            }
            CorrectedError::BelowNoise { at_most } => {
                Self { rmse: at_most.sqrt(), low: 0.0, high: at_most.sqrt(), below_noise: true }
            }
            CorrectedError::UnknownNoise => {
                Self { rmse: figures.rmse(), low: figures.rmse(), high: figures.rmse(), below_noise: false }
            }
        }
    }
}

/// How wrong a picture is, within each mask that has pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PointError {
    /// Over the whole picture.
    pub all: RmsError,
    /// Near edges of depth.
    pub edges: Option<RmsError>,
    /// Elsewhere.
    pub interior: Option<RmsError>,
    /// HDR-FLIP over the whole picture, 0 to 1.
    pub flip_hdr: f64,
}

impl From<&Comparison> for PointError {
    fn from(comparison: &Comparison) -> Self {
        let within = |mask| comparison.within(mask).map(RmsError::new);
        Self {
            all: RmsError::new(comparison.all()),
            edges: within(MaskKind::Edges),
            interior: within(MaskKind::Interior),
            flip_hdr: comparison.all().flip_hdr,
        }
    }
}

/// A method on the chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Its name.
    pub name: String,
    /// What it is drawn as.
    pub family: Family,
    /// Layers of the RGB-D picture that it uses; `None` where it uses none or nobody knows.
    pub layers: Option<usize>,
    /// Rays for each pixel that gets some; `None` for methods without.
    pub samples: Option<u32>,
    /// Predicted error that it may leave in a pixel; `None` for methods that are asked for none.
    pub tolerance: Option<f32>,
    /// Seconds of the filter or tracer alone.
    pub kernel: Timing,
    /// Seconds of the whole command with its files.
    pub command: Timing,
    /// How wrong its picture is.
    pub error: PointError,
    /// The method that is no slower by the kernel's time and more accurate (or as accurate and faster); `None` on the
    /// frontier.
    pub kernel_dominated_by: Option<String>,
    /// The same by the time of the whole command.
    pub command_dominated_by: Option<String>,
}

impl Point {
    /// A rung that ran here.
    #[must_use]
    pub fn of_rung(measured: &Measured, error: PointError) -> Self {
        let Measured { rung, kernel, command, .. } = measured;
        Self {
            name: rung.name(),
            family: rung.family(),
            layers: rung.layers().filter(|&layers| layers != usize::MAX),
            samples: rung.samples(),
            tolerance: rung.tolerance(),
            kernel: kernel.clone(),
            command: command.clone(),
            error,
            kernel_dominated_by: None,
            command_dominated_by: None,
        }
    }

    /// Another program's picture, which took `seconds`; they stand for kernel and command alike.
    #[must_use]
    pub fn of_candidate(name: String, seconds: Timing, error: PointError) -> Self {
        Self {
            name,
            family: Family::Candidate,
            layers: None,
            samples: None,
            tolerance: None,
            kernel: seconds.clone(),
            command: seconds,
            error,
            kernel_dominated_by: None,
            command_dominated_by: None,
        }
    }

    /// Its time.
    #[must_use]
    pub fn time(&self, clock: Clock) -> &Timing {
        match clock {
            Clock::Kernel => &self.kernel,
            Clock::Command => &self.command,
        }
    }

    /// The method that makes it needless; `None` on the frontier.
    #[must_use]
    pub fn dominated_by(&self, clock: Clock) -> Option<&str> {
        match clock {
            Clock::Kernel => self.kernel_dominated_by.as_deref(),
            Clock::Command => self.command_dominated_by.as_deref(),
        }
    }

    pub(crate) fn tradeoff(&self, clock: Clock) -> Tradeoff {
        Tradeoff { seconds: self.time(clock).median(), error: self.error.all.rmse }
    }
}

/// What the figures rest on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conditions {
    /// What was taken, such as scene and shot.
    pub subject: String,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Largest radius of the circle of confusion in pixels.
    pub largest_coc_radius_px: Option<f64>,
    /// Samples per pixel of the truth.
    pub truth_samples: u32,
    /// Root mean square noise of the truth, which is taken off every error.
    pub truth_noise_rmse: f64,
    /// Seconds to trace colour and depth, which the filter is given; in no method's time.
    pub rgbd_seconds: f64,
    /// How often each method ran.
    pub runs: usize,
    /// Where.
    pub machine: Machine,
    /// The command line that made the chart.
    pub command: String,
}

/// All methods by time and error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    format: u32,
    conditions: Conditions,
    points: Vec<Point>,
}

impl Chart {
    /// The chart of these methods, each told whether another makes it needless.
    #[must_use]
    pub fn new(conditions: Conditions, mut points: Vec<Point>) -> Self {
        for clock in [Clock::Kernel, Clock::Command] {
            let tradeoffs: Vec<Tradeoff> = points.iter().map(|point| point.tradeoff(clock)).collect();
            let names: Vec<String> = points.iter().map(|point| point.name.clone()).collect();
            for (point, dominator) in points.iter_mut().zip(dominated_by(&tradeoffs)) {
                let dominator = dominator.map(|i| names[i].clone());
                match clock {
                    Clock::Kernel => point.kernel_dominated_by = dominator,
                    Clock::Command => point.command_dominated_by = dominator,
                }
            }
        }
        Self { format: CHART_FORMAT, conditions, points }
    }

    /// What the figures rest on.
    #[must_use]
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The methods, in the order given.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// All figures as JSON; `format` says which version of this structure it is.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    /// One line for each method under a heading; seconds and RMS errors, empty where there is none.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut csv =
            "method,family,layers,samples,tolerance,kernel_s,kernel_low_s,kernel_high_s,command_s,command_low_s,\
                       command_high_s,rmse,rmse_low,rmse_high,below_noise,rmse_edges,rmse_interior,flip_hdr,\
                       kernel_dominated_by,command_dominated_by\n"
                .to_owned();
        for point in &self.points {
            let PointError { all, edges, interior, flip_hdr } = &point.error;
            let times = [&point.kernel, &point.command].map(|time| [time.median(), time.low(), time.high()]);
            let family = serde_json::json!(point.family);
            let mut cells = vec![quoted(&point.name), family.as_str().unwrap_or_default().to_owned()];
            cells.extend([text(point.layers), text(point.samples), text(point.tolerance)]);
            cells.extend(times.as_flattened().iter().map(f64::to_string));
            cells.extend([all.rmse, all.low, all.high].map(|error| error.to_string()));
            cells.push(all.below_noise.to_string());
            cells.extend([edges, interior].map(|error| text(error.map(|error| error.rmse))));
            cells.push(flip_hdr.to_string());
            let dominators = [&point.kernel_dominated_by, &point.command_dominated_by];
            cells.extend(dominators.map(|name| name.as_deref().map(quoted).unwrap_or_default()));
            csv.push_str(&cells.join(","));
            csv.push('\n');
        }
        csv
    }

    /// The chart of one clock as SVG: both axes logarithmic, error bars of one standard error and of the middle half of the
    /// runs, the Pareto frontier, and below it what each method reached. It follows the reader's light or dark scheme.
    #[must_use]
    pub fn to_svg(&self, clock: Clock) -> String {
        chart_svg::draw(self, clock)
    }
}

fn text(value: Option<impl ToString>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// A cell of CSV (RFC 4180): in quotes where it needs them.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

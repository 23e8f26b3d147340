//! The suite as one SVG file: for each mode the error and the change per step over the sweep, a line for each method.

use maud::{Markup, html};

use super::report::short;
use super::{Estimate, Mode, Stability, SweepFigures};
use crate::{
    Family,
    chart_svg::{joined, line, path, svg},
    labels::Rect,
    log_axis::{LogAxis, two_digits},
    marks::px,
};

/// Height of a mode with its heading and axes.
const BLOCK: f64 = 196.0;

/// Where the first mode begins.
const TOP: f64 = 118.0;

/// The two plots of a mode, from its own top: errors, changes.
const PLOTS: [Rect; 2] =
    [Rect { x: 52.0, y: 42.0, width: 252.0, height: 112.0 }, Rect { x: 374.0, y: 42.0, width: 252.0, height: 112.0 }];

/// The whole file.
pub(super) fn draw(stability: &Stability) -> String {
    let conditions = stability.conditions();
    let [width, height] = conditions.size;
    let about = format!(
        "{width}x{height}, {} steps, truths of {} samples; left: error, right: change per step, both RMS",
        conditions.steps, conditions.quality.truth_samples
    );
    let title = format!("{}: stability", conditions.subject);
    let content = html! {
        (line("title", (16.0, 28.0), &title))
        (line("soft", (16.0, 48.0), &about))
        (legend(stability))
        @for (i, sweep) in stability.sweeps().iter().enumerate() { (block(sweep, TOP + BLOCK * i as f64)) }
    };
    svg(&title, TOP + BLOCK * stability.sweeps().len() as f64, &content)
}

/// A line for each method, and for truth and no filter.
fn legend(stability: &Stability) -> Markup {
    let methods = stability.methods();
    let names =
        methods.iter().enumerate().map(|(i, (name, family))| (stroke(*family, is_second(&methods, i)), short(name)));
    let fixed =
        [("noise".to_owned(), "truth's change".to_owned()), (stroke(Family::Pinhole, false), "no filter".to_owned())];
    html! {
        @for (i, (class, name)) in fixed.into_iter().chain(names).enumerate() {
            @let (x, y) = (16.0 + 152.0 * (i % 4) as f64, 66.0 + 17.0 * (i / 4) as f64);
            (path(&class, &format!("M{} {}H{}", px(x), px(y), px(x + 22.0))))
            (line("label", (x + 28.0, y + 4.0), &name))
        }
    }
}

/// Whether a method of the same family stands before it: with fewer layers.
fn is_second(methods: &[(String, Family)], index: usize) -> bool {
    methods[..index].iter().any(|(_, family)| *family == methods[index].1)
}

/// The class of a method's line; those of one family with more layers are drawn stronger.
fn stroke(family: Family, is_second: bool) -> String {
    format!("curve {}{}", family.class(), if is_second { " strong" } else { "" })
}

/// One mode: heading, verdict and both plots.
fn block(sweep: &SweepFigures, top: f64) -> Markup {
    let broken = sweep.curves.iter().filter(|curve| !curve.verdict.holds()).count();
    let verdict = match broken {
        0 => "held by all".to_owned(),
        count => format!("not held by {count} of {}", sweep.curves.len()),
    };
    html! {
        (line("label", (16.0, top + 16.0), sweep.mode.name()))
        (line("soft", (190.0, top + 16.0), &verdict))
        (errors(sweep, moved(PLOTS[0], top)))
        (changes(sweep, moved(PLOTS[1], top)))
    }
}

fn moved(rect: Rect, down: f64) -> Rect {
    Rect { y: rect.y + down, ..rect }
}

fn errors(sweep: &SweepFigures, plot: Rect) -> Markup {
    let unfiltered: Vec<f64> = sweep.unfiltered.iter().map(Estimate::rmse).collect();
    let curves: Vec<Vec<f64>> =
        sweep.curves.iter().map(|curve| curve.error.iter().map(Estimate::rmse).collect()).collect();
    let axes = Axes::new(sweep, plot, curves.iter().flatten().chain(&unfiltered).copied());
    html! {
        (axes.draw(sweep))
        (axes.curve(&stroke(Family::Pinhole, false), &sweep.at, &unfiltered))
        (methods(sweep, &axes, &sweep.at, &curves))
    }
}

fn changes(sweep: &SweepFigures, plot: Rect) -> Markup {
    let truth: Vec<f64> = sweep.truth_change.iter().map(|truth| truth.rms + truth.noise_rms).collect();
    let curves: Vec<Vec<f64>> = sweep.curves.iter().map(|curve| curve.change_rms.clone()).collect();
    let axes = Axes::new(sweep, plot, curves.iter().flatten().chain(&truth).copied());
    html! {
        (axes.draw(sweep))
        (axes.curve("noise", &sweep.change_at, &truth))
        (methods(sweep, &axes, &sweep.change_at, &curves))
    }
}

fn methods(sweep: &SweepFigures, axes: &Axes, at: &[f64], curves: &[Vec<f64>]) -> Markup {
    let named: Vec<(String, Family)> = sweep.curves.iter().map(|curve| (curve.name.clone(), curve.family)).collect();
    html! {
        @for (i, values) in curves.iter().enumerate() {
            (axes.curve(&stroke(named[i].1, is_second(&named, i)), at, values))
        }
    }
}

/// Places along x in equal steps of the sweep, values along y on a logarithmic axis that ends where nobody sees a change.
struct Axes {
    plot: Rect,
    ends: [f64; 2],
    count: f64,
    y: LogAxis,
}

/// The lowest value drawn, of what nobody sees.
const FLOOR: f64 = 0.1;

impl Axes {
    fn new(sweep: &SweepFigures, plot: Rect, values: impl Iterator<Item = f64>) -> Self {
        let seen = values.map(|value| value.max(FLOOR * Mode::UNSEEN));
        let y = LogAxis::around(seen, plot.y + plot.height, plot.y);
        let ends = [sweep.at.first(), sweep.at.last()].map(|at| at.copied().unwrap_or(0.0));
        Self { plot, ends, count: sweep.at.len().max(2) as f64 - 1.0, y }
    }

    /// Grid, frame and ticks.
    fn draw(&self, sweep: &SweepFigures) -> Markup {
        let Rect { x, y, width, height } = self.plot;
        let bottom = y + height;
        html! {
            @for tick in self.y.ticks() {
                (path("grid", &format!("M{} {}H{}", px(x), px(self.y.place(tick)), px(x + width))))
                (line("soft end", (x - 5.0, self.y.place(tick) + 4.0), &two_digits(tick)))
            }
            rect class="frame" x=(x) y=(y) width=(width) height=(height) {}
            (line("soft", (x, bottom + 15.0), &signed(self.ends[0])))
            (line("soft end", (x + width, bottom + 15.0), &signed(self.ends[1])))
            (line("soft middle", (x + 0.5 * width, bottom + 30.0), sweep.mode.axis()))
        }
    }

    /// A line of values; changes lead to a step, so that theirs begin at the second.
    fn curve(&self, class: &str, at: &[f64], values: &[f64]) -> Markup {
        let skipped = self.count + 1.0 - at.len() as f64;
        let spot = |(i, &value): (usize, &f64)| {
            let along = (i as f64 + skipped) / self.count;
            (self.plot.x + along * self.plot.width, self.y.place(value.max(FLOOR * Mode::UNSEEN)))
        };
        path(class, &joined(values.iter().enumerate().map(spot)))
    }
}

/// A place on the sweep, with its sign.
fn signed(value: f64) -> String {
    if value < 0.0 { format!("\u{2212}{}", two_digits(-value)) } else { two_digits(value) }
}

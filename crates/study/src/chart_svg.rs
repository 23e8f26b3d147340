//! The chart as one SVG file.
//!
//! Drawn with `maud`, as the plot crates (plotters, kuva) write fixed colours into each element, where a chart in a page
//! must follow the reader's light or dark scheme by a style sheet, and name the dominated methods below it.

use maud::{Markup, PreEscaped, html};

use crate::{
    Chart, Clock, Family, Point, Tradeoff, frontier,
    labels::{Labelled, Rect, place_labels},
    log_axis::{LogAxis, seconds_text, two_digits},
    marks::{mark, px},
};

const STYLE: &str = include_str!("chart.css");

/// Width of the drawing; it is scaled to the page, down to 400 pixels.
pub(crate) const WIDTH: f64 = 640.0;

/// Where the axes cross and end.
pub(crate) const PLOT: Rect = Rect { x: 64.0, y: 92.0, width: 528.0, height: 370.0 };

/// Height of a line of the table below.
pub(crate) const ROW: f64 = 20.0;

/// Mean width of a letter of a label, and the height of its line, at its largest size.
pub(crate) const LETTER: [f64; 2] = [6.9, 14.0];

/// The whole file.
pub(crate) fn draw(chart: &Chart, clock: Clock) -> String {
    let height = PLOT.y + PLOT.height + 74.0 + ROW * (chart.points().len() + 1) as f64;
    let content = html! {
        (heading(chart, clock))
        (plot(chart, clock))
        (table(chart, clock, PLOT.y + PLOT.height + 76.0))
    };
    svg(&chart.conditions().subject, height, &content)
}

/// A file of the chart's style around its content.
pub(crate) fn svg(title: &str, height: f64, content: &Markup) -> String {
    let drawing = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (WIDTH) " " (height) } role="img" {
            title { (title) }
            style { (PreEscaped(STYLE)) }
            rect class="paper" width=(WIDTH) height=(height) {}
            (content)
        }
    };
    drawing.into_string() + "\n"
}

/// A line of text.
pub(crate) fn line(class: &str, (x, y): (f64, f64), text: &str) -> Markup {
    html! { text class=(class) x=(px(x)) y=(px(y)) { (text) } }
}

fn heading(chart: &Chart, clock: Clock) -> Markup {
    let conditions = chart.conditions();
    let [width, height] = conditions.size;
    let blur = conditions.largest_coc_radius_px.map(|radius| format!(", largest blur radius {radius:.1} px"));
    let noise = two_digits(conditions.truth_noise_rmse);
    let what = match clock {
        Clock::Kernel => "filter or tracer alone",
        Clock::Command => "whole command with its files",
    };
    let runs = if conditions.runs == 1 { "1 run".to_owned() } else { format!("median of {} runs", conditions.runs) };
    html! {
        (line("title", (16.0, 28.0), &conditions.subject))
        (line("soft", (16.0, 48.0), &format!("{width}x{height}{}; truth of {} samples, its noise {noise} taken off",
            blur.unwrap_or_default(), conditions.truth_samples)))
        (line("soft", (16.0, 65.0), &format!("{}: {what}, {runs}", conditions.machine)))
    }
}

/// Axes, points, frontier and labels.
fn plot(chart: &Chart, clock: Clock) -> Markup {
    let points = chart.points();
    let times = points.iter().flat_map(|point| [point.time(clock).low(), point.time(clock).high()]);
    let x = LogAxis::around(times, PLOT.x, PLOT.x + PLOT.width);
    let errors = points.iter().map(|point| point.error.all.rmse);
    let y = LogAxis::around(errors, PLOT.y + PLOT.height, PLOT.y);
    let place = |point: &Point| (x.place(point.time(clock).median()), y.place(point.error.all.rmse));

    // Find room for the names
    let stairs = stairs(points, clock, place);
    let traced: Vec<_> = points.iter().filter(|point| point.family == Family::Trace).map(place).collect();
    let lines: Vec<Rect> = [&stairs, &traced].into_iter().flat_map(|line| along(line)).collect();
    let boxes: Vec<Labelled> = points
        .iter()
        .map(|point| {
            let (x, y) = place(point);
            Labelled { x, y, width: LETTER[0] * point.name.chars().count() as f64, height: LETTER[1] }
        })
        .collect();
    let labels = place_labels(&boxes, &lines, PLOT);

    html! {
        (grid(&x, &y))
        (time_ticks(&x))
        (error_ticks(&y))
        (line("soft", (16.0, PLOT.y - 9.0), "RMS error"))
        (line("soft end", (WIDTH - 12.0, PLOT.y - 9.0), "PSNR, dB"))
        (line("soft middle", (PLOT.x + 0.5 * PLOT.width, PLOT.y + PLOT.height + 37.0), "time"))
        (noise_line(chart.conditions().truth_noise_rmse, &y))
        (path("frontier", &joined(stairs.into_iter())))
        (path("series trace", &joined(traced.into_iter())))
        @for point in points { (bars(point, clock, &x, &y)) }
        @for point in points { (mark(point.family, point.dominated_by(clock).is_none(), place(point))) }
        @for (point, label) in points.iter().zip(&labels) { (name(point, label, place(point))) }
    }
}

/// Lines across the plot, and its border.
pub(crate) fn grid(x: &LogAxis, y: &LogAxis) -> Markup {
    let (top, bottom, left, right) = (PLOT.y, PLOT.y + PLOT.height, PLOT.x, PLOT.x + PLOT.width);
    let upright = |ticks: &[f64]| {
        let lines = ticks.iter().map(|&tick| format!("M{} {top}V{bottom}", px(x.place(tick))));
        lines.collect::<String>()
    };
    let level = |ticks: &[f64]| {
        let lines = ticks.iter().map(|&tick| format!("M{left} {}H{right}", px(y.place(tick))));
        lines.collect::<String>()
    };
    html! {
        (path("fine", &(upright(&x.fine_ticks()) + &level(&y.fine_ticks()))))
        (path("grid", &(upright(&x.ticks()) + &level(&y.ticks()))))
        rect class="frame" x=(left) y=(top) width=(PLOT.width) height=(PLOT.height) {}
    }
}

/// Times below the plot.
fn time_ticks(x: &LogAxis) -> Markup {
    html! {
        @for tick in x.ticks() {
            (line("soft middle", (x.place(tick), PLOT.y + PLOT.height + 18.0), &seconds_text(tick)))
        }
    }
}

/// Errors on the left, the same in dB on the right.
fn error_ticks(y: &LogAxis) -> Markup {
    let decibels = (0..20).map(|ten| f64::from(ten) * 10.0).map(|db| (db, 10_f64.powf(-db / 20.0)));
    html! {
        @for tick in y.ticks() {
            (line("soft end", (PLOT.x - 7.0, y.place(tick) + 4.0), &two_digits(tick)))
        }
        @for (db, error) in decibels.filter(|&(_, error)| y.holds(error)) {
            (line("soft", (PLOT.x + PLOT.width + 7.0, y.place(error) + 4.0), &db.to_string()))
        }
    }
}

/// Where the truth's own noise lies, if that is on the chart.
fn noise_line(noise: f64, y: &LogAxis) -> Markup {
    let at = y.place(noise);
    html! {
        @if y.holds(noise) {
            (path("noise", &format!("M{} {}H{}", PLOT.x, px(at), PLOT.x + PLOT.width)))
            (line("soft", (PLOT.x + 6.0, at - 5.0), "noise of the truth"))
        }
    }
}

/// The frontier as stairs, corner by corner: more time buys nothing before the next step.
fn stairs(points: &[Point], clock: Clock, place: impl Fn(&Point) -> (f64, f64)) -> Vec<(f64, f64)> {
    let tradeoffs: Vec<Tradeoff> = points.iter().map(|point| point.tradeoff(clock)).collect();
    let steps: Vec<(f64, f64)> = frontier(&tradeoffs).into_iter().map(|i| place(&points[i])).collect();
    let mut corners = Vec::new();
    let mut height = PLOT.y;
    for (x, y) in steps {
        corners.extend([(x, height), (x, y)]);
        height = y;
    }
    if !corners.is_empty() {
        corners.push((PLOT.x + PLOT.width, height));
    }
    corners
}

/// What a line covers, in small pieces.
pub(crate) fn along(line: &[(f64, f64)]) -> Vec<Rect> {
    const PIECE: f64 = 4.0;
    let pieces = |ends: &[(f64, f64)]| {
        let ((x0, y0), (x1, y1)) = (ends[0], ends[1]);
        let count = ((x1 - x0).hypot(y1 - y0) / PIECE).ceil() as usize;
        let at = move |i: usize| (i as f64 + 0.5) / count as f64;
        let piece = move |i: usize| Rect::around(x0 + at(i) * (x1 - x0), y0 + at(i) * (y1 - y0), PIECE, PIECE);
        (0..count).map(piece).collect::<Vec<_>>()
    };
    line.windows(2).flat_map(pieces).collect()
}

/// A line through places.
pub(crate) fn joined(places: impl Iterator<Item = (f64, f64)>) -> String {
    let step = |(i, (x, y)): (usize, (f64, f64))| format!("{}{} {}", if i == 0 { 'M' } else { 'L' }, px(x), px(y));
    places.enumerate().map(step).collect()
}

pub(crate) fn path(class: &str, steps: &str) -> Markup {
    html! { @if !steps.is_empty() { path class=(class) d=(steps) {} } }
}

/// The middle half of the runs, one standard error up and down, and an arrow where the error may be any lower.
fn bars(point: &Point, clock: Clock, x: &LogAxis, y: &LogAxis) -> Markup {
    const CAP: f64 = 3.0;
    let (time, error) = (point.time(clock), &point.error.all);
    let (at_x, at_y) = (x.place(time.median()), y.place(error.rmse));
    let [left, right] = [time.low(), time.high()].map(|seconds| x.place(seconds));
    let mut steps = format!("M{} {}H{}", px(left), px(at_y), px(right));
    for end in [left, right] {
        steps += &format!("M{} {}V{}", px(end), px(at_y - CAP), px(at_y + CAP));
    }
    if error.below_noise {
        let tip = (at_y + 22.0).min(PLOT.y + PLOT.height);
        steps += &format!("M{} {}V{}", px(at_x), px(at_y), px(tip));
        steps += &format!(
            "M{} {}L{} {}L{} {}",
            px(at_x - 4.0),
            px(tip - 6.0),
            px(at_x),
            px(tip),
            px(at_x + 4.0),
            px(tip - 6.0)
        );
    } else {
        let [top, bottom] = [error.high, error.low].map(|error| y.place(error));
        steps += &format!("M{} {}V{}", px(at_x), px(top), px(bottom));
        for end in [top, bottom] {
            steps += &format!("M{} {}H{}", px(at_x - CAP), px(end), px(at_x + CAP));
        }
    }
    path(&format!("bar {}", point.family.class()), &steps)
}

/// The name of a point, with a thin line to it where it stands apart.
fn name(point: &Point, label: &Rect, (x, y): (f64, f64)) -> Markup {
    const APART: f64 = 12.0;
    let nearest = (x.clamp(label.x, label.x + label.width), y.clamp(label.y, label.y + label.height));
    let is_apart = (nearest.0 - x).hypot(nearest.1 - y) > APART;
    // A shorter text than reckoned stays beside its point
    let (class, at) = if label.x + label.width <= x {
        ("label end", label.x + label.width)
    } else if label.x >= x {
        ("label", label.x)
    } else {
        ("label middle", label.x + 0.5 * label.width)
    };
    html! {
        @if is_apart { (path("lead", &joined([(x, y), nearest].into_iter()))) }
        (line(class, (at, label.y + 0.78 * label.height), &point.name))
    }
}

/// What each method reached, fastest first.
fn table(chart: &Chart, clock: Clock, top: f64) -> Markup {
    let mut points: Vec<&Point> = chart.points().iter().collect();
    points.sort_by(|a, b| a.time(clock).median().total_cmp(&b.time(clock).median()));
    let verdict = |point: &Point| match point.dominated_by(clock) {
        Some(name) => format!("dominated by {name}"),
        None => "on the frontier".to_owned(),
    };
    let error = |point: &Point| {
        let error = point.error.all;
        format!("{}{}", if error.below_noise { "< " } else { "" }, two_digits(error.rmse))
    };
    let row = |i: usize| top + ROW * (i + 1) as f64;
    html! {
        (line("soft", (38.0, top), "method"))
        (line("soft end", (268.0, top), "time"))
        (line("soft end", (356.0, top), "RMS error"))
        @for (i, point) in points.into_iter().enumerate() {
            (mark(point.family, point.dominated_by(clock).is_none(), (24.0, row(i) - 4.5)))
            (line("label", (38.0, row(i)), &point.name))
            (line("label end", (268.0, row(i)), &seconds_text(point.time(clock).median())))
            (line("label end", (356.0, row(i)), &error(point)))
            (line("soft", (376.0, row(i)), &verdict(point)))
        }
    }
}

//! A series as one SVG file, in the style of the chart.

use maud::{Markup, html};

use crate::{
    Growth, Series,
    chart_svg::{LETTER, PLOT, ROW, along, grid, joined, line, path, svg},
    labels::{Labelled, Rect, place_labels},
    log_axis::{LogAxis, seconds_text, two_digits},
    marks::{mark, px},
};

/// The whole file.
pub(crate) fn draw(series: &Series) -> String {
    let height = PLOT.y + PLOT.height + 74.0 + ROW * (series.methods().len() + 1) as f64;
    let runs = if series.runs() == 1 { "1 run".to_owned() } else { format!("median of {} runs", series.runs()) };
    let content = html! {
        (line("title", (16.0, 28.0), series.subject()))
        (line("soft", (16.0, 48.0), &format!("how time grows with {}", series.over().text())))
        (line("soft", (16.0, 65.0), &format!("{}: filter or tracer alone, {runs}", series.machine())))
        (plot(series))
        (table(series, PLOT.y + PLOT.height + 76.0))
    };
    svg(series.subject(), height, &content)
}

fn plot(series: &Series) -> Markup {
    let places = || series.methods().iter().flat_map(|growth| &growth.places);
    let x = LogAxis::around(places().map(|place| place.at), PLOT.x, PLOT.x + PLOT.width);
    let times = places().flat_map(|place| [place.kernel.low(), place.kernel.high()]);
    let y = LogAxis::around(times, PLOT.y + PLOT.height, PLOT.y);
    let spots = |growth: &Growth| -> Vec<(f64, f64)> {
        growth.places.iter().map(|place| (x.place(place.at), y.place(place.kernel.median()))).collect()
    };

    // Name each line at its end
    let ends: Vec<Labelled> = series
        .methods()
        .iter()
        .map(|growth| {
            let (x, y) = spots(growth).last().copied().unwrap_or_default();
            Labelled { x, y, width: LETTER[0] * growth.name.chars().count() as f64, height: LETTER[1] }
        })
        .collect();
    let lines: Vec<Rect> = series.methods().iter().flat_map(|growth| along(&spots(growth))).collect();
    let labels = place_labels(&ends, &lines, PLOT);

    html! {
        (grid(&x, &y))
        @for tick in x.ticks() {
            (line("soft middle", (x.place(tick), PLOT.y + PLOT.height + 18.0), &two_digits(tick)))
        }
        @for tick in y.ticks() {
            (line("soft end", (PLOT.x - 7.0, y.place(tick) + 4.0), &seconds_text(tick)))
        }
        (line("soft", (16.0, PLOT.y - 9.0), "time"))
        (line("soft middle", (PLOT.x + 0.5 * PLOT.width, PLOT.y + PLOT.height + 37.0), series.over().text()))
        @for growth in series.methods() {
            (path(&format!("series {}", growth.family.class()), &joined(spots(growth).into_iter())))
            (path(&format!("bar {}", growth.family.class()), &spreads(growth, &x, &y)))
            @for spot in spots(growth) { (mark(growth.family, true, spot)) }
        }
        @for (growth, label) in series.methods().iter().zip(&labels) {
            (line("label", (label.x, label.y + 0.78 * label.height), &growth.name))
        }
    }
}

/// The middle half of the runs at each step.
fn spreads(growth: &Growth, x: &LogAxis, y: &LogAxis) -> String {
    let spread = |place: &crate::Place| {
        let [low, high] = [place.kernel.low(), place.kernel.high()].map(|seconds| px(y.place(seconds)));
        format!("M{} {low}V{high}", px(x.place(place.at)))
    };
    growth.places.iter().map(spread).collect()
}

/// The power with which each method grows, and what it took at first and last.
fn table(series: &Series, top: f64) -> Markup {
    let row = |i: usize| top + ROW * (i + 1) as f64;
    let time =
        |place: Option<&crate::Place>| place.map(|place| seconds_text(place.kernel.median())).unwrap_or_default();
    html! {
        (line("soft", (38.0, top), "method"))
        (line("soft end", (268.0, top), "first"))
        (line("soft end", (356.0, top), "last"))
        (line("soft", (376.0, top), "grows with the power"))
        @for (i, growth) in series.methods().iter().enumerate() {
            (mark(growth.family, true, (24.0, row(i) - 4.5)))
            (line("label", (38.0, row(i)), &growth.name))
            (line("label end", (268.0, row(i)), &time(growth.places.first())))
            (line("label end", (356.0, row(i)), &time(growth.places.last())))
            (line("label", (376.0, row(i)), &growth.exponent.map(|p| format!("{p:.2}")).unwrap_or_default()))
        }
    }
}

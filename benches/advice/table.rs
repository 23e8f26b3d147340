//! How often advice keeps its word, and what it costs, from the lines of earlier runs.

use std::collections::BTreeMap;
use std::path::Path;

use filter::{GatherSettings, Method};
use study::{ExpectedError, Forecast, HybridSettings, Rung, Tolerance, choose};

/// The tolerances of the table.
const TOLERANCES: [Tolerance; 6] = [
    Tolerance::Psnr(35.0),
    Tolerance::Psnr(40.0),
    Tolerance::Psnr(45.0),
    Tolerance::HdrFlip(0.05),
    Tolerance::HdrFlip(0.02),
    Tolerance::HdrFlip(0.01),
];

/// A rung that was forecast and measured.
struct Line {
    forecast: Forecast,
    seconds: f64,
    error: ExpectedError,
}

/// What is run for a case and a tolerance.
type Policy = dyn Fn(&[Line], &Tolerance) -> Outcome;

/// What became of one piece of advice.
struct Outcome {
    is_kept: bool,
    /// Time over that of the cheapest rung that is truly within the tolerance, less 1; `None` where none is or it is not kept.
    regret: Option<f64>,
}

/// Prints the table of every scene in the file, and of all.
#[expect(clippy::print_stdout, reason = "the figures are what the bench is for")]
pub(crate) fn print(file: &Path) {
    let text = std::fs::read_to_string(file).expect("a file of lines");
    let mut cases: BTreeMap<(String, String, String), Vec<Line>> = BTreeMap::new();
    for cells in text.lines().map(|line| line.split(',').collect::<Vec<_>>()) {
        let &[scene, shot, width, rung, ref numbers @ ..] = cells.as_slice() else { continue };
        let Some(line) = line(rung, numbers) else { continue };
        cases.entry((scene.to_owned(), shot.to_owned(), width.to_owned())).or_default().push(line);
    }
    let mut scenes: Vec<&str> = cases.keys().map(|(scene, ..)| scene.as_str()).collect();
    scenes.dedup();
    scenes.push("");
    println!("{:<12} {:<22} {:>5} {:>7} {:>12} {:>10}", "scene", "policy", "cases", "kept %", "mean regret", "90 %");
    for scene in scenes {
        let of_scene =
            || cases.iter().filter(|((name, ..), _)| scene.is_empty() || name == scene).map(|(_, lines)| lines);
        let policies: [(&str, &Policy); 4] = [
            ("advice", &advised),
            ("always the default", &|lines, tolerance| always(lines, tolerance, "merged 2 layers")),
            ("always the tracer, 64", &|lines, tolerance| always(lines, tolerance, "trace 64")),
            ("always the tracer, 256", &|lines, tolerance| always(lines, tolerance, "trace 256")),
        ];
        for (name, policy) in policies {
            let outcomes: Vec<Outcome> =
                of_scene().flat_map(|lines| TOLERANCES.iter().map(move |tolerance| policy(lines, tolerance))).collect();
            let kept = outcomes.iter().filter(|outcome| outcome.is_kept).count();
            let mut regrets: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.regret).collect();
            regrets.sort_by(f64::total_cmp);
            let mean = regrets.iter().sum::<f64>() / regrets.len().max(1) as f64;
            let high = regrets.get(regrets.len() * 9 / 10).copied().unwrap_or(f64::NAN);
            let share = 100.0 * kept as f64 / outcomes.len().max(1) as f64;
            let scene = if scene.is_empty() { "all" } else { scene };
            println!("{scene:<12} {name:<22} {:>5} {share:>7.1} {mean:>12.2} {high:>10.2}", outcomes.len());
        }
    }
}

/// A rung by its name, with what was forecast and measured of it.
fn line(rung: &str, numbers: &[&str]) -> Option<Line> {
    let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().ok()).collect::<Option<_>>()?;
    let &[forecast_seconds, seconds, forecast_rmse, rmse, forecast_flip, flip] = numbers.as_slice() else {
        return None;
    };
    let error = |rmse, flip| ExpectedError { rmse, hdr_flip: Some(flip) };
    let (rung, error_forecast) = (of_name(rung)?, error(forecast_rmse, forecast_flip));
    let forecast = Forecast { rung, seconds: forecast_seconds, error: error_forecast, kernel: None };
    Some(Line { forecast, seconds, error: error(rmse, flip) })
}

/// A rung by the name that [`Rung::name`] gives it.
fn of_name(name: &str) -> Option<Rung> {
    let gather = |layers| GatherSettings { layers, ..GatherSettings::default() };
    let (first, rest) = name.split_once(' ').unwrap_or((name, ""));
    Some(match first {
        "pinhole" => Rung::Filter(Method::Pinhole),
        "own-coc" => Rung::Filter(Method::OwnCoc(gather(1))),
        "merged" => Rung::Filter(Method::Merged(gather(rest.split(' ').next()?.parse().ok()?))),
        "trace" => Rung::Trace { samples: rest.parse().ok()? },
        "hybrid" => Rung::Hybrid(HybridSettings { tolerance: rest.parse().ok()?, ..HybridSettings::default() }),
        _ => return None,
    })
}

fn advised(lines: &[Line], tolerance: &Tolerance) -> Outcome {
    let forecasts: Vec<Forecast> = lines.iter().map(|line| line.forecast.clone()).collect();
    let choice = choose(&forecasts, tolerance, None).expect("forecasts");
    let chosen = forecasts.iter().position(|forecast| std::ptr::eq(forecast, choice.forecast)).expect("one of them");
    outcome(lines, tolerance, &lines[chosen], choice.is_within)
}

fn always(lines: &[Line], tolerance: &Tolerance, name: &str) -> Outcome {
    let chosen = lines.iter().find(|line| line.forecast.rung.name() == name).expect("a rung of the ladder");
    outcome(lines, tolerance, chosen, true)
}

fn outcome(lines: &[Line], tolerance: &Tolerance, chosen: &Line, was_promised: bool) -> Outcome {
    let is_within = |line: &Line| tolerance.used_by(&line.error) <= 1.0;
    let cheapest = lines.iter().filter(|line| is_within(line)).map(|line| line.seconds).reduce(f64::min);
    match cheapest {
        // Nothing does: the advice must say so
        None => Outcome { is_kept: !was_promised, regret: None },
        Some(least) => {
            let is_kept = is_within(chosen);
            Outcome { is_kept, regret: is_kept.then(|| chosen.seconds / least - 1.0) }
        }
    }
}

//! How often advice keeps its word, and what it costs, from the lines of earlier runs.

use std::collections::BTreeMap;
use std::path::Path;

use filter::{GatherSettings, Method};
use study::{Doubt, ExpectedError, Forecast, HybridSettings, Rung, Tolerance, choose};

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
    /// Seconds of the filter or the tracer alone, and from file to file.
    seconds: [f64; 2],
    error: ExpectedError,
}

/// What is run for a case and a tolerance.
type Policy = dyn Fn(&[Line], &Tolerance) -> Outcome;

/// What became of one piece of advice.
struct Outcome {
    is_kept: bool,
    /// Time over that of the cheapest rung that is truly within the tolerance, less 1, by either clock; `None` where none is or
    /// it is not kept.
    regret: Option<[f64; 2]>,
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
    println!("regret, mean, median and 90 %: from file to file | the filter or the tracer alone");
    println!("{:<12} {:<22} {:>5} {:>7}", "scene", "policy", "cases", "kept %");
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
            let [alone, whole] = [0, 1].map(|clock| regrets(&outcomes, clock));
            let share = 100.0 * kept as f64 / outcomes.len().max(1) as f64;
            let scene = if scene.is_empty() { "all" } else { scene };
            println!("{scene:<12} {name:<22} {:>5} {share:>7.1} {whole} | {alone}", outcomes.len());
        }
    }
}

/// Mean, median and 90 % of the regrets by one clock.
fn regrets(outcomes: &[Outcome], clock: usize) -> String {
    let mut regrets: Vec<f64> = outcomes.iter().filter_map(|outcome| Some(outcome.regret?[clock])).collect();
    regrets.sort_by(f64::total_cmp);
    let mean = regrets.iter().sum::<f64>() / regrets.len().max(1) as f64;
    let [median, high] =
        [0.5, 0.9].map(|share| regrets.get((regrets.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN));
    format!("{mean:>8.2} {median:>8.2} {high:>8.2}")
}

/// A rung by its name, with what was forecast and measured of it.
fn line(rung: &str, numbers: &[&str]) -> Option<Line> {
    let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().ok()).collect::<Option<_>>()?;
    let &[forecast_seconds, kernel, command, forecast_rmse, rmse, forecast_flip, flip, doubt_rmse, doubt_flip] =
        numbers.as_slice()
    else {
        return None;
    };
    let error = |rmse, flip| ExpectedError { rmse, hdr_flip: Some(flip) };
    let doubt = doubt_rmse.is_finite().then_some(Doubt { rmse: doubt_rmse, hdr_flip: doubt_flip });
    let (rung, error_forecast) = (of_name(rung)?, error(forecast_rmse, forecast_flip));
    let forecast = Forecast { rung, seconds: forecast_seconds, error: error_forecast, doubt, kernel: None };
    Some(Line { forecast, seconds: [kernel, command], error: error(rmse, flip) })
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
        "hybrid" => {
            let (tolerance, samples) = rest.split_once(' ').unwrap_or((rest, "256"));
            let (tolerance, samples) = (tolerance.parse().ok()?, samples.parse().ok()?);
            Rung::Hybrid(HybridSettings { tolerance, samples, ..HybridSettings::default() })
        }
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
    let cheapest = [0, 1]
        .map(|clock| lines.iter().filter(|line| is_within(line)).map(|line| line.seconds[clock]).reduce(f64::min));
    match cheapest {
        [Some(alone), Some(whole)] => {
            let is_kept = is_within(chosen);
            let regret = [chosen.seconds[0] / alone - 1.0, chosen.seconds[1] / whole - 1.0];
            Outcome { is_kept, regret: is_kept.then_some(regret) }
        }
        // Nothing does: the advice must say so
        _ => Outcome { is_kept: !was_promised, regret: None },
    }
}

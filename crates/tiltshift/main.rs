//! The command line: what was typed, made into values, handed to the libraries. The only place that prints or exits.

mod command;
mod config;
mod console;
mod failure;
mod files;
mod focus_keys;
mod focus_wish;
mod frame_pattern;
mod lens_options;
mod presets;
mod read_arguments;
mod values;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::failure::{Failure, Outcome};

/// Tilt-shift depth of field: trace it, filter it, and measure how far the two are apart.
///
/// Lengths of lenses are in mm, distances in metres, angles in degrees. Exit codes: 0 done, 1 a threshold was exceeded
/// or a frame of a sequence failed, 2 bad input or usage, 130 interrupted.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Cli {
    /// Take options from a file (TOML): their names without dashes before, e.g. f-number = 1.4, tilt = 6, coc = true, lists for
    /// several values; in a table [COMMAND] for one command only. What is typed comes first.
    #[arg(long, global = true, value_name = "FILE.toml")]
    config: Option<std::path::PathBuf>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Trace a scene through a tilted lens: the ground truth, and the RGB-D frame that filters need.
    Render(command::render::Options),
    /// Join parts of a render.
    Merge(command::merge::Options),
    Filter(Box<command::filter::Options>),
    /// Say how far pictures are from a reference, and where.
    Compare(command::compare::Options),
    Info(command::info::Options),
    Lens(Box<command::lens::Options>),
    /// Filter a shot of a scene, and trace the pixels that the filter predicts to get wrong.
    Hybrid(command::hybrid::Options),
    /// Run every method on a shot of a scene, and chart time against error.
    Chart(command::chart::Options),
    /// Sweep every method through the points where methods fail, and say where it does not fail softly.
    Stability(command::stability::Options),
    /// Say why the filter is wrong on a shot of a scene: every named cause's share of its squared error.
    Causes(command::causes::Options),
    /// Say which method is the cheapest that comes within a tolerance.
    Advise(Box<command::advise::Options>),
    /// Score pictures of any program against the truths of the benchmark.
    Benchmark(command::benchmark::Options),
    /// Trace, filter and compare a scene of the project, and leave a report to open.
    Demo(command::demo::Options),
    Completions(command::completions::Options),
    Man(command::man::Options),
}

fn main() -> ExitCode {
    hush_the_decoder();
    console::listen_for_interrupts();
    match parsed().map_err(Failure::from).and_then(|cli| run(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console::say(format_args!("tiltshift: {failure}"));
            failure.exit_code()
        }
    }
}

/// What was typed, with what a --config file adds. Where that makes no sense clap says why, and ends the program.
fn parsed() -> anyhow::Result<Cli> {
    let mut command = Cli::command();
    command.build();
    let line = config::with_config(&command, std::env::args_os().collect())?;
    let matches = Cli::command().get_matches_from(line);
    Ok(Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()))
}

/// Keeps quiet about panics of the decoder of EXR files: the reader catches them, and says in a sentence what they mean.
fn hush_the_decoder() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !panic.location().is_some_and(|place| place.file().contains("/exr-1.")) {
            usual(panic);
        }
    }));
}

fn run(command: Command) -> Outcome {
    let outcome = match command {
        Command::Render(options) => command::render::run(&options),
        Command::Merge(options) => command::merge::run(&options),
        Command::Filter(options) => command::filter::run(&options),
        Command::Compare(options) => command::compare::run(&options),
        Command::Info(options) => command::info::run(&options),
        Command::Lens(options) => command::lens::run(&options),
        Command::Hybrid(options) => command::hybrid::run(&options),
        Command::Chart(options) => command::chart::run(&options),
        Command::Stability(options) => command::stability::run(&options),
        Command::Causes(options) => command::causes::run(&options),
        Command::Advise(options) => command::advise::run(&options),
        Command::Benchmark(options) => command::benchmark::run(&options),
        Command::Demo(options) => command::demo::run(&options),
        Command::Completions(options) => command::completions::run(&options, &mut Cli::command()),
        Command::Man(options) => command::man::run(&options, &Cli::command()),
    };
    // Whatever error an interrupted stage came up with, it was the interruption
    match outcome {
        Err(_) if console::is_interrupted() => Err(Failure::Interrupted),
        Ok(()) if console::lost_output() => {
            Err(anyhow::anyhow!("the result could not be written to standard output").into())
        }
        outcome => outcome,
    }
}

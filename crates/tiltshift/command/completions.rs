//! `tiltshift completions`: what a shell needs to complete command lines.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::console;
use crate::failure::Outcome;

/// Write the completions of a shell to standard output.
///
/// For bash: tiltshift completions bash > ~/.local/share/bash-completion/completions/tiltshift
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The shell.
    shell: Shell,
}

/// Writes them.
pub(crate) fn run(options: &Options, command: &mut Command) -> Outcome {
    let mut bytes = Vec::new();
    clap_complete::generate(options.shell, command, "tiltshift", &mut bytes);
    console::print(String::from_utf8_lossy(&bytes).trim_end());
    Ok(())
}

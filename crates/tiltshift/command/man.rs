//! `tiltshift man`: manual pages.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command};
use clap_mangen::Man;

use crate::console::say;
use crate::failure::Outcome;
use crate::files::make_folder;

/// Write manual pages, one for tiltshift and one for each command, into a folder.
///
/// To read one: man ./FOLDER/tiltshift-filter.1
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The folder.
    folder: PathBuf,
}

/// Writes them.
pub(crate) fn run(options: &Options, command: &Command) -> Outcome {
    make_folder(&options.folder)?;
    let mut command = command.clone().disable_help_subcommand(true);
    command.build();
    let mut count = 0;
    let subcommands = command.get_subcommands().filter(|subcommand| !subcommand.is_hide_set());
    for page in std::iter::once(&command).chain(subcommands) {
        let name =
            if page.get_name() == "tiltshift" { "tiltshift".into() } else { format!("tiltshift-{}", page.get_name()) };
        let mut bytes = Vec::new();
        Man::new(page.clone().display_name(name.clone()))
            .render(&mut bytes)
            .context("the manual page cannot be made")?;
        let path = options.folder.join(format!("{name}.1"));
        rgbd::replace_file(&path, &bytes).with_context(|| format!("cannot write {path:?}"))?;
        count += 1;
    }
    say(format_args!("wrote {count} pages into {}", options.folder.display()));
    Ok(())
}

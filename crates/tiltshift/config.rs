//! `--config FILE.toml`: options from a file, under the names that they have on the command line, which comes first.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use clap::{Arg, Command};
use toml::{Table, Value};

/// The command line with the options of its --config file at the end, but for those that it gives itself or that exclude one it
/// gives.
pub(crate) fn with_config(command: &Command, mut line: Vec<OsString>) -> anyhow::Result<Vec<OsString>> {
    let end = line.iter().position(|word| word == "--").unwrap_or(line.len());
    let Some(path) = config_file(&line[1..end])? else { return Ok(line) };
    let subcommands = || command.get_subcommands().map(Command::get_name);
    let named = line[1..end].iter().find_map(|word| command.find_subcommand(word.to_str()?));
    let Some(subcommand) = named else { return Ok(line) };
    let given = given(subcommand, &line[1..end]);

    // Read the file: keys for all commands, and a table for each that wants its own
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {path:?}"))?;
    let table: Table = text.parse().map_err(|error: toml::de::Error| anyhow!("{path:?} is no TOML: {error}"))?;
    let mut options = Vec::new();
    for (key, value) in table {
        match value {
            Value::Table(_) if !subcommands().any(|name| name == key) => {
                bail!(
                    "{path:?} has a table [{key}]; tables are named as commands: {}",
                    subcommands().collect::<Vec<_>>().join(", ")
                )
            }
            Value::Table(own) if key == subcommand.get_name() => options.extend(own),
            Value::Table(_) => {}
            value => options.push((key, value)),
        }
    }

    // Put what the line leaves open at its end
    let mut words = Vec::new();
    for (key, value) in options {
        let arg = option(subcommand, &key, &path)?;
        if !given.iter().any(|other| other.get_id() == arg.get_id() || exclude(subcommand, arg, other)) {
            words.extend(words_of(arg, &key, value, &path)?);
        }
    }
    line.splice(end..end, words);
    Ok(line)
}

/// The file that the line names.
fn config_file(words: &[OsString]) -> anyhow::Result<Option<PathBuf>> {
    for (i, word) in words.iter().enumerate() {
        if word == "--config" {
            let file = words.get(i + 1).ok_or_else(|| anyhow!("--config needs a file"))?;
            return Ok(Some(file.into()));
        }
        if let Some(file) = word.to_str().and_then(|word| word.strip_prefix("--config=")) {
            return Ok(Some(file.into()));
        }
    }
    Ok(None)
}

/// The options that the line gives.
fn given<'a>(subcommand: &'a Command, words: &[OsString]) -> Vec<&'a Arg> {
    let names = words.iter().filter_map(|word| word.to_str());
    let is_named = |word: &str, arg: &Arg| match word.strip_prefix("--") {
        Some(long) => names_option(arg, long.split('=').next().unwrap_or(long)),
        None => word.strip_prefix('-').and_then(|rest| rest.chars().next()) == arg.get_short(),
    };
    let dashed: Vec<&str> = names.filter(|word| word.starts_with('-')).collect();
    subcommand
        .get_arguments()
        .filter(|arg| dashed.iter().any(|word| arg.get_long().is_some() && is_named(word, arg)))
        .collect()
}

/// Whether an option goes by that name.
fn names_option(arg: &Arg, name: &str) -> bool {
    arg.get_long() == Some(name) || arg.get_all_aliases().is_some_and(|aliases| aliases.contains(&name))
}

/// The option of a key; an error names the nearest where there is none.
fn option<'a>(subcommand: &'a Command, key: &str, path: &Path) -> anyhow::Result<&'a Arg> {
    const NOT_FOR_FILES: [&str; 3] = ["config", "help", "version"];
    let key_as_option = key.replace('_', "-");
    let found = subcommand.get_arguments().find(|arg| names_option(arg, &key_as_option));
    found.filter(|_| !NOT_FOR_FILES.contains(&key)).ok_or_else(|| {
        let name = subcommand.get_name();
        anyhow!("{path:?} has a key {key:?}, which is no option of `tiltshift {name}`; see `tiltshift {name} --help`")
    })
}

/// Whether two options cannot stand together.
fn exclude(subcommand: &Command, a: &Arg, b: &Arg) -> bool {
    let names =
        |a: &Arg, b: &Arg| subcommand.get_arg_conflicts_with(a).iter().any(|other| other.get_id() == b.get_id());
    let share = subcommand.get_groups().any(|group| {
        let has = |arg: &Arg| group.get_args().any(|id| id == arg.get_id());
        group.get_id() == "focus" && has(a) && has(b)
    });
    names(a, b) || names(b, a) || share
}

/// An option as it is typed.
fn words_of(arg: &Arg, key: &str, value: Value, path: &Path) -> anyhow::Result<Vec<OsString>> {
    let long = arg.get_long().unwrap_or(key);
    let takes_value = arg.get_action().takes_values();
    let text = |value: Value| match value {
        Value::String(text) => Ok(text),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => {
            bail!("{key} in {path:?} is no number, text or list of them")
        }
    };
    match value {
        Value::Boolean(is_set) if !takes_value => {
            Ok(if is_set { vec![format!("--{long}").into()] } else { Vec::new() })
        }
        _ if !takes_value => bail!("{key} in {path:?} is a switch; give it true or false"),
        Value::Array(values) => {
            let several = arg.get_num_args().is_some_and(|count| count.max_values() > 1);
            // A list of two numbers may be what is typed with a comma between
            if !several && !matches!(arg.get_action(), clap::ArgAction::Append) {
                let parts: Vec<String> = values.into_iter().map(text).collect::<anyhow::Result<_>>()?;
                return Ok(vec![format!("--{long}={}", parts.join(",")).into()]);
            }
            let mut words: Vec<OsString> = Vec::new();
            for (i, value) in values.into_iter().enumerate() {
                let value = match value {
                    Value::Array(parts) => parts.into_iter().map(text).collect::<anyhow::Result<Vec<_>>>()?.join(","),
                    value => text(value)?,
                };
                if several {
                    words.extend((i == 0).then(|| format!("--{long}").into()));
                    words.push(value.into());
                } else {
                    words.push(format!("--{long}={value}").into());
                }
            }
            Ok(words)
        }
        value => Ok(vec![format!("--{long}={}", text(value)?).into()]),
    }
}

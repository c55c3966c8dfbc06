//! Turns the errors of `clap` about a command line into one line.

use std::io::{self, Write};

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use input::suggest;

use super::{Command, Trouble, complain};

/// Prints help and version, which were asked for, or else complains; returns the exit status.
pub(super) fn told(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let printed = error.print().and_then(|()| io::stdout().flush());
            printed.map_or_else(|error| Trouble::Output(error).told(), |()| 0)
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            2
        }
        _ => {
            complain(in_one_line(error));
            2
        }
    }
}

fn in_one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.is_empty())
        .filter(|line| !line.starts_with("For more information") && !line.starts_with("tip:"))
        .collect();
    let mut what = lines.join(" ").trim_start_matches("error: ").to_owned();
    for (ours, plain) in PLAIN {
        what = what.replace(ours, plain);
    }
    let verb = verb();
    what = what.replace("unrecognized subcommand", &format!("there is no {}", kind(&verb)));
    let meant = match meant(error) {
        Some(name) => format!("did you mean {name}? if not, "),
        None => meant_verb(error, &verb),
    };
    let path: Vec<_> = verb.iter().map(clap::Command::get_name).collect();
    format!("{what}; {meant}see {} --help", path.join(" "))
}

/// Words of the libraries, and plainer ones.
const PLAIN: [(&str, &str); 7] = [
    ("invalid digit found in string", "not a whole number of 0 or more"),
    ("number too large to fit in target type", "too large a number"),
    ("number would be too large to fit in target type", "too large a number"),
    ("invalid float literal", "not a number"),
    ("invalid IPv4 address syntax", "not an IPv4 address such as 127.0.0.1"),
    (" is not in ", " is out of range, which is "),
    ("..=", " to "),
];

/// The word for the sub-commands of the last of these verbs: they are verbs, too, unless it names them
/// otherwise.
fn kind(verb: &[clap::Command]) -> String {
    let name = verb.last().and_then(clap::Command::get_subcommand_value_name);
    name.map_or_else(|| "verb".to_owned(), str::to_lowercase)
}

/// The name that was probably meant.
fn meant(error: &clap::Error) -> Option<String> {
    let suggested =
        [ContextKind::SuggestedSubcommand, ContextKind::SuggestedArg, ContextKind::SuggestedValue];
    match suggested.into_iter().find_map(|kind| error.get(kind))? {
        ContextValue::String(name) => Some(name.clone()),
        ContextValue::Strings(names) => names.last().cloned(),
        _ => None,
    }
}

/// The verb that was probably meant, by how many letters differ.
fn meant_verb(error: &clap::Error, verb: &[clap::Command]) -> String {
    match (error.get(ContextKind::InvalidSubcommand), verb.last()) {
        (Some(ContextValue::String(wrong)), Some(command)) => {
            suggest::question(wrong, command.get_subcommands().map(clap::Command::get_name))
        }
        _ => String::new(),
    }
}

/// The command and the verbs that the command line begins with, such as `uchain keys show`.
fn verb() -> Vec<clap::Command> {
    let mut path = vec![Command::command()];
    for word in std::env::args().skip(1) {
        let Some(verb) = path.last().and_then(|command| command.find_subcommand(&word)) else {
            break;
        };
        path.push(verb.clone());
    }
    path
}

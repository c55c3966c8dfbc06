//! `uchain bench NAME --record FILE.md`, and `uchain replay --flight --record FILE.md`: a table as a
//! file that says what made it.
//!
//! The file has no date and nothing of the machine in it, so the same command of the same build writes
//! the same bytes again, apart from figures that measure time.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use input::InputError;

/// The option of a command whose table is kept.
#[derive(Args, Default)]
pub(super) struct RecordArgs {
    /// Also write the table into this file, with the command, the seeds and the revision that made it;
    /// replaces a file of the same command, so other options take another name
    #[arg(long, value_name = "FILE.md")]
    record: Option<PathBuf>,
}

impl RecordArgs {
    /// Whether a file was asked for.
    pub(super) const fn is_given(&self) -> bool {
        self.record.is_some()
    }

    /// The file that was asked for, made sure of before anything is flown for it.
    pub(super) fn open(&self, source: Source) -> Result<Option<Record>, InputError> {
        self.record.clone().map(|path| Record::open(path, source)).transpose()
    }
}

/// What makes a table.
pub(super) struct Source {
    /// The command, without the program's name: `bench link`.
    pub(super) command: String,
    /// The first part of the name of a file that has the table.
    pub(super) file: &'static str,
    /// What it does, in one sentence without its full stop.
    pub(super) about: &'static str,
    /// The page of the book that explains it.
    pub(super) page: &'static str,
}

/// A table that has been made.
pub(super) struct Made<'a> {
    /// The seeds that were flown with, in words; `None` where the command has none.
    pub(super) seeds: Option<&'a str>,
    pub(super) table: &'a str,
    /// The bounds that were missed.
    pub(super) missed: &'a [String],
}

/// The file of a command, which can be written.
pub(super) struct Record {
    path: PathBuf,
    source: Source,
}

impl Record {
    fn open(path: PathBuf, source: Source) -> Result<Self, InputError> {
        let record = Self { path, source };
        if record.path.extension().is_none_or(|extension| extension != "md") {
            let remedy = format!("give a name such as {}.md", record.source.file);
            return Err(record.wrong("--record takes a file whose name ends in .md", remedy));
        }
        if record.path.exists() && !record.is_of_its_command() {
            let wrong = format!("uchain {} did not write what is there", record.source.command);
            return Err(record.wrong(wrong, "give --record another name, or move it away"));
        }
        let draft = record.draft();
        File::create_new(&draft)
            .and_then(|_| fs::remove_file(&draft))
            .map_err(|error| record.unwritable(&error))?;
        Ok(record)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file in one step.
    pub(super) fn write(&self, line: &[OsString], made: &Made<'_>) -> Result<(), InputError> {
        let draft = self.draft();
        let text = self.text(line, made);
        let written = File::create(&draft)
            .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
            .and_then(|()| fs::rename(&draft, &self.path));
        written.map_err(|error| {
            let _ = fs::remove_file(&draft);
            self.unwritable(&error)
        })
    }

    /// The line by which such a file is known.
    fn mark(&self) -> String {
        let command = &self.source.command;
        format!("<!-- Written by uchain {command} --record, which replaces the whole file. -->\n")
    }

    fn is_of_its_command(&self) -> bool {
        input::file::read_text(&self.path, input::file::LARGEST_TEXT)
            .is_ok_and(|text| text.starts_with(&self.mark()))
    }

    /// The file beside it that takes its place when it is whole; two commands have two.
    fn draft(&self) -> PathBuf {
        self.path.with_extension(format!("md.{}", std::process::id()))
    }

    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> InputError {
        InputError::new(wrong, remedy).in_file(&self.path)
    }

    fn unwritable(&self, error: &io::Error) -> InputError {
        let wrong = format!("cannot be written: {error}");
        self.wrong(wrong, "give --record a file in a directory that is there and can be written to")
    }

    fn text(&self, line: &[OsString], made: &Made<'_>) -> String {
        let Source { command, about, page, .. } = &self.source;
        let arguments: String =
            line.iter().skip(1).map(|word| " ".to_owned() + &quoted(word)).collect();
        let revision = report::REVISION.unwrap_or("unknown, because this is a debug build");
        let seeds = made.seeds.map(|seeds| format!("- seeds: {seeds}\n")).unwrap_or_default();
        let mut text = format!(
            "{}# Results of `{command}`\n\n{about}. The book explains it in `docs/src/{page}`.\n\n\
             ```\nuchain{arguments}\n```\n\n{seeds}- version: {}\n- revision: {revision}\n\n\
             ```text\n{}```\n",
            self.mark(),
            env!("CARGO_PKG_VERSION"),
            made.table,
        );
        if !made.missed.is_empty() {
            text += "\nBounds that were missed:\n\n";
            text.extend(made.missed.iter().map(|missed| format!("- {missed}\n")));
        }
        text
    }
}

/// A word of a command line, quoted for a shell.
fn quoted(word: &OsString) -> String {
    let text = word.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,=:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.into_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_with_a_space_or_a_quote_is_one_word_of_the_shell() {
        for (word, told) in
            [("--seed=3", "--seed=3"), ("", "''"), ("a b", "'a b'"), ("it's", r"'it'\''s'")]
        {
            assert_eq!(quoted(&word.into()), told);
        }
    }
}

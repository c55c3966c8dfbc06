//! `uchain bench NAME --record FILE.md`: the table of a benchmark as a file that says what made it.
//!
//! The file has no date and nothing of the machine in it, so the same command of the same build writes
//! the same bytes again, apart from figures that measure time.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use input::InputError;

use benchmarks::{Entry, Outcome};

/// The option of a benchmark whose table is kept.
#[derive(Args, Default)]
pub(super) struct RecordArgs {
    /// Also write the table into this file, with the command, the seeds and the revision that made it;
    /// replaces a file of the same benchmark, so other options take another name
    #[arg(long, value_name = "FILE.md")]
    record: Option<PathBuf>,
}

impl RecordArgs {
    /// The file that was asked for, made sure of before anything is flown for it.
    pub(super) fn open(&self, entry: &'static Entry) -> Result<Option<Record>, InputError> {
        self.record.clone().map(|path| Record::open(path, entry)).transpose()
    }
}

/// The file of a benchmark, which can be written.
pub(super) struct Record {
    path: PathBuf,
    entry: &'static Entry,
}

impl Record {
    fn open(path: PathBuf, entry: &'static Entry) -> Result<Self, InputError> {
        let record = Self { path, entry };
        if record.path.extension().is_none_or(|extension| extension != "md") {
            let remedy = format!("give a name such as {}.md", entry.name);
            return Err(record.wrong("--record takes a file whose name ends in .md", remedy));
        }
        if record.path.exists() && !record.is_of_its_benchmark() {
            let wrong = format!("uchain bench {} did not write what is there", entry.name);
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
    pub(super) fn write(&self, line: &[OsString], outcome: &Outcome) -> Result<(), InputError> {
        let draft = self.draft();
        let text = self.text(line, outcome);
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
        let name = self.entry.name;
        format!(
            "<!-- Written by uchain bench {name} --record, which replaces the whole file. -->\n"
        )
    }

    fn is_of_its_benchmark(&self) -> bool {
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

    fn text(&self, line: &[OsString], outcome: &Outcome) -> String {
        let Entry { name, about, page, .. } = self.entry;
        let arguments: String =
            line.iter().skip(1).map(|word| " ".to_owned() + &quoted(word)).collect();
        let revision = report::REVISION.unwrap_or("unknown, because this is a debug build");
        let mut text = format!(
            "{}# Results of `bench {name}`\n\n{about}. The book explains it in `docs/src/{page}`.\n\n\
             ```\nuchain{arguments}\n```\n\n- seeds: {}\n- version: {}\n- revision: {revision}\n\n\
             ```text\n{}```\n",
            self.mark(),
            outcome.seeds,
            env!("CARGO_PKG_VERSION"),
            outcome.table,
        );
        if !outcome.missed.is_empty() {
            text += "\nBounds that were missed:\n\n";
            text.extend(outcome.missed.iter().map(|missed| format!("- {missed}\n")));
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

//! Reads the centrelines of Therion's data files, `.th`, and of its configuration files.
//!
//! The grammar is that of the Therion Book, chapters "Data format" and "centreline", and where the
//! book is silent, what Therion 6.1.6 does. Drawings (scraps, maps, surfaces, layouts) are passed
//! over. Names of stations have the surveys around them before them, the outermost first, as in
//! Therion's export for Survex: station `1@inner.outer` is `outer.inner.1`.

mod bearings;
mod blocks;
mod centreline;
mod data;
mod fixes;
mod legs;
mod names;
mod options;
mod order;
mod words;

use std::borrow::Cow;

use crate::draft::Draft;
use crate::error::Refusal;
use crate::files::{self, Files, Opened};
use crate::survex::{MOST_BYTES, MOST_FILES, unopened};
use crate::survey::Source;
use bearings::Bearing;
use blocks::Block;
use centreline::Centreline;
use fixes::Output;
use names::Names;

/// The deepest that files include each other.
const DEEPEST: usize = 32;

/// What is read of a set of files so far.
pub(crate) struct Reader<'a> {
    files: &'a dyn Files,
    draft: Draft,
    source: Source,
    /// The paths of the files that are being read, each included by the one before.
    open: Vec<String>,
    bytes: usize,
    included: usize,
    names: Names,
    /// The blocks that are open: surveys, centrelines and groups.
    blocks: Vec<Block>,
    /// The settings of the centreline that is open.
    centreline: Option<Centreline>,
    /// The word that ends what is passed over, and where it began.
    skipped: Option<(String, Source)>,
    /// How the bearings of each leg are turned, known when all is read.
    bearings: Vec<Bearing>,
    /// The system of the positions, where stations are fixed on the earth.
    output: Option<Output>,
    /// The first station that is fixed without a system.
    local: Option<Source>,
}

/// Reads the file `entry` of `files` and all that it includes.
pub(crate) fn read(files: &dyn Files, entry: &str, opened: &Opened) -> Result<Draft, Refusal> {
    let mut reader = Reader {
        files,
        draft: Draft::default(),
        source: Source::default(),
        open: Vec::new(),
        bytes: 0,
        included: 0,
        names: Names::default(),
        blocks: Vec::new(),
        centreline: None,
        skipped: None,
        bearings: Vec::new(),
        output: None,
        local: None,
    };
    let told = |refusal: Refusal| Refusal { wrong: names::shown(&refusal.wrong), ..refusal };
    reader.file(entry, opened).and_then(|()| reader.finish()).map_err(told)?;
    Ok(reader.draft)
}

impl Reader<'_> {
    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        self.draft.wrong(self.source, wrong, remedy)
    }

    fn remark(&mut self, text: impl Into<String>) {
        self.draft.warn(self.source, 0, text);
    }

    fn file(&mut self, path: &str, opened: &Opened) -> Result<(), Refusal> {
        let outer = self.source;
        self.bytes = self.bytes.saturating_add(opened.bytes.len());
        self.included += 1;
        if self.bytes > MOST_BYTES || self.included > MOST_FILES {
            let most = MOST_BYTES >> 20;
            let wrong = format!("the survey has more than {most} MB or {MOST_FILES} files");
            return Err(self.wrong(wrong, "give a part of it"));
        }
        self.source = Source { file: self.draft.file(&opened.path), line: 0 };
        self.open.push(path.to_owned());
        let text = files::text(&opened.bytes);
        let mut lines = words::lines(&text);
        while let Some((number, line)) = lines.next() {
            self.source.line = number;
            self.draft.require_line(&line, self.source)?;
            self.line(&line, || lines.clone())?;
        }
        self.draft.end_repeats();
        self.open.pop();
        self.source = outer;
        Ok(())
    }

    /// Reads a line; `rest` gives those that follow it in its file.
    fn line<'t, I: Iterator<Item = (u32, Cow<'t, str>)>>(
        &mut self,
        line: &str,
        rest: impl Fn() -> I,
    ) -> Result<(), Refusal> {
        let words = words::split(line);
        let Some((key, arguments)) = words.split_first() else { return Ok(()) };
        if let Some((end, _)) = &self.skipped {
            if key == end {
                self.skipped = None;
            }
            return Ok(());
        }
        match key.as_str() {
            "encoding" | "require" => Ok(()),
            "input" => self.input(arguments),
            key if self.centreline.is_some() => self.in_centreline(key, arguments, &words),
            key => self.in_survey(key, arguments, rest),
        }
    }

    /// Reads another file in the place of the line.
    fn input(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let [name] = arguments else {
            return Err(self.wrong("input names no single file", "give one file to a line"));
        };
        // Such a file has drawings and no centreline.
        if name.to_ascii_lowercase().ends_with(".th2") {
            return Ok(());
        }
        let from = self.open.last().cloned().unwrap_or_default();
        let found = files::open_named(self.files, &from, name, &[".th"]);
        let (path, opened) = match found {
            Ok(found) => found,
            // Where the file lacks its ending, it may be one of drawings.
            Err(_) if files::open_named(self.files, &from, name, &[".th2"]).is_ok() => {
                return Ok(());
            }
            Err(error) => {
                let (wrong, remedy) = unopened(name, &error);
                return Err(self.wrong(wrong, remedy));
            }
        };
        if self.open.contains(&path) {
            let wrong = format!("\"{name}\" includes itself");
            return Err(self.wrong(wrong, "remove this input"));
        }
        if self.open.len() >= DEEPEST {
            let wrong = format!("files include each other {DEEPEST} deep");
            return Err(self.wrong(wrong, "include them from fewer levels"));
        }
        self.file(&path, &opened)
    }

    /// Finishes what had to wait until all was read.
    fn finish(&mut self) -> Result<(), Refusal> {
        if let Some((end, source)) = self.skipped.take() {
            let wrong = format!("this block has no {end}");
            return Err(self.draft.wrong(source, wrong, "add it"));
        }
        if let Some(block) = self.blocks.last() {
            let wrong = format!("this {} has no end", block.kind.word());
            let remedy = format!("add end{}", block.kind.word());
            return Err(self.draft.wrong(block.source, wrong, remedy));
        }
        self.check_references()?;
        self.turn_bearings();
        self.separate_levels();
        Ok(())
    }
}

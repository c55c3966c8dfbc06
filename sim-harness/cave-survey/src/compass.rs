//! Reads the files of Compass: surveys, `.dat`, the same with closed loops, `.clp`, and projects,
//! `.mak`, that list them.
//!
//! The format is that of Compass's own help pages, "Survey data file format" and "Project file
//! format", and what `cavern` 1.4.22 makes of it where they leave a choice. Numbers are in feet and
//! degrees whatever the header says of the notes.

mod datums;
mod header;
mod project;
mod shots;

use crate::draft::Draft;
use crate::earth::Base;
use crate::error::Refusal;
use crate::files::{self, Opened};
use crate::survex::characters::{Characters, Cursor};
use crate::survey::{Source, StationId};
use header::Header;
pub(crate) use project::project;

/// The character that separates the surveys of a file.
const FORM_FEED: u8 = 0x0c;

/// Reads one survey file.
pub(crate) fn survey(opened: &Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    read_into(&mut draft, opened, &mut None)?;
    Ok(draft)
}

/// The part of a file that a line belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Before the line of the declination.
    Head,
    /// Before the names of the columns.
    Columns,
    Lines,
}

/// What is read of a survey file so far.
struct Reader<'a> {
    draft: &'a mut Draft,
    characters: Characters,
    header: Header,
    part: Part,
    source: Source,
    /// The station at which the last shot with dimensions ended.
    last: Option<StationId>,
    /// The angle from the compass's north to that of the grid, rad, of the shots of this survey.
    declination: Option<f64>,
}

/// Reads a survey file. Where a project gives a base, the declinations are those of the base and of
/// the days of the surveys.
fn read_into(draft: &mut Draft, opened: &Opened, base: &mut Option<Base>) -> Result<(), Refusal> {
    let source = Source { file: draft.file(&opened.path), line: 0 };
    let has_corrections = !opened.path.to_ascii_lowercase().ends_with(".clp");
    let mut reader = Reader {
        draft,
        characters: Characters::compass(),
        header: Header::default(),
        part: Part::Head,
        source,
        last: None,
        declination: None,
    };
    let mut any = false;
    let text = files::text(&opened.bytes);
    for line in files::lines(&text) {
        reader.source.line = reader.source.line.saturating_add(1);
        reader.draft.require_line(line, reader.source)?;
        // What stands before a form feed in its line belongs to the survey that it ends.
        for (piece, line) in line.split(char::from(FORM_FEED)).enumerate() {
            if piece > 0 {
                reader.begin_survey();
            }
            if !line.trim().is_empty() {
                reader.line(line, base, has_corrections)?;
            }
        }
        any |= reader.part == Part::Lines;
    }
    reader.draft.end_repeats();
    if any {
        return Ok(());
    }
    let wrong = "there is no survey in it, with DECLINATION: and FROM TO LENGTH …";
    Err(draft.wrong(source, wrong, "give a survey file of Compass"))
}

impl Reader<'_> {
    fn begin_survey(&mut self) {
        self.part = Part::Head;
        self.header = Header::default();
        self.last = None;
        self.draft.end_repeats();
    }

    fn line(
        &mut self,
        line: &str,
        base: &mut Option<Base>,
        has_corrections: bool,
    ) -> Result<(), Refusal> {
        let text = line.trim();
        match self.part {
            Part::Head if text.starts_with("DECLINATION:") => {
                self.header.read(text, has_corrections).map_err(|word| {
                    let wrong = format!("\"{word}\" is no number in the head of the survey");
                    self.draft.wrong(self.source, wrong, "give degrees, and feet for the tape")
                })?;
                self.declination = None;
                self.part = Part::Columns;
            }
            Part::Head => {
                if let Some(date) = text.strip_prefix("SURVEY DATE:") {
                    self.header.date = header::date(date);
                }
            }
            Part::Columns => {
                let first = text.split_whitespace().next().unwrap_or_default();
                if !first.eq_ignore_ascii_case("FROM") {
                    let wrong = "the names of the columns are missing";
                    let remedy = "add the line FROM TO LENGTH BEARING …";
                    return Err(self.draft.wrong(self.source, wrong, remedy));
                }
                self.part = Part::Lines;
            }
            Part::Lines => {
                let declination = match self.declination {
                    Some(known) => known,
                    None => self.find_declination(base),
                };
                self.shot(Cursor::new(line.as_bytes()), declination)?;
            }
        }
        Ok(())
    }

    /// The declination of the present survey, rad.
    fn find_declination(&mut self, base: &mut Option<Base>) -> f64 {
        let angle = match base {
            None => self.header.declination,
            Some(base) => {
                if self.header.date.is_none() {
                    let text = "the survey has no date, so that its declination is taken for 0";
                    self.draft.warn(self.source, 0, text);
                }
                base.declination(self.header.date)
            }
        };
        self.declination = Some(angle);
        angle
    }
}

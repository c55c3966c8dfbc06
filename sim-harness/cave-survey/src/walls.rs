//! Reads the files of Walls: surveys, `.srv`, and projects, `.wpj`, that list them.
//!
//! The format is that of the help of Walls, by David McKenzie, where it says anything, and else what
//! `cavern` 1.4.24 makes of such files; its manual, chapter "David McKenzie's Walls", lists what it
//! found out. Directives and options that move no station are passed over, with a remark where they
//! might be expected to.

mod directives;
mod fields;
mod legs;
mod numbers;
mod project;
mod units;
mod variances;

use std::collections::{HashMap, HashSet};

use crate::draft::Draft;
use crate::earth::{self, Day, System};
use crate::error::Refusal;
use crate::files::{self, Opened};
use crate::survey::{LegFlags, Source, StationId};
pub(crate) use project::project;
use units::Units;

/// The most often that options are saved at once; Walls itself has room for 10.
const MOST_SAVED: usize = 100;
/// The longest line that macros may make, in bytes.
const LONGEST_LINE: usize = 10_000;

/// Reads one survey file.
pub(crate) fn survey(opened: &Opened) -> Result<Draft, Refusal> {
    let mut reader = Reader::default();
    reader.file(opened)?;
    Ok(reader.finished())
}

/// The place on the earth of a project.
#[derive(Clone, Debug)]
struct Earth {
    /// The system of the coordinates.
    system: System,
    /// Longitude and latitude, degrees.
    place: [f64; 2],
    /// The height above the sea, m.
    up: f64,
    /// The angle from true north to the grid's, rad.
    convergence: f64,
}

/// What is read of a set of files so far.
#[derive(Default)]
struct Reader {
    draft: Draft,
    units: Units,
    /// The options that `#Units save` put aside.
    saved: Vec<Units>,
    macros: HashMap<String, String>,
    source: Source,
    /// The flags of the segment.
    segment: LegFlags,
    date: Option<Day>,
    earth: Option<Earth>,
    /// The magnetic declination of a day, rad.
    last_declination: Option<(Day, f64)>,
    warned_of_date: bool,
    /// The station at which the last leg with dimensions ended.
    last: Option<StationId>,
    /// Stations between which legs of no length lead.
    joined: Vec<(StationId, StationId, Source)>,
    /// The stations that are fixed exactly.
    fixed: HashSet<StationId>,
    /// The names that flags call entrances.
    entrances: Vec<String>,
}

impl Reader {
    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        self.draft.wrong(self.source, wrong, remedy)
    }

    fn remark(&mut self, text: impl Into<String>) {
        self.draft.warn(self.source, 0, text);
    }

    /// Reads a survey file with the options that are set. What it sets itself ends with it.
    fn file(&mut self, opened: &Opened) -> Result<(), Refusal> {
        let outer = (self.units.clone(), self.macros.clone(), self.source);
        self.source = Source { file: self.draft.file(&opened.path), line: 0 };
        let bytes = opened.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&opened.bytes);
        let text = files::text(bytes);
        let mut commented = 0u32;
        for line in files::lines(&text) {
            self.source.line = self.source.line.saturating_add(1);
            self.draft.require_line(line, self.source)?;
            let text = line.trim();
            if let Some(directive) = text.strip_prefix("#[") {
                commented = commented.saturating_add(1 - u32::from(directive.contains("#]")));
            } else if text.starts_with("#]") {
                commented = commented.checked_sub(1).ok_or_else(|| {
                    self.wrong("this #] closes no #[", "remove it, or add the #[")
                })?;
            } else if commented > 0 || text.is_empty() || text.starts_with(';') {
            } else if let Some(directive) = text.strip_prefix('#') {
                self.directive(directive)?;
            } else {
                self.data(text)?;
            }
        }
        if commented > 0 {
            return Err(self.wrong("a #[ is not closed", "add the #]"));
        }
        self.draft.end_repeats();
        (self.units, self.macros, self.source) = outer;
        self.saved.clear();
        (self.segment, self.date, self.last) = (LegFlags::default(), None, None);
        Ok(())
    }

    /// The angle from the north of the compass to that of the grid for the present line, rad.
    fn declination(&mut self) -> f64 {
        let Some(earth) = &self.earth else { return self.units.declination.unwrap_or(0.0) };
        let (place, up, convergence) = (earth.place, earth.up, earth.convergence);
        if let Some(given) = self.units.declination {
            return given - convergence;
        }
        let Some(day) = self.date else {
            if !std::mem::replace(&mut self.warned_of_date, true) {
                self.remark("the survey has no date, so that its declination is taken for 0");
            }
            return -convergence;
        };
        if let Some((known, angle)) = self.last_declination
            && known == day
        {
            return angle - convergence;
        }
        let magnetic = earth::magnetic_declination(place, up, day).unwrap_or(0.0);
        self.last_declination = Some((day, magnetic));
        magnetic - convergence
    }

    /// The draft of all that was read.
    fn finished(mut self) -> Draft {
        let fixed: HashSet<StationId> = self.draft.fixes.iter().map(|fix| fix.station).collect();
        for (from, to, source) in std::mem::take(&mut self.joined) {
            // Between two fixed stations such a leg says no more than that they belong together.
            if fixed.contains(&from) && fixed.contains(&to) {
                self.draft.sight(from, to, LegFlags::default(), source);
            } else if from != to {
                self.draft.equate(to, from, source);
            }
        }
        for name in &self.entrances {
            if let Some(station) = self.draft.known(name) {
                self.draft.stations[station].is_entrance = true;
            }
        }
        self.draft
    }
}

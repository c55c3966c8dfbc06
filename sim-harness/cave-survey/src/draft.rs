//! Gathers what the readers find, before any station has a position.

use std::collections::HashMap;
use std::sync::Arc;

use crate::error::{Place, Refusal, Warning, printable};
use crate::files::{LARGEST_PROJECT, LONGEST_LINE};
use crate::matrix::{self, Matrix, Vector};
use crate::survey::{CrossSection, LegFlags, Source, StationId};

/// The most legs of a survey. The longest surveyed cave has some 100,000; a file with more than
/// this is no cave.
pub const MOST_LEGS: usize = 250_000;

/// The most of what is no leg: stations, equates, fixed stations, dimensions and names of surveys,
/// together. A survey of as many legs as are read has half of it.
pub(crate) const MOST_ITEMS: usize = 1_500_000;

/// The most warnings that are kept.
pub(crate) const MOST_WARNINGS: usize = 1000;

#[derive(Clone, Debug)]
pub(crate) struct DraftStation {
    pub(crate) name: Box<str>,
    pub(crate) source: Source,
    pub(crate) is_wall: bool,
    pub(crate) is_entrance: bool,
    /// Whether a leg, an equate or a line without measurements uses it.
    pub(crate) is_used: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct DraftLeg {
    pub(crate) from: StationId,
    pub(crate) to: StationId,
    pub(crate) vector: Vector,
    pub(crate) covariance: Matrix,
    pub(crate) length: f64,
    pub(crate) flags: LegFlags,
    pub(crate) source: Source,
    /// How many successive measurements of the same leg this one is the mean of.
    pub(crate) repeats: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct Fix {
    pub(crate) station: StationId,
    pub(crate) at: Vector,
    /// The covariance; `None` where the position is exact.
    pub(crate) covariance: Option<Matrix>,
    pub(crate) source: Source,
    /// Whether it may stay unused without a remark.
    pub(crate) is_reference: bool,
}

/// An unfinished survey.
#[derive(Clone, Debug, Default)]
pub(crate) struct Draft {
    pub(crate) title: Option<String>,
    pub(crate) stations: Vec<DraftStation>,
    pub(crate) legs: Vec<DraftLeg>,
    pub(crate) equates: Vec<(StationId, StationId, Source)>,
    /// Pairs of stations that see each other.
    pub(crate) unmeasured: Vec<(StationId, StationId, LegFlags, Source)>,
    pub(crate) fixes: Vec<Fix>,
    pub(crate) passages: Vec<Vec<(CrossSection, Source)>>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) files: Vec<Arc<str>>,
    /// The station that is the origin where none is fixed.
    pub(crate) first: Option<StationId>,
    /// Whether positions are in a coordinate system of the earth, so that no origin is invented.
    pub(crate) is_on_earth: bool,
    names: HashMap<Box<str>, StationId>,
    /// Whether the last leg may be averaged with the next one.
    repeatable: bool,
    /// How much there is of what is no leg.
    items: usize,
}

impl Draft {
    /// Adds a file's name.
    pub(crate) fn file(&mut self, path: &str) -> u32 {
        self.files.push(path.into());
        (self.files.len() - 1) as u32
    }

    /// The place of a source, for messages.
    pub(crate) fn place(&self, source: Source, column: u32) -> Option<Place> {
        let file = self.files.get(source.file as usize)?.clone();
        Some(Place { file, line: source.line, column })
    }

    pub(crate) fn warn(&mut self, source: Source, column: u32, text: impl Into<String>) {
        let kept = self.warnings.len();
        if kept < MOST_WARNINGS {
            let place = self.place(source, column);
            self.warnings.push(Warning { place, text: printable(text) });
        } else if kept == MOST_WARNINGS {
            let text = format!("more than {MOST_WARNINGS} remarks; the rest are left out");
            self.warnings.push(Warning { place: None, text });
        }
    }

    /// A refusal at a line.
    pub(crate) fn wrong(
        &self,
        source: Source,
        wrong: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Refusal {
        let refusal = Refusal::new(wrong, remedy);
        match self.place(source, 0) {
            Some(place) => refusal.at(place),
            None => refusal,
        }
    }

    /// The station of that name, which is new where there was none, and whether it is.
    pub(crate) fn station(&mut self, name: &str, source: Source) -> (StationId, bool) {
        if let Some(&known) = self.names.get(name) {
            return (known, false);
        }
        let id = self.anonymous(false, source);
        self.stations[id].name = name.into();
        self.names.insert(name.into(), id);
        (id, true)
    }

    /// The station of that name, if there is one.
    pub(crate) fn known(&self, name: &str) -> Option<StationId> {
        self.names.get(name).copied()
    }

    /// A station without a name.
    pub(crate) fn anonymous(&mut self, is_wall: bool, source: Source) -> StationId {
        let name = "".into();
        let station = DraftStation { name, source, is_wall, is_entrance: false, is_used: false };
        self.stations.push(station);
        self.items += 1;
        self.stations.len() - 1
    }

    /// Counts one thing that takes memory and is no leg.
    pub(crate) const fn count_item(&mut self) {
        self.items += 1;
    }

    /// Refuses a survey of more things than there is room for. Readers ask at each line.
    pub(crate) fn require_room(&self, source: Source) -> Result<(), Refusal> {
        if self.items <= MOST_ITEMS {
            return Ok(());
        }
        let wrong =
            format!("the survey has more than {MOST_ITEMS} stations, equates and dimensions");
        Err(self.wrong(source, wrong, "give a part of it"))
    }

    /// Refuses a line that is longer than any that a program writes.
    pub(crate) fn require_line(&self, line: &str, source: Source) -> Result<(), Refusal> {
        if line.len() <= LONGEST_LINE {
            return self.require_room(source);
        }
        let wrong = format!("the line has more than {LONGEST_LINE} bytes");
        Err(self.wrong(source, wrong, "end it earlier"))
    }

    /// Refuses a project that is larger than any list of files.
    pub(crate) fn require_project(&self, bytes: &[u8], source: Source) -> Result<(), Refusal> {
        if bytes.len() <= LARGEST_PROJECT {
            return Ok(());
        }
        let wrong = format!("the project has more than {} MB", LARGEST_PROJECT >> 20);
        Err(self.wrong(source, wrong, "give a part of it"))
    }

    fn uses(&mut self, first: StationId, second: StationId) {
        self.first.get_or_insert(first);
        self.stations[first].is_used = true;
        self.stations[second].is_used = true;
    }

    /// Adds a leg. One that measures again what the leg just before it did, in the same direction,
    /// is averaged with it, as `cavern` does with the repeated shots of laser instruments.
    pub(crate) fn leg(&mut self, leg: DraftLeg, to_is_first: bool) -> Result<(), Refusal> {
        if leg.from == leg.to {
            let name = &self.stations[leg.from].name;
            let wrong = format!("the leg begins and ends at the same station \"{name}\"");
            return Err(self.wrong(leg.source, wrong, "correct one of the names"));
        }
        if self.legs.len() >= MOST_LEGS {
            let wrong = format!("the survey has more than {MOST_LEGS} legs");
            return Err(self.wrong(leg.source, wrong, "give a part of it"));
        }
        let numbers = leg.vector.iter().chain(leg.covariance.iter().flatten());
        if numbers.chain([&leg.length]).any(|number| !number.is_finite() || number.abs() > 1e12) {
            let wrong = "the leg's readings are too large to compute with";
            return Err(self.wrong(leg.source, wrong, "correct them, or their units"));
        }
        let (first, second) = if to_is_first { (leg.to, leg.from) } else { (leg.from, leg.to) };
        self.uses(first, second);
        let same = |last: &&mut DraftLeg| last.from == leg.from && last.to == leg.to;
        if let Some(last) = self.legs.last_mut().filter(same).filter(|_| self.repeatable) {
            let n = f64::from(last.repeats);
            let mean = |old: f64, new: f64| (old * n + new) / (n + 1.0);
            for (old, new) in last.vector.iter_mut().zip(leg.vector) {
                *old = mean(*old, new);
            }
            let covariance = matrix::sum(&matrix::share(&last.covariance, n), &leg.covariance);
            last.covariance = matrix::share(&covariance, 1.0 / (n + 1.0));
            last.length = mean(last.length, leg.length);
            last.repeats += 1;
        } else {
            self.legs.push(leg);
        }
        self.repeatable = true;
        Ok(())
    }

    /// Ends the averaging of repeated legs, as the end of a file does.
    pub(crate) fn end_repeats(&mut self) {
        self.repeatable = false;
    }

    /// Notes that two names are of one station.
    pub(crate) fn equate(&mut self, a: StationId, b: StationId, source: Source) {
        self.repeatable = false;
        self.items += 1;
        self.uses(b, a);
        self.equates.push((a, b, source));
    }

    /// Notes that a station is fixed.
    pub(crate) fn fix(&mut self, fix: Fix) {
        self.items += 1;
        self.fixes.push(fix);
    }

    /// Adds a cross-section: to the last passage where that `goes_on`, or else as a new one.
    pub(crate) fn cross_section(&mut self, section: CrossSection, source: Source, goes_on: bool) {
        self.items += 1;
        match self.passages.last_mut().filter(|_| goes_on) {
            Some(passage) => passage.push((section, source)),
            None => self.passages.push(vec![(section, source)]),
        }
    }

    /// Notes that two stations see each other.
    pub(crate) fn sight(&mut self, a: StationId, b: StationId, flags: LegFlags, source: Source) {
        for station in [a, b] {
            self.stations[station].is_used = true;
        }
        self.items += 1;
        self.unmeasured.push((a, b, flags, source));
    }
}

//! Reads all variables of a log of the µSD card deck, as series over time.

use std::path::Path;

use input::InputError;

use crate::formats::read_bytes;
use crate::formats::usd::CUT;
use crate::formats::usd::container::{Container, Event};

/// A longer time between two events, in µs, is a damaged clock: ten minutes, more than a battery
/// lasts.
const LONGEST_GAP_US: u64 = 600_000_000;

/// The variables of one event type, which have their times in common.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// The time of each event since the first one of the log, s; each is later than the one before.
    pub times: Vec<f64>,
    /// The variables as `group.name`, each with one value for each event.
    pub variables: Vec<(String, Vec<f64>)>,
}

/// All variables of a log.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    /// The event types, in the log's order.
    pub types: Vec<Rows>,
    /// What was wrong with the log, where it could be read none the less.
    pub note: Option<String>,
}

impl Variables {
    /// Reads a log. One that was cut short is read as far as it goes. Events out of their order are
    /// passed over.
    ///
    /// # Errors
    /// [`InputError`] where the file cannot be read, is no such log, or holds no event.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        Self::parse(&read_bytes(file)?, file)
    }

    /// Reads a log from its bytes; `file` is named in errors.
    ///
    /// # Errors
    /// As for [`read`](Self::read).
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Self, InputError> {
        let mut log = Container::open(bytes, file)?;
        let mut collector = Collector::of(&log);
        while let Some(event) = log.next() {
            let Ok(event) = event else {
                collector.broken = true;
                break;
            };
            if !collector.take(event) {
                break;
            }
        }
        let cut = !log.is_whole || collector.broken;
        collector.finish(cut).ok_or_else(|| {
            InputError::new("no event follows the header", "give a log that was written in flight")
                .in_file(file)
        })
    }

    /// The times and the values of a variable; `None` where the log does not have it.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<(&[f64], &[f64])> {
        self.types.iter().find_map(|rows| {
            let (_, values) = rows.variables.iter().find(|(known, _)| known == name)?;
            (!values.is_empty()).then_some((rows.times.as_slice(), values.as_slice()))
        })
    }
}

/// The variables while they are being read.
struct Collector {
    types: Vec<Rows>,
    first: Option<u64>,
    last: u64,
    broken: bool,
    passed_over: usize,
}

impl Collector {
    fn of(log: &Container<'_>) -> Self {
        let rows = |names: &[String]| Rows {
            times: Vec::new(),
            variables: names.iter().map(|name| (name.clone(), Vec::new())).collect(),
        };
        let types = log.types.iter().map(|kind| rows(&kind.names)).collect();
        Self { types, first: None, last: 0, broken: false, passed_over: 0 }
    }

    /// Takes an event; false where its time says that nothing behind it can be trusted.
    fn take(&mut self, event: Event) -> bool {
        let first = *self.first.get_or_insert(event.micros);
        if event.micros > self.last.max(first).saturating_add(LONGEST_GAP_US) {
            self.broken = true;
            return false;
        }
        let time = event.micros.saturating_sub(first) as f64 * 1e-6;
        let Some(rows) = self.types.get_mut(event.kind) else { return true };
        if event.micros < first || rows.times.last().is_some_and(|last| time <= *last) {
            self.passed_over += 1;
            return true;
        }
        self.last = self.last.max(event.micros);
        rows.times.push(time);
        for ((_, values), value) in rows.variables.iter_mut().zip(event.values) {
            values.push(value);
        }
        true
    }

    fn finish(self, cut: bool) -> Option<Variables> {
        self.types.iter().any(|rows| !rows.times.is_empty()).then(|| {
            let passed_over = (self.passed_over > 0).then(|| {
                format!("events out of their order were passed over: {}", self.passed_over)
            });
            let notes: Vec<String> =
                cut.then(|| CUT.to_owned()).into_iter().chain(passed_over).collect();
            let note = (!notes.is_empty()).then(|| notes.join("; "));
            Variables { types: self.types, note }
        })
    }
}

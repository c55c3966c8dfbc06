//! Holds a log after parsing: the checked samples, and a list of the rows that were wrong.

use std::collections::BTreeMap;

use agent::AgentConfig;
use serde::Serialize;
use units::{Dbm, Duration, Instant, Metres, MetresPerSecond};

/// An error in a row for which its file is not refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Anomaly {
    /// The row has too few or too many fields, or nothing in one that it needs. Skipped.
    RowLength,
    /// A field that must be a number is not one. Skipped.
    NotANumber,
    /// An RSSI that no receiver reads: 0 dBm and above, or under −120 dBm. Skipped.
    ImpossibleRssi,
    /// A speed that nothing in these logs reaches. The sample counts, the speed as unknown.
    ImpossibleMotion,
    /// A receiver whose position is not known. Its samples count, their speeds as unknown.
    UnknownReceiver,
    /// In a flight log, a link that has a value in other rows and none in this one. The links
    /// that have one count.
    MissingLink,
    /// The clock is behind an earlier row's, by no more than a link's silence. Skipped.
    ClockBackwards,
    /// The clock fell back by more than that: a new recording begins. Every filter starts anew.
    ClockRestart,
    /// A link was silent for longer than `lost_after`. Its filter starts anew with this row.
    Gap,
}

impl Anomaly {
    /// The name that reports use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RowLength => "row-length",
            Self::NotANumber => "not-a-number",
            Self::ImpossibleRssi => "impossible-rssi",
            Self::ImpossibleMotion => "impossible-motion",
            Self::UnknownReceiver => "unknown-receiver",
            Self::MissingLink => "missing-link",
            Self::ClockBackwards => "clock-backwards",
            Self::ClockRestart => "clock-restart",
            Self::Gap => "gap",
        }
    }

    /// Whether such a row was not of the format at all. A file of mostly these is refused.
    const fn is_malformed(self) -> bool {
        matches!(self, Self::RowLength | Self::NotANumber)
    }
}

/// The lines of a file that had each kind of anomaly; the first line is 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Anomalies {
    lines: BTreeMap<Anomaly, Vec<usize>>,
}

impl Anomalies {
    fn add(&mut self, kind: Anomaly, line: usize) {
        let lines = self.lines.entry(kind).or_default();
        // A row can hold many packets that are wrong in the same way.
        if lines.last() != Some(&line) {
            lines.push(line);
        }
    }

    /// Returns the lines that had this anomaly, in order.
    #[must_use]
    pub fn of(&self, kind: Anomaly) -> &[usize] {
        self.lines.get(&kind).map_or(&[], Vec::as_slice)
    }

    /// Returns every kind of anomaly that occurred, with its lines.
    pub fn iter(&self) -> impl Iterator<Item = (Anomaly, &[usize])> {
        self.lines.iter().map(|(kind, lines)| (*kind, lines.as_slice()))
    }

    fn malformed(&self) -> (usize, Option<usize>) {
        let bad = || self.iter().filter(|(kind, _)| kind.is_malformed());
        (
            bad().map(|(_, lines)| lines.len()).sum(),
            bad().filter_map(|(_, lines)| lines.first()).min().copied(),
        )
    }
}

impl Serialize for Anomalies {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Lines<'a> {
            count: usize,
            lines: &'a [usize],
        }
        serializer.collect_map(
            self.iter().map(|(kind, lines)| (kind.name(), Lines { count: lines.len(), lines })),
        )
    }
}

/// One packet as it was received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The line of the file.
    pub line: usize,
    /// When it was received.
    pub time: Instant,
    /// Index into [`Recording::links`].
    pub link: usize,
    /// Its strength.
    pub rssi: Dbm,
    /// The rate at which the two ends separated since the link's previous packet; `None` where the
    /// log has none.
    pub separating: Option<MetresPerSecond>,
    /// Where the ends were; `None` where the log does not say.
    pub ends: Option<Ends>,
    /// Nothing that was known of the link before holds: it is the link's first packet, the clock
    /// restarted, or the link was silent for longer than on-board code waits.
    pub restarts: bool,
}

/// Where the ends of a link were when a packet was received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The distance between them.
    pub distance: Metres,
    /// The point of the end that moves, m. Where only the distance is known, a point at that
    /// distance from the origin.
    pub moving: [f64; 3],
}

impl Ends {
    /// Ends of which only the distance is known.
    pub fn apart(distance: Metres) -> Self {
        Self { distance, moving: [f64::from(distance.0), 0.0, 0.0] }
    }
}

/// What is wrong with a row of a table, for the error of a file that is refused for such rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// The number of the field, the first being 0; `None` where the whole row is wrong.
    pub field: Option<usize>,
    /// The character that separates the fields.
    pub separator: u8,
    /// What is wrong, in words.
    pub what: String,
}

/// A checked file of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Rows that were not empty, header excluded.
    pub rows: usize,
    /// The names of the links.
    pub links: Vec<String>,
    /// The samples, in order of time.
    pub samples: Vec<Sample>,
    /// The rows that were wrong.
    pub anomalies: Anomalies,
    /// How the file was interpreted, where that needs to be said.
    pub note: Option<String>,
    /// The first row that was not of the format, with its line, where its parser says more of it.
    pub wrong: Option<(usize, Wrong)>,
}

impl Recording {
    /// The first row that is not of the format, where most rows are not.
    pub fn mostly_malformed(&self) -> Option<usize> {
        let (malformed, first) = self.anomalies.malformed();
        first.filter(|_| malformed * 2 > self.rows)
    }
}

/// A neighbour that was silent for longer counts as lost on board, and its filter is reset.
pub const LOST_AFTER: Duration = AgentConfig::DEFAULT.retreat.lost_after;

/// Builds a [`Recording`]: what every parser writes into, and where clocks and gaps are judged.
#[derive(Debug, Default)]
pub struct Recorder {
    recording: Recording,
    index: BTreeMap<String, usize>,
    /// When each link was last heard, since the clock last restarted.
    heard: Vec<Option<Instant>>,
}

impl Recorder {
    /// Counts a row.
    pub fn row(&mut self) {
        self.recording.rows += 1;
    }

    /// Says something about the file as a whole, behind what was said before.
    pub fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        self.recording.note = Some(match self.recording.note.take() {
            Some(before) => format!("{before}; {note}"),
            None => note,
        });
    }

    /// Notes a wrong row.
    pub fn anomaly(&mut self, kind: Anomaly, line: usize) {
        self.recording.anomalies.add(kind, line);
    }

    /// Counts a row that is not of the format, and keeps what is wrong with the first.
    pub fn wrong(&mut self, kind: Anomaly, line: usize, wrong: Wrong) {
        self.recording.wrong.get_or_insert((line, wrong));
        self.anomaly(kind, line);
    }

    /// Judges a row's time by the clock that it was taken with. Whether the row counts.
    pub fn clock_is_sound(&mut self, clock: &mut Clock, now: Instant, line: usize) -> bool {
        match clock.read(now) {
            Reading::Onward => true,
            Reading::Behind => {
                self.anomaly(Anomaly::ClockBackwards, line);
                false
            }
            Reading::Restarted => {
                self.anomaly(Anomaly::ClockRestart, line);
                self.heard.fill(None);
                true
            }
        }
    }

    /// The link of this name, so that a sample need not look it up.
    pub fn link(&mut self, name: &str) -> usize {
        if let Some(&known) = self.index.get(name) {
            return known;
        }
        let link = self.recording.links.len();
        self.index.insert(name.to_owned(), link);
        self.recording.links.push(name.to_owned());
        self.heard.push(None);
        link
    }

    /// Adds a sample, or notes why its row is wrong.
    pub fn sample(
        &mut self,
        line: usize,
        time: Instant,
        link: usize,
        rssi: Dbm,
        separating: Option<MetresPerSecond>,
        ends: Option<Ends>,
    ) {
        let Some(heard) = self.heard.get_mut(link) else { return };
        let before = heard.replace(time);
        if before.is_some_and(|before| time < before) {
            *heard = before;
            return self.anomaly(Anomaly::ClockBackwards, line);
        }
        let silence = before.map(|before| time.since(before));
        let gap = silence.is_some_and(|silence| silence > LOST_AFTER);
        if gap {
            self.anomaly(Anomaly::Gap, line);
        }
        let restarts = gap || silence.is_none();
        let sample = Sample { line, time, link, rssi, separating, ends, restarts };
        self.recording.samples.push(sample);
    }

    /// The recording.
    pub fn finish(self) -> Recording {
        self.recording
    }
}

/// One clock of a log. Its rows are in order of time, or something is wrong with them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    latest: Option<Instant>,
}

enum Reading {
    Onward,
    Behind,
    Restarted,
}

impl Clock {
    fn read(&mut self, now: Instant) -> Reading {
        let behind = self.latest.map_or(Duration::ZERO, |latest| latest.since(now));
        // A row a little late was overtaken by others. When time is far behind, the clock is what
        // changed, and to wait for it to catch up would throw the rest of the file away.
        let reading = match behind {
            Duration::ZERO => Reading::Onward,
            late if late <= LOST_AFTER => return Reading::Behind,
            _ => Reading::Restarted,
        };
        self.latest = Some(now);
        reading
    }
}

/// The rate at which two ends separate, from their distances at this packet and at the one before.
/// Later packets are not used.
#[derive(Clone, Copy, Debug, Default)]
pub struct RadialSpeed {
    since: Option<(Instant, Metres)>,
    speed: MetresPerSecond,
}

impl RadialSpeed {
    /// Positions are annotated every 30 to 500 ms, while packets on different channels arrive
    /// 2 ms apart: over a shorter time than this a step of the annotation is not a speed.
    const SHORTEST: Duration = Duration::from_millis(100);

    /// The distance is `distance` now. The mean speed since the packet before this one.
    pub fn at(&mut self, now: Instant, distance: Metres) -> MetresPerSecond {
        let Some((then, before)) = self.since else {
            self.since = Some((now, distance));
            return self.speed;
        };
        let span = now.since(then);
        if now < then {
            *self = Self { since: Some((now, distance)), ..Self::default() };
        } else if span >= Self::SHORTEST {
            self.speed = MetresPerSecond((distance - before).0 / span.as_secs_f32());
            self.since = Some((now, distance));
        }
        self.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Instant {
        Instant::from_millis(ms)
    }

    #[test]
    fn a_late_row_is_skipped_and_a_restarted_clock_is_followed() {
        let (mut recorder, mut clock) = (Recorder::default(), Clock::default());
        let sound: Vec<bool> = [9_000, 8_999, 9_100, 50, 250]
            .into_iter()
            .enumerate()
            .map(|(i, ms)| recorder.clock_is_sound(&mut clock, at(ms), i + 1))
            .collect();
        assert_eq!(sound, [true, false, true, true, true]);
        let anomalies = recorder.finish().anomalies;
        assert_eq!(anomalies.of(Anomaly::ClockBackwards), [2]);
        assert_eq!(anomalies.of(Anomaly::ClockRestart), [4]);
    }

    #[test]
    fn a_gap_restarts_its_own_link_only() {
        let mut recorder = Recorder::default();
        let (a, b) = (recorder.link("a"), recorder.link("b"));
        for (line, ms, link) in [(1, 0, a), (2, 1_000, b), (3, 2_001, a), (4, 2_900, b)] {
            recorder.sample(line, at(ms), link, Dbm(-60.0), None, None);
        }
        let recording = recorder.finish();
        let restarts: Vec<bool> = recording.samples.iter().map(|s| s.restarts).collect();
        assert_eq!(restarts, [true, true, true, false]);
        assert_eq!(recording.anomalies.of(Anomaly::Gap), [3]);
    }

    #[test]
    fn a_repeated_position_is_rest_and_a_step_within_milliseconds_is_no_speed() {
        let mut radial = RadialSpeed::default();
        assert_eq!(radial.at(at(0), Metres(1.0)), MetresPerSecond::ZERO);
        assert_eq!(radial.at(at(500), Metres(1.0)), MetresPerSecond::ZERO);
        assert_eq!(radial.at(at(502), Metres(1.25)), MetresPerSecond::ZERO);
        assert_eq!(radial.at(at(1_000), Metres(1.25)), MetresPerSecond(0.5));
    }
}

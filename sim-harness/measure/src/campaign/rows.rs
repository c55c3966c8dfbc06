//! One run of a campaign as a row of a table, from which the campaign's figures are made.
//!
//! Numbers are written by their shortest decimals, so that a row that is read back is the row that
//! was written, to the bit. A cell is empty where there is no value.

mod fields;

use super::Run;
use crate::metrics::{ExploreMetrics, HoldMetrics, NoHold, RunMetrics, SwarmMetrics};
use crate::verdict::{Ended, Failure, Judgement};
use bodies::craft::record::{End, FlightMetrics};

use fields::{FIELDS, Field};

/// One run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The place of its settings in the campaign's grid; zero where there is none.
    pub point: usize,
    /// The seed.
    pub seed: u64,
    /// The verdict.
    pub outcome: Outcome,
    /// The figures. A row that was read has none of the radio.
    pub metrics: RunMetrics,
}

/// The verdict of one mission, without the data of its failures.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The names of its failures; empty for a mission that succeeded.
    pub failures: Vec<String>,
    /// Why the exploration ended.
    pub ended: Option<Ended>,
    /// See [`Judgement::came_m`].
    pub came_m: f32,
    /// See [`Judgement::could_m`].
    pub could_m: f32,
    /// See [`Judgement::stood_s`].
    pub stood_s: f32,
    /// See [`Judgement::surplus_at_rest`].
    pub surplus_at_rest: f32,
}

impl Outcome {
    /// The outcome of a mission that was judged.
    #[must_use]
    pub fn of(judgement: &Judgement) -> Self {
        Self {
            failures: judgement.failures.iter().map(|it| Failure::name(it).to_owned()).collect(),
            ended: judgement.ended,
            came_m: judgement.came_m,
            could_m: judgement.could_m,
            stood_s: judgement.stood_s,
            surplus_at_rest: judgement.surplus_at_rest,
        }
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// True or false.
    Flag,
    /// Words.
    Text,
    /// A number.
    Number,
    /// A number of things.
    Count,
}

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// There is no value.
    None,
    /// True or false.
    Flag(bool),
    /// Words.
    Text(String),
    /// A number.
    Number(f32),
    /// A number of things.
    Count(u32),
}

/// One column of the table, after those of the settings and the seed.
pub struct Column {
    /// The name, including its unit.
    pub name: &'static str,
    /// What it holds.
    pub kind: Kind,
    of: Of,
}

#[derive(Clone, Copy)]
enum Of {
    Success,
    Failures,
    Ended,
    Verdict(fn(&Outcome) -> f32, fn(&mut Outcome) -> &mut f32),
    NoHold,
    Metric(&'static Field),
    Ends(usize),
}

/// All columns, in order.
pub static COLUMNS: std::sync::LazyLock<Vec<Column>> = std::sync::LazyLock::new(columns);

fn columns() -> Vec<Column> {
    let column = |name, kind, of| Column { name, kind, of };
    let mut columns = vec![
        column("success", Kind::Flag, Of::Success),
        column("failures", Kind::Text, Of::Failures),
        column("ended", Kind::Text, Of::Ended),
        column("came_m", Kind::Number, Of::Verdict(|it| it.came_m, |it| &mut it.came_m)),
        column("could_m", Kind::Number, Of::Verdict(|it| it.could_m, |it| &mut it.could_m)),
        column("stood_s", Kind::Number, Of::Verdict(|it| it.stood_s, |it| &mut it.stood_s)),
        column(
            "surplus_at_rest",
            Kind::Number,
            Of::Verdict(|it| it.surplus_at_rest, |it| &mut it.surplus_at_rest),
        ),
        column("no_hold", Kind::Text, Of::NoHold),
    ];
    columns.extend(FIELDS.iter().map(|field| column(field.name, field.kind, Of::Metric(field))));
    columns.extend((0..End::ALL.len()).map(|n| column(END_NAMES[n], Kind::Count, Of::Ends(n))));
    columns
}

/// The names of the columns with the ends of flights, in the order of [`End::ALL`].
const END_NAMES: [&str; End::ALL.len()] = [
    "end_told",
    "end_no_setpoint",
    "end_no_imu",
    "end_no_flow",
    "end_no_height",
    "end_battery",
    "end_overload",
    "end_blocked",
    "end_ordered",
    "end_tumbled",
    "end_free_fall",
    "end_propeller_stuck",
];

impl Column {
    /// The value in a row.
    #[must_use]
    pub fn cell(&self, row: &Row) -> Cell {
        let number = |value: f32| if value.is_nan() { Cell::None } else { Cell::Number(value) };
        match self.of {
            Of::Success => Cell::Flag(row.outcome.failures.is_empty()),
            Of::Failures => Cell::Text(row.outcome.failures.join(";")),
            Of::Ended => row.outcome.ended.map_or(Cell::None, |it| Cell::Text(it.name().into())),
            Of::Verdict(of, _) => number(of(&row.outcome)),
            Of::NoHold => match row.metrics.hold {
                Ok(_) => Cell::None,
                Err(why) => Cell::Text(why.name().into()),
            },
            Of::Metric(field) => (field.get)(&row.metrics),
            Of::Ends(n) => row.metrics.flight.map_or(Cell::None, |it| Cell::Count(it.ends[n])),
        }
    }

    /// Puts a value as it is written into a row; `None` where it is none of this column.
    fn read(&self, text: &str, row: &mut Row) -> Option<()> {
        match self.of {
            Of::Success => return (text == "true" || text == "false").then_some(()),
            Of::Failures => {
                let names = text.split(';').filter(|name| !name.is_empty());
                row.outcome.failures = names.map(str::to_owned).collect();
            }
            _ if text.is_empty() => {}
            Of::Ended => {
                row.outcome.ended = Some(Ended::ALL.into_iter().find(|it| it.name() == text)?);
            }
            Of::Verdict(_, at) => *at(&mut row.outcome) = text.parse().ok()?,
            Of::NoHold => row.metrics.hold = Err(NoHold::named(text)?),
            Of::Metric(field) => (field.set)(&mut row.metrics, text)?,
            Of::Ends(n) => fields::flight(&mut row.metrics).ends[n] = text.parse().ok()?,
        }
        Some(())
    }
}

impl Cell {
    /// The value as it is written.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::None => String::new(),
            Self::Flag(value) => value.to_string(),
            Self::Text(text) => text.clone(),
            Self::Number(value) => value.to_string(),
            Self::Count(count) => count.to_string(),
        }
    }
}

impl Row {
    /// The row of a run.
    #[must_use]
    pub fn of(point: usize, run: &Run) -> Self {
        let outcome = Outcome::of(&run.judgement);
        Self { point, seed: run.seed, outcome, metrics: run.metrics }
    }

    /// The values of [`COLUMNS`] as they are written.
    pub fn texts(&self) -> impl Iterator<Item = String> {
        COLUMNS.iter().map(|column| column.cell(self).text())
    }

    /// Reads the values of [`COLUMNS`]; `None` where one is missing, too many or none of its
    /// column.
    #[must_use]
    pub fn read<'a>(
        point: usize,
        seed: u64,
        texts: impl ExactSizeIterator<Item = &'a str>,
    ) -> Option<Self> {
        if texts.len() != COLUMNS.len() {
            return None;
        }
        let mut row = Self { point, seed, outcome: Outcome::NONE, metrics: fields::NONE };
        COLUMNS.iter().zip(texts).try_for_each(|(column, text)| column.read(text, &mut row))?;
        Some(row)
    }
}

impl Outcome {
    const NONE: Self = Self {
        failures: Vec::new(),
        ended: None,
        came_m: f32::NAN,
        could_m: f32::NAN,
        stood_s: f32::NAN,
        surplus_at_rest: f32::NAN,
    };
}

#[cfg(test)]
mod tests {
    use super::super::{Run, figures, json};
    use super::*;
    use crate::metrics::Reference;
    use crate::verdict::judged;
    use scenario::Scenario;

    /// A mission with a hold, one without, a swarm, an exploration, and rigid bodies.
    #[test]
    fn a_row_that_is_read_back_gives_the_same_figures() {
        for (name, seconds) in [
            ("straight", 80),
            ("repair-6", 30),
            ("swarm-b", 20),
            ("explore-room", 10),
            ("short-hop", 6),
        ] {
            let whole = Scenario::open(name).unwrap();
            let scenario = Scenario { duration_us: seconds * 1_000_000, ..whole };
            let world = scenario.world();
            let reference = Reference::of(&scenario, &world);
            let (metrics, judgement) = judged(&scenario, &world, &reference, 3);
            let row = Row::of(2, &Run { seed: 3, metrics, judgement });
            let texts: Vec<_> = row.texts().collect();
            let read = Row::read(2, 3, texts.iter().map(String::as_str)).unwrap();
            assert_eq!(read.texts().collect::<Vec<_>>(), texts, "{name}");
            assert_eq!(format!("{:?}", read.outcome), format!("{:?}", row.outcome), "{name}");
            let told = |row: &Row| json(&figures(&[row.metrics])).to_string();
            assert_eq!(told(&read), told(&row), "{name}");
            for broken in [&texts[1..], &[&texts[..], &texts[..1]].concat()] {
                assert!(Row::read(2, 3, broken.iter().map(String::as_str)).is_none());
            }
        }
    }

    #[test]
    fn the_names_are_those_of_all_ends_and_no_name_is_there_twice() {
        for (name, end) in END_NAMES.iter().zip(End::ALL) {
            assert_eq!(*name, format!("end_{}", end.name().replace('-', "_")));
        }
        let mut names: Vec<_> = COLUMNS.iter().map(|column| column.name).collect();
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
    }
}

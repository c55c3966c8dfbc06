//! Prints the comparison of chip and host in three forms: as a table, as JSON, and as a CSV of every
//! step.

use std::fmt;
use std::io;

use onboard::replay::{Answer, Stepped};
use serde::Serialize;
use units::{Dbm, Instant, NodeId, Setpoint};

/// Rows of a log's table: so many steps are spread over the log.
const TABLE: usize = 12;

/// The results of a replay on a chip for all of its logs.
#[derive(Clone, Debug, Serialize)]
pub struct ChipSummary {
    /// The chip: `virtual` or `probe`.
    pub on: &'static str,
    /// The steps of all logs.
    pub steps: usize,
    /// Those whose answers were equal, bit for bit, but for the cycles.
    pub equal: usize,
    /// The most cycles of a step.
    pub cycles_max: u32,
    /// The mean of the cycles of all steps; `None` where there was no step.
    pub cycles_mean: Option<f64>,
    /// Each log, in the order given.
    pub logs: Vec<ChipReport>,
}

/// The results of a replay on a chip for one log.
#[derive(Clone, Debug, Serialize)]
pub struct ChipReport {
    /// The log, as it was named.
    pub log: String,
    /// The chip: `virtual` or `probe`.
    pub on: &'static str,
    /// The movement policy.
    pub policy: &'static str,
    /// The links with the fewest packets, which were left out because no drone has so many
    /// neighbours.
    pub links_left_out: usize,
    /// The steps.
    pub steps: usize,
    /// The steps whose answers were equal, bit for bit, but for the cycles.
    pub equal: usize,
    /// The first step whose answers differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_difference: Option<Difference>,
    /// The most cycles of a step.
    pub cycles_max: u32,
    /// The mean of the cycles of all steps; `None` where there was no step.
    pub cycles_mean: Option<f64>,
    /// The times at which the launch rule began to call for a relay on the chip, in seconds of the
    /// log, each once.
    pub launches_s: Vec<f64>,
    /// Every step.
    #[serde(skip)]
    pub rows: Vec<Row>,
    #[serde(skip)]
    cycles: u64,
}

/// Two answers that differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The step, from 1.
    pub step: usize,
    /// Its time, in seconds of the log.
    pub time_s: f64,
    /// The number of the drone that was replayed.
    pub node: u8,
    /// The first part of the answers that differs.
    pub part: &'static str,
    /// That part of the host's answer.
    pub host: String,
    /// That part of the chip's answer.
    pub chip: String,
}

/// One step on the host and on the chip.
#[derive(Clone, Debug)]
pub struct Row {
    /// The number of the drone.
    pub node: NodeId,
    /// The time of the log.
    pub time: Instant,
    /// The host's answer.
    pub host: Stepped,
    /// The chip's answer.
    pub chip: Stepped,
}

impl ChipSummary {
    pub(super) fn of(on: &'static str, logs: Vec<ChipReport>) -> Self {
        let steps = logs.iter().map(|log| log.steps).sum();
        Self {
            on,
            steps,
            equal: logs.iter().map(|log| log.equal).sum(),
            cycles_max: logs.iter().map(|log| log.cycles_max).max().unwrap_or(0),
            cycles_mean: mean(logs.iter().map(|log| log.cycles).sum(), steps),
            logs,
        }
    }

    /// Whether every step was equal.
    #[must_use]
    pub const fn is_equal(&self) -> bool {
        self.equal == self.steps
    }

    /// Writes every step of every log as a row of a CSV file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_steps(&self, out: impl io::Write) -> io::Result<()> {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(COLUMNS)?;
        for log in &self.logs {
            for row in &log.rows {
                csv.write_record(row.fields(&log.log))?;
            }
        }
        csv.flush()
    }
}

fn mean(cycles: u64, steps: usize) -> Option<f64> {
    // To a tenth of a cycle.
    (steps > 0).then(|| (10.0 * cycles as f64 / steps as f64).round() / 10.0)
}

impl ChipReport {
    pub(super) fn new(
        log: String,
        on: &'static str,
        policy: &'static str,
        links_left_out: usize,
    ) -> Self {
        Self {
            log,
            on,
            policy,
            links_left_out,
            steps: 0,
            equal: 0,
            first_difference: None,
            cycles_max: 0,
            cycles_mean: None,
            launches_s: Vec::new(),
            rows: Vec::new(),
            cycles: 0,
        }
    }

    /// Adds a step with both answers.
    pub(super) fn add(&mut self, node: NodeId, time: Instant, host: Stepped, chip: Stepped) {
        let row = Row { node, time, host, chip };
        self.steps += 1;
        self.cycles_max = self.cycles_max.max(row.chip.cycles);
        self.cycles += u64::from(row.chip.cycles);
        self.cycles_mean = mean(self.cycles, self.steps);
        if row.chip.launches && !self.launches_s.contains(&row.seconds()) {
            self.launches_s.push(row.seconds());
        }
        if row.is_equal() {
            self.equal += 1;
        } else if self.first_difference.is_none() {
            self.first_difference = Some(row.difference(self.steps));
        }
        self.rows.push(row);
    }
}

/// One part of an answer, in words.
type Part = fn(&Stepped) -> String;

/// The columns of the CSV file.
const COLUMNS: [&str; 16] = [
    "log",
    "drone",
    "time_s",
    "equal",
    "cycles",
    "state",
    "chip_state",
    "forward_mps",
    "chip_forward_mps",
    "front_dbm",
    "chip_front_dbm",
    "back_dbm",
    "chip_back_dbm",
    "launches",
    "chip_launches",
    "links",
];

impl Row {
    fn seconds(&self) -> f64 {
        self.time.as_micros() as f64 / 1e6
    }

    /// Whether the two answers are the same bytes, but for the cycles.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        let bytes = |stepped: &Stepped| {
            let mut bytes = Vec::new();
            let stepped = Stepped { cycles: 0, ..stepped.clone() };
            Answer::Stepped(stepped).send(0, |byte| bytes.push(byte));
            bytes
        };
        bytes(&self.host) == bytes(&self.chip)
    }

    fn difference(&self, step: usize) -> Difference {
        // A float is written with as many digits as it takes to tell it from all others.
        let parts: [(&str, Part); 6] = [
            ("launches", |stepped| format!("{:?}", stepped.launches)),
            ("state", |stepped| format!("{:?}", stepped.outputs.status.state)),
            ("set-point", |stepped| format!("{:?}", stepped.outputs.setpoint)),
            ("estimates", |stepped| format!("{:?}", stepped.estimates)),
            ("status", |stepped| format!("{:?}", stepped.outputs.status)),
            ("report", |stepped| format!("{:?}", stepped.outputs.report)),
        ];
        let differing = parts.into_iter().map(|(part, of)| (part, of(&self.host), of(&self.chip)));
        let found = differing.into_iter().find(|(_, host, chip)| host != chip);
        let (part, host, chip) =
            found.unwrap_or_else(|| ("bits of a NaN", String::new(), String::new()));
        Difference { step, time_s: self.seconds(), node: self.node.0, part, host, chip }
    }

    fn fields(&self, log: &str) -> [String; COLUMNS.len()] {
        let Self { host, chip, .. } = self;
        let state = |of: &Stepped| of.outputs.status.state.name().to_owned();
        let forward = |of: &Stepped| forward(of).map_or_else(String::new, |mps| mps.to_string());
        let link = |rssi: Option<Dbm>| rssi.map_or_else(String::new, |rssi| rssi.0.to_string());
        let [front, back] = ends(host).map(link);
        let [chip_front, chip_back] = ends(chip).map(link);
        [
            log.to_owned(),
            self.node.0.to_string(),
            self.seconds().to_string(),
            u8::from(self.is_equal()).to_string(),
            chip.cycles.to_string(),
            state(host),
            state(chip),
            forward(host),
            forward(chip),
            front,
            chip_front,
            back,
            chip_back,
            u8::from(host.launches).to_string(),
            u8::from(chip.launches).to_string(),
            chip.estimates.len().to_string(),
        ]
    }
}

/// The speed along the tunnel of a set-point, m/s.
fn forward(stepped: &Stepped) -> Option<f32> {
    match stepped.outputs.setpoint {
        Setpoint::Fly { forward, .. } => Some(forward.0),
        Setpoint::Off | Setpoint::Stop => None,
    }
}

/// The filtered strengths of the links in front and behind.
fn ends(stepped: &Stepped) -> [Option<Dbm>; 2] {
    let status = &stepped.outputs.status;
    [status.front, status.back].map(|link| link.map(|link| link.rssi))
}

impl fmt::Display for ChipSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for log in &self.logs {
            writeln!(f, "{log}")?;
        }
        Ok(())
    }
}

impl fmt::Display for ChipReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} on {}, policy {}", self.log, self.on, self.policy)?;
        let (steps, equal) = (self.steps, self.equal);
        write!(f, "  {equal} of {steps} steps equal the host's, bit for bit; at most ")?;
        writeln!(f, "{} cycles a step, {:.0} on average", self.cycles_max, self.mean())?;
        if self.links_left_out > 0 {
            writeln!(f, "  {} links with the fewest packets left out", self.links_left_out)?;
        }
        if let Some(Difference { step, time_s, node, part, host, chip }) = &self.first_difference {
            writeln!(f, "  step {step}, at {time_s} s, drone {node}, differs in the {part}:")?;
            writeln!(f, "    host {host}\n    chip {chip}")?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "  {:>9} {:>5} {:>26} {:>17} {:>17} {:>17}",
            "", "", "state", "front dBm", "back dBm", "forward m/s"
        )?;
        write!(f, "  {:>9} {:>5} {:>13}{:>13}", "time s", "drone", "host", "chip")?;
        writeln!(f, "{0:>9}{1:>9}{0:>9}{1:>9}{0:>9}{1:>9} {2:>8}", "host", "chip", "cycles")?;
        let every = self.rows.len().div_ceil(TABLE).max(1);
        self.rows.iter().step_by(every).try_for_each(|row| writeln!(f, "  {row}"))
    }
}

impl ChipReport {
    fn mean(&self) -> f64 {
        self.cycles_mean.unwrap_or(0.0)
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |value: Option<f32>, digits: usize| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
        };
        let Self { host, chip, .. } = self;
        let state = |of: &Stepped| of.outputs.status.state.name();
        write!(
            f,
            "{:>9.2} {:>5} {:>13}{:>13}",
            self.seconds(),
            self.node.0,
            state(host),
            state(chip)
        )?;
        let (mine, theirs) = (ends(host), ends(chip));
        for (mine, theirs) in mine.into_iter().zip(theirs) {
            let text = |rssi: Option<Dbm>| number(rssi.map(|rssi| rssi.0), 2);
            write!(f, "{:>9}{:>9}", text(mine), text(theirs))?;
        }
        write!(f, "{:>9}{:>9}", number(forward(host), 3), number(forward(chip), 3))?;
        write!(f, " {:>8}", chip.cycles)
    }
}

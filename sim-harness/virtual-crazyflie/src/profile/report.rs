//! The report of a profile: plain figures, and a table.

use std::fmt;

use super::account::{Account, Runs, Tally};
use super::names;

/// Durations in microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Durations {
    /// The number of measurements.
    pub count: u64,
    /// Half of them took no longer.
    pub p50: f64,
    /// 99 of 100 took no longer.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

/// The time that a task takes.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskLoad {
    /// Module and function.
    pub name: String,
    /// The share of the time, 0 to 1.
    pub share: f64,
    /// The duration of a poll, without interrupts.
    pub own: Durations,
    /// The duration of a poll, with interrupts.
    pub whole: Durations,
    /// How long it waits from being woken to being polled. `None` where it is not known when tasks
    /// are woken: the image's debug information does not tell.
    pub latency: Option<Durations>,
}

/// The time that an exception takes.
#[derive(Clone, Debug, PartialEq)]
pub struct InterruptLoad {
    /// The name in the chip's manual.
    pub name: String,
    /// The exception's number in IPSR.
    pub number: u16,
    /// The share of the time, 0 to 1, without the tasks that the exception polls.
    pub share: f64,
    /// The duration of its handler, with the tasks that it polls, without other interrupts.
    pub own: Durations,
    /// The duration from its beginning to its end.
    pub whole: Durations,
}

/// The time that a watched function takes.
#[derive(Clone, Debug, PartialEq)]
pub struct WatchedTime {
    /// The name by which it is watched.
    pub name: String,
    /// The share of the time, 0 to 1.
    pub share: f64,
    /// The duration without interrupts.
    pub own: Durations,
    /// The duration with interrupts.
    pub whole: Durations,
}

/// The depth of the stack, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackUse {
    /// The size of the stack.
    pub size: u32,
    /// Since the start, by the paint that is gone; `None` where it was never painted.
    pub by_paint: Option<u32>,
    /// The deepest that was seen at a trap.
    pub seen: Option<u32>,
}

/// A profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The time that was measured, in seconds.
    pub seconds: f64,
    /// The share of it that the core did not sleep, 0 to 1.
    pub load: f64,
    /// The share of the program itself, outside of tasks and interrupts: start-up, and the
    /// thread's executor.
    pub executor: f64,
    /// The tasks, by name.
    pub tasks: Vec<TaskLoad>,
    /// The interrupts, by number.
    pub interrupts: Vec<InterruptLoad>,
    /// The watched functions, in the order in which they were requested.
    pub watched: Vec<WatchedTime>,
    /// The stack, if the image says where it is.
    pub stack: Option<StackUse>,
    /// Resets within the measurement.
    pub resets: u64,
    /// Polls and calls of which the end was not seen; they are charged, but not among the
    /// durations.
    pub unfinished: u64,
}

impl Report {
    pub(super) fn new(
        account: &Account,
        tasks: &[String],
        watched: &[String],
        knows_wakes: bool,
        core_hz: u32,
        stack: Option<StackUse>,
    ) -> Self {
        let (cycles, slept) = account.window();
        let share = |busy: u64| busy as f64 / cycles.max(1) as f64;
        let durations = |tally: &Tally| durations(tally, core_hz);
        let pair = |runs: &Runs| (durations(&runs.own), durations(&runs.whole));
        let mut tasks: Vec<TaskLoad> = tasks
            .iter()
            .zip(&account.tasks)
            .map(|(name, task)| {
                let (own, whole) = pair(&task.runs);
                let latency = knows_wakes.then(|| durations(&task.latency));
                TaskLoad { name: name.clone(), share: share(task.runs.busy), own, whole, latency }
            })
            .collect();
        tasks.sort_by(|one, other| one.name.cmp(&other.name));
        let interrupts = account.interrupts.iter().map(|(number, runs)| {
            let (own, whole) = pair(runs);
            let name = names::exception(*number);
            InterruptLoad { name, number: *number, share: share(runs.busy), own, whole }
        });
        let watched = watched.iter().zip(&account.watched).map(|(name, runs)| {
            let (own, whole) = pair(runs);
            WatchedTime { name: name.clone(), share: share(runs.busy), own, whole }
        });
        Self {
            seconds: cycles as f64 / f64::from(core_hz.max(1)),
            load: if cycles == 0 { 0.0 } else { 1.0 - share(slept) },
            executor: share(account.thread),
            tasks,
            interrupts: interrupts.collect(),
            watched: watched.collect(),
            stack,
            resets: account.resets,
            unfinished: account.unfinished,
        }
    }
}

fn durations(tally: &Tally, core_hz: u32) -> Durations {
    let micros = |cycles: u64| cycles as f64 * 1e6 / f64::from(core_hz.max(1));
    Durations {
        count: tally.count(),
        p50: micros(tally.percentile(0.5)),
        p99: micros(tally.percentile(0.99)),
        max: micros(tally.max()),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:.3} s, processor busy {:.1} %", self.seconds, self.load * 100.0)?;
        let width = self.names().map(|name| name.chars().count()).max().unwrap_or(0).max(12);
        head(f, "task", width, true)?;
        for task in &self.tasks {
            row(f, &task.name, width, task.share, &task.own, &task.whole)?;
            match task.latency {
                Some(latency) if latency.count > 0 => {
                    writeln!(f, " {:>9.1} {:>9.1}", latency.p50, latency.max)?;
                }
                _ => writeln!(f, " {:>9} {:>9}", "-", "-")?,
            }
        }
        share(f, "(executor)", width, self.executor)?;
        head(f, "interrupt", width, false)?;
        for interrupt in &self.interrupts {
            row(f, &interrupt.name, width, interrupt.share, &interrupt.own, &interrupt.whole)?;
            writeln!(f)?;
        }
        share(f, "(sleep)", width, 1.0 - self.load)?;
        if !self.watched.is_empty() {
            head(f, "function", width, false)?;
        }
        for watched in &self.watched {
            row(f, &watched.name, width, watched.share, &watched.own, &watched.whole)?;
            writeln!(f)?;
        }
        if let Some(stack) = &self.stack {
            let bytes =
                |bytes: Option<u32>| bytes.map_or("-".to_owned(), |bytes| bytes.to_string());
            let (paint, seen) = (bytes(stack.by_paint), bytes(stack.seen));
            writeln!(f, "stack {} bytes: {paint} used by the paint, {seen} seen", stack.size)?;
        }
        if self.resets > 0 {
            writeln!(f, "{} resets", self.resets)?;
        }
        if self.unfinished > 0 {
            writeln!(f, "{} polls or calls whose end was not seen", self.unfinished)?;
        }
        Ok(())
    }
}

impl Report {
    fn names(&self) -> impl Iterator<Item = &String> {
        let tasks = self.tasks.iter().map(|task| &task.name);
        let interrupts = self.interrupts.iter().map(|interrupt| &interrupt.name);
        tasks.chain(interrupts).chain(self.watched.iter().map(|watched| &watched.name))
    }
}

fn head(f: &mut fmt::Formatter<'_>, what: &str, width: usize, latency: bool) -> fmt::Result {
    write!(f, "{what:<width$} {:>8} {:>8}", "count", "share")?;
    for column in ["own p50", "own max", "all p50", "all max"] {
        write!(f, " {column:>9}")?;
    }
    if latency {
        write!(f, " {:>9} {:>9}", "late p50", "late max")?;
    }
    writeln!(f, "   (us)")
}

fn row(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    width: usize,
    share: f64,
    own: &Durations,
    whole: &Durations,
) -> fmt::Result {
    write!(f, "{name:<width$} {:>8} {:>6.2} %", own.count, share * 100.0)?;
    write!(f, " {:>9.1} {:>9.1} {:>9.1} {:>9.1}", own.p50, own.max, whole.p50, whole.max)
}

fn share(f: &mut fmt::Formatter<'_>, name: &str, width: usize, share: f64) -> fmt::Result {
    writeln!(f, "{name:<width$} {:>8} {:>6.2} %", "", share * 100.0)
}

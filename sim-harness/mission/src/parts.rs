//! The time that each part of the simulation takes on this machine, for the benchmark that shows it.

use std::time::{Duration, Instant};

/// A part of the simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Bodies, their walls and their sensors.
    Bodies,
    /// Agents: filter, policy, navigation.
    Agents,
    /// The drones' ends of the radio link.
    Links,
    /// The air between the drones, or the ideal link.
    Medium,
    /// Everything else.
    Rest,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 5] = [Self::Bodies, Self::Agents, Self::Links, Self::Medium, Self::Rest];

    /// The name of the part.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bodies => "bodies and rays",
            Self::Agents => "agents",
            Self::Links => "radio links",
            Self::Medium => "medium",
            Self::Rest => "rest",
        }
    }
}

/// A stopwatch that is told which part begins. It does not run unless it is asked for.
#[derive(Default)]
pub(super) struct Stopwatch(Option<Box<Times>>);

struct Times {
    part: Part,
    since: Instant,
    spent: [Duration; Part::ALL.len()],
    /// How often the stopwatch was read in each part, which takes time as well.
    reads: [u32; Part::ALL.len()],
}

impl Stopwatch {
    /// A stopwatch that runs.
    pub(super) fn started() -> Self {
        Self(Some(Box::new(Times {
            part: Part::Rest,
            since: Instant::now(),
            spent: [Duration::ZERO; Part::ALL.len()],
            reads: [0; Part::ALL.len()],
        })))
    }

    /// Notes that this part begins, and that the one before it ends.
    #[inline]
    pub(super) fn enter(&mut self, part: Part) {
        if let Some(times) = &mut self.0 {
            times.enter(part);
        }
    }

    /// The time spent in each part, in the order of [`Part::ALL`], without that for reading the
    /// clock.
    pub(super) fn spent(&self) -> Option<[Duration; Part::ALL.len()]> {
        let times = self.0.as_ref()?;
        let read = time_of_a_read();
        let net = |n: usize| times.spent[n].saturating_sub(read * times.reads[n]);
        Some(std::array::from_fn(net))
    }
}

impl Times {
    fn enter(&mut self, part: Part) {
        let now = Instant::now();
        let last = self.part as usize;
        self.spent[last] += now - self.since;
        self.reads[last] += 1;
        (self.part, self.since) = (part, now);
    }
}

fn time_of_a_read() -> Duration {
    const READS: u32 = 10_000;
    let begun = Instant::now();
    for _ in 0..READS {
        std::hint::black_box(Instant::now());
    }
    begun.elapsed() / READS
}

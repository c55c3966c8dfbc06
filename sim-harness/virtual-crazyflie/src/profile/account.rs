//! Charges the time between two moments to a task, an interrupt or the executor.
//!
//! Exceptions nest, so there is a stack of levels, the program itself at the bottom; the one
//! at the top has the processor. On each level functions and polls nest too.

use std::collections::BTreeMap;

use super::Moment;
use super::quick::QuickMap;

/// A histogram of durations in cycles. Exact; equal times are common.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Tally {
    counts: QuickMap<u64, u64>,
    total: u64,
    max: u64,
}

impl Tally {
    pub(super) fn add(&mut self, cycles: u64) {
        *self.counts.entry(cycles).or_default() += 1;
        self.total += 1;
        self.max = self.max.max(cycles);
    }

    pub(super) fn count(&self) -> u64 {
        self.total
    }

    pub(super) const fn max(&self) -> u64 {
        self.max
    }

    /// The least time that this share (0 to 1) of all did not exceed.
    pub(super) fn percentile(&self, share: f64) -> u64 {
        let rank = (share.clamp(0.0, 1.0) * self.total as f64).ceil().max(1.0) as u64;
        let mut counts: Vec<_> = self.counts.iter().collect();
        counts.sort_unstable();
        let mut seen = 0;
        for (cycles, count) in counts {
            seen += count;
            if seen >= rank {
                return *cycles;
            }
        }
        0
    }
}

/// The durations of a task's polls, a watched function's calls, or an interrupt's runs.
#[derive(Clone, Debug, Default)]
pub(super) struct Runs {
    /// Time without what broke in.
    pub(super) own: Tally,
    /// Time from begin to end.
    pub(super) whole: Tally,
    /// Cycles that belong to it and to nothing nested in it.
    pub(super) busy: u64,
}

/// A task and its account.
#[derive(Clone, Debug, Default)]
pub(super) struct Task {
    pub(super) runs: Runs,
    /// The times from a task's wake-up to its poll.
    pub(super) latency: Tally,
}

/// An activity within a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    /// A task's poll.
    Poll(usize),
    /// A watched function's call.
    Watched(usize),
}

#[derive(Clone, Copy, Debug)]
struct Activity {
    what: What,
    began: u64,
    own: u64,
    /// Stack pointer and return address when it began.
    frame: (u32, u32),
    /// It began before the measurement did, so how long it takes is not known.
    cut: bool,
}

#[derive(Clone, Debug, Default)]
struct Level {
    exception: u16,
    began: u64,
    own: u64,
    /// The stack pointer when its handler began.
    sp: u32,
    cut: bool,
    activities: Vec<Activity>,
}

/// All that has been charged.
#[derive(Clone, Debug)]
pub(super) struct Account {
    /// Never empty.
    levels: Vec<Level>,
    /// Up to when all is charged: cycles, and those of them that were slept.
    charged: (u64, u64),
    since: Option<(u64, u64)>,
    pub(super) tasks: Vec<Task>,
    pub(super) watched: Vec<Runs>,
    pub(super) interrupts: BTreeMap<u16, Runs>,
    /// The program itself, between tasks: start-up, and the thread executor.
    pub(super) thread: u64,
    /// Calls and polls of which the end was not seen.
    pub(super) unfinished: u64,
    pub(super) resets: u64,
}

impl Account {
    pub(super) fn new(tasks: usize) -> Self {
        Self {
            levels: vec![Level::default()],
            charged: (0, 0),
            since: None,
            tasks: vec![Task::default(); tasks],
            watched: vec![],
            interrupts: BTreeMap::new(),
            thread: 0,
            unfinished: 0,
            resets: 0,
        }
    }

    /// Adds one more watched function.
    pub(super) fn watch(&mut self) {
        self.watched.push(Runs::default());
    }

    /// Cycles measured, and how many of them were slept.
    pub(super) fn window(&self) -> (u64, u64) {
        let (cycles, slept) = self.since.unwrap_or(self.charged);
        (self.charged.0 - cycles, self.charged.1 - slept)
    }

    /// Forgets all results; what goes on goes on, but counts no more.
    pub(super) fn restart(&mut self, now: &Moment) {
        let mut levels = std::mem::take(&mut self.levels);
        for level in &mut levels {
            level.cut = true;
            for activity in &mut level.activities {
                activity.cut = true;
            }
        }
        let watched = vec![Runs::default(); self.watched.len()];
        let charged = (now.cycles, now.slept);
        *self = Self { levels, watched, charged, ..Self::new(self.tasks.len()) };
        self.since = Some(self.charged);
    }

    /// Charges the time that has passed to the level that had the processor.
    pub(super) fn charge(&mut self, now: &Moment) {
        if self.since.is_none() {
            self.charged = (now.cycles, now.slept);
            self.since = Some(self.charged);
        }
        let passed = now.cycles.saturating_sub(self.charged.0);
        let active = passed.saturating_sub(now.slept.saturating_sub(self.charged.1));
        self.charged = (now.cycles, now.slept);
        let level = top(&mut self.levels);
        level.own += active;
        let mut task = None;
        for activity in &mut level.activities {
            activity.own += active;
            match activity.what {
                What::Poll(index) => task = Some(index),
                What::Watched(index) => self.watched[index].busy += active,
            }
        }
        match (task, level.exception) {
            (Some(task), _) => self.tasks[task].runs.busy += active,
            (None, 0) => self.thread += active,
            (None, exception) => self.interrupts.entry(exception).or_default().busy += active,
        }
    }

    /// An exception's handler begins.
    pub(super) fn enter(&mut self, now: &Moment) {
        let sp = now.registers[13];
        if top(&mut self.levels).exception == now.exception && top(&mut self.levels).sp == sp {
            // Seen a second time: another came in before its first instruction.
            return;
        }
        // The one before it may have ended unseen.
        if let Some(same) = self.find(now.exception) {
            self.close_above(same.max(1) - 1, now);
        }
        self.levels.push(Level { exception: now.exception, began: now.cycles, ..Level::default() });
    }

    /// The level at the top ends.
    pub(super) fn leave(&mut self, now: &Moment) {
        self.settle(now);
        if self.levels.len() > 1 {
            self.close_above(self.levels.len() - 2, now);
        }
    }

    /// Whether this has begun already, just here, and nothing since then on its level.
    pub(super) fn has_begun(&mut self, now: &Moment, what: What) -> bool {
        self.settle(now);
        let last = top(&mut self.levels).activities.last();
        last.is_some_and(|activity| activity.what == what && activity.frame == frame(now))
    }

    /// A task is polled.
    pub(super) fn polled(&mut self, now: &Moment, task: usize, woken: Option<u64>) {
        if let Some(woken) = woken
            && self.since.is_none_or(|(since, _)| woken >= since)
        {
            self.tasks[task].latency.add(now.cycles.saturating_sub(woken));
        }
        self.begin(now, What::Poll(task));
    }

    /// A function or poll begins.
    pub(super) fn begin(&mut self, now: &Moment, what: What) {
        self.settle(now);
        let frame = frame(now);
        let activity = Activity { what, began: now.cycles, own: 0, frame, cut: false };
        top(&mut self.levels).activities.push(activity);
    }

    /// The core is where an executor goes on after a poll.
    pub(super) fn poll_returned(&mut self, now: &Moment) {
        self.returned_to(now, |activity| matches!(activity.what, What::Poll(_)));
    }

    /// The core is where a watched function may have returned to.
    pub(super) fn returned(&mut self, now: &Moment) {
        let here = (now.registers[13], now.registers[15]);
        self.returned_to(now, |activity| {
            matches!(activity.what, What::Watched(_)) && activity.frame == here
        });
    }

    fn returned_to(&mut self, now: &Moment, is_it: impl Fn(&Activity) -> bool) {
        self.settle(now);
        let level = self.levels.len() - 1;
        let Some(index) = self.levels[level].activities.iter().rposition(is_it) else { return };
        // What began within it has ended with it, though that was not seen.
        self.unfinished += (self.levels[level].activities.len() - index - 1) as u64;
        let activity = self.levels[level].activities[index];
        self.levels[level].activities.truncate(index);
        if !activity.cut {
            let runs = match activity.what {
                What::Poll(task) => &mut self.tasks[task].runs,
                What::Watched(index) => &mut self.watched[index],
            };
            runs.own.add(activity.own);
            runs.whole.add(now.cycles.saturating_sub(activity.began));
        }
    }

    /// The chip has been reset: nothing goes on any more.
    pub(super) fn reset(&mut self) {
        self.resets += 1;
        self.levels = vec![Level::default()];
    }

    /// Makes the levels agree with the core, where the beginning or the end of a handler was not
    /// seen.
    fn settle(&mut self, now: &Moment) {
        match self.find(now.exception) {
            Some(level) => self.close_above(level, now),
            None => self.levels.push(Level {
                exception: now.exception,
                began: now.cycles,
                cut: true,
                ..Level::default()
            }),
        }
    }

    fn find(&self, exception: u16) -> Option<usize> {
        self.levels.iter().rposition(|level| level.exception == exception)
    }

    fn close_above(&mut self, lowest: usize, now: &Moment) {
        while self.levels.len() > lowest + 1 {
            let Some(level) = self.levels.pop() else { return };
            self.unfinished += level.activities.len() as u64;
            if !level.cut {
                let runs = self.interrupts.entry(level.exception).or_default();
                runs.own.add(level.own);
                runs.whole.add(now.cycles.saturating_sub(level.began));
            }
        }
    }
}

fn top(levels: &mut [Level]) -> &mut Level {
    levels.last_mut().expect("the program's own level is never closed")
}

/// The identity of a call: its stack pointer, and its return address.
fn frame(now: &Moment) -> (u32, u32) {
    (now.registers[13], now.registers[14] & !1)
}

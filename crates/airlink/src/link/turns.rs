//! When this node speaks: which turn is its next, and how far the one that it is in has got.

use units::Instant;
use wire::p2p::{Counter, Wave};

use super::life::Life;
use super::{Airlink, End};
use crate::schedule::Turn;
use crate::seal::Seal;

/// The turn that has been begun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    turn: Turn,
    /// The next packet's place in it.
    place: u8,
    /// The radio chip is busy until then.
    not_before: Instant,
    /// It has begun with a command to the head, which is to be said twice.
    pub(super) doubles: bool,
}

impl<S: Seal> Airlink<S> {
    /// When there is something to say in a turn of this node's.
    pub(super) fn next_turn(&self) -> Option<Instant> {
        let counter = self.life.next()?;
        let due = |wave| {
            let ready = self.ready(wave);
            match self.open {
                Some(open) if open.turn.wave == wave && open.place < self.schedule.burst() => {
                    let at = self.begin(open.turn, counter, open.place, open.not_before);
                    if open.doubles || ready.is_some_and(|ready| ready <= at) {
                        return Some(at);
                    }
                }
                _ => {}
            }
            let turn = self.schedule.turn_from(wave, ready?.max(self.from), self.follow.phase());
            Some(self.begin(turn, counter, 0, turn.start))
        };
        [Wave::Outward, Wave::Inward].into_iter().filter_map(due).min()
    }

    /// The next packet's number, if this node may speak at `now`.
    pub(super) fn wake(&mut self, now: Instant) -> Option<Counter> {
        if let Life::Listening { until, next } = self.life {
            if now < until {
                return None;
            }
            self.life = Life::Member { since: now, next };
            self.follow.stop_below(self.identity.node);
        }
        self.life.next()
    }

    /// When the packet `place` of `turn` begins.
    fn begin(&self, turn: Turn, counter: Counter, place: u8, not_before: Instant) -> Instant {
        (turn.start + self.schedule.wait(counter, place)).max(not_before)
    }

    /// The turn and the place in it that `now` is right for.
    pub(super) fn turn(&mut self, now: Instant, counter: Counter) -> Option<(Turn, u8)> {
        let half = self.schedule.half_slot();
        let Some(turn) = self.schedule.turn_at(now, self.follow.phase()) else {
            self.from = self.from.max(now);
            self.open = None;
            return None;
        };
        // All turns before it are over, also one that has been begun.
        self.from = self.from.max(turn.start - half);
        self.open = self.open.filter(|open| {
            open.turn.wave == turn.wave
                && turn.start.max(open.turn.start).since(turn.start.min(open.turn.start)) < half
        });
        // The frame may have moved a little since.
        if self.open.is_none() && turn.start + half < self.from {
            return None;
        }
        let (turn, place, not_before) = self
            .open
            .map_or((turn, 0, turn.start), |open| (open.turn, open.place, open.not_before));
        let at = self.begin(turn, counter, place, not_before);
        if place >= self.schedule.burst() || now < at {
            return None;
        }
        if now > at + self.schedule.lateness() {
            if self.ready(turn.wave).is_some_and(|ready| ready <= at) {
                self.counters.missed = self.counters.missed.wrapping_add(1);
            }
            self.close(turn, now);
            return None;
        }
        Some((turn, place))
    }

    /// Nothing more is said in `turn`.
    pub(super) fn close(&mut self, turn: Turn, now: Instant) {
        let place = self.schedule.burst();
        self.begun(Open { turn, place, not_before: now, doubles: false });
    }

    /// A packet of `turn` goes out as `place`; the next may follow `not_before`.
    pub(super) fn said(&mut self, turn: Turn, place: u8, not_before: Instant, doubles: bool) {
        self.begun(Open { turn, place: place + 1, not_before, doubles });
    }

    fn begun(&mut self, open: Open) {
        self.from = self.from.max(open.turn.start + self.schedule.half_slot());
        self.open = Some(open);
    }

    /// From when on there is something to say in a turn of `wave`.
    fn ready(&self, wave: Wave) -> Option<Instant> {
        if matches!(self.life, Life::Leaving { .. }) {
            return Some(Instant::ZERO);
        }
        let membership = match (self.joins, self.refuses) {
            (true, _) => Some(Instant::ZERO),
            (false, Some((_, at))) => Some(at),
            (false, None) => None,
        };
        let report = self.report.as_ref().map(|_| Instant::ZERO);
        let end = match &self.end {
            End::Base(orders) => orders.ready(wave),
            End::Drone(teller) => teller.ready().filter(|_| wave == Wave::Inward),
        };
        let [commands, telemetry] = [self.commands.ready(wave), self.telemetry.ready(wave)];
        [membership, report, end, commands, telemetry, Some(self.beacon_at)]
            .into_iter()
            .flatten()
            .min()
    }
}

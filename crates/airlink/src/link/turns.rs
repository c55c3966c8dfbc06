//! The times of this node's transmissions: its next turn, and how far the present one has got.

use units::Instant;
use wire::p2p::{Counter, Wave};

use super::lifecycle::Lifecycle;
use super::{Airlink, End};
use crate::schedule::{FramePhase, Turn, Turns};
use crate::seal::Seal;

/// The turn in which this node has sent last, or that it has closed.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenTurn {
    turn: Turn,
    /// The place of the next packet in the turn.
    place: u8,
    /// The radio chip is busy until this moment.
    not_before: Instant,
    /// Whether the turn has begun with a command to the head, which is to be sent twice.
    pub(super) repeats_command: bool,
}

/// The counter of the packet `place` of `turn`, where `next` is the one after that of the last packet:
/// the first packet of a turn is stamped with the turn's beginning, and those after it follow.
/// `None` where counters have no room for that time.
pub(super) fn stamped(next: Counter, turn: Turn, place: u8) -> Option<Counter> {
    if place == 0 { next.stamped(turn.start) } else { Some(next) }
}

/// What a packet of another node can change of that on which a link's next turn depends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct TurnState {
    phase: FramePhase,
    queues: [u8; 2],
}

impl<S: Seal> Airlink<S> {
    /// The state from which it is seen whether a packet of another node has changed the next turn.
    /// An order or telemetry that has come to its end is put in a queue as well.
    pub(super) const fn turn_state(&self) -> TurnState {
        TurnState {
            phase: self.clock_sync.phase(),
            queues: [self.commands.changes(), self.telemetry.changes()],
        }
    }

    /// The next moment in a turn of this node at which it has a packet to send.
    pub(super) fn next_turn(&self) -> Option<Instant> {
        let counter = self.lifecycle.next()?;
        let any = self.any_message_due_at();
        let outward = self.next_turn_of(Wave::Outward, counter, any);
        let inward = self.next_turn_of(Wave::Inward, counter, any);
        Some(outward.min(inward))
    }

    /// The same of one wave, where a message for either wave is due from `any` on.
    fn next_turn_of(&self, wave: Wave, counter: Counter, any: Instant) -> Instant {
        let ready = self.earlier(any, wave);
        match self.open_turn {
            Some(open) if open.turn.wave == wave && open.place < self.schedule.burst() => {
                let at = self.packet_start(open.turn, counter, open.place, open.not_before);
                if open.repeats_command || ready <= at {
                    return at;
                }
            }
            _ => {}
        }
        let earliest = ready.max(self.no_turn_before);
        let turn = self.schedule.turn_from(wave, earliest, self.clock_sync.phase(), self.turns);
        self.packet_start(turn, counter, 0, turn.start)
    }

    /// The counter of the next packet, if this node may send at `now`. A node that has listened for
    /// long enough becomes a member here.
    pub(super) fn next_counter(&mut self, now: Instant) -> Option<Counter> {
        if let Lifecycle::Listening { until, next } = self.lifecycle {
            if now < until {
                return None;
            }
            self.lifecycle = Lifecycle::Member { since: now, next };
            self.clock_sync.unfollow_below(self.identity.node);
        }
        self.lifecycle.next()
    }

    /// The turns that this node may use at `now`. It shares those of other numbers once it has been
    /// a member for a while in which the chain was stretched.
    fn turns_at(&mut self, now: Instant) -> Turns {
        let alone = self.crowded_at.is_none_or(|at| now.since(at) > self.config.lost_after);
        let shares = alone && self.lifecycle.has_settled(now, self.config.lost_after);
        self.turns = if shares { Turns::Shared } else { Turns::Own };
        self.turns
    }

    /// The moment at which the packet `place` of `turn` begins.
    fn packet_start(
        &self,
        turn: Turn,
        counter: Counter,
        place: u8,
        not_before: Instant,
    ) -> Instant {
        let counter = stamped(counter, turn, place).unwrap_or(counter);
        (turn.start + self.schedule.wait(counter, place)).max(not_before)
    }

    /// The turn and the place in it of a packet that is sent at `now`; `None` if `now` is too early
    /// or too late for a packet.
    pub(super) fn turn_and_place(&mut self, now: Instant, counter: Counter) -> Option<(Turn, u8)> {
        let half = self.schedule.half_slot();
        let turns = self.turns_at(now);
        let Some(turn) = self.schedule.turn_at(now, self.clock_sync.phase(), turns) else {
            self.no_turn_before = self.no_turn_before.max(now);
            self.open_turn = None;
            return None;
        };
        // All earlier turns are over, even one that has been begun.
        self.no_turn_before = self.no_turn_before.max(turn.start - half);
        self.open_turn = self.open_turn.filter(|open| {
            open.turn.wave == turn.wave
                && turn.start.max(open.turn.start).since(turn.start.min(open.turn.start)) < half
        });
        // A turn that was closed seems to be a new one when the frame has moved a little since.
        if self.open_turn.is_none() && turn.start + half < self.no_turn_before {
            return None;
        }
        let (turn, place, not_before) = self
            .open_turn
            .map_or((turn, 0, turn.start), |open| (open.turn, open.place, open.not_before));
        let at = self.packet_start(turn, counter, place, not_before);
        if place >= self.schedule.burst() || now < at {
            return None;
        }
        if now > at + self.schedule.lateness() {
            if self.earlier(self.any_message_due_at(), turn.wave) <= at {
                self.counters.missed = self.counters.missed.wrapping_add(1);
            }
            self.close_turn(turn, now);
            return None;
        }
        Some((turn, place))
    }

    /// Ends `turn`, in which this node has nothing more to send.
    pub(super) fn close_turn(&mut self, turn: Turn, now: Instant) {
        let place = self.schedule.burst();
        self.set_open_turn(OpenTurn { turn, place, not_before: now, repeats_command: false });
    }

    /// Records that the packet `place` of `turn` is sent, and that the next may follow at
    /// `not_before`.
    pub(super) fn advance_turn(
        &mut self,
        turn: Turn,
        place: u8,
        not_before: Instant,
        repeats_command: bool,
    ) {
        self.set_open_turn(OpenTurn { turn, place: place + 1, not_before, repeats_command });
    }

    fn set_open_turn(&mut self, open: OpenTurn) {
        let half = self.schedule.half_slot();
        self.no_turn_before = self.no_turn_before.max(open.turn.start + half);
        self.open_turn = Some(open);
    }

    /// The time from which this node has a message to send that may go in either wave. There is
    /// always one, since the next beacon is.
    fn any_message_due_at(&self) -> Instant {
        let leaves = matches!(self.lifecycle, Lifecycle::Leaving { .. });
        if leaves || self.join_pending || self.report.is_some() || !self.missions.is_empty() {
            return Instant::ZERO;
        }
        match self.pending_refusal {
            Some((_, at)) => at.min(self.beacon_due_at),
            None => self.beacon_due_at,
        }
    }

    /// `any`, or the time from which this node has a command or telemetry to send in a turn of
    /// `wave`, whichever is earlier.
    fn earlier(&self, any: Instant, wave: Wave) -> Instant {
        if any == Instant::ZERO {
            return any;
        }
        let own = match &self.end {
            End::Base(orders) => orders.due_at(wave),
            End::Drone(sender) => sender.due_at().filter(|_| wave == Wave::Inward),
        };
        let sooner = |at: Instant, other: Option<Instant>| other.map_or(at, |other| at.min(other));
        let at = sooner(sooner(any, own), self.commands.due_at(wave));
        sooner(at, self.telemetry.due_at(wave))
    }
}

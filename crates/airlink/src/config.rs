//! How patient a node is.

use units::Duration;

/// What a link is built with. Every time is measured on the node's own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinkConfig {
    /// How often a capsule is said that nobody farther on is heard to say.
    pub tries: u8,
    /// Whether a command that is said for the first time is said twice, where the turn has room.
    pub doubles: bool,
    /// Whom nothing is heard of for as long is not named in reports and not followed.
    pub lost_after: Duration,
    /// A later epoch of somebody who was heard less than this ago is taken for a second node of its
    /// number.
    pub alive: Duration,
    /// Who has spoken for as long keeps its number against a newcomer.
    pub settles_after: Duration,
    /// What was heard of a far end counts no more after as long without another word of it.
    pub forgets_after: Duration,
    /// Time between commands to the head: the pilot's stick.
    pub stick_every: Duration,
    /// What the operator said to the head this long ago is not said any more, if it is to fly.
    pub stick_lasts: Duration,
    /// Time that telemetry has to say that a new task is heeded.
    pub again_after: Duration,
    /// Time after which the next of those who do not say so is told again.
    pub again_every: Duration,
    /// Time after which the next node in turn is told once more what it has heeded before.
    pub remind_every: Duration,
    /// Time between beacons.
    pub beacon_every: Duration,
    /// Time between telemetry, of a relay.
    pub telemetry_every: Duration,
    /// Time between telemetry, of the head.
    pub head_telemetry_every: Duration,
}

impl LinkConfig {
    /// What was measured to be good (`tests/suite/delay.rs`).
    pub const DEFAULT: Self = Self {
        // A hop fails once in 1,000 at 50 % loss, once in 35 at 70 %. Few are needed: whoever has
        // heard it farther on stops. With 4 the stick's delay over 8 hops, 95th percentile, was 0.9 s
        // at 50 % and 12 s at 70 %; with 10 it is 0.7 s and 1.5 s, over 15 hops 1.1 s and 3.1 s, and
        // the air is 6 % and 12 % full. More do not help: at 70 % all turns are taken.
        tries: 10,
        // Brings that delay at 20 % loss from 0.46 to 0.28 s.
        doubles: true,
        // 10 reports, 2 beacons; `chain` counts a neighbour as lost at about that time.
        lost_after: Duration::from_secs(2),
        // 5 reports: all lost at 20 % once in 3,000. Whoever is back sooner after a reboot is let
        // in when that time is over.
        alive: Duration::from_secs(1),
        settles_after: Duration::from_secs(2),
        // Three times as long as one node says anything: its tries, one in a frame.
        forgets_after: Duration::from_secs(3),
        // The agent's round (design: 5 Hz).
        stick_every: Duration::from_millis(200),
        // Two rounds and a half: one lost word is bridged, a dead console is not.
        stick_lasts: Duration::from_millis(500),
        // There and back over 15 hops at 20 % loss, mostly. What is said anew sooner overtakes what
        // is still on its way: with 0.4 s it took 16 nodes 0.3 s longer to stop.
        again_after: Duration::from_secs(1),
        // One in a frame leaves room for their answers.
        again_every: Duration::from_millis(100),
        remind_every: Duration::from_secs(1),
        beacon_every: Duration::from_secs(1),
        telemetry_every: Duration::from_secs(1),
        head_telemetry_every: Duration::from_millis(500),
    };
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

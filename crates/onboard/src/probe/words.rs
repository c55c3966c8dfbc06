//! Values as the words of a slot: how each type that an agent takes or gives is written and read.

use core::sync::atomic::{AtomicU32, Ordering};

use agent::{
    BodyVelocity, ChainDuty, Duty, Fitness, LandReason, LinkView, Outputs, Reckoning, State,
    Status as AgentStatus,
};
use chain::neighbours::Heard;
use chain::report::Report;
use chain::search::{Leg, Place, Search};
use flight::{Attitude, Battery, Cause, Mode, NotReady, Status, StopCause};
use tunnel_nav::{Diagonals, Range, Side, Walls};
use units::{
    Dbm, Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond, NodeId, Order,
    Phase, Point2, Pose2, Radians, RadiansPerSecond, Setpoint, Volts,
};

/// Writes words into a slot. Words beyond its end are lost, which shows in the length.
pub(super) struct Writer<'a> {
    words: &'a [AtomicU32],
    length: usize,
}

impl<'a> Writer<'a> {
    /// A writer at the beginning of a slot's words.
    pub(super) const fn new(words: &'a [AtomicU32]) -> Self {
        Self { words, length: 0 }
    }

    /// How many words were written, with those that were lost.
    pub(super) const fn length(&self) -> usize {
        self.length
    }

    pub(super) fn word(&mut self, word: u32) {
        if let Some(place) = self.words.get(self.length) {
            place.store(word, Ordering::Relaxed);
        }
        self.length += 1;
    }
}

/// Words that were read from a slot.
pub(super) struct Reader<'a>(&'a [u32]);

impl Reader<'_> {
    pub(super) fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*word)
    }
}

/// The value that all of these words are; `None` where they are not one, or more than it.
pub(super) fn whole<T>(words: &[u32], get: impl FnOnce(&mut Reader<'_>) -> Option<T>) -> Option<T> {
    let mut reader = Reader(words);
    get(&mut reader).filter(|_| reader.0.is_empty())
}

/// A value that is written as words.
pub(super) trait Words: Sized {
    fn put(&self, out: &mut Writer<'_>);
    fn get(from: &mut Reader<'_>) -> Option<Self>;
}

impl Words for u64 {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(*self as u32);
        out.word((*self >> 32) as u32);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        Some(Self::from(from.word()?) | Self::from(from.word()?) << 32)
    }
}

impl Words for u16 {
    fn put(&self, out: &mut Writer<'_>) {
        out.word((*self).into());
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        from.word()?.try_into().ok()
    }
}

impl Words for f32 {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(self.to_bits());
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        from.word().map(Self::from_bits)
    }
}

impl Words for bool {
    fn put(&self, out: &mut Writer<'_>) {
        out.word((*self).into());
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        match from.word()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Words> Words for Option<T> {
    fn put(&self, out: &mut Writer<'_>) {
        self.is_some().put(out);
        if let Some(value) = self {
            value.put(out);
        }
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        if bool::get(from)? { T::get(from).map(Some) } else { Some(None) }
    }
}

impl<T: Words> Words for [T; 2] {
    fn put(&self, out: &mut Writer<'_>) {
        self.iter().for_each(|value| value.put(out));
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        Some([T::get(from)?, T::get(from)?])
    }
}

impl Words for NodeId {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(self.0.into());
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        from.word()?.try_into().ok().map(Self)
    }
}

impl Words for Instant {
    fn put(&self, out: &mut Writer<'_>) {
        self.as_micros().put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        u64::get(from).map(Self::from_micros)
    }
}

impl Words for Duration {
    fn put(&self, out: &mut Writer<'_>) {
        self.as_micros().put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        u64::get(from).map(Self::from_micros)
    }
}

impl Words for u8 {
    fn put(&self, out: &mut Writer<'_>) {
        out.word((*self).into());
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        from.word()?.try_into().ok()
    }
}

/// Quantities, each one float.
macro_rules! quantities {
    ($($name:ident),*) => {
        $(impl Words for $name {
            fn put(&self, out: &mut Writer<'_>) {
                self.0.put(out);
            }

            fn get(from: &mut Reader<'_>) -> Option<Self> {
                f32::get(from).map(Self)
            }
        })*
    };
}

/// Structs by their fields.
macro_rules! structs {
    ($($name:ident { $($field:ident),* })*) => {
        $(impl Words for $name {
            fn put(&self, out: &mut Writer<'_>) {
                let Self { $($field),* } = self;
                $($field.put(out);)*
            }

            fn get(from: &mut Reader<'_>) -> Option<Self> {
                $(let $field = Words::get(from)?;)*
                Some(Self { $($field),* })
            }
        })*
    };
}

/// Enums by the numbers of their variants.
macro_rules! enums {
    ($($name:ident {
        $($code:literal = $variant:ident $(($value:ident))? $({ $($field:ident),* })?),* $(,)?
    })*) => {
        $(impl Words for $name {
            fn put(&self, out: &mut Writer<'_>) {
                match self {
                    $(Self::$variant $(($value))? $({ $($field),* })? => {
                        out.word($code);
                        $($value.put(out);)?
                        $($($field.put(out);)*)?
                    })*
                }
            }

            fn get(from: &mut Reader<'_>) -> Option<Self> {
                Some(match from.word()? {
                    $($code => {
                        $(let $value = Words::get(from)?;)?
                        $($(let $field = Words::get(from)?;)*)?
                        Self::$variant $(($value))? $({ $($field),* })?
                    })*
                    _ => return None,
                })
            }
        })*
    };
}

quantities! { Dbm, Metres, MetresPerDb, MetresPerSecond, Radians, RadiansPerSecond, Volts }

structs! {
    BodyVelocity { forward, lateral }
    Diagonals { nw, ne, sw, se }
    LinkSpan { weakest, strongest }
    LinkSum { surplus, compliance, links }
    Place { way, weaker }
    Search { from, best, leg, since }
    Report { from, sequence, phase, velocity, odometer, links, sums, waiting, head_velocity, recall }
    Heard { report, rssi, reverse }
    LinkView { peer, raw, rssi, velocity, is_base }
    Point2 { x, y }
    Pose2 { at, yaw }
    Reckoning { odometer, pose }
    AgentStatus { state, front, back, here, walls }
    Outputs { setpoint, report, status }
    Attitude { roll, pitch, yaw }
    Battery { volts, endurance }
    Status { mode, attitude, velocity, height, battery }
}

enums! {
    Range { 0 = At(distance), 1 = Clear, 2 = Invalid }
    Walls { 0 = Both, 1 = One(side), 2 = Neither }
    Side { 0 = Left, 1 = Right }
    Phase { 0 = Waiting, 1 = Transit, 2 = Linked, 3 = Base, 4 = Out, 5 = Searching }
    Order { 0 = Wait, 1 = Explore(speed), 2 = Return, 3 = Land, 4 = Stop }
    Setpoint { 0 = Off, 1 = Fly { forward, lateral, yaw_rate, height }, 2 = Stop }
    Fitness { 0 = Fit, 1 = Unfit, 2 = Landing(why), 3 = Landed(why), 4 = Stopped }
    LandReason {
        0 = Ordered, 1 = Home, 2 = TakeOffFailed, 3 = LinkLost, 4 = Unfit(why), 5 = Restarted,
        6 = Retired,
    }
    State {
        0 = Idle,
        1 = Armed { since },
        2 = TakingOff { since },
        3 = OnMission(duty),
        4 = Landing { since, why },
        5 = Landed { why },
        6 = Stopped,
    }
    Duty { 0 = Chain(duty) }
    ChainDuty {
        0 = Leading { patient_until },
        1 = Relaying { patient_until },
        2 = Reconnecting { since, from },
        3 = Searching { search },
        4 = Retiring,
        5 = BackingUp { since, from },
    }
    Leg { 0 = Ahead, 1 = Behind, 2 = ToBest, 3 = Back }
    Mode {
        0 = Grounded { waits_for },
        1 = Flying { since },
        2 = Landing { since, why },
        3 = Landed { why },
        4 = Stopped { why },
    }
    NotReady {
        0 = NoImu, 1 = Calibrating, 2 = Tilted, 3 = NoFlow, 4 = NoHeight, 5 = NoBattery,
        6 = BatteryLow,
    }
    Cause {
        0 = NoSetpoint, 1 = NoImu, 2 = NoFlow, 3 = NoHeight, 4 = Battery, 5 = Overload, 6 = Blocked,
    }
    StopCause { 0 = Ordered, 1 = Tumbled, 2 = FreeFall, 3 = PropellerStuck }
}

//! Writes and reads values as words of 32 bits: each type that an agent takes or gives, for the
//! [probe](crate::probe) and for a [replay](crate::replay).
//!
//! A number or the bits of a float takes one word, a moment two; an `Option` has a word 0 or 1 before
//! its value, an enum the number of its variant before the variant's fields; a struct is its fields in
//! the order of the lists below.

use core::sync::atomic::{AtomicU32, Ordering};

use agent::{
    BodyVelocity, ChainDuty, Duty, ExploreDuty, Fitness, LandReason, LinkView, Located, Outputs,
    Reckoning, State, Status as AgentStatus, SwarmDuty, Told,
};
use chain::filter::LinkEstimate;
use chain::neighbours::Heard;
use chain::report::Report;
use chain::search::{Leg, Place, Search};
use flight::{Attitude, Battery, Cause, Mode, NotReady, Status, StopCause};
use heapless::Vec;
use tunnel_nav::{Diagonals, Range, Side, Walls};
use units::{
    Branch, Course, DbPerMetre, Dbm, Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerDb,
    MetresPerSecond, NodeId, Order, Payload, Phase, Point2, PolicyCode, Pose2, Radians,
    RadiansPerSecond, Role, Setpoint, Signpost, Volts,
};

/// Writes words into the memory of a slot or of a frame. Words beyond its end are lost, which shows in
/// the length. The words are atomic for the probe's sake, which is a static.
pub(crate) struct Writer<'a> {
    words: &'a [AtomicU32],
    length: usize,
}

impl<'a> Writer<'a> {
    /// A writer at the beginning of a slot's words.
    pub(crate) const fn new(words: &'a [AtomicU32]) -> Self {
        Self { words, length: 0 }
    }

    /// How many words were written, with those that were lost.
    pub(crate) const fn length(&self) -> usize {
        self.length
    }

    pub(crate) fn word(&mut self, word: u32) {
        if let Some(place) = self.words.get(self.length) {
            place.store(word, Ordering::Relaxed);
        }
        self.length += 1;
    }
}

/// Words that were read from a slot or a frame.
pub(crate) struct Reader<'a>(&'a [u32]);

impl Reader<'_> {
    pub(crate) fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*word)
    }
}

/// The value that all of these words are; `None` where they are not one, or more than it.
pub(crate) fn whole<T>(words: &[u32], get: impl FnOnce(&mut Reader<'_>) -> Option<T>) -> Option<T> {
    let mut reader = Reader(words);
    get(&mut reader).filter(|_| reader.0.is_empty())
}

/// A value that is written as words.
pub(crate) trait Words: Sized {
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

/// A list by its length and its values.
impl<T: Words, const N: usize> Words for Vec<T, N> {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(self.len() as u32);
        self.iter().for_each(|value| value.put(out));
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        let count = from.word()? as usize;
        let mut list = Self::new();
        // A list that is too long for this one ends at its first value without a place.
        for _ in 0..count {
            list.push(T::get(from)?).ok()?;
        }
        Some(list)
    }
}

impl<A: Words, B: Words> Words for (A, B) {
    fn put(&self, out: &mut Writer<'_>) {
        self.0.put(out);
        self.1.put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        Some((A::get(from)?, B::get(from)?))
    }
}

impl Words for u32 {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(*self);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        from.word()
    }
}

impl Words for PolicyCode {
    fn put(&self, out: &mut Writer<'_>) {
        self.get().put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        u8::get(from).and_then(Self::new)
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
        $(impl $crate::words::Words for $name {
            fn put(&self, out: &mut $crate::words::Writer<'_>) {
                let Self { $($field),* } = self;
                $($field.put(out);)*
            }

            fn get(from: &mut $crate::words::Reader<'_>) -> Option<Self> {
                $(let $field = $crate::words::Words::get(from)?;)*
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
        $(impl $crate::words::Words for $name {
            fn put(&self, out: &mut $crate::words::Writer<'_>) {
                match self {
                    $(Self::$variant $(($value))? $({ $($field),* })? => {
                        out.word($code);
                        $($value.put(out);)?
                        $($($field.put(out);)*)?
                    })*
                }
            }

            fn get(from: &mut $crate::words::Reader<'_>) -> Option<Self> {
                Some(match from.word()? {
                    $($code => {
                        $(let $value = $crate::words::Words::get(from)?;)?
                        $($(let $field = $crate::words::Words::get(from)?;)*)?
                        Self::$variant $(($value))? $({ $($field),* })?
                    })*
                    _ => return None,
                })
            }
        })*
    };
}

pub(crate) use {enums, structs};

quantities! { DbPerMetre, Dbm, Metres, MetresPerDb, MetresPerSecond, Radians, RadiansPerSecond, Volts }

structs! {
    Course { speed, branch }
    BodyVelocity { forward, lateral }
    Diagonals { nw, ne, sw, se }
    LinkSpan { weakest, strongest }
    LinkSum { surplus, compliance, links }
    Place { way, weaker }
    Search { from, best, leg, since }
    Heard { report, rssi, reverse }
    LinkView { peer, raw, rssi, velocity, is_base }
    Point2 { x, y }
    Pose2 { at, yaw }
    Located { pose, deviation }
    Told { from, at, rssi, payload }
    Reckoning { odometer, pose }
    AgentStatus { state, front, back, here, walls }
    Outputs { setpoint, report, status }
    LinkEstimate { rssi, variance, slopes }
    Attitude { roll, pitch, yaw }
    Battery { volts, endurance }
    Status { mode, attitude, velocity, height, battery }
}

/// The length, and four bytes in each word.
impl Words for Payload {
    fn put(&self, out: &mut Writer<'_>) {
        out.word(self.as_bytes().len() as u32);
        for bytes in self.as_bytes().chunks(4) {
            let mut word = [0; 4];
            word.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
            out.word(u32::from_le_bytes(word));
        }
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        let length = from.word()? as usize;
        let mut bytes = [0; Self::MOST];
        for part in bytes.get_mut(..length)?.chunks_mut(4) {
            let word = from.word()?.to_le_bytes();
            part.iter_mut().zip(word).for_each(|(to, from)| *to = from);
        }
        Self::new(bytes.get(..length)?)
    }
}

/// The marks are the lowest bits of one word, since a round has 31 reports.
impl Words for Report {
    fn put(&self, out: &mut Writer<'_>) {
        let Self { from, sequence, phase, velocity, odometer, links, sums, waiting, .. } = self;
        let Self { head_velocity, recall, calls, is_uneven, signpost, .. } = self;
        from.put(out);
        sequence.put(out);
        phase.put(out);
        velocity.put(out);
        odometer.put(out);
        links.put(out);
        sums.put(out);
        waiting.put(out);
        head_velocity.put(out);
        out.word(u32::from(*recall) | u32::from(*calls) << 1 | u32::from(*is_uneven) << 2);
        signpost.put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        let mut report = Self {
            from: Words::get(from)?,
            sequence: Words::get(from)?,
            phase: Words::get(from)?,
            velocity: Words::get(from)?,
            odometer: Words::get(from)?,
            links: Words::get(from)?,
            sums: Words::get(from)?,
            waiting: Words::get(from)?,
            head_velocity: Words::get(from)?,
            recall: false,
            calls: false,
            is_uneven: false,
            signpost: None,
        };
        let marks = from.word().filter(|marks| *marks < 1 << 3)?;
        let [recall, calls, is_uneven] = [0, 1, 2].map(|bit| marks >> bit & 1 == 1);
        report.signpost = Words::get(from)?;
        Some(Self { recall, calls, is_uneven, ..report })
    }
}

/// Two words, since a round has one in each report: the small numbers are bytes of the first.
impl Words for Signpost {
    fn put(&self, out: &mut Writer<'_>) {
        let branch = Branch::code(self.branch);
        out.word(u32::from_le_bytes([self.revision, self.index, self.count, branch]));
        self.from.put(out);
    }

    fn get(from: &mut Reader<'_>) -> Option<Self> {
        let [revision, index, count, branch] = from.word()?.to_le_bytes();
        let branch = Branch::from_code(branch)?;
        Some(Self { revision, index, count, from: Words::get(from)?, branch })
    }
}

enums! {
    Branch { 0 = Left, 1 = Right, 2 = Straight }
    Range { 0 = At(distance), 1 = Clear, 2 = Invalid }
    Walls { 0 = Both, 1 = One(side), 2 = Neither }
    Side { 0 = Left, 1 = Right }
    Role { 0 = Head, 1 = Relay, 2 = Base }
    Phase { 0 = Waiting, 1 = Transit, 2 = Linked, 3 = Base, 4 = Out, 5 = Searching, 6 = Perched }
    Order { 0 = Wait, 1 = Explore(course), 2 = Return, 3 = Land, 4 = Stop, 5 = Perch }
    Setpoint { 0 = Off, 1 = Fly { forward, lateral, yaw_rate, height }, 2 = Stop }
    Fitness { 0 = Fit, 1 = Unfit, 2 = Landing(why), 3 = Landed(why), 4 = Stopped }
    LandReason {
        0 = Ordered, 1 = Home, 2 = TakeOffFailed, 3 = LinkLost, 4 = Unfit(why), 5 = Restarted,
        6 = Retired, 7 = Perched, 8 = PositionLost,
        9 = Done,
    }
    State {
        0 = Idle,
        1 = Armed { since },
        2 = TakingOff { since },
        3 = OnMission(duty),
        4 = Landing { since, why },
        5 = Landed { why },
        6 = Stopped,
        7 = Perched,
        8 = Rising { since },
    }
    Duty { 0 = Chain(duty), 1 = Swarm(duty), 2 = Explore(duty) }
    SwarmDuty {
        0 = Hovering { since },
        1 = Surveying,
        2 = Gathering,
        3 = Crossing,
        4 = Returning,
    }
    ExploreDuty { 0 = Lost { since }, 1 = Waiting, 2 = Exploring { goal }, 3 = Returning { has_seen_all } }
    ChainDuty {
        0 = Leading { patient_until },
        1 = Relaying { patient_until },
        2 = Reconnecting { since, from },
        3 = Searching { search },
        4 = Retiring,
        5 = BackingUp { since, from },
        6 = Rejoining { since, to, passed },
        7 = Siting { since },
        8 = Homing,
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

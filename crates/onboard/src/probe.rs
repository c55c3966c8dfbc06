//! Defines the probe: a static of fixed layout in which a firmware shows the inputs and decisions
//! of its drone to an emulator or a debugger.
//!
//! | field | what | words |
//! |---|---|---|
//! | `version` | [`VERSION`], once the firmware has begun | 1 |
//! | `flight` | a [`Slot`] with the flight code's [`Status`], after each of its steps | 2 and [`FLIGHT`] |
//! | `order` | a [`Slot`] with the number of the last order that the link has brought | 2 and [`ORDER`] |
//! | `round` | a [`Slot`] with the [`Round`] that the agent made last | 2 and [`ROUND`] |
//!
//! A slot begins with a count, which is odd while the slot is being written and grows by two each
//! time, and with the number of words that follow. The module
//! `words` defines how values become words.

use core::mem::offset_of;
use core::sync::atomic::{AtomicU32, Ordering};

use agent::{BodyVelocity, Fitness, Inputs, Located, Outputs, Told};
use chain::neighbours::Heard;
use flight::Status;
use heapless::Vec;
use tunnel_nav::Diagonals;
use units::{Duration, Instant, Metres, Order, Radians};
use wire::p2p::Counter;

use crate::mailbox::{REPORTS, TOLD};
use crate::words::{Reader, Words, Writer, whole};

/// The name of the probe's symbol.
pub const SYMBOL: &str = "UCHAIN_PROBE";
/// The version of the layout.
pub const VERSION: u32 = 7;

/// Words of the flight code's status at most.
pub const FLIGHT: usize = 20;
/// Words of an order's number.
pub const ORDER: usize = 2;
/// Words of a round at most.
pub const ROUND: usize = 92 + REPORTS * 24 + TOLD * 16;

/// The probe, as it lies in memory.
#[repr(C)]
#[derive(Debug)]
pub struct Probe {
    version: AtomicU32,
    flight: Slot<FLIGHT>,
    order: Slot<ORDER>,
    round: Slot<ROUND>,
}

impl Default for Probe {
    fn default() -> Self {
        Self::new()
    }
}

impl Probe {
    /// The offset of the slot `flight`, in bytes from the probe's beginning.
    pub const FLIGHT_AT: usize = offset_of!(Self, flight);
    /// See [`FLIGHT_AT`](Self::FLIGHT_AT).
    pub const ORDER_AT: usize = offset_of!(Self, order);
    /// See [`FLIGHT_AT`](Self::FLIGHT_AT).
    pub const ROUND_AT: usize = offset_of!(Self, round);

    /// A probe that shows nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            version: AtomicU32::new(0),
            flight: Slot::new(),
            order: Slot::new(),
            round: Slot::new(),
        }
    }

    /// Shows the version of the layout, from then on. Until then it is 0, so that a probe takes no
    /// room in flash.
    pub fn begin(&self) {
        self.version.store(VERSION, Ordering::Relaxed);
    }

    /// Shows the status of the flight code.
    pub fn show_flight(&self, status: &Status) {
        self.flight.write(|out| status.put(out));
    }

    /// Shows the number of an order that the link has brought.
    pub fn show_order(&self, counter: Counter) {
        let number = u64::from(counter.epoch().get()) << 24 | u64::from(counter.count());
        self.order.write(|out| number.put(out));
    }

    /// Shows the inputs and outputs of the agent.
    pub fn show_round(&self, now: Instant, inputs: &Inputs<'_>, outputs: &Outputs) {
        self.round.write(|out| {
            now.put(out);
            put_inputs(inputs, out);
            outputs.put(out);
        });
    }
}

/// A value and how often it was written.
#[repr(C)]
#[derive(Debug)]
pub struct Slot<const N: usize> {
    count: AtomicU32,
    length: AtomicU32,
    words: [AtomicU32; N],
}

impl<const N: usize> Slot<N> {
    const fn new() -> Self {
        Self {
            count: AtomicU32::new(0),
            length: AtomicU32::new(0),
            words: [const { AtomicU32::new(0) }; N],
        }
    }

    fn write(&self, put: impl FnOnce(&mut Writer<'_>)) {
        // There is one writer of each slot, and a reader has stopped the processor.
        let count = self.count.load(Ordering::Relaxed).wrapping_add(1);
        self.count.store(count, Ordering::SeqCst);
        let mut writer = Writer::new(&self.words);
        put(&mut writer);
        self.length.store(writer.length() as u32, Ordering::SeqCst);
        self.count.store(count.wrapping_add(1), Ordering::SeqCst);
    }
}

/// One round of an agent, as it was read from a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// The time of the round, by the drone's clock.
    pub now: Instant,
    /// The inputs of the agent.
    pub inputs: OwnedInputs,
    /// The outputs of the agent.
    pub outputs: Outputs,
}

/// The inputs of an agent: [`Inputs`] that own the reports and messages that were heard.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "as in agent::Inputs")]
pub struct OwnedInputs {
    pub ranges: Diagonals,
    pub velocity: Option<BodyVelocity>,
    pub heading: Option<Radians>,
    pub height: Option<Metres>,
    pub order: Option<Order>,
    pub fitness: Fitness,
    pub endurance: Option<Duration>,
    pub located: Option<Located>,
    pub heard: Vec<Heard, REPORTS>,
    pub told: Vec<Told, TOLD>,
}

impl OwnedInputs {
    /// The inputs as the agent takes them.
    #[must_use]
    pub fn borrow(&self) -> Inputs<'_> {
        Inputs {
            ranges: self.ranges,
            velocity: self.velocity,
            heading: self.heading,
            height: self.height,
            heard: &self.heard,
            located: self.located,
            told: &self.told,
            order: self.order,
            fitness: self.fitness,
            endurance: self.endurance,
        }
    }
}

/// The flight code's status by the words of its slot.
#[must_use]
pub fn flight(words: &[u32]) -> Option<Status> {
    whole(words, Status::get)
}

/// The number of the last order by the words of its slot: the epoch, and 24 bits of count.
#[must_use]
pub fn order(words: &[u32]) -> Option<u64> {
    whole(words, u64::get)
}

/// A round by the words of its slot.
#[must_use]
pub fn round(words: &[u32]) -> Option<Round> {
    whole(words, |from| {
        Some(Round {
            now: Instant::get(from)?,
            inputs: get_inputs(from)?,
            outputs: Outputs::get(from)?,
        })
    })
}

fn put_inputs(inputs: &Inputs<'_>, out: &mut Writer<'_>) {
    inputs.ranges.put(out);
    inputs.velocity.put(out);
    inputs.heading.put(out);
    inputs.height.put(out);
    inputs.order.put(out);
    inputs.fitness.put(out);
    inputs.endurance.put(out);
    inputs.located.put(out);
    out.word(inputs.heard.len() as u32);
    inputs.heard.iter().for_each(|heard| heard.put(out));
    out.word(inputs.told.len() as u32);
    inputs.told.iter().for_each(|told| told.put(out));
}

fn get_inputs(from: &mut Reader<'_>) -> Option<OwnedInputs> {
    Some(OwnedInputs {
        ranges: Diagonals::get(from)?,
        velocity: Option::get(from)?,
        heading: Option::get(from)?,
        height: Option::get(from)?,
        order: Option::get(from)?,
        fitness: Fitness::get(from)?,
        endurance: Option::get(from)?,
        located: Option::get(from)?,
        heard: Vec::get(from)?,
        told: Vec::get(from)?,
    })
}

#[cfg(test)]
mod tests {
    use agent::{ChainDuty, Duty, LinkView, Reckoning, State, Status as AgentStatus};
    use chain::report::Report;
    use chain::search::{Place, Search};
    use flight::{Attitude, Battery, Cause, Mode};
    use tunnel_nav::{Range, Side, Walls};
    use units::{
        Branch, Course, Dbm, LinkSpan, LinkSum, MetresPerDb, MetresPerSecond, NodeId, Payload,
        Phase, Point2, Pose2, RadiansPerSecond, Setpoint, Signpost, Volts,
    };
    use wire::p2p::Epoch;

    use super::*;

    fn read<const N: usize>(slot: &Slot<N>) -> std::vec::Vec<u32> {
        let length = slot.length.load(Ordering::Relaxed) as usize;
        assert!(length <= N, "{length} words in a slot of {N}");
        slot.words[..length].iter().map(|word| word.load(Ordering::Relaxed)).collect()
    }

    /// The longest round there is comes back as it went, to the last bit.
    #[test]
    fn the_longest_round_comes_back_as_it_went() {
        let sum = LinkSum { surplus: Metres(-7.7), compliance: MetresPerDb(1.3), links: u8::MAX };
        let branch = Some(Branch::Right);
        let signpost = Signpost { revision: 3, index: 1, count: 2, from: Metres(8.5), branch };
        let report = Report {
            from: NodeId(7),
            sequence: u16::MAX,
            phase: Phase::Linked,
            velocity: MetresPerSecond(-0.1),
            odometer: Metres(3.3),
            links: Some(LinkSpan { weakest: Dbm(-70.5), strongest: Dbm(-50.1) }),
            sums: [sum; 2],
            waiting: 3,
            head_velocity: MetresPerSecond(0.2),
            signpost: Some(signpost),
            recall: true,
            calls: true,
            is_uneven: true,
        };
        let heard = [Heard { report, rssi: Some(Dbm(-61.7)), reverse: Some(Dbm(-62.9)) }; REPORTS];
        let payload = Payload::new(&[7; Payload::MOST]).unwrap();
        let at = Instant::from_micros(1 << 33);
        let told = [Told { from: NodeId(3), at, rssi: Dbm(-70.5), payload }; TOLD];
        let pose = Pose2 { at: Point2::new(1.5, -0.25), yaw: Radians(0.75) };
        let speed = MetresPerSecond(0.3);
        let inputs = Inputs {
            ranges: Diagonals {
                nw: Range::At(Metres(1.1)),
                ne: Range::At(Metres(0.2)),
                sw: Range::Clear,
                se: Range::Invalid,
            },
            velocity: Some(BodyVelocity { forward: speed, lateral: MetresPerSecond(-0.0) }),
            heading: Some(Radians(-3.1)),
            height: Some(Metres(0.31)),
            located: Some(Located { pose, deviation: Metres(0.01) }),
            told: &told,
            heard: &heard,
            order: Some(Order::Explore(Course { speed, branch })),
            fitness: Fitness::Landing(Cause::Overload),
            endurance: Some(Duration::from_micros(u64::MAX)),
        };
        let link = LinkView {
            peer: NodeId(3),
            raw: Dbm(-63.0),
            rssi: Dbm(-62.25),
            velocity: speed,
            is_base: true,
        };
        let since = Instant::from_micros(1 << 40);
        let place = Place { way: Metres(9.0), weaker: Dbm(-71.5) };
        let search = Search::begin(since, place);
        let state = State::OnMission(Duty::Chain(ChainDuty::Searching { search }));
        let walls = Walls::One(Side::Left);
        let (front, back) = (Some(link), Some(link));
        let setpoint = Setpoint::Fly {
            forward: speed,
            lateral: speed,
            yaw_rate: RadiansPerSecond(0.5),
            height: Metres(0.3),
        };
        let here = Reckoning { odometer: Metres(-1.0), pose };
        let outputs =
            Outputs { setpoint, report, status: AgentStatus { state, front, back, here, walls } };
        let probe = Probe::new();
        probe.show_round(since, &inputs, &outputs);
        let back = round(&read(&probe.round)).unwrap();
        assert_eq!((back.now, &back.outputs), (since, &outputs));
        assert_eq!(std::format!("{:?}", back.inputs.borrow()), std::format!("{inputs:?}"));
        assert_eq!(probe.round.count.load(Ordering::Relaxed), 2);
    }

    #[test]
    fn a_status_comes_back_as_it_went() {
        let status = Status {
            mode: Mode::Landing { since: Instant::from_micros(1), why: Cause::Blocked },
            attitude: Attitude { roll: Radians(0.1), pitch: Radians(-0.2), yaw: Radians(3.0) },
            velocity: Some([MetresPerSecond(0.1), MetresPerSecond(0.2)]),
            height: Some(Metres(0.3)),
            battery: Battery { volts: Volts(3.7), endurance: Some(Duration::from_secs(200)) },
        };
        let probe = Probe::new();
        probe.show_flight(&status);
        let epoch = Epoch::new(1 << 9).unwrap();
        probe.show_order(Counter::new(epoch, 5).unwrap());
        assert_eq!(flight(&read(&probe.flight)), Some(status));
        assert_eq!(order(&read(&probe.order)), Some(1 << 33 | 5));
        let words = read(&probe.flight);
        assert_eq!(flight(&words[..words.len() - 1]), None);
    }
}

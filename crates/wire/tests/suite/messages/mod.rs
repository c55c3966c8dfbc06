//! Messages to test with: any of them, of numbers as they fly or of any bits.
#![allow(dead_code, unreachable_pub, missing_docs)]

use proptest::prelude::*;
use units::{
    Branch, Course, Dbm, Duration, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond,
    MissionKind, NodeId, Order, Payload, Phase, Role, SIGNPOSTS, Signpost, Volts,
};
use wire::p2p::{
    Beacon, Capsule, Commands, Counter, Epoch, HEARD, Header, Heard, Kind, Membership, Message,
    MissionMessage, REUSE, Report, TAG, Telemetry, Wave,
};

/// A report of which nothing is worth saying.
pub const SILENT: Report = Report {
    phase: Phase::Waiting,
    recall: false,
    calls: false,
    is_uneven: false,
    velocity: MetresPerSecond(0.0),
    odometer: Metres(0.0),
    links: None,
    sums: [LinkSum::NONE; 2],
    waiting: 0,
    head_velocity: MetresPerSecond(0.0),
    signpost: None,
    heard: heapless::Vec::new(),
};

/// Where the numbers of a message come from.
#[derive(Clone, Copy)]
pub enum Numbers {
    /// In the range of their type.
    Flying,
    /// Any bits, and often those of no number.
    Wild,
}

impl Numbers {
    fn of(self, range: std::ops::Range<f32>) -> BoxedStrategy<f32> {
        let none = prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e30]);
        match self {
            Self::Flying => range.boxed(),
            Self::Wild => {
                prop_oneof![2 => range, 2 => any::<u32>().prop_map(f32::from_bits), 1 => none]
                    .boxed()
            }
        }
    }

    fn powers(self) -> BoxedStrategy<Dbm> {
        self.of(-127.0..0.0).prop_map(Dbm).boxed()
    }

    fn nodes(self) -> BoxedStrategy<NodeId> {
        match self {
            Self::Flying => (0_u8..16).prop_map(NodeId).boxed(),
            Self::Wild => any::<u8>().prop_map(NodeId).boxed(),
        }
    }

    fn voltages(self) -> BoxedStrategy<Option<Volts>> {
        prop::option::of(self.of(0.02..5.1).prop_map(Volts)).boxed()
    }

    fn speeds(self) -> BoxedStrategy<MetresPerSecond> {
        self.of(-32.0..32.0).prop_map(MetresPerSecond).boxed()
    }
}

pub fn epochs() -> impl Strategy<Value = Epoch> {
    (1_u32..1 << 24).prop_map(|epoch| Epoch::new(epoch).unwrap())
}

pub fn counters() -> impl Strategy<Value = Counter> {
    (1_u32..1 << 24, 0_u32..1 << 24)
        .prop_map(|(epoch, count)| Counter::new(Epoch::new(epoch).unwrap(), count).unwrap())
}

pub fn headers(numbers: Numbers) -> impl Strategy<Value = Header> {
    let wave = prop::sample::select(&[Wave::Outward, Wave::Inward]);
    (prop::sample::select(&Kind::ALL), numbers.nodes(), wave, 0_u8..8, counters()).prop_map(
        |(kind, from, wave, code, counter)| {
            let first = from.0.min(15) % REUSE;
            let owners: Vec<u8> = (first..16).step_by(REUSE.into()).collect();
            let owner = NodeId(owners[usize::from(code / 2) % owners.len()]);
            Header { kind, from, wave, place: code % 2, owner, counter }
        },
    )
}

pub fn beacons(numbers: Numbers) -> impl Strategy<Value = Beacon> {
    let role = prop::sample::select(&[Role::Head, Role::Relay, Role::Base]);
    (role, any::<u8>(), numbers.voltages()).prop_map(|(role, state, battery)| Beacon {
        role,
        state,
        battery,
    })
}

fn links(numbers: Numbers) -> impl Strategy<Value = Option<LinkSpan>> {
    let links = (numbers.powers(), numbers.powers()).prop_map(move |(a, b)| match numbers {
        Numbers::Flying if a > b => LinkSpan { weakest: b, strongest: a },
        _ => LinkSpan { weakest: a, strongest: b },
    });
    prop::option::of(links)
}

fn phases() -> impl Strategy<Value = Phase> {
    prop::sample::select(&[
        Phase::Waiting,
        Phase::Transit,
        Phase::Linked,
        Phase::Base,
        Phase::Out,
        Phase::Searching,
        Phase::Perched,
    ])
}

fn sums(numbers: Numbers) -> impl Strategy<Value = [LinkSum; 2]> {
    let links = match numbers {
        Numbers::Flying => (1_u8..16).boxed(),
        Numbers::Wild => any::<u8>().boxed(),
    };
    let sum = (numbers.of(-2047.0..2047.0), numbers.of(0.0..63.9), links).prop_map(
        |(surplus, compliance, links)| LinkSum {
            surplus: Metres(surplus),
            compliance: MetresPerDb(compliance),
            links,
        },
    );
    prop::array::uniform2(prop_oneof![1 => Just(LinkSum::NONE), 3 => sum])
}

pub fn heard(numbers: Numbers) -> impl Strategy<Value = Heard> {
    (numbers.nodes(), numbers.powers(), any::<bool>(), epochs())
        .prop_map(|(node, rssi, is_new, epoch)| Heard { node, rssi, is_new, epoch })
}

fn all_heard(numbers: Numbers) -> impl Strategy<Value = heapless::Vec<Heard, HEARD>> {
    prop::collection::vec(heard(numbers), 0..=HEARD).prop_map(move |all| {
        let mut different = heapless::Vec::<Heard, HEARD>::new();
        for heard in all {
            let twice = different.iter().any(|other| other.node == heard.node);
            if matches!(numbers, Numbers::Wild) || !twice {
                different.push(heard).unwrap();
            }
        }
        different
    })
}

pub fn reports(numbers: Numbers) -> impl Strategy<Value = Report> {
    let flown = (numbers.speeds(), numbers.of(-16_000.0..16_000.0).prop_map(Metres));
    let head = numbers.of(-0.5..0.5).prop_map(MetresPerSecond);
    let heard = all_heard(numbers);
    let waiting = match numbers {
        Numbers::Flying => (0_u8..4).boxed(),
        Numbers::Wild => any::<u8>().boxed(),
    };
    let post = match numbers {
        Numbers::Flying => prop::option::of(signposts(numbers)).boxed(),
        Numbers::Wild => prop::option::of(wild_signposts()).boxed(),
    };
    let head = (waiting, head, post);
    (phases(), any::<[bool; 3]>(), flown, links(numbers), sums(numbers), head, heard).prop_map(
        move |(phase, [recall, calls, uneven], (velocity, odometer), links, sums, head, heard)| {
            let (waiting, head_velocity, signpost) = head;
            Report {
                phase,
                recall,
                calls,
                is_uneven: uneven && (phase == Phase::Linked || matches!(numbers, Numbers::Wild)),
                velocity,
                odometer,
                links,
                sums,
                waiting,
                head_velocity,
                signpost,
                heard,
            }
        },
    )
}

pub fn branches() -> impl Strategy<Value = Option<Branch>> {
    prop::option::of(prop::sample::select(&[Branch::Left, Branch::Right, Branch::Straight]))
}

pub fn signposts(numbers: Numbers) -> impl Strategy<Value = Signpost> {
    let place = (1..=SIGNPOSTS as u8).prop_flat_map(|count| (0..count, Just(count)));
    let from = numbers.of(-2000.0..2000.0).prop_map(Metres);
    (any::<u8>(), place, from, branches()).prop_map(|(revision, (index, count), from, branch)| {
        Signpost { revision, index, count, from, branch }
    })
}

fn wild_signposts() -> impl Strategy<Value = Signpost> {
    let from = Numbers::Wild.of(-2000.0..2000.0).prop_map(Metres);
    (any::<u8>(), 0..12_u8, 0..12_u8, from, branches()).prop_map(
        |(revision, index, count, from, branch)| Signpost { revision, index, count, from, branch },
    )
}

pub fn capsules<const N: usize>(numbers: Numbers) -> impl Strategy<Value = Capsule<N>> {
    (numbers.nodes(), counters(), any::<[u8; N]>(), any::<[u8; TAG]>())
        .prop_map(|(node, counter, sealed, tag)| Capsule { node, counter, sealed, tag })
}

pub fn commands(numbers: Numbers) -> impl Strategy<Value = Commands> {
    let pair = (capsules(numbers), proptest::option::of(capsules(numbers)));
    pair.prop_map(move |(first, second): (Capsule<4>, Option<Capsule<4>>)| {
        let differs = |second: &Capsule<4>| second.node != first.node;
        let second = second.filter(|second| matches!(numbers, Numbers::Wild) || differs(second));
        Commands { first, second }
    })
}

pub fn memberships(numbers: Numbers) -> impl Strategy<Value = Membership> {
    prop_oneof![
        Just(Membership::Join),
        Just(Membership::Leave),
        (numbers.nodes(), epochs()).prop_map(|(node, epoch)| Membership::Refused { node, epoch }),
    ]
}

pub fn missions() -> impl Strategy<Value = MissionMessage> {
    let payload = proptest::collection::vec(any::<u8>(), 0..=Payload::MOST);
    (proptest::sample::select(&MissionKind::ALL[..]), payload).prop_map(|(mission, bytes)| {
        MissionMessage { mission, payload: Payload::new(&bytes).unwrap() }
    })
}

pub fn messages(numbers: Numbers) -> impl Strategy<Value = Message> {
    prop_oneof![
        beacons(numbers).prop_map(Message::Beacon),
        reports(numbers).prop_map(Message::Report),
        commands(numbers).prop_map(Message::Command),
        capsules(numbers).prop_map(Message::Telemetry),
        memberships(numbers).prop_map(Message::Membership),
        missions().prop_map(Message::Mission),
    ]
}

pub fn tasks(numbers: Numbers) -> impl Strategy<Value = Order> {
    prop_oneof![
        Just(Order::Wait),
        (numbers.speeds(), branches())
            .prop_map(|(speed, branch)| Order::Explore(Course { speed, branch })),
        Just(Order::Return),
        Just(Order::Land),
        Just(Order::Perch),
        Just(Order::Stop),
    ]
}

pub fn telemetry(numbers: Numbers) -> impl Strategy<Value = Telemetry> {
    let endurance = match numbers {
        Numbers::Flying => (0_u64..1_016_000_000).boxed(),
        Numbers::Wild => any::<u64>().boxed(),
    };
    let neighbour = prop::option::of((numbers.nodes(), numbers.powers()));
    (
        any::<(u8, u8, u16)>(),
        numbers.voltages(),
        prop::option::of(endurance.prop_map(Duration::from_micros)),
        (neighbour.clone(), neighbour),
        numbers.of(-3270.0..3270.0),
        numbers.of(-1.27..1.27),
        prop::option::of(numbers.of(0.0..5.07).prop_map(Metres)),
    )
        .prop_map(|(bytes, battery, endurance, (front, back), odometer, velocity, height)| {
            let (state, fault, heeded) = bytes;
            Telemetry {
                state,
                fault,
                battery,
                endurance,
                front,
                back,
                odometer: Metres(odometer),
                velocity: MetresPerSecond(velocity),
                height,
                heeded,
            }
        })
}

//! A replay's records: any bytes give a record or an error, a lost byte costs one record, and a
//! session decides what a drone decides that is told the same.

use airlink::Sealed;
use chain::neighbours::Heard;
use chain::report::Report;
use onboard::replay::{
    Answer, Begin, HEARD, LONGEST, NoStopwatch, Receiver, Refusal, Request, Session, Step,
    Stopwatch, VERSION,
};
use onboard::{Config, Drone, Sensed, Setup, Start};
use proptest::prelude::*;
use tunnel_nav::{Diagonals, Range};
use units::{
    Branch, Dbm, Instant, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond, NODES, NodeId,
    Order, Phase, PolicyCode, Role, Signpost,
};

fn begin(policy: u8) -> Begin {
    Begin {
        node: NodeId(1),
        role: Role::Relay,
        in_air: Some(Instant::from_millis(3)),
        policy: PolicyCode::new(policy).unwrap(),
        is_filtered: false,
        links: 2,
    }
}

/// A metre to each wall.
const WALLS: Diagonals = {
    let wall = Range::At(Metres(1.0));
    Diagonals { nw: wall, ne: wall, sw: wall, se: wall }
};

fn heard(from: u8, sequence: u16, rssi: f32) -> Heard {
    let sum = LinkSum { surplus: Metres(1.5), compliance: MetresPerDb(0.5), links: 2 };
    let report = Report {
        from: NodeId(from),
        sequence,
        phase: if from == 2 { Phase::Base } else { Phase::Linked },
        velocity: MetresPerSecond(0.125),
        odometer: Metres(f32::from(sequence) * 0.025),
        links: Some(LinkSpan { weakest: Dbm(rssi), strongest: Dbm(rssi) }),
        sums: [sum; 2],
        waiting: 1,
        head_velocity: MetresPerSecond(0.25),
        signpost: Some(Signpost {
            revision: 1,
            index: 0,
            count: 2,
            from: Metres(7.5),
            branch: Some(Branch::Left),
        }),
        recall: false,
        calls: false,
        is_uneven: false,
    };
    Heard { report, rssi: Some(Dbm(rssi)), reverse: Some(Dbm(rssi - 1.0)) }
}

fn step(n: u16, rssi: [f32; 2]) -> Step {
    Step {
        now: Instant::from_millis(200 * u64::from(n)),
        velocity: None,
        ranges: WALLS,
        height: Some(Metres(0.3)),
        order: Some(Order::explore(MetresPerSecond(0.25))),
        heard: [heard(0, n, rssi[0]), heard(2, n, rssi[1])].into_iter().collect(),
        strengths: [(0, Dbm(rssi[0])), (1, Dbm(rssi[1]))].into_iter().collect(),
    }
}

fn bytes(send: impl FnOnce(&mut dyn FnMut(u8))) -> Vec<u8> {
    let mut bytes = Vec::new();
    send(&mut |byte| bytes.push(byte));
    bytes
}

fn request_bytes(request: &Request, number: u32) -> Vec<u8> {
    bytes(|byte| request.send(number, byte))
}

/// All requests, and all errors, that the bytes hold.
fn received(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Result<(u32, Request), Refusal>> {
    bytes.iter().filter_map(|byte| receiver.push(*byte, Request::parse)).collect()
}

fn answered(bytes: &[u8]) -> Option<(u32, Answer)> {
    let mut receiver = Receiver::new();
    bytes.iter().find_map(|byte| {
        receiver.push(*byte, |frame| frame.ok().and_then(|frame| Answer::parse(&frame)))
    })?
}

fn drone() -> Box<Drone<Sealed>> {
    Box::new(Drone::switched_off())
}

fn answer(session: &mut Session, drone: &mut Drone<Sealed>, request: &Request) -> Answer {
    session.answer(drone, request, &NoStopwatch)
}

/// The layout is a contract between a host and a firmware that may have been built months apart:
/// when these bytes change, the version has to.
#[test]
fn the_bytes_of_a_beginning_are_those_of_this_version() {
    assert_eq!(VERSION, 4);
    let expected = [
        // Consistent overhead byte stuffing: runs of bytes without a zero, each behind its length
        // and one. Kind, version, magic; the number; then a word for each value, low byte first.
        0x06, 0x01, 0x04, 0x52, 0x55, 0x09, 0x01, 0x01, // number 9
        0x02, 0x01, 0x01, 0x01, // node 1
        0x02, 0x01, 0x01, 0x01, // a relay
        0x02, 0x01, 0x01, 0x01, // in the air
        0x03, 0xB8, 0x0B, 0x01, 0x01, 0x01, 0x01, 0x01, // since 3,000 µs
        0x02, 0x06, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, // policy 6, strengths not filtered
        0x02, 0x02, 0x01, 0x01, // links
        0x05, 0xF8, 0x44, 0x21, 0xC1, 0x00, // CRC, end
    ];
    assert_eq!(request_bytes(&Request::Begin(begin(6)), 9), expected);
}

#[test]
fn the_longest_step_and_the_longest_answer_fit_a_frame() {
    let longest = Step {
        velocity: Some(agent::BodyVelocity {
            forward: MetresPerSecond(0.1),
            lateral: MetresPerSecond(0.2),
        }),
        heard: (0..HEARD as u8).map(|from| heard(from, 7, -60.5)).collect(),
        strengths: (0..NODES as u8).map(|link| (link, Dbm(-70.25))).collect(),
        ..step(3, [-60.0; 2])
    };
    let request = Request::Step(longest);
    let bytes = request_bytes(&request, u32::MAX);
    assert!(bytes.len() < 4 * LONGEST, "{} bytes", bytes.len());
    assert_eq!(received(&mut Receiver::new(), &bytes), [Ok((u32::MAX, request.clone()))]);

    let (mut session, mut drone) = (Session::new(), drone());
    // The slopes are estimated by the policy `chain` alone.
    answer(&mut session, &mut drone, &Request::Begin(begin(6)));
    let answer = answer(&mut session, &mut drone, &request);
    let Answer::Stepped(stepped) = &answer else { panic!("{answer:?}") };
    // All but the drone itself.
    assert_eq!(stepped.estimates.len(), HEARD - 1);
    assert!(stepped.estimates.iter().all(|(_, estimate)| estimate.slopes.is_some()));
    let bytes = self::bytes(|byte| answer.send(5, byte));
    // The firmware's ring of answers has 1,024.
    assert!(bytes.len() < 700, "{} bytes", bytes.len());
    assert_eq!(answered(&bytes), Some((5, answer)));
}

/// The three share a word.
#[test]
fn each_mark_of_a_report_comes_back_by_itself() {
    for marks in 0..8 {
        let [recall, calls, is_uneven] = [1, 2, 4].map(|bit| marks & bit != 0);
        let heard = heard(0, 7, -60.5);
        let report = Report { recall, calls, is_uneven, ..heard.report };
        let heard = std::iter::once(Heard { report, ..heard }).collect();
        let request = Request::Step(Step { heard, ..step(3, [-60.0; 2]) });
        let bytes = request_bytes(&request, 1);
        assert_eq!(received(&mut Receiver::new(), &bytes), [Ok((1, request))]);
    }
}

#[test]
fn what_cannot_be_carried_out_is_refused() {
    let (mut session, mut drone) = (Session::new(), drone());
    let step = Request::Step(step(1, [-60.0; 2]));
    assert_eq!(answer(&mut session, &mut drone, &step), Answer::Refused(Refusal::NotBegun));
    let unknown = Request::Begin(begin(200));
    assert_eq!(answer(&mut session, &mut drone, &unknown), Answer::Refused(Refusal::UnknownPolicy));
    assert_eq!(answer(&mut session, &mut drone, &step), Answer::Refused(Refusal::NotBegun));
    assert_eq!(answer(&mut session, &mut drone, &Request::Begin(begin(6))), Answer::Begun);
    assert!(matches!(answer(&mut session, &mut drone, &step), Answer::Stepped(_)));
    for refusal in [Refusal::NoDebugger, Refusal::Airborne, Refusal::NotIdle, Refusal::NotReady] {
        let bytes = bytes(|byte| Answer::Refused(refusal).send(3, byte));
        assert_eq!(answered(&bytes), Some((3, Answer::Refused(refusal))));
    }
}

#[test]
fn another_version_of_the_records_is_told_from_damage() {
    let mut bytes = request_bytes(&Request::Begin(begin(6)), 9);
    // The version is the frame's second byte, behind the first run's length.
    bytes[2] = VERSION + 1;
    let mut damaged = received(&mut Receiver::new(), &bytes);
    assert_eq!(damaged.pop(), Some(Err(Refusal::Malformed)));
    // Whole, with the CRC of these very bytes, it is another version.
    let mut words = vec![0x5552_0001 | u32::from(VERSION + 1) << 8, 9];
    let crc = storage::crc32(words.iter().flat_map(|word| word.to_le_bytes()));
    words.push(crc);
    let plain: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let mut stuffed: Vec<u8> = Vec::new();
    for run in plain.split(|byte| *byte == 0) {
        stuffed.push(run.len() as u8 + 1);
        stuffed.extend(run);
    }
    stuffed.push(0);
    assert_eq!(received(&mut Receiver::new(), &stuffed), [Err(Refusal::Version)]);
}

#[test]
fn a_stopwatch_times_each_round() {
    struct Fixed;
    impl Stopwatch for Fixed {
        fn time<R>(&self, round: impl FnOnce() -> R) -> (R, u32) {
            (round(), 1_234)
        }
    }
    let (mut session, mut drone) = (Session::new(), drone());
    answer(&mut session, &mut drone, &Request::Begin(begin(6)));
    let answer = session.answer(&mut drone, &Request::Step(step(1, [-60.0; 2])), &Fixed);
    assert!(matches!(answer, Answer::Stepped(stepped) if stepped.cycles == 1_234));
}

fn strengths() -> impl Strategy<Value = Vec<[f32; 2]>> {
    proptest::collection::vec(proptest::array::uniform2(-90.0_f32..-30.0), 1..40)
}

proptest! {
    #[test]
    fn any_bytes_give_a_request_or_an_error_and_the_next_frame_is_received(
        noise in proptest::collection::vec(any::<u8>(), 0..4_000),
    ) {
        let mut receiver = Receiver::new();
        received(&mut receiver, &noise);
        received(&mut receiver, &[0]);
        let request = Request::Step(step(4, [-60.0, -61.5]));
        prop_assert_eq!(received(&mut receiver, &request_bytes(&request, 8)), [Ok((8, request))]);
    }

    #[test]
    fn a_lost_or_damaged_byte_costs_one_record_or_two(
        at in 0_usize..300, flip in 1_u8..=255, is_lost: bool,
    ) {
        let requests: Vec<_> = (0..4).map(|n| Request::Step(step(n, [-60.0, -61.5]))).collect();
        let mut bytes = Vec::new();
        for (request, number) in requests.iter().zip(1..) {
            bytes.extend(request_bytes(request, number));
        }
        let at = at % bytes.len();
        if is_lost {
            bytes.remove(at);
        } else {
            bytes[at] ^= flip;
        }
        let received = received(&mut Receiver::new(), &bytes);
        let whole = received.iter().flatten().count();
        // Where the end of a frame is lost, the frame behind it is lost, too.
        prop_assert!((2..4).contains(&whole), "{whole}");
        for (number, request) in received.iter().flatten() {
            prop_assert_eq!(request, &requests[*number as usize - 1]);
        }
    }

    #[test]
    fn a_session_decides_what_its_drone_decides_by_itself(
        strengths in strengths(), policy in 1_u8..=6,
    ) {
        let (mut session, mut replayed) = (Session::new(), drone());
        answer(&mut session, &mut replayed, &Request::Begin(begin(policy)));
        let mut config = Config::DEFAULT;
        let code = PolicyCode::new(policy).unwrap();
        config.agent.policy = chain::policy::Policy::with_code(code).unwrap().config;
        let start = Start::InAir { at: Instant::from_millis(3), flown: Metres::ZERO };
        let mut alone: Drone<Sealed> =
            Drone::new(config, &Setup { start, ..Setup::new(NodeId(1), Role::Relay) });
        for (n, rssi) in (1..).zip(strengths) {
            let step = step(n, rssi);
            for heard in &step.heard {
                alone.hear(step.now, *heard);
            }
            alone.heed(step.now, step.order.unwrap());
            let sensed = Sensed { ranges: WALLS, height: step.height, ..Sensed::NONE };
            let expected = alone.step(step.now, &sensed).agent;
            let answer = answer(&mut session, &mut replayed, &Request::Step(step));
            let Answer::Stepped(stepped) = answer else { panic!("{answer:?}") };
            prop_assert_eq!(stepped.outputs, expected);
            let estimates: Vec<_> = alone.estimates().collect();
            prop_assert_eq!(&stepped.estimates[..], &estimates[..]);
        }
    }
}

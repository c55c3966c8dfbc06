//! The report on the air: its bytes, and that they and it say the same.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Dbm, Metres, MetresPerSecond, NodeId};
use wire::report::{Error, LENGTH, Links, Order, Phase, Report, Task};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

const GOLDEN: Report = Report {
    from: NodeId(3),
    sequence: 0x1234,
    phase: Phase::Linked,
    velocity: MetresPerSecond(-0.25),
    odometer: Metres(12.34),
    links: Some(Links { weakest: Dbm(-71.25), strongest: Dbm(-58.0) }),
    order: Some(Order { sequence: 0xABCD, task: Task::Explore(MetresPerSecond(0.4)) }),
    recall: true,
};

/// By the table in the module's documentation.
const GOLDEN_BYTES: [u8; LENGTH] = [
    1, // version
    3, // from
    0x34,
    0x12,        // sequence
    0b1010_1010, // recall, explore, links, linked
    0x06,
    0xFF, // -250 mm/s
    0xD2,
    0x04,
    0x00,
    0x00, // 1234 cm
    0xE3,
    0xFE, // -285 quarters
    0x18,
    0xFF, // -232 quarters
    0xCD,
    0xAB, // sequence of the order
    0x90,
    0x01, // 400 mm/s
];

#[test]
fn the_bytes_are_those_of_the_table() {
    assert_eq!(GOLDEN.encode(), GOLDEN_BYTES);
    assert_eq!(Report::decode(&GOLDEN_BYTES), Ok(GOLDEN));
}

fn phases() -> impl Strategy<Value = Phase> {
    prop::sample::select(&[Phase::Waiting, Phase::Transit, Phase::Linked, Phase::Base, Phase::Out])
}

/// Reports of `speeds`, `ways` and `powers`.
fn reports(
    speeds: impl Strategy<Value = f32> + Clone,
    ways: impl Strategy<Value = f32>,
    powers: impl Strategy<Value = f32> + Clone,
) -> impl Strategy<Value = Report> {
    let links = prop::option::of(
        (powers.clone(), powers)
            .prop_map(|(a, b)| Links { weakest: Dbm(a.min(b)), strongest: Dbm(a.max(b)) }),
    );
    let task = prop_oneof![
        Just(Task::Wait),
        speeds.clone().prop_map(|speed| Task::Explore(MetresPerSecond(speed))),
        Just(Task::Return),
        Just(Task::Land),
        Just(Task::Stop),
    ];
    let order = prop::option::of(
        (any::<u16>(), task).prop_map(|(sequence, task)| Order { sequence, task }),
    );
    (any::<u8>(), any::<u16>(), phases(), speeds, ways, links, order, any::<bool>()).prop_map(
        |(from, sequence, phase, velocity, odometer, links, order, recall)| Report {
            from: NodeId(from),
            sequence,
            phase,
            velocity: MetresPerSecond(velocity),
            odometer: Metres(odometer),
            links,
            order,
            recall,
        },
    )
}

/// Numbers that are whole steps come back as they were.
fn in_steps() -> impl Strategy<Value = Report> {
    reports(
        any::<i16>().prop_map(|mm| f32::from(mm) / 1000.0),
        (-4_000_000_i32..4_000_000).prop_map(|cm| cm as f32 / 100.0),
        any::<i16>().prop_map(|quarters| f32::from(quarters) / 4.0),
    )
}

/// Numbers as they fly.
fn flying() -> impl Strategy<Value = Report> {
    reports(-30f32..30.0, -1000f32..1000.0, -128f32..0.0)
}

/// Any bits, and often those of no number.
fn bits() -> impl Strategy<Value = f32> + Clone {
    let none = prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0]);
    prop_oneof![3 => any::<u32>().prop_map(f32::from_bits), 1 => none]
}

/// Reports of any bits, with links in any order.
fn wild() -> impl Strategy<Value = Report> {
    let links = prop::option::of(
        (bits(), bits()).prop_map(|(a, b)| Links { weakest: Dbm(a), strongest: Dbm(b) }),
    );
    (reports(bits(), bits(), bits()), links).prop_map(|(report, links)| Report { links, ..report })
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn whole_steps_go_and_come_unchanged(report in in_steps()) {
        prop_assert_eq!(Report::decode(&report.encode()), Ok(report));
    }

    #[test]
    fn other_numbers_move_by_half_a_step(report in flying()) {
        let back = Report::decode(&report.encode()).unwrap();
        // And a little: the step itself is rounded to an f32.
        prop_assert!((back.velocity - report.velocity).abs().0 <= 0.000_51);
        prop_assert!((back.odometer - report.odometer).abs().0 <= 0.005_1);
        if let (Some(back), Some(links)) = (back.links, report.links) {
            prop_assert!((back.weakest - links.weakest).abs().0 <= 0.125_1);
            prop_assert!((back.strongest - links.strongest).abs().0 <= 0.125_1);
        }
        let (there, was) = (back.links.is_some(), report.links.is_some());
        prop_assert_eq!(there, was);
        match (back.order, report.order) {
            (
                Some(Order { task: Task::Explore(back), .. }),
                Some(Order { task: Task::Explore(speed), .. }),
            ) => prop_assert!((back - speed).abs().0 <= 0.000_51),
            (back, was) => prop_assert_eq!(back, was),
        }
    }

    /// What is not a number, and what has no end, is not on the air.
    #[test]
    fn every_report_can_be_sent_and_is_finite(report in wild()) {
        let back = Report::decode(&report.encode()).unwrap();
        prop_assert!(back.velocity.0.is_finite() && back.odometer.0.is_finite());
        if let Some(links) = back.links {
            prop_assert!(links.weakest.0.is_finite() && links.strongest.0.is_finite());
            prop_assert!(links.weakest <= links.strongest);
        }
        if let Some(Order { task: Task::Explore(speed), .. }) = back.order {
            prop_assert!(speed.0.is_finite());
        }
    }

    #[test]
    fn any_bytes_are_a_report_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        let _ = Report::decode(&bytes);
    }

    /// One report, one encoding: whatever is taken is what would have been sent.
    #[test]
    fn what_is_taken_would_be_sent_the_same(
        report in in_steps(), at in 1_usize..LENGTH, bit in 0_u8..8,
    ) {
        let mut bytes = report.encode();
        bytes[at] ^= 1 << bit;
        if let Ok(other) = Report::decode(&bytes) {
            // Beyond 40 km an f32 has no centimetres.
            prop_assume!(other.odometer.abs() < Metres(40_000.0));
            prop_assert_eq!(other.encode(), bytes);
        }
    }
}

#[test]
fn what_is_no_report_says_why() {
    let with = |at: usize, byte: u8| {
        let mut bytes = GOLDEN_BYTES;
        bytes[at] = byte;
        bytes.to_vec()
    };
    let silent = Report { links: None, order: None, ..GOLDEN }.encode();
    let silent_with = |at: usize| {
        let mut bytes = silent;
        bytes[at] = 1;
        bytes.to_vec()
    };
    let table = [
        ("nothing", vec![], Error::Length(0)),
        ("short", GOLDEN_BYTES[..18].to_vec(), Error::Length(18)),
        ("long", [&GOLDEN_BYTES[..], &[0]].concat(), Error::Length(20)),
        ("another version", with(0, 2), Error::Version(2)),
        ("another version of another length", vec![2, 0], Error::Version(2)),
        ("no such phase", with(4, 0b0010_1101), Error::Code(0b0010_1101)),
        ("no such order", with(4, 0b0110_1010), Error::Code(6)),
        ("a speed to land with", with(4, 0b0100_1010), Error::Reserved),
        ("links that are not there", silent_with(11), Error::Reserved),
        ("an order that is not there", silent_with(15), Error::Reserved),
        ("a speed of no order", silent_with(17), Error::Reserved),
        ("the weakest the strongest", with(12, 0xFF), Error::Links),
    ];
    for (what, bytes, error) in table {
        assert_eq!(Report::decode(&bytes), Err(error), "{what}");
    }
}

#[test]
fn links_that_contradict_each_other_are_not_sent() {
    let links = Links { weakest: Dbm(-50.0), strongest: Dbm(-60.0) };
    let sent = Report { links: Some(links), ..GOLDEN }.encode();
    assert_eq!(Report::decode(&sent).unwrap().links, None);
}

//! Any packets: they do no harm, nothing grows without bound, and a client that may only look changes
//! nothing but that it may stop the drone.

use crate::common::{Line, seeded};
use crtp::{Access, Event, Packet, Parameters, Server, Snapshot};
use proptest::prelude::*;
use units::{Duration, Instant};

/// Bytes that resemble a request: a port with a service, and a small first byte.
fn packets() -> impl Strategy<Value = Vec<u8>> {
    let port = prop::sample::select(&[0_u8, 2, 3, 4, 5, 6, 7, 8, 9, 13, 15]);
    let likely = (port, 0_u8..4, 0_u8..14, prop::collection::vec(any::<u8>(), 0..30)).prop_map(
        |(port, channel, command, mut data)| {
            let mut packet = vec![port << 4 | channel, command];
            packet.append(&mut data);
            packet.truncate(31);
            packet
        },
    );
    let small = (any::<u8>(), prop::collection::vec(0_u8..4, 0..12))
        .prop_map(|(header, data)| [vec![header], data].concat());
    let bytes = prop::collection::vec(any::<u8>(), 0..40);
    let by_name = (
        prop::sample::select(&["task", "speed", "height", "launchLimit", "retreatLimit", "node"]),
        any::<[u8; 5]>(),
    )
        .prop_map(|(name, [a, b, c, d, kind])| {
            let kind = if kind < 128 { 8 } else { 6 };
            [b"\x2F\0uchain\0", name.as_bytes(), &[0, kind, a, b, c, d]].concat()
        });
    prop_oneof![4 => likely, 4 => small, 1 => bytes, 2 => by_name]
}

/// Every client may stop a drone and say where it is, and do no more than that.
fn stops_or_locates_at_most(event: Option<Event>) -> bool {
    let stops = matches!(event, Some(Event::EmergencyStop | Event::EmergencyStopWatchdog));
    stops || matches!(event, None | Some(Event::Position(_) | Event::ResetEstimate))
}

fn sessions() -> impl Strategy<Value = Vec<(Vec<u8>, u64, u8)>> {
    prop::collection::vec((packets(), 0_u64..100_000, 0_u8..4), 0..200)
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn any_packets_in_any_order_do_no_harm(session in sessions()) {
        let mut line = Line::new();
        for (packet, micros, polls) in session {
            line.pass(Duration::from_micros(micros));
            line.receive(&packet);
            for _ in 0..polls {
                line.next();
            }
        }
        // What waits is bounded: 16 answers, 512 bytes of text, and each of 16 blocks once.
        prop_assert!(line.all().len() <= 16 + 18 + 16);
        let Parameters { speed, height, launch_limit, retreat_limit, .. } = line.parameters;
        prop_assert!(speed.0.abs() <= 0.4 && (0.2..=1.0).contains(&height.0));
        prop_assert!(retreat_limit.0 >= -96.0 && launch_limit.0 <= -20.0);
        prop_assert!(launch_limit.0 - retreat_limit.0 >= 1.0);
    }

    #[test]
    fn who_may_only_look_changes_nothing_and_starts_nothing(session in sessions()) {
        let mut line = Line::new();
        line.access = Access::Read;
        let before = (line.parameters, line.snapshot);
        for (packet, micros, _) in session {
            line.pass(Duration::from_micros(micros));
            let event = line.receive(&packet);
            prop_assert!(stops_or_locates_at_most(event), "{:?}", event);
            line.server.poll(line.now, &line.snapshot, &line.parameters);
        }
        prop_assert_eq!((line.parameters, line.snapshot), before);
    }

    /// A client that may only look is answered like any other, but for what it may not.
    #[test]
    fn who_may_only_look_sees_the_same(session in sessions()) {
        let mut full = Line::new();
        let mut read = Line::new();
        read.access = Access::Read;
        for (packet, micros, _) in session {
            let port = packet.first().map_or(0, |header| header >> 4);
            // What is set and flown is another matter.
            if [2, 3, 6, 7, 8, 9, 13].contains(&port) {
                continue;
            }
            for line in [&mut full, &mut read] {
                line.pass(Duration::from_micros(micros));
                line.receive(&packet);
            }
            prop_assert_eq!(full.all(), read.all());
        }
    }

    #[test]
    fn what_goes_out_is_a_packet(session in sessions()) {
        let mut line = Line::new();
        for (packet, micros, _) in session {
            line.pass(Duration::from_micros(micros));
            line.receive(&packet);
            while let Some(packet) =
                line.server.poll(line.now, &line.snapshot, &line.parameters)
            {
                prop_assert_eq!(Packet::from_bytes(packet.bytes()), Ok(packet));
            }
        }
    }
}

#[test]
fn a_server_is_small() {
    assert!(size_of::<Server>() < 4096, "{}", size_of::<Server>());
    assert!(size_of::<Snapshot>() < 2048, "{}", size_of::<Snapshot>());
}

#[test]
fn the_end_of_time_is_survived() {
    let mut line = Line::new();
    line.control(&[6, 1, 0x11, 0, 0]);
    line.control(&[8, 1, 1, 0]);
    line.now = Instant::from_micros(u64::MAX);
    for _ in 0..10 {
        line.next();
        line.send(0x5D, &[8, 1, 1, 0]);
    }
}

//! The air, packet by packet: what two, three and four stations hear of each other.

use radio_model::Reception;
use sim_harness::mission::medium::timing::{air_us, flight_us};
use sim_harness::mission::medium::{Medium, MediumConfig, Polling};
use units::{Db, Dbm};
use wire::radio::Datarate;

/// A receiver without chance and without noise.
const EXACT: Reception =
    Reception { noise_variance: 0.0, resolution: Db(1.0), loss_rate: 0.0, sensitivity: Dbm(-95.0) };

fn air(reception: Reception, stations: usize) -> Medium {
    Medium::new(MediumConfig::of(reception), stations, 1)
}

/// Everything that arrives: when, from whom, and by whom it was heard.
fn all(
    medium: &mut Medium,
    mut strength: impl FnMut(usize, usize) -> Option<Dbm>,
) -> Vec<(u64, usize, Vec<usize>)> {
    let mut arrivals = Vec::new();
    while let Some(arrival) = medium.arrive(&mut strength) {
        let heard = arrival.heard.iter().map(|receipt| receipt.by).collect();
        arrivals.push((arrival.at_us, arrival.from, heard));
    }
    arrivals
}

/// All members hear each other, equally well.
fn equal(_: usize, _: usize) -> Option<Dbm> {
    Some(Dbm(-60.0))
}

#[test]
fn a_packet_arrives_whole_when_it_has_flown() {
    let mut medium = air(EXACT, 3);
    let data: Vec<u8> = (0..40).collect();
    medium.send(1, 5_000, &data);
    let due = 5_000 + flight_us(Datarate::Mbit2, 40);
    assert_eq!(medium.next(), Some(due));
    let arrival = medium.arrive(&mut |_, to| Some(Dbm(-60.0 - to as f32))).unwrap();
    assert_eq!((arrival.at_us, arrival.from, arrival.data), (due, 1, &data[..]));
    let heard: Vec<_> = arrival.heard.iter().map(|r| (r.by, r.rssi)).collect();
    assert_eq!(heard, [(0, Dbm(-60.0)), (2, Dbm(-62.0))]);
    assert_eq!(medium.next(), None);
    assert_eq!(medium.tally().sent, 1);
    assert_eq!(medium.tally().air_us, air_us(Datarate::Mbit2, 40));
}

#[test]
fn whoever_is_too_weak_or_dead_hears_nothing() {
    let mut medium = air(EXACT, 3);
    medium.send(0, 0, &[1]);
    let heard = all(&mut medium, |_, to| (to == 1).then_some(Dbm(-96.0)));
    assert_eq!(heard[0].2, Vec::<usize>::new());
    assert_eq!(medium.tally().weak, 2);
}

#[test]
fn who_speaks_is_deaf() {
    let mut medium = air(EXACT, 2);
    medium.send(0, 0, &[0; 20]);
    medium.send(1, 100, &[0; 20]);
    assert!(all(&mut medium, equal).iter().all(|(_, _, heard)| heard.is_empty()));
    assert_eq!(medium.tally().deaf, 2);
    // One after the other, both are heard.
    medium.send(0, 10_000, &[0; 20]);
    medium.send(1, 11_000, &[0; 20]);
    assert!(all(&mut medium, equal).iter().all(|(_, _, heard)| heard.len() == 1));
}

#[test]
fn of_two_at_once_the_stronger_is_heard_if_it_is_much_stronger() {
    for (spare, heard_from) in [(0.0, vec![]), (11.0, vec![]), (13.0, vec![0])] {
        let mut medium = air(EXACT, 3);
        medium.send(0, 0, &[0; 30]);
        medium.send(1, 50, &[0; 30]);
        let strength = |from, _| Some(Dbm(if from == 0 { -60.0 } else { -60.0 - spare }));
        let arrivals = all(&mut medium, strength);
        let at_third: Vec<_> = arrivals
            .iter()
            .filter(|(_, _, by)| by.contains(&2))
            .map(|(_, from, _)| *from)
            .collect();
        assert_eq!(at_third, heard_from, "{spare} dB");
        assert_eq!(medium.tally().collisions, 2 - heard_from.len() as u64);
    }
}

/// Two that do not hear each other destroy each other where both are heard, and nowhere else.
#[test]
fn hidden_stations_collide_in_the_middle() {
    let mut medium = air(EXACT, 4);
    medium.send(0, 0, &[0; 30]);
    medium.send(3, 50, &[0; 30]);
    // In a row: only those next to each other hear each other, and 0, 2 and 3 do as well.
    let links = [(0, 1), (1, 2), (2, 3), (0, 2)];
    let strength = |from: usize, to: usize| {
        links.contains(&(from.min(to), from.max(to))).then_some(Dbm(-60.0))
    };
    let arrivals = all(&mut medium, strength);
    assert_eq!(arrivals[0].2, [1]);
    assert_eq!(arrivals[1].2, Vec::<usize>::new(), "2 heard both");
}

#[test]
fn a_radio_that_is_given_the_next_packet_too_soon_drops_the_first() {
    let mut medium =
        Medium::new(MediumConfig { datarate: Datarate::Kbit250, ..MediumConfig::of(EXACT) }, 2, 1);
    medium.send(0, 0, &[1; 60]);
    medium.send(0, 0, &[2; 60]);
    let arrivals = all(&mut medium, equal);
    assert_eq!((arrivals[0].2.len(), arrivals[1].2.len()), (0, 1));
    assert_eq!(medium.tally().cut, 1);
    // At 2 Mbit/s the serial line is slower than the air.
    let mut medium = air(EXACT, 2);
    medium.send(0, 0, &[1; 60]);
    medium.send(0, 0, &[2; 60]);
    assert!(all(&mut medium, equal).iter().all(|(_, _, heard)| heard.len() == 1));
}

#[test]
fn a_jammer_is_heard_through_by_who_is_much_stronger_only() {
    let mut medium = air(EXACT, 3);
    medium.jam(2, 0, 50_000);
    let strength = |from: usize, to: usize| {
        Some(Dbm(if from == 2 { -70.0 } else { -50.0 - 15.0 * to as f32 }))
    };
    for n in 0..20 {
        medium.send(0, 2_000 * n, &[0; 20]);
        medium.send(1, 2_000 * n + 1_000, &[0; 20]);
    }
    let arrivals = all(&mut medium, strength);
    assert_eq!(arrivals.len(), 40);
    for (_, from, heard) in &arrivals {
        let wanted: &[usize] = if *from == 1 { &[0] } else { &[] };
        assert_eq!(heard, wanted);
    }
    medium.send(0, 60_000, &[0; 20]);
    assert_eq!(all(&mut medium, strength)[0].2, [1, 2], "it is over");
}

/// Chance takes what it is said to take, in each direction by itself, whatever the seed.
#[test]
fn a_fifth_is_lost_by_chance() {
    let mut medium = air(Reception { loss_rate: 0.2, ..EXACT }, 3);
    let mut counts = [[0_u32; 3]; 3];
    for n in 0..4_000_u64 {
        let from = (n % 2) as usize;
        medium.send(from, 10_000 * n, &[0; 20]);
        let arrival = medium.arrive(&mut equal).unwrap();
        arrival.heard.iter().for_each(|receipt| counts[from][receipt.by] += 1);
    }
    for (from, to) in [(0, 1), (0, 2), (1, 0), (1, 2)] {
        let part = f64::from(counts[from][to]) / 2_000.0;
        assert!((part - 0.8).abs() < 0.04, "{from} to {to}: {part}");
    }
    assert!((0.19..0.21).contains(&(medium.tally().chance as f64 / 8_000.0)));
}

/// A dongle that asks a hundred times a second takes the base's ears for its own part of the
/// time, and nobody's who is far from it.
#[test]
fn a_polling_dongle_deafens_the_base_for_a_part_of_the_time() {
    let config = MediumConfig { polling: Some(Polling::of(2)), ..MediumConfig::of(EXACT) };
    let mut medium = Medium::new(config, 3, 1);
    let strength =
        |from: usize, to: usize| Some(Dbm(if from.abs_diff(to) == 1 { -60.0 } else { -80.0 }));
    let (mut at_far, mut at_base, runs) = (0, 0, 2_000_u64);
    for n in 0..runs {
        medium.send(1, 7_301 * n, &[0; 30]);
        let arrival = medium.arrive(&mut { strength }).unwrap();
        at_far += arrival.heard.iter().filter(|r| r.by == 0).count();
        at_base += arrival.heard.iter().filter(|r| r.by == 2).count();
    }
    assert_eq!(at_far as u64, runs, "20 dB stronger than the dongle");
    let lost = 1.0 - at_base as f64 / runs as f64;
    // Question, turn and answer take 0.34 ms of 10, the packet 0.16 ms.
    assert!((0.03..0.08).contains(&lost), "{lost}");
    assert_eq!(medium.tally().deaf, runs - at_base as u64);
}

#[test]
fn the_same_seed_hears_the_same() {
    let run = |seed| {
        let mut medium = Medium::new(MediumConfig::of(Reception::PAPER), 3, seed);
        let mut heard = Vec::new();
        for n in 0..200 {
            medium.send(n % 3, 3_000 * n as u64, &[n as u8; 20]);
            let arrival = medium.arrive(&mut equal).unwrap();
            heard.push(arrival.heard.to_vec());
        }
        heard
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

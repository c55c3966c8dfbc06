//! The air, packet by packet: what two, three and four stations hear of each other.

use radio_model::{Fades, Reception};
use sim_harness::medium::timing::{
    RAMP_UP_US, REPORTS_US, ROUND_NS, air_us, handed_soonest_us, received_us, soonest_us,
};
use sim_harness::medium::{Arrives, Jams, Medium, MediumConfig, Polling, Receipt, Repeater};
use units::{Db, Dbm, Duration};
use wire::radio::Datarate;

/// A receiver without chance and without noise.
const EXACT: Reception =
    Reception { noise_variance: 0.0, resolution: Db(1.0), loss_rate: 0.0, sensitivity: Dbm(-95.0) };

/// A medium whose packets arrive at all receivers at once.
fn at_antenna(reception: Reception) -> MediumConfig {
    MediumConfig { arrives: Arrives::AtAntenna, ..MediumConfig::of(reception) }
}

fn air(reception: Reception, stations: usize) -> Medium {
    Medium::new(at_antenna(reception), stations, 1)
}

/// Everything that arrives: when, from whom, and by whom it was heard.
fn all(
    medium: &mut Medium,
    mut strength: impl FnMut(usize, usize) -> Option<Dbm>,
) -> Vec<(u64, usize, Vec<usize>)> {
    let mut arrivals = Vec::new();
    while medium.next().is_some() {
        let Some(arrival) = medium.advance(&mut strength) else { continue };
        let heard = arrival.heard.iter().map(|receipt| receipt.by).collect();
        arrivals.push((arrival.at_us, arrival.from, heard));
    }
    arrivals
}

/// What is heard of the packet that arrives next.
fn next(
    medium: &mut Medium,
    mut strength: impl FnMut(usize, usize) -> Option<Dbm>,
) -> Vec<Receipt> {
    loop {
        assert!(medium.next().is_some(), "nothing is on its way");
        if let Some(arrival) = medium.advance(&mut strength) {
            return arrival.heard.to_vec();
        }
    }
}

/// All members hear each other, equally well.
fn equal(_: usize, _: usize) -> Option<Dbm> {
    Some(Dbm(-60.0))
}

#[test]
fn a_packet_arrives_whole_when_it_has_flown() {
    let mut medium = Medium::new(MediumConfig::of(EXACT), 3, 1);
    let data: Vec<u8> = (0..40).collect();
    medium.send(1, 50_000, &data);
    let due = 50_000 + soonest_us(Datarate::Mbit2, 40);
    let mut heard = Vec::new();
    while medium.next().is_some() {
        let Some(arrival) = medium.advance(&mut |_, to| Some(Dbm(-60.0 - to as f32))) else {
            continue;
        };
        assert_eq!((arrival.from, arrival.data), (1, &data[..]));
        // Each chip may be in a round of its main loop, or report the battery and the strength.
        let latest = due + 2 * (ROUND_NS / 1_000 + REPORTS_US);
        assert!((due..=latest).contains(&arrival.at_us), "{} for {due}", arrival.at_us);
        heard.extend(arrival.heard.iter().map(|r| (r.by, r.rssi)));
    }
    heard.sort_by_key(|(by, _)| *by);
    assert_eq!(heard, [(0, Dbm(-60.0)), (2, Dbm(-62.0))]);
    assert_eq!(medium.tally().sent, 1);
    assert_eq!(medium.tally().air_us, air_us(Datarate::Mbit2, 40));
}

/// The chip passes on what it has heard before it looks at what it is to send.
#[test]
fn a_packet_waits_until_the_chip_has_passed_on_the_one_that_it_heard() {
    let on_air = |second_us: u64| {
        let mut medium = Medium::new(MediumConfig::of(EXACT), 2, 1);
        medium.inject(0, 33_000, &[1; 60]);
        medium.send(1, second_us, &[2; 60]);
        let arrivals = all(&mut medium, equal);
        let (at_us, _, _) = *arrivals.iter().find(|(_, from, _)| *from == 1).unwrap();
        at_us - received_us(60) - air_us(Datarate::Mbit2, 60) - RAMP_UP_US
    };
    // Station 1 hears the end of the packet at 33.285 ms, and passes it on until 34.2 ms.
    let passed_us = 33_285 + received_us(60);
    let slack_us = 2 * ROUND_NS / 1_000 + REPORTS_US;
    let handed_us = 33_400;
    let begins_us = on_air(handed_us - handed_soonest_us(60));
    assert!((passed_us..=passed_us + slack_us).contains(&begins_us), "{begins_us}");
    let later_us = on_air(38_000 - handed_soonest_us(60));
    assert!((38_000..=38_000 + slack_us).contains(&later_us), "{later_us}");
}

#[test]
fn whoever_is_too_weak_or_dead_hears_nothing() {
    let mut medium = air(EXACT, 3);
    medium.send(0, 0, &[1]);
    let heard = all(&mut medium, |_, to| (to == 1).then_some(Dbm(-99.5)));
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

/// A receiver that has found an address stays with this packet until its end.
#[test]
fn the_first_packet_keeps_the_receiver_from_a_stronger_one() {
    // Station 2 hears station 0 well, and station 1 better by 20 dB.
    let strength = |from, _| Some(Dbm(if from == 1 { -50.0 } else { -70.0 }));
    for (first, then, heard_from) in [(0, 1, None), (1, 0, Some(1))] {
        let mut medium = air(EXACT, 3);
        medium.inject(first, 1_000, &[0; 30]);
        medium.inject(then, 1_100, &[0; 30]);
        let arrivals = all(&mut medium, strength);
        let at_third = arrivals.iter().find(|(_, _, by)| by.contains(&2)).map(|(_, from, _)| *from);
        assert_eq!(at_third, heard_from, "{first} first");
        assert_eq!(medium.tally().collisions, 2 - u64::from(heard_from.is_some()));
    }
    // Both begin before the address of either is over: the stronger is found.
    let mut medium = air(EXACT, 3);
    medium.inject(0, 1_000, &[0; 30]);
    medium.inject(1, 1_010, &[0; 30]);
    assert!(all(&mut medium, strength).iter().any(|(_, from, by)| *from == 1 && by.contains(&2)));
}

/// A packet whose address no receiver finds keeps none: it is drowned, too weak, or a carrier.
#[test]
fn only_an_address_that_is_found_keeps_a_receiver() {
    let strength = |from: usize, _: usize| Some(Dbm([-90.0, -50.0, -70.0, -75.0][from]));
    for other in [0, 3] {
        let mut medium = air(Reception { sensitivity: Dbm(-85.0), ..EXACT }, 5);
        match other {
            // Below the sensitivity by 5 dB.
            0 => medium.inject(0, 1_000, &[0; 30]),
            _ => medium.jam(3, 1_000, 1_400),
        }
        medium.inject(1, 1_100, &[0; 30]);
        let arrivals = all(&mut medium, strength);
        assert!(arrivals.iter().any(|(_, from, by)| *from == 1 && by.contains(&4)), "{other}");
    }
    // Station 2's address is drowned by station 3, so station 1, which comes later, is heard.
    let mut medium = air(EXACT, 5);
    medium.jam(3, 900, 1_050);
    medium.inject(2, 1_000, &[0; 30]);
    medium.inject(1, 1_100, &[0; 30]);
    let arrivals = all(&mut medium, strength);
    assert!(arrivals.iter().any(|(_, from, by)| *from == 1 && by.contains(&4)));
}

/// Near the sensitivity long packets are lost more often than short ones, and weak ones more often.
#[test]
fn loss_grows_with_length_and_weakness() {
    let lost = |dbm: f32, length: usize| {
        let mut medium = air(Reception { sensitivity: Dbm(-85.0), ..EXACT }, 2);
        (0..2_000_u64)
            .filter(|n| {
                medium.inject(0, 10_000 * (n + 1), &vec![0; length]);
                next(&mut medium, |_, _| Some(Dbm(dbm))).is_empty()
            })
            .count() as f32
            / 2_000.0
    };
    assert_eq!(lost(-78.0, 60), 0.0);
    let [weak, weaker] = [lost(-84.0, 60), lost(-85.0, 60)];
    assert!((0.08..0.14).contains(&weak) && (0.39..0.48).contains(&weaker), "{weak} {weaker}");
    let short = lost(-85.0, 17);
    assert!((0.16..0.24).contains(&short), "{short}");
}

/// Packets of a link that fades are lost one after the other, and those of others are not.
#[test]
fn fades_last_and_each_link_has_its_own() {
    let fades = Fades { share: 0.3, mean: Duration::from_millis(500) };
    let mut medium = Medium::new(MediumConfig { fades, ..at_antenna(EXACT) }, 3, 1);
    let heard: Vec<Vec<usize>> = (0..20_000_u64)
        .map(|n| {
            medium.inject(0, 50_000 * (n + 1), &[0; 20]);
            next(&mut medium, equal).iter().map(|receipt| receipt.by).collect()
        })
        .collect();
    let hears = |to: usize| heard.iter().map(move |by| by.contains(&to));
    for to in [1, 2] {
        let lost = hears(to).filter(|hears| !hears).count();
        let bursts = hears(to).zip(hears(to).skip(1)).filter(|(was, is)| *was && !is).count();
        assert!((5_200..6_800).contains(&lost), "{lost} of 20,000");
        // 500 ms are ten packets; a fade that no packet meets is not seen.
        let mean = lost as f32 / bursts as f32;
        assert!((8.0..13.0).contains(&mean), "{mean} packets");
    }
    let both = hears(1).zip(hears(2)).filter(|(one, two)| !one && !two).count();
    assert!((1_300..2_400).contains(&both), "{both} at once, of 9 %");
}

/// The waves go the same way there and back, so a link fades in both directions at once.
#[test]
fn a_fade_holds_in_both_directions() {
    let fades = Fades { share: 0.4, mean: Duration::from_secs(2) };
    let mut medium = Medium::new(MediumConfig { fades, ..at_antenna(EXACT) }, 2, 1);
    let mut is_heard = |from: usize, at_us: u64| {
        medium.inject(from, at_us, &[0; 20]);
        !next(&mut medium, equal).is_empty()
    };
    let (mut alike, mut faded) = (0, 0);
    for n in 1..=5_000_u64 {
        // A millisecond apart, of fades of two seconds.
        let (there, back) = (is_heard(0, 50_000 * n), is_heard(1, 50_000 * n + 1_000));
        alike += u32::from(there == back);
        faded += u32::from(!there);
    }
    assert!((1_500..2_500).contains(&faded), "{faded} of 5,000");
    assert!(alike > 4_980, "{alike} of 5,000");
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
        Medium::new(MediumConfig { datarate: Datarate::Kbit250, ..at_antenna(EXACT) }, 2, 1);
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
        let heard = next(&mut medium, equal);
        heard.iter().for_each(|receipt| counts[from][receipt.by] += 1);
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
    let config = MediumConfig { polling: Some(Polling::at(2, 100.0)), ..at_antenna(EXACT) };
    let mut medium = Medium::new(config, 3, 1);
    let strength =
        |from: usize, to: usize| Some(Dbm(if from.abs_diff(to) == 1 { -60.0 } else { -80.0 }));
    let (mut at_far, mut at_base, runs) = (0, 0, 2_000_u64);
    for n in 0..runs {
        medium.send(1, 7_301 * n, &[0; 30]);
        let heard = next(&mut medium, strength);
        at_far += heard.iter().filter(|r| r.by == 0).count();
        at_base += heard.iter().filter(|r| r.by == 2).count();
    }
    assert_eq!(at_far as u64, runs, "20 dB stronger than the dongle");
    let lost = 1.0 - at_base as f64 / runs as f64;
    // Question, turn and answer take 0.34 ms of 10, the packet 0.16 ms.
    assert!((0.03..0.08).contains(&lost), "{lost}");
    assert_eq!(medium.tally().deaf, runs - at_base as u64);
}

/// A dongle without a rate limit once met the same turns in each frame, and cut off the head of a
/// chain for a minute.
#[test]
fn questions_without_a_rate_limit_meet_no_turn_for_ever() {
    let config = MediumConfig { polling: Some(Polling::at(1, 1_000.0)), ..at_antenna(EXACT) };
    let mut medium = Medium::new(config, 2, 1);
    for phase_us in (0..1_000).step_by(50) {
        let heard = (1..=200_u64).filter(|frame| {
            let start_us = (frame + 1_000 * phase_us) * 100_000 + phase_us;
            medium.inject(0, start_us, &[0; 54]);
            !next(&mut medium, equal).is_empty()
        });
        let heard = heard.count();
        assert!(
            (1..200).contains(&heard),
            "{heard} of 200 that begin {phase_us} µs after a whole ms"
        );
    }
}

/// What is repeated is on the air as soon as a radio can turn round, and not a turn or a round later.
#[test]
fn a_repeater_sends_its_copy_as_soon_as_it_can() {
    for (delay_us, begins_us) in [(0, RAMP_UP_US), (RAMP_UP_US, RAMP_UP_US), (450, 450)] {
        let mut medium = air(EXACT, 4);
        let repeater = Repeater { ear: 2, mouth: 3, delay_us, jams: Jams::Nothing };
        medium.repeat(&[repeater]);
        medium.inject(0, 50_000, &[1; 20]);
        // Stations 0 and 1 do not hear each other; the mouth stands beside 1.
        let near = |from: usize, to: usize| match (from, to) {
            (0, 2) | (3, 1) => Some(Dbm(-50.0)),
            _ => None,
        };
        let arrivals = all(&mut medium, near);
        let ends_us = 50_000 + air_us(Datarate::Mbit2, 20);
        let copy_us = ends_us + begins_us + air_us(Datarate::Mbit2, 20);
        assert_eq!(arrivals, [(ends_us, 0, vec![2]), (copy_us, 3, vec![1])], "{delay_us} µs");
    }
}

#[test]
fn the_same_seed_hears_the_same() {
    let run = |seed| {
        let mut medium = Medium::new(at_antenna(Reception::PAPER), 3, seed);
        let mut heard = Vec::new();
        for n in 0..200 {
            medium.send(n % 3, 3_000 * n as u64, &[n as u8; 20]);
            heard.push(next(&mut medium, equal));
        }
        heard
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

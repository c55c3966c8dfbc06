//! Six rangers on one bus: they start, are lost one by one or all at once, and recover, and a
//! reading is never attributed to another ranger.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::common;
use crate::common::{Decks, block_on, seeded, wall, with_decks};
use proptest::prelude::*;
use sensors::Error;
use sensors::bus::HealthConfig;
use sensors::expander::{Expander, Lines};
use sensors::models::{
    ExpanderModel, Fault, I2cModel, ModelBus, Vl53l1xFault, Vl53l1xModel, Wires,
};
use sensors::multi_ranger::{Beam, BeamState, DeckProbe, MultiRanger, RangerConfig};
use sensors::vl53l1x::RangeStatus;
use units::{Duration, Instant, Metres};

/// Time from one poll to the next, in µs.
const POLL: u32 = 5_000;
/// The most transactions of a poll: seven for each of six rangers, when all end their calibration
/// at once, and 55 to restart one while no ranger is at its address.
const MOST_IN_POLL: u32 = 97;
/// The most transactions of a poll in flight: three for each ranger that has a reading.
const MOST_IN_FLIGHT: u32 = 18;

type Rangers<'a> = MultiRanger<ModelBus<'a>>;

fn rangers<'a>(decks: &Decks<'a>) -> Rangers<'a> {
    MultiRanger::new(decks.bus(), RangerConfig::DEFAULT, decks.wires.now())
}

/// Polls for so many milliseconds, counts the readings, and asserts that each is the distance of
/// its own ranger's wall.
fn run(decks: &Decks<'_>, rangers: &mut Rangers<'_>, ms: u32) -> HashMap<Beam, u32> {
    let mut counts = HashMap::new();
    for _ in 0..ms * 1_000 / POLL {
        let before = decks.wires.transactions();
        let sweep = block_on(rangers.poll(decks.wires.now()));
        let made = decks.wires.transactions() - before;
        assert!(made <= MOST_IN_POLL, "{made} transactions");
        for (beam, reading) in sweep.iter() {
            if let Some(range) = reading.range() {
                assert!((range - wall(beam)).abs() < Metres(0.001), "{beam:?} reads {range}");
            }
            *counts.entry(beam).or_default() += 1;
        }
        decks.wires.advance(POLL);
    }
    counts
}

fn all_live(rangers: &Rangers<'_>) -> bool {
    Beam::ALL.iter().all(|beam| rangers.state(*beam) == BeamState::Live)
}

fn started<'a>(decks: &Decks<'a>) -> Rangers<'a> {
    let mut rangers = rangers(decks);
    run(decks, &mut rangers, 500);
    assert!(all_live(&rangers));
    rangers
}

#[test]
fn six_rangers_at_one_address_are_ranging_within_half_a_second() {
    with_decks(|decks| {
        let mut rangers = rangers(decks);
        assert!(!rangers.is_settled());
        run(decks, &mut rangers, 500);
        assert!(rangers.is_settled() && all_live(&rangers));
        for beam in Beam::ALL {
            assert_eq!(decks.ranger(beam).borrow().address(), beam.address());
            assert_eq!((rangers.errors(beam), rangers.losses(beam)), (0, 0));
            assert_eq!(rangers.last_error(beam), None);
        }
    });
}

#[test]
fn every_side_gives_thirty_readings_a_second_and_the_ranger_that_looks_down_forty() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        let begin = decks.wires.now();
        let counts = run(decks, &mut rangers, 10_000);
        assert!(decks.wires.transactions() < 10_000_000 / POLL * MOST_IN_FLIGHT);
        let seconds = decks.wires.now().since(begin).as_secs_f32();
        for beam in Beam::ALL {
            let rate = counts[&beam] as f32 / seconds;
            let least = if beam == Beam::Down { 39.0 } else { 29.5 };
            assert!(rate >= least, "{beam:?}: {rate} a second");
        }
    });
}

#[test]
fn an_absent_ranger_is_lost_alone_and_recovers() {
    for gone in Beam::ALL {
        with_decks(|decks| {
            let mut rangers = started(decks);
            decks.ranger(gone).borrow_mut().fault = Fault::Absent;
            let counts = run(decks, &mut rangers, 3_000);
            for beam in Beam::ALL {
                let state = rangers.state(beam);
                if beam == gone {
                    assert_eq!(state, BeamState::Lost);
                    assert!(matches!(
                        rangers.last_error(beam),
                        Some(Error::Bus(_) | Error::Timeout)
                    ));
                    assert_eq!(counts.get(&beam), None);
                } else {
                    assert_eq!((state, rangers.losses(beam)), (BeamState::Live, 0), "{beam:?}");
                    assert!(counts[&beam] >= 75, "{beam:?}: {}", counts[&beam]);
                }
            }
            decks.ranger(gone).borrow_mut().fault = Fault::None;
            run(decks, &mut rangers, 2_500);
            assert!(all_live(&rangers), "{gone:?} has not recovered");
            assert_eq!(rangers.losses(gone), 1);
        });
    }
}

#[test]
fn all_six_recover_from_a_dip_of_the_supply_that_resets_their_addresses() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.expander.borrow_mut().reset();
        for beam in Beam::ALL {
            decks.ranger(beam).borrow_mut().reset();
        }
        run(decks, &mut rangers, 1_000);
        assert!(all_live(&rangers));
    });
}

#[test]
fn two_rangers_that_are_reset_at_once_are_not_confused() {
    for (one, other) in [(Beam::Down, Beam::Front), (Beam::Back, Beam::Right)] {
        with_decks(|decks| {
            let mut rangers = started(decks);
            decks.ranger(one).borrow_mut().reset();
            decks.ranger(other).borrow_mut().reset();
            run(decks, &mut rangers, 1_000);
            assert!(all_live(&rangers));
        });
    }
}

#[test]
fn a_frozen_ranger_is_restarted() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.ranger(Beam::Left).borrow_mut().ranging_fault = Vl53l1xFault::Frozen;
        run(decks, &mut rangers, 600);
        assert!(rangers.losses(Beam::Left) >= 1);
        decks.ranger(Beam::Left).borrow_mut().ranging_fault = Vl53l1xFault::None;
        run(decks, &mut rangers, 2_500);
        assert!(all_live(&rangers));
    });
}

#[test]
fn a_ranger_whose_laser_fails_is_restarted_and_its_readings_say_why() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.ranger(Beam::Up).borrow_mut().ranging_fault = Vl53l1xFault::Status(2);
        let mut seen = None;
        for _ in 0..40 {
            let sweep = block_on(rangers.poll(decks.wires.now()));
            seen = seen.or(sweep.of(Beam::Up).map(|reading| reading.status));
            decks.wires.advance(POLL);
        }
        assert_eq!(seen, Some(RangeStatus::Hardware(2)));
        assert!(rangers.losses(Beam::Up) >= 1);
    });
}

#[test]
fn a_target_out_of_reach_is_a_reading_and_not_a_failure() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.ranger(Beam::Front).borrow_mut().distance = Metres(20.0);
        let counts = run(decks, &mut rangers, 3_000);
        assert!(counts[&Beam::Front] >= 85);
        assert_eq!(rangers.losses(Beam::Front), 0);
    });
}

#[test]
fn a_ranger_that_never_boots_is_tried_less_and_less_often() {
    with_decks(|decks| {
        decks.ranger(Beam::Back).borrow_mut().ranging_fault = Vl53l1xFault::NeverBoots;
        let mut rangers = rangers(decks);
        let mut starts = 0;
        let mut before = BeamState::Lost;
        for _ in 0..20_000_000 / POLL {
            block_on(rangers.poll(decks.wires.now()));
            let state = rangers.state(Beam::Back);
            starts += u32::from(before == BeamState::Lost && state == BeamState::Starting);
            before = state;
            decks.wires.advance(POLL);
        }
        assert!((8..=18).contains(&starts), "{starts} attempts in 20 s");
        assert!(rangers.is_settled(), "a program would have to wait for the ranger");
        assert_eq!(rangers.last_error(Beam::Back), Some(&Error::Timeout));
    });
}

/// The configuration that a probe finds, and the round in which it does.
fn probe(decks: &Decks<'_>) -> (RangerConfig, u32) {
    let mut deck_probe = DeckProbe::new();
    for round in 1..=20 {
        let before = decks.wires.transactions();
        let found = block_on(deck_probe.ask(decks.bus()));
        assert!(decks.wires.transactions() - before <= 13);
        if let Some(config) = found {
            return (config, round);
        }
        decks.wires.advance(50_000);
    }
    panic!("undecided after 20 rounds");
}

#[test]
fn a_probe_finds_both_decks_in_one_round_and_all_six_start_after_it() {
    with_decks(|decks| {
        assert_eq!(probe(decks), (RangerConfig::DEFAULT, 1));
        started(decks);
        // The processor alone was reset: rangers at their own addresses are put in reset again.
        assert_eq!(probe(decks), (RangerConfig::DEFAULT, 1));
        started(decks);
    });
}

#[test]
fn a_deck_counts_as_missing_only_if_it_never_answered() {
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        assert_eq!(probe(decks), (RangerConfig::FLOW_DECK, 20));
    });
    for fault in [Fault::NackAfter(0), Fault::NackAfter(4), Fault::Stuck(0xFF)] {
        with_decks(|decks| {
            decks.expander.borrow_mut().fault = fault;
            let expected = match fault {
                Fault::NackAfter(0) => RangerConfig::FLOW_DECK,
                _ => RangerConfig::DEFAULT,
            };
            assert_eq!(probe(decks), (expected, 20), "{fault:?}");
        });
    }
    with_decks(|decks| {
        decks.wires.hang(true);
        assert_eq!(probe(decks), (RangerConfig::DEFAULT, 20));
    });
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        for beam in &Beam::ALL[1..] {
            decks.ranger(*beam).borrow_mut().fault = Fault::Absent;
        }
        assert_eq!(probe(decks), (RangerConfig::DEFAULT, 20), "no deck at all");
    });
}

#[test]
fn a_deck_that_answers_late_is_found() {
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        let mut deck_probe = DeckProbe::new();
        for _ in 0..10 {
            assert_eq!(block_on(deck_probe.ask(decks.bus())), None);
        }
        decks.expander.borrow_mut().fault = Fault::None;
        assert_eq!(block_on(deck_probe.ask(decks.bus())), Some(RangerConfig::DEFAULT));
    });
}

/// An expander that was not there at boot means that side rangers may be at 0x29 as well.
#[test]
fn no_ranger_gets_an_address_while_an_unexpected_expander_answers() {
    with_decks(|decks| {
        let mut rangers = MultiRanger::new(decks.bus(), RangerConfig::FLOW_DECK, decks.wires.now());
        assert!(run(decks, &mut rangers, 1_000).is_empty());
        assert_eq!(rangers.last_error(Beam::Down), Some(&Error::AddressTaken));
        assert_eq!(decks.ranger(Beam::Down).borrow().address(), 0x29);
    });
}

#[test]
fn the_flow_deck_alone_needs_no_expander() {
    let down = RefCell::new(Vl53l1xModel::alone());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&down];
    let wires = Wires::new(&devices);
    let mut rangers =
        MultiRanger::new(ModelBus::new(&wires), RangerConfig::FLOW_DECK, Instant::ZERO);
    for _ in 0..100 {
        block_on(rangers.poll(wires.now()));
        wires.advance(POLL);
    }
    assert_eq!(rangers.state(Beam::Down), BeamState::Live);
    assert_eq!(rangers.state(Beam::Front), BeamState::Unused);
    assert!(rangers.is_settled() && !rangers.bus_is_suspect());
}

#[test]
fn without_an_expander_no_ranger_is_taken_for_the_one_that_looks_down() {
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        let mut rangers = rangers(decks);
        let counts = run(decks, &mut rangers, 3_000);
        assert!(counts.is_empty() && rangers.is_settled() && !rangers.bus_is_suspect());
        decks.expander.borrow_mut().fault = Fault::None;
        run(decks, &mut rangers, 2_500);
        assert!(all_live(&rangers));
    });
}

#[test]
fn the_multi_ranger_deck_alone_ranges_too() {
    with_decks(|decks| {
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        let config = probe(decks).0;
        assert_eq!(config, RangerConfig::MULTI_RANGER);
        let mut rangers = MultiRanger::new(decks.bus(), config, decks.wires.now());
        run(decks, &mut rangers, 600);
        for beam in &Beam::ALL[1..] {
            assert_eq!(rangers.state(*beam), BeamState::Live);
        }
    });
}

/// The ranger that looks down might otherwise return to 0x29 together with a side ranger, and both
/// get one address.
#[test]
fn no_ranger_is_released_while_the_one_that_looks_down_is_lost() {
    with_decks(|decks| {
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        let mut rangers = rangers(decks);
        run(decks, &mut rangers, 3_000);
        assert_eq!(decks.lines.load(Ordering::Relaxed) & Lines::ALL.bits(), 0);
        assert!(rangers.is_settled());
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::None;
        run(decks, &mut rangers, 2_500);
        assert!(all_live(&rangers));
    });
}

#[test]
fn a_ranger_that_the_configuration_does_not_use_stays_in_reset() {
    with_decks(|decks| {
        let config = RangerConfig { up: None, ..RangerConfig::DEFAULT };
        let mut rangers = MultiRanger::new(decks.bus(), config, decks.wires.now());
        run(decks, &mut rangers, 600);
        assert_eq!(rangers.state(Beam::Up), BeamState::Unused);
        assert_eq!(decks.lines.load(Ordering::Relaxed) & Lines::UP.bits(), 0);
        assert!(rangers.is_settled());
    });
}

#[test]
fn a_foreign_ranger_at_the_default_address_keeps_the_sides_lost_until_it_is_gone() {
    let lines = AtomicU8::new(0);
    let foreign = RefCell::new(Vl53l1xModel::alone());
    let front = RefCell::new(Vl53l1xModel::new(Some((&lines, Lines::FRONT))));
    let expander = RefCell::new(ExpanderModel::new(&lines, 0xFF));
    let devices: [&RefCell<dyn I2cModel + '_>; 3] = [&expander, &foreign, &front];
    let wires = Wires::new(&devices);
    wires.advance(POLL);
    let config = RangerConfig { down: None, up: None, ..RangerConfig::DEFAULT };
    let mut rangers = MultiRanger::new(ModelBus::new(&wires), config, wires.now());
    let poll = |rangers: &mut Rangers<'_>| {
        for _ in 0..400 {
            block_on(rangers.poll(wires.now()));
            wires.advance(POLL);
        }
    };
    poll(&mut rangers);
    assert_eq!(rangers.state(Beam::Front), BeamState::Lost);
    assert_eq!(rangers.last_error(Beam::Front), Some(&Error::AddressTaken));
    assert_eq!(foreign.borrow().address(), 0x29, "the foreign ranger got another address");
    foreign.borrow_mut().fault = Fault::Absent;
    poll(&mut rangers);
    assert_eq!(rangers.state(Beam::Front), BeamState::Live);
}

#[test]
fn after_a_reset_of_the_processor_the_ranger_that_looks_down_is_at_its_own_address() {
    with_decks(|decks| {
        started(decks);
        let mut rangers = started(decks);
        assert_eq!(rangers.losses(Beam::Down), 0);
        run(decks, &mut rangers, 500);
        assert!(all_live(&rangers));
    });
}

#[test]
fn an_absent_expander_does_not_stop_the_rangers_that_range() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.expander.borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Back).borrow_mut().reset();
        let counts = run(decks, &mut rangers, 2_000);
        assert!(counts[&Beam::Front] >= 55);
        assert_eq!(rangers.state(Beam::Back), BeamState::Lost);
        decks.expander.borrow_mut().fault = Fault::None;
        run(decks, &mut rangers, 2_500);
        assert!(all_live(&rangers));
    });
}

/// Without the expander the driver cannot know which ranger is at 0x29: it could be a side.
#[test]
fn the_ranger_that_looks_down_is_not_started_while_a_side_might_be_in_its_place() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        decks.expander.borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Front).borrow_mut().reset();
        run(decks, &mut rangers, 3_000);
        assert_eq!(rangers.state(Beam::Down), BeamState::Lost);
        assert_eq!(decks.ranger(Beam::Front).borrow().address(), 0x29);
    });
}

#[test]
fn a_hung_bus_is_distinguished_from_absent_devices_and_all_recover() {
    with_decks(|decks| {
        let mut rangers = started(decks);
        assert!(!rangers.bus_is_suspect());
        decks.wires.hang(true);
        block_on(rangers.poll(decks.wires.now()));
        assert!(rangers.bus_is_suspect());
        run(decks, &mut rangers, 1_000);
        decks.wires.hang(false);
        run(decks, &mut rangers, 2_500);
        assert!(!rangers.bus_is_suspect() && all_live(&rangers));
    });
}

#[test]
fn the_expanders_levels_are_written_first_and_read_back() {
    with_decks(|decks| {
        let mut bus = common::Recorder::new(decks.bus());
        block_on(Expander::new(&mut bus).drive(Lines::FRONT | Lines::LEFT)).unwrap();
        let expected = "20 w 01 50\n20 w 03 a8\n20 w 01 r 50\n20 w 03 r a8\n";
        assert_eq!(bus.log, expected);
        assert_eq!(decks.lines.load(Ordering::Relaxed) & Lines::ALL.bits(), 0x50);
        decks.expander.borrow_mut().fault = Fault::Stuck(0x00);
        let outcome = block_on(Expander::new(decks.bus()).drive(Lines::UP));
        assert_eq!(outcome, Err(Error::NotKept { register: 0x01 }));
    });
}

/// A ranger is reset at any moment around the release of another from reset.
#[test]
fn a_ranger_that_is_reset_while_another_boots_is_not_taken_for_it() {
    for (reset, index) in [(Beam::Down, 0), (Beam::Left, 4)] {
        for micros in (50_000..80_000).step_by(1_000) {
            with_decks(|decks| {
                let mut rangers = started(decks);
                decks.ranger(Beam::Front).borrow_mut().reset();
                decks.contact.borrow_mut().reset_later(index, micros);
                run(decks, &mut rangers, 50);
                decks.ranger(Beam::Front).borrow_mut().fault = Fault::Absent;
                run(decks, &mut rangers, 100);
                decks.ranger(Beam::Front).borrow_mut().fault = Fault::None;
                run(decks, &mut rangers, 600);
                assert!(all_live(&rangers), "{reset:?} after {micros} us");
            });
        }
    }
}

/// A ranger that is lost while another boots has not been put in reset yet. If it answers at 0x29
/// instead of the other it must not get the other's address.
#[test]
fn a_ranger_that_is_lost_while_another_boots_does_not_get_its_address() {
    // The time of its last reading decides whether the failure is noticed during the 20 ms in which
    // the other boots.
    let noticed = (500..540).step_by(5).filter(|&begin| is_lost_while_another_boots(begin));
    assert!(noticed.count() >= 2);
}

/// Makes Front fail so many ms after the beginning, and Back while Front boots. Returns whether the
/// failure of Back is noticed while Front boots.
fn is_lost_while_another_boots(begin: u32) -> bool {
    with_decks(|decks| {
        let health = HealthConfig {
            tolerated: 0,
            // The next attempt at Back, which would put it in reset, is far away.
            first_retry: Duration::from_secs(1),
            ..HealthConfig::DEFAULT
        };
        let config = RangerConfig { health, ..RangerConfig::DEFAULT };
        let mut rangers = MultiRanger::new(decks.bus(), config, decks.wires.now());
        run(decks, &mut rangers, begin);
        decks.ranger(Beam::Front).borrow_mut().fault = Fault::Absent;
        while rangers.state(Beam::Front) != BeamState::Starting {
            run(decks, &mut rangers, POLL / 1_000);
        }
        decks.ranger(Beam::Back).borrow_mut().fault = Fault::NackAfter(0);
        while rangers.state(Beam::Back) == BeamState::Live {
            run(decks, &mut rangers, POLL / 1_000);
        }
        if rangers.state(Beam::Front) != BeamState::Starting {
            return false;
        }
        decks.wires.advance(POLL);
        decks.ranger(Beam::Back).borrow_mut().fault = Fault::None;
        decks.ranger(Beam::Back).borrow_mut().reset();
        decks.wires.advance(POLL);
        run(decks, &mut rangers, 200);
        assert_eq!(rangers.state(Beam::Front), BeamState::Lost);
        decks.ranger(Beam::Front).borrow_mut().fault = Fault::None;
        run(decks, &mut rangers, 3_000);
        assert!(all_live(&rangers));
        true
    })
}

#[test]
fn a_failed_transaction_while_one_ranger_recovers_loses_no_other() {
    for failing in 0..100 {
        with_decks(|decks| {
            let mut rangers = started(decks);
            decks.ranger(Beam::Front).borrow_mut().reset();
            run(decks, &mut rangers, 50);
            decks.wires.refuse_after(Some(failing));
            run(decks, &mut rangers, 150);
            for beam in Beam::ALL.into_iter().filter(|beam| *beam != Beam::Front) {
                assert_eq!(rangers.losses(beam), 0, "{beam:?} for transaction {failing}");
            }
        });
    }
}

/// A fault, or its end, during a flight.
#[derive(Clone, Copy, Debug)]
enum Mishap {
    /// The transaction after so many more fails.
    FailTransaction(u32),
    /// This ranger is absent.
    Absent(usize),
    /// This ranger is present again.
    Present(usize),
    /// This ranger is reset so many µs later, even in the middle of a transaction.
    Reset(usize, u32),
    /// This ranger repeats its last result.
    Freeze(usize),
    /// The supply dips, which resets all rangers and the expander.
    SupplyDip,
    ExpanderReset,
    /// The expander is absent (true) or present.
    ExpanderAbsent(bool),
}

fn mishaps() -> impl Strategy<Value = Vec<(Mishap, u32)>> {
    let mishap = prop_oneof![
        (0u32..60).prop_map(Mishap::FailTransaction),
        (0usize..6).prop_map(Mishap::Absent),
        (0usize..6).prop_map(Mishap::Present),
        (0usize..6, 0u32..15_000).prop_map(|(index, micros)| Mishap::Reset(index, micros)),
        (0usize..6).prop_map(Mishap::Freeze),
        Just(Mishap::SupplyDip),
        Just(Mishap::ExpanderReset),
        any::<bool>().prop_map(Mishap::ExpanderAbsent),
    ];
    prop::collection::vec((mishap, 5u32..400), 1..16)
}

fn apply(decks: &Decks<'_>, mishap: Mishap) {
    let ranger = |index: usize| decks.ranger(Beam::ALL[index]).borrow_mut();
    match mishap {
        Mishap::FailTransaction(after) => decks.wires.refuse_after(Some(after)),
        Mishap::Absent(index) => ranger(index).fault = Fault::Absent,
        Mishap::Present(index) => ranger(index).fault = Fault::None,
        Mishap::Reset(index, micros) => decks.contact.borrow_mut().reset_later(index, micros),
        Mishap::Freeze(index) => ranger(index).ranging_fault = Vl53l1xFault::Frozen,
        Mishap::SupplyDip => {
            decks.expander.borrow_mut().reset();
            (0..6).for_each(|index| ranger(index).reset());
        }
        Mishap::ExpanderReset => decks.expander.borrow_mut().reset(),
        Mishap::ExpanderAbsent(gone) => {
            decks.expander.borrow_mut().fault = if gone { Fault::Absent } else { Fault::None };
        }
    }
}

proptest! {
    #![proptest_config(seeded())]

    /// During any sequence of faults no valid range belongs to another ranger and no poll exceeds
    /// its bound of transactions (`run` asserts both), and after the faults all six recover.
    #[test]
    fn all_rangers_recover_from_faults_and_none_is_taken_for_another(mishaps in mishaps()) {
        with_decks(|decks| {
            let mut rangers = rangers(decks);
            for (mishap, ms) in &mishaps {
                apply(decks, *mishap);
                run(decks, &mut rangers, *ms);
            }
            decks.wires.refuse_after(None);
            decks.expander.borrow_mut().fault = Fault::None;
            for beam in Beam::ALL {
                decks.ranger(beam).borrow_mut().fault = Fault::None;
                decks.ranger(beam).borrow_mut().ranging_fault = Vl53l1xFault::None;
            }
            run(decks, &mut rangers, 5_000);
            prop_assert!(all_live(&rangers), "{:?}", Beam::ALL.map(|beam| rangers.state(beam)));
            Ok(())
        })?;
    }

    /// One failed transaction in flight loses no ranger.
    #[test]
    fn a_single_failed_transaction_loses_no_ranger(failing in 0u32..2_000) {
        with_decks(|decks| {
            let mut rangers = started(decks);
            decks.wires.refuse_after(Some(failing));
            run(decks, &mut rangers, 1_000);
            for beam in Beam::ALL {
                prop_assert_eq!(rangers.losses(beam), 0);
            }
            Ok(())
        })?;
    }
}

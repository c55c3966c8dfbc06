//! Six rangers on one bus: they come up, they are lost one by one and all at once, and they come
//! back, and never does one answer for another.

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

/// From one poll to the next, in µs.
const POLL: u32 = 5_000;
/// A poll makes no more transactions than this: seven for each of six rangers, when all end their
/// calibration at once, and 55 to bring one back of which nothing is where it should be.
const MOST: u32 = 97;
/// In flight, three for each ranger that has a reading.
const ORDINARY: u32 = 18;

type Rangers<'a> = MultiRanger<ModelBus<'a>>;

fn rangers<'a>(decks: &Decks<'a>) -> Rangers<'a> {
    MultiRanger::new(decks.bus(), RangerConfig::DEFAULT, decks.wires.now())
}

/// Polls for so many milliseconds. Counts the readings, and is sure that each is of the wall that
/// its beam looks at.
fn run(decks: &Decks<'_>, rangers: &mut Rangers<'_>, ms: u32) -> HashMap<Beam, u32> {
    let mut counts = HashMap::new();
    for _ in 0..ms * 1_000 / POLL {
        let before = decks.wires.transactions();
        let sweep = block_on(rangers.poll(decks.wires.now()));
        let made = decks.wires.transactions() - before;
        assert!(made <= MOST, "{made} transactions");
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

fn brought_up<'a>(decks: &Decks<'a>) -> Rangers<'a> {
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
fn every_side_gives_thirty_readings_a_second_and_the_ground_forty() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
        let begin = decks.wires.now();
        let counts = run(decks, &mut rangers, 10_000);
        assert!(decks.wires.transactions() < 10_000_000 / POLL * ORDINARY);
        let seconds = decks.wires.now().since(begin).as_secs_f32();
        for beam in Beam::ALL {
            let rate = counts[&beam] as f32 / seconds;
            let least = if beam == Beam::Down { 39.0 } else { 29.5 };
            assert!(rate >= least, "{beam:?}: {rate} a second");
        }
    });
}

#[test]
fn a_ranger_that_goes_is_lost_alone_and_comes_back() {
    for gone in Beam::ALL {
        with_decks(|decks| {
            let mut rangers = brought_up(decks);
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
            assert!(all_live(&rangers), "{gone:?} came back");
            assert_eq!(rangers.losses(gone), 1);
        });
    }
}

#[test]
fn a_dip_of_the_supply_brings_all_six_back_to_one_address_and_then_apart() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
        decks.expander.borrow_mut().reset();
        for beam in Beam::ALL {
            decks.ranger(beam).borrow_mut().reset();
        }
        run(decks, &mut rangers, 1_000);
        assert!(all_live(&rangers));
    });
}

#[test]
fn two_that_are_reset_at_once_are_not_taken_for_each_other() {
    for (one, other) in [(Beam::Down, Beam::Front), (Beam::Back, Beam::Right)] {
        with_decks(|decks| {
            let mut rangers = brought_up(decks);
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
        let mut rangers = brought_up(decks);
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
        let mut rangers = brought_up(decks);
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
fn a_target_out_of_reach_is_a_reading_and_no_failure() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
        decks.ranger(Beam::Front).borrow_mut().distance = Metres(20.0);
        let counts = run(decks, &mut rangers, 3_000);
        assert!(counts[&Beam::Front] >= 85);
        assert_eq!(rangers.losses(Beam::Front), 0);
    });
}

#[test]
fn a_ranger_that_never_boots_is_tried_ever_less_often() {
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
        assert!(rangers.is_settled(), "the others need not wait for it");
        assert_eq!(rangers.last_error(Beam::Back), Some(&Error::Timeout));
    });
}

/// What a probe finds, and in which round.
fn probed(decks: &Decks<'_>) -> (RangerConfig, u32) {
    let mut probe = DeckProbe::new();
    for round in 1..=20 {
        let before = decks.wires.transactions();
        let found = block_on(probe.ask(decks.bus()));
        assert!(decks.wires.transactions() - before <= 13);
        if let Some(config) = found {
            return (config, round);
        }
        decks.wires.advance(50_000);
    }
    panic!("undecided after 20 rounds");
}

#[test]
fn a_probe_finds_both_decks_at_once_and_all_six_come_up_after_it() {
    with_decks(|decks| {
        assert_eq!(probed(decks), (RangerConfig::DEFAULT, 1));
        brought_up(decks);
        // The processor alone is reset: sides at their own addresses are put in reset again.
        assert_eq!(probed(decks), (RangerConfig::DEFAULT, 1));
        brought_up(decks);
    });
}

#[test]
fn a_deck_counts_as_missing_only_if_it_never_answered() {
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        assert_eq!(probed(decks), (RangerConfig::FLOW_DECK, 20));
    });
    for fault in [Fault::NackAfter(0), Fault::NackAfter(4), Fault::Stuck(0xFF)] {
        with_decks(|decks| {
            decks.expander.borrow_mut().fault = fault;
            let expected = match fault {
                Fault::NackAfter(0) => RangerConfig::FLOW_DECK,
                _ => RangerConfig::DEFAULT,
            };
            assert_eq!(probed(decks), (expected, 20), "{fault:?}");
        });
    }
    with_decks(|decks| {
        decks.wires.hang(true);
        assert_eq!(probed(decks), (RangerConfig::DEFAULT, 20));
    });
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        for beam in &Beam::ALL[1..] {
            decks.ranger(*beam).borrow_mut().fault = Fault::Absent;
        }
        assert_eq!(probed(decks), (RangerConfig::DEFAULT, 20), "no deck at all");
    });
}

#[test]
fn a_deck_that_answers_late_is_found() {
    with_decks(|decks| {
        decks.expander.borrow_mut().fault = Fault::Absent;
        let mut probe = DeckProbe::new();
        for _ in 0..10 {
            assert_eq!(block_on(probe.ask(decks.bus())), None);
        }
        decks.expander.borrow_mut().fault = Fault::None;
        assert_eq!(block_on(probe.ask(decks.bus())), Some(RangerConfig::DEFAULT));
    });
}

/// Its rangers may be at 0x29 as well.
#[test]
fn nobody_is_moved_while_an_expander_answers_that_was_not_there_at_boot() {
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
fn without_an_expander_nobody_is_taken_for_the_ground() {
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
        let config = probed(decks).0;
        assert_eq!(config, RangerConfig::MULTI_RANGER);
        let mut rangers = MultiRanger::new(decks.bus(), config, decks.wires.now());
        run(decks, &mut rangers, 600);
        for beam in &Beam::ALL[1..] {
            assert_eq!(rangers.state(*beam), BeamState::Live);
        }
    });
}

/// Otherwise it might come back just when another is at 0x29, and be moved together with it.
#[test]
fn nobody_leaves_its_reset_while_the_ground_is_lost() {
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
fn a_beam_that_the_configuration_does_without_is_left_in_reset() {
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
fn a_stranger_at_the_default_address_keeps_the_sides_down_until_it_is_gone() {
    let lines = AtomicU8::new(0);
    let stranger = RefCell::new(Vl53l1xModel::alone());
    let front = RefCell::new(Vl53l1xModel::new(Some((&lines, Lines::FRONT))));
    let expander = RefCell::new(ExpanderModel::new(&lines, 0xFF));
    let devices: [&RefCell<dyn I2cModel + '_>; 3] = [&expander, &stranger, &front];
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
    assert_eq!(stranger.borrow().address(), 0x29, "nobody moved it");
    stranger.borrow_mut().fault = Fault::Absent;
    poll(&mut rangers);
    assert_eq!(rangers.state(Beam::Front), BeamState::Live);
}

#[test]
fn a_processor_that_was_reset_alone_finds_the_ground_at_its_own_address() {
    with_decks(|decks| {
        brought_up(decks);
        let mut rangers = brought_up(decks);
        assert_eq!(rangers.losses(Beam::Down), 0);
        run(decks, &mut rangers, 500);
        assert!(all_live(&rangers));
    });
}

#[test]
fn an_expander_that_is_gone_leaves_those_that_range_alone() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
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

/// With its expander gone nobody knows which ranger is at 0x29: it could be a side.
#[test]
fn the_ground_is_not_claimed_while_a_side_might_be_in_its_place() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
        decks.expander.borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Down).borrow_mut().fault = Fault::Absent;
        decks.ranger(Beam::Front).borrow_mut().reset();
        run(decks, &mut rangers, 3_000);
        assert_eq!(rangers.state(Beam::Down), BeamState::Lost);
        assert_eq!(decks.ranger(Beam::Front).borrow().address(), 0x29);
    });
}

#[test]
fn a_hung_bus_is_told_from_absent_devices_and_survived() {
    with_decks(|decks| {
        let mut rangers = brought_up(decks);
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
fn the_expander_is_driven_levels_first_and_read_back() {
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

/// A contact that opens just while another ranger is let out of its reset, at whatever moment.
#[test]
fn one_that_is_reset_while_another_boots_is_not_taken_for_it() {
    for (struck, index) in [(Beam::Down, 0), (Beam::Left, 4)] {
        for micros in (50_000..80_000).step_by(1_000) {
            with_decks(|decks| {
                let mut rangers = brought_up(decks);
                decks.ranger(Beam::Front).borrow_mut().reset();
                decks.contact.borrow_mut().strike(index, micros);
                run(decks, &mut rangers, 50);
                decks.ranger(Beam::Front).borrow_mut().fault = Fault::Absent;
                run(decks, &mut rangers, 100);
                decks.ranger(Beam::Front).borrow_mut().fault = Fault::None;
                run(decks, &mut rangers, 600);
                assert!(all_live(&rangers), "{struck:?} after {micros} us");
            });
        }
    }
}

/// A ranger that is given up while another boots has not been put in reset yet. If it turns up at
/// 0x29 in the other's stead it must not get the other's place.
#[test]
fn one_that_is_given_up_while_another_boots_does_not_take_its_place() {
    // Whether the failure is noticed during the 20 ms for which the other boots depends on when it
    // was last read.
    let met = (500..540).step_by(5).filter(|&begin| given_up_while_another_boots(begin));
    assert!(met.count() >= 2);
}

/// Front is lost so many ms after the beginning, and Left fails while Front boots. Whether that is
/// noticed meanwhile.
fn given_up_while_another_boots(begin: u32) -> bool {
    with_decks(|decks| {
        let health = HealthConfig {
            tolerated: 0,
            // Its own next turn, which would put it in reset, is far away.
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
        decks.ranger(Beam::Left).borrow_mut().fault = Fault::NackAfter(0);
        while rangers.state(Beam::Left) == BeamState::Live {
            run(decks, &mut rangers, POLL / 1_000);
        }
        if rangers.state(Beam::Front) != BeamState::Starting {
            return false;
        }
        decks.wires.advance(POLL);
        decks.ranger(Beam::Left).borrow_mut().fault = Fault::None;
        decks.ranger(Beam::Left).borrow_mut().reset();
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
fn a_lost_transaction_while_one_is_brought_back_costs_no_other() {
    for lost in 0..100 {
        with_decks(|decks| {
            let mut rangers = brought_up(decks);
            decks.ranger(Beam::Front).borrow_mut().reset();
            run(decks, &mut rangers, 50);
            decks.wires.refuse_after(Some(lost));
            run(decks, &mut rangers, 150);
            for beam in Beam::ALL.into_iter().filter(|beam| *beam != Beam::Front) {
                assert_eq!(rangers.losses(beam), 0, "{beam:?} for transaction {lost}");
            }
        });
    }
}

/// Something that goes wrong in the air.
#[derive(Clone, Copy, Debug)]
enum Mishap {
    Refuse(u32),
    Go(usize),
    Return(usize),
    /// A ranger is reset so many µs later, in the middle of whatever the bus does then.
    Reset(usize, u32),
    Freeze(usize),
    Dip,
    ExpanderReset,
    Expander(bool),
}

fn mishaps() -> impl Strategy<Value = Vec<(Mishap, u32)>> {
    let mishap = prop_oneof![
        (0u32..60).prop_map(Mishap::Refuse),
        (0usize..6).prop_map(Mishap::Go),
        (0usize..6).prop_map(Mishap::Return),
        (0usize..6, 0u32..15_000).prop_map(|(index, micros)| Mishap::Reset(index, micros)),
        (0usize..6).prop_map(Mishap::Freeze),
        Just(Mishap::Dip),
        Just(Mishap::ExpanderReset),
        any::<bool>().prop_map(Mishap::Expander),
    ];
    prop::collection::vec((mishap, 5u32..400), 1..16)
}

fn befall(decks: &Decks<'_>, mishap: Mishap) {
    let ranger = |index: usize| decks.ranger(Beam::ALL[index]).borrow_mut();
    match mishap {
        Mishap::Refuse(after) => decks.wires.refuse_after(Some(after)),
        Mishap::Go(index) => ranger(index).fault = Fault::Absent,
        Mishap::Return(index) => ranger(index).fault = Fault::None,
        Mishap::Reset(index, micros) => decks.contact.borrow_mut().strike(index, micros),
        Mishap::Freeze(index) => ranger(index).ranging_fault = Vl53l1xFault::Frozen,
        Mishap::Dip => {
            decks.expander.borrow_mut().reset();
            (0..6).for_each(|index| ranger(index).reset());
        }
        Mishap::ExpanderReset => decks.expander.borrow_mut().reset(),
        Mishap::Expander(gone) => {
            decks.expander.borrow_mut().fault = if gone { Fault::Absent } else { Fault::None };
        }
    }
}

proptest! {
    #![proptest_config(seeded())]

    /// Whatever happens and whenever, no valid range is ever another beam's, no poll makes more
    /// transactions than its bound (both asserted as it runs), and when the trouble is over all
    /// six come back.
    #[test]
    fn trouble_passes_and_nobody_answers_for_another(mishaps in mishaps()) {
        with_decks(|decks| {
            let mut rangers = rangers(decks);
            for (mishap, ms) in &mishaps {
                befall(decks, *mishap);
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

    /// One lost transaction in flight costs no ranger its place.
    #[test]
    fn a_single_lost_transaction_loses_no_ranger(lost in 0u32..2_000) {
        with_decks(|decks| {
            let mut rangers = brought_up(decks);
            decks.wires.refuse_after(Some(lost));
            run(decks, &mut rangers, 1_000);
            for beam in Beam::ALL {
                prop_assert_eq!(rangers.losses(beam), 0);
            }
            Ok(())
        })?;
    }
}

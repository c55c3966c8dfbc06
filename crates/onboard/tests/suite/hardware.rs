//! A radio chip that is not set as it was told, a radio firmware that is too old, and a board that is
//! none of ours: the drone stays on the ground, and says why.

use agent::Fitness;
use onboard::hardware::{HardwareFault, RadioChip};
use onboard::{Drone, Sensed, Snapshot};
use storage::settings::{Radio, Settings};
use units::{Dbm, Instant};
use wire::radio::Channel;
use wire::syslink::{Incoming, Outgoing, Port, Release};

use crate::common::packets::ECHO;
use crate::common::{Clear, relay};

const RADIO: Radio = Settings::DEFAULT.radio;
const NEW: &[u8] = b"2025.02 (CF21)";

fn at(millis: u64) -> Instant {
    Instant::from_millis(millis)
}

/// A chip in Bluetooth mode that was told its settings at time zero and has answered with these.
fn in_bluetooth(version: &[u8], radio: Radio) -> RadioChip {
    let mut chip = RadioChip::new();
    assert!(chip.is_to_be_told(at(0)), "it begins with nothing");
    chip.note_told(at(0), RADIO);
    for packet in [
        Incoming::NrfVersion(version),
        Incoming::Channel(radio.channel),
        Incoming::Datarate(radio.datarate),
        Incoming::Address(radio.address),
    ] {
        assert!(chip.fault(at(1)).is_some(), "not all is confirmed before {packet:?}");
        chip.take(at(1), &packet);
    }
    chip
}

/// Such a chip that has then sent a packet, and has answered with this power.
fn answered(version: &[u8], radio: Radio) -> RadioChip {
    let mut chip = in_bluetooth(version, radio);
    chip.note_sent(at(1));
    chip.take(at(1), &Incoming::Power(radio.power));
    chip
}

/// The settings of the radio.
const SETTINGS: [Outgoing<'_>; 4] = [
    Outgoing::Channel(RADIO.channel),
    Outgoing::Datarate(RADIO.datarate),
    Outgoing::Address(RADIO.address),
    Outgoing::Power(RADIO.power),
];

#[test]
fn in_bluetooth_mode_a_chip_is_told_only_what_the_vendors_firmware_tells_it_and_once() {
    let mut chip = RadioChip::new();
    chip.note_told(at(0), RADIO);
    assert_eq!(SETTINGS.map(|setting| chip.is_told(&setting)), [true, true, true, false]);
    // An answer was lost.
    for packet in [Incoming::Channel(RADIO.channel), Incoming::Address(RADIO.address)] {
        chip.take(at(1), &packet);
    }
    assert!(chip.is_to_be_told(at(200)));
    assert_eq!(SETTINGS.map(|setting| chip.is_told(&setting)), [false, true, false, false]);
    let mut chip = in_bluetooth(NEW, RADIO);
    assert_eq!(chip.fault(at(1)), None, "a client at its USB can let it fly");
    for ms in (5..600_000).step_by(5) {
        chip.take(at(ms), &Incoming::Rssi(None));
        // A phone's packets come by Bluetooth, for a while.
        if ms > 300_000 && ms < 350_000 {
            chip.take(at(ms), &Incoming::Raw(&[0xFF]));
        }
        assert!(!chip.is_to_be_told(at(ms)), "{ms} ms");
    }
}

#[test]
fn a_chip_that_has_left_bluetooth_mode_is_told_its_power() {
    let port = Port::new(11).unwrap();
    let heard = Incoming::P2pBroadcast { port, rssi: Dbm(-50.0), data: &[1] };
    for packet in [Some(heard), Some(Incoming::Rssi(Some(Dbm(-50.0)))), None] {
        let mut chip = in_bluetooth(NEW, RADIO);
        match packet {
            Some(packet) => chip.take(at(900), &packet),
            None => chip.note_sent(at(900)),
        }
        assert_eq!(chip.fault(at(900)), None, "it was not told its power yet");
        assert!(chip.is_to_be_told(at(900)), "{packet:?}");
        assert!(chip.is_told(&Outgoing::Power(RADIO.power)));
        chip.take(at(901), &Incoming::Power(RADIO.power));
        assert_eq!((chip.fault(at(1_400)), chip.is_to_be_told(at(901))), (None, false));
    }
}

#[test]
fn a_power_that_is_not_confirmed_is_a_fault_once_its_time_is_over() {
    let mut chip = in_bluetooth(NEW, RADIO);
    let mut faults = Vec::new();
    for ms in (100..3_000).step_by(5) {
        // Its packets go out, and its reports come, but never the power.
        chip.note_sent(at(ms));
        chip.take(at(ms), &Incoming::Rssi(None));
        if chip.is_to_be_told(at(ms)) {
            chip.note_told(at(ms), RADIO);
        }
        faults.push(chip.fault(at(ms)));
    }
    let (early, late) = faults.split_at(80);
    assert!(early.iter().all(Option::is_none), "{early:?}");
    let fault = Some(HardwareFault::RadioSettings);
    assert!(late.iter().all(|now| *now == fault), "{late:?}");
}

#[test]
fn a_chip_that_confirms_everything_has_no_fault_and_is_left_alone() {
    let mut chip = answered(NEW, RADIO);
    assert_eq!((chip.fault(at(1)), chip.answers()), (None, true));
    assert_eq!(chip.release(), Release::parse(NEW));
    for ms in (10..60_000).step_by(10) {
        chip.take(at(ms), &Incoming::Rssi(None));
        let packet = Incoming::Raw(&[0xFF]);
        if ms % 1_000 == 0 {
            chip.take(at(ms), &packet);
        }
        assert!(!chip.is_to_be_told(at(ms)), "{ms} ms");
    }
}

#[test]
fn a_setting_that_is_confirmed_wrongly_is_a_fault_and_is_told_again() {
    let other = Radio { channel: Channel::new(33).unwrap(), ..RADIO };
    let mut chip = answered(NEW, other);
    assert_eq!(chip.fault(at(1)), Some(HardwareFault::RadioSettings));
    assert!(!chip.is_to_be_told(at(100)), "not at once, or a broken chip would be told for ever");
    assert!(chip.is_to_be_told(at(200)));
    chip.note_told(at(200), RADIO);
    chip.take(at(201), &Incoming::Channel(RADIO.channel));
    assert_eq!(chip.fault(at(201)), None);
}

#[test]
fn a_chip_that_hears_nothing_is_told_again_and_keeps_what_it_has_confirmed() {
    let mut chip = answered(NEW, RADIO);
    let data = [1, 2];
    let port = Port::new(11).unwrap();
    let packet = Incoming::P2pBroadcast { port, rssi: Dbm(-50.0), data: &data };
    chip.take(at(1_000), &packet);
    for ms in (1_005..6_000).step_by(5) {
        chip.take(at(ms), &Incoming::Rssi(None));
        assert!(!chip.is_to_be_told(at(ms)));
    }
    assert!(chip.is_to_be_told(at(6_000)));
    chip.note_told(at(6_000), RADIO);
    assert_eq!((chip.fault(at(6_000)), chip.answers()), (None, true));
    assert!(!chip.is_to_be_told(at(6_100)));
}

#[test]
fn a_chip_that_falls_silent_was_reset_and_has_to_confirm_anew() {
    let mut chip = answered(NEW, RADIO);
    assert!(!chip.is_to_be_told(at(1_000)) && chip.is_to_be_told(at(1_001)));
    chip.note_told(at(1_001), RADIO);
    let fault = Some(HardwareFault::RadioSettings);
    assert_eq!((chip.fault(at(1_001)), chip.answers()), (fault, false));
}

#[test]
fn a_firmware_older_than_2022_01_or_without_a_version_is_refused() {
    let old = Some(HardwareFault::RadioFirmware);
    for (text, fault) in [
        (&b"2021.06 (CF21)"[..], old),
        (b"2021.12-3-g12ab34c*", old),
        (b"2016.09", old),
        (b"2022.01", None),
        (b"2022.01.1 (CF21)", None),
        (b"2025.12.1", None),
        // A build that is no release names itself as its builder likes.
        (b"NA", None),
        (b"8a7b6c5*", None),
    ] {
        assert_eq!(answered(text, RADIO).fault(at(1)), fault, "{}", text.escape_ascii());
    }
    assert_eq!(Release::parse(b"2022.13"), None);
    assert_eq!(Release::parse(b"20220.1"), None);
}

#[test]
fn a_chip_that_never_tells_its_version_is_refused() {
    let mut chip = RadioChip::new();
    chip.note_told(at(0), RADIO);
    for packet in [
        Incoming::Channel(RADIO.channel),
        Incoming::Datarate(RADIO.datarate),
        Incoming::Address(RADIO.address),
        Incoming::Power(RADIO.power),
    ] {
        chip.take(at(1), &packet);
    }
    assert_eq!(chip.fault(at(1)), Some(HardwareFault::RadioFirmware));
    assert!(chip.is_to_be_told(at(200)), "it is asked again");
}

#[test]
fn a_drone_with_a_fault_of_its_hardware_is_unfit_and_says_why() {
    for fault in [HardwareFault::Board, HardwareFault::RadioFirmware, HardwareFault::RadioSettings]
    {
        let mut drone = relay();
        assert!(is_fit(&mut drone, 200));
        drone.note_hardware(Some(fault));
        assert!(!is_fit(&mut drone, 400), "{fault:?}");
        drone.client(at(500), &ECHO);
        let mut text = String::new();
        while let Some(packet) = drone.poll_client(at(500), &Snapshot::DEFAULT) {
            text.extend(packet.bytes().iter().skip(1).map(|byte| char::from(*byte)));
        }
        assert!(text.contains(fault.words()), "{text}");
        drone.note_hardware(None);
        assert!(is_fit(&mut drone, 800));
    }
}

/// Runs a round, and returns whether the agent was told that the machine is fit.
fn is_fit(drone: &mut Drone<Clear>, ms: u64) -> bool {
    let mut fitness = None;
    drone.step_shown(at(ms), &Sensed::NONE, None, |inputs, _| fitness = Some(inputs.fitness));
    fitness == Some(Fitness::Fit)
}

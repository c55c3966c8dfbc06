//! What can go wrong on the board goes wrong when it was asked to, as it was asked to, and no
//! longer.

use super::{Bench, DECKS, MS, SENSORS, US, frame};
use proptest::prelude::*;
use sensors::models::Vl53l1xFault;
use sensors::multi_ranger::Beam;
use units::{Acceleration, AngularVelocity, Dbm};
use virtual_crazyflie::board::{Config, Device, Fault, Shares};
use virtual_crazyflie::soc::{Board, I2cBus, Level, Nanos, Pin, SpiBus};

const FOREVER: Nanos = Nanos::MAX;

/// Nine clocks and a stop by hand, as the firmware mends a bus. Whether the data line is free then.
fn mend(bench: &mut Bench, clock: (char, u8), data: (char, u8)) -> bool {
    let half = 5 * US;
    bench.drive(data.0, data.1, Level::Released);
    bench.drive(clock.0, clock.1, Level::Released);
    for _ in 0..9 {
        bench.wait(half);
        if bench.is_high(data.0, data.1) {
            break;
        }
        bench.drive(clock.0, clock.1, Level::Low);
        bench.wait(half);
        bench.drive(clock.0, clock.1, Level::Released);
    }
    for (line, level) in
        [(clock, Level::Low), (data, Level::Low), (clock, Level::Released), (data, Level::Released)]
    {
        bench.wait(half);
        bench.drive(line.0, line.1, level);
    }
    bench.wait(half);
    bench.is_high(data.0, data.1)
}

const DECK_PINS: (I2cBus, (char, u8), (char, u8)) = (DECKS, ('B', 6), ('B', 7));
const SENSOR_PINS: (I2cBus, (char, u8), (char, u8)) = (SENSORS, ('A', 8), ('C', 9));

#[test]
fn a_held_data_line_is_freed_by_clocks() {
    for (bus, clock, data) in [DECK_PINS, SENSOR_PINS] {
        let address = if bus == DECKS { 0x50 } else { 0x69 };
        for clocks in 1..=9 {
            let mut bench = Bench::new();
            bench.board.inject(Fault::SdaHeld { bus, clocks: Some(clocks) }, 10 * MS, FOREVER);
            bench.run_to(10 * MS - 1);
            assert!(bench.answers(bus, address));
            bench.run_to(11 * MS);
            assert_eq!(bench.board.i2c_lines(bus), (true, false));
            assert!(!bench.answers(bus, address));
            assert!(mend(&mut bench, clock, data), "{clocks} clocks");
            assert_eq!(bench.board.i2c_lines(bus), (true, true));
            assert!(bench.answers(bus, address));
        }
    }
}

#[test]
fn a_data_line_held_for_ever_stays_low_until_the_fault_is_over() {
    let (bus, clock, data) = DECK_PINS;
    let mut bench = Bench::new();
    bench.board.inject(Fault::SdaHeld { bus, clocks: None }, 0, 50 * MS);
    assert!(!mend(&mut bench, clock, data));
    bench.run_to(50 * MS);
    assert_eq!(bench.board.i2c_lines(bus), (true, true));
    assert!(bench.answers(bus, 0x50));
}

#[test]
fn a_held_clock_cannot_be_freed() {
    let (bus, clock, data) = SENSOR_PINS;
    let mut bench = Bench::new();
    bench.board.inject(Fault::SclHeld(bus), 0, 50 * MS);
    assert_eq!(bench.board.i2c_lines(bus), (false, true));
    mend(&mut bench, clock, data);
    assert!(!bench.is_high(clock.0, clock.1));
    assert!(!bench.answers(bus, 0x69));
    assert!(bench.answers(DECKS, 0x50), "the other bus is another");
    bench.run_to(50 * MS);
    assert!(bench.answers(bus, 0x69));
}

#[test]
fn a_stop_by_hand_ends_what_was_under_way() {
    let (bus, clock, data) = DECK_PINS;
    let mut bench = Bench::new();
    // A page is half written, and the bus is taken away.
    for byte in [None, Some(0x00), Some(0x20), Some(0x77)] {
        match byte {
            None => assert!(bench.board.i2c_start(bus, 0x50, false)),
            Some(byte) => assert!(bench.board.i2c_write(bus, byte)),
        }
    }
    assert!(mend(&mut bench, clock, data));
    assert!(!bench.answers(bus, 0x50), "the stop lets it keep the page");
    bench.wait(5 * MS);
    assert_eq!(bench.read(bus, 0x50, &[0x00, 0x20], 1), Some(vec![0x77]));
}

#[test]
fn a_silent_device_is_silent_alone_and_for_its_time() {
    let devices = [
        (Device::Gyro, SENSORS, 0x69, 0x18),
        (Device::Accel, SENSORS, 0x18, 0x69),
        (Device::Eeprom, DECKS, 0x50, 0x20),
        (Device::Expander, DECKS, 0x20, 0x50),
        (Device::Ranger(Beam::Down), DECKS, 0x29, 0x20),
    ];
    for (device, bus, address, other) in devices {
        // With all lines low the Flow deck's ranger is alone at its address.
        let mut bench = Bench::with(&Config { floating: 0x00, ..Config::default() });
        bench.board.inject(Fault::Silent(device), 10 * MS, 20 * MS);
        bench.run_to(9 * MS);
        assert!(bench.answers(bus, address));
        bench.run_to(10 * MS);
        assert!(!bench.answers(bus, address), "{device:?}");
        assert!(bench.answers(bus, other));
        bench.run_to(20 * MS);
        assert!(bench.answers(bus, address));
    }
}

#[test]
fn every_nth_byte_is_refused() {
    let mut bench = Bench::new();
    bench.board.inject(Fault::NackEvery(Device::Expander, 3), 0, FOREVER);
    let answers: Vec<bool> = (0..9).map(|_| bench.answers(DECKS, 0x20)).collect();
    assert_eq!(answers, [true, true, false, true, true, false, true, true, false]);
}

#[test]
fn a_device_without_supply_begins_anew() {
    let mut bench = Bench::new();
    bench.wait(5 * MS);
    bench.start_imu();
    let lines_low = [[0x01, 0x00], [0x03, 0xA8]];
    for bytes in lines_low {
        assert!(bench.write(DECKS, 0x20, &bytes));
    }
    assert!(bench.write(DECKS, 0x29, &[0x00, 0x01, 0x6A]));
    for device in [Device::Gyro, Device::Expander, Device::Ranger(Beam::Down)] {
        bench.board.inject(Fault::Unpowered(device), bench.now, bench.now + 5 * MS);
    }
    assert!(!bench.answers(SENSORS, 0x69) && bench.answers(SENSORS, 0x18));
    assert!(!bench.answers(DECKS, 0x20) && !bench.answers(DECKS, 0x6A));
    bench.wait(10 * MS);
    assert_eq!(bench.read(SENSORS, 0x69, &[0x15], 1), Some(vec![0x00]));
    assert_eq!(bench.read(SENSORS, 0x18, &[0x7D], 1), Some(vec![0x04]), "it had its supply");
    assert_eq!(bench.read(DECKS, 0x20, &[0x03], 1), Some(vec![0xFF]));
    assert_eq!(bench.addresses(DECKS), [0x20, 0x29, 0x50]);
}

#[test]
fn a_stuck_device_reads_as_one_byte() {
    let mut bench = Bench::new();
    bench.board.inject(Fault::Reads(Device::Eeprom, 0x55), 0, MS);
    assert_eq!(bench.read(DECKS, 0x50, &[0, 0], 2), Some(vec![0x55, 0x55]));
    bench.wait(MS);
    assert_eq!(bench.read(DECKS, 0x50, &[0, 0], 2), Some(vec![0xFF, 0xFF]));
}

#[test]
fn a_flow_sensor_that_is_gone_reads_as_ones_and_comes_back_unconfigured() {
    let mut bench = Bench::new();
    bench.drive('B', 4, Level::Low);
    bench.board.inject(Fault::Unpowered(Device::Flow), 0, MS);
    assert_eq!(bench.board.spi_exchange(SpiBus::Spi1, 0x16), 0xFF);
    bench.wait(MS);
    assert_ne!(bench.board.spi_exchange(SpiBus::Spi1, 0x16), 0xFF);
}

#[test]
fn a_frozen_inertial_sensor_goes_on_with_what_it_measured_last() {
    let turn = |rate| AngularVelocity([rate, 0.0, 0.0]);
    let still = Acceleration([0.0, 0.0, 9.8]);
    let mut bench = Bench::new();
    bench.start_imu();
    bench.board.set_inertia(turn(1.0), still);
    bench.wait(2 * MS);
    let before = bench.axes(0x69, 0x02);
    bench.board.inject(Fault::ImuFrozen, bench.now, bench.now + 10 * MS);
    bench.board.set_inertia(turn(2.0), still);
    bench.wait(5 * MS);
    assert_eq!(bench.axes(0x69, 0x02), before);
    bench.wait(10 * MS);
    assert_ne!(bench.axes(0x69, 0x02), before, "what was set meanwhile counts");
}

#[test]
fn without_data_ready_samples_come_unannounced() {
    let mut bench = Bench::new();
    bench.start_imu();
    let from = bench.now + 10 * MS;
    bench.board.inject(Fault::DataReadyMissing, from, from + 10 * MS);
    bench.run_to(from);
    while bench.board.due() < from + 10 * MS {
        bench.run_to(bench.board.due());
        assert!(!bench.is_high('C', 14));
    }
    let status = bench.read(SENSORS, 0x69, &[0x10], 1);
    assert_eq!(status, Some(vec![0x82]));
    bench.run_to(from + 11 * MS + 100 * US);
    let highs = (0..1_000).filter(|_| {
        bench.wait(10 * US);
        bench.is_high('C', 14)
    });
    assert_eq!(highs.count(), 300, "three in ten");
}

#[test]
fn a_ranger_ranges_badly_when_asked_to() {
    let mut bench = Bench::with(&Config { multi_ranger: false, ..Config::default() });
    bench.wait(2 * MS);
    bench.start_ranger(0x29);
    bench.board.inject(Fault::Ranging(Beam::Down, Vl53l1xFault::Status(7)), 0, 50 * MS);
    bench.run_to(40 * MS);
    assert_eq!(bench.result(0x29)[0], 7);
    bench.run_to(100 * MS);
    assert_eq!(bench.result(0x29)[0], 9);
}

#[test]
fn the_eeprom_holds_other_bytes_from_a_moment_on() {
    let mut bench = Bench::new();
    let bytes = vec![0xDE, 0xAD];
    bench.board.inject(Fault::EepromBytes { at: 0x1FFF, bytes: bytes.clone() }, 0, FOREVER);
    bench.board.inject(Fault::EepromBytes { at: 4, bytes }, 5 * MS, 6 * MS);
    assert_eq!(bench.board.eeprom()[0x1FFF], 0xDE);
    assert_eq!(bench.board.eeprom()[4], 0xFF);
    bench.run_to(50 * MS);
    assert_eq!(bench.board.eeprom()[4..6], [0xDE, 0xAD]);
}

#[test]
fn flow_control_can_be_stuck() {
    let wait = Pin::new('A', 4);
    let mut bench = Bench::new();
    bench.board.inject(Fault::FlowControlStuck, 10 * MS, 20 * MS);
    assert_eq!(bench.board.due(), 10 * MS);
    bench.run_to(10 * MS);
    assert_eq!(bench.board.level(wait), Level::High);
    assert_eq!(bench.board.due(), 20 * MS);
    bench.run_to(20 * MS);
    assert_eq!(bench.board.level(wait), Level::Low);
}

#[test]
fn a_radio_chip_that_was_reset_has_forgotten_everything() {
    let wait = Pin::new('A', 4);
    let mut bench = Bench::new();
    bench.send(0x01, &[60]);
    bench.send(0x0B, &[]);
    bench.send(0x14, &[]);
    bench.run_to(703 * MS + 125 * US);
    bench.board.inject(Fault::RadioReset, bench.now, FOREVER);
    let cut = bench.now;
    assert_eq!(bench.board.level(wait), Level::Released, "the pin is not driven");
    bench.send(0x0B, &[]);
    bench.run_to(1_000 * MS);
    // What was on its way ends in the middle.
    assert!(bench.heard.iter().all(|byte| byte.at < cut));
    let last = bench.heard.iter().filter(|byte| byte.at >= 703 * MS).count();
    assert!((1..22).contains(&last), "{last} of the 22 bytes of two reports");
    bench.run_to(1_700 * MS);
    assert_eq!(bench.board.level(wait), Level::Low);
    assert_eq!(bench.board.radio().model().unwrap().tuning().channel, 80);
    assert!(!bench.board.radio().model().unwrap().listens());
    bench.heard.clear();
    bench.board.hear(bench.now, 1, &[1], Dbm(-50.0));
    bench.wait(100 * MS);
    assert!(bench.heard.is_empty());
    bench.send(0x0B, &[]);
    bench.wait(100 * MS);
    assert_eq!(bench.frames().len(), 1, "no reports unless they are asked for again");
}

/// A conversation over a disturbed line: what came, and what the chip counted.
fn disturbed(shares: Shares, seed: u64) -> (Vec<u8>, String) {
    let mut bench = Bench::new();
    // Bluetooth is over: the radio may be set.
    bench.tell(0x0A, &[11]);
    bench.board.inject(Fault::Noise { shares, seed }, bench.now, 200 * MS);
    for n in 0..100_u8 {
        bench.send(0x07, &[n]);
        bench.wait(MS);
    }
    let bytes = bench
        .heard
        .iter()
        .map(|byte| byte.data ^ u8::from(byte.noise) << 6 ^ u8::from(byte.broken) << 7)
        .collect();
    (bytes, format!("{:?}", bench.board.radio().model().unwrap().counters()))
}

#[test]
fn noise_is_the_seeds_and_hits_both_directions() {
    let shares = Shares { flipped: 5_000, noisy: 5_000, broken: 5_000, lost: 5_000 };
    let (clean, _) = disturbed(Shares::default(), 3);
    let (first, counters) = disturbed(shares, 3);
    assert_eq!((first.clone(), counters.clone()), disturbed(shares, 3));
    assert_ne!(first, disturbed(shares, 4).0);
    assert_ne!(first, clean);
    assert!(!counters.contains("good: 101,"), "{counters}");
    assert!(!counters.contains("broken_bytes: 0,"), "{counters}");
    let none = disturbed(Shares { lost: 1_000_000, ..Shares::default() }, 1);
    assert!(none.0.is_empty() && none.1.contains("good: 1,"));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 32,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    /// Whatever comes over the line, the chip goes on, and understands the next good frame that
    /// follows a pause long enough for anything that was begun.
    #[test]
    fn no_bytes_bring_the_radio_chip_down(line in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut bench = Bench::new();
        // Without a start there is no frame that could switch it off.
        let line: Vec<u8> = line.into_iter().filter(|byte| !matches!(byte, 0xBC | 0xCF)).collect();
        bench.send_bytes(&line);
        bench.send_bytes(&[0xBC, 0xCF, 0x08]);
        bench.send_bytes(&line);
        bench.wait(10 * MS);
        bench.send_bytes(&[0; 70]);
        bench.wait(10 * MS);
        bench.heard.clear();
        let good = bench.board.radio().model().unwrap().counters().good;
        bench.send_bytes(&frame(0x01, &[80]));
        bench.wait(MS);
        prop_assert_eq!(bench.board.radio().model().unwrap().counters().good, good + 1);
        prop_assert_eq!(bench.frames().len(), 1);
    }
}

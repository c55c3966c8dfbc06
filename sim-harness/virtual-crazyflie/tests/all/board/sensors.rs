//! The sensors as the chip's buses and pins see them.

use super::{Bench, DECKS, MS, SENSORS, US};
use sensors::multi_ranger::Beam;
use sensors::vl53l1x::{CountRate, RangeStatus};
use units::{Acceleration, AngularVelocity, Metres};
use virtual_crazyflie::board::{Blink, Config, Flow, InertialNoise, Led, Sight};
use virtual_crazyflie::soc::{Board, I2cBus, Level, Nanos, Pin, SpiBus};

const SIGHT: Sight = Sight {
    distance: Metres(1.234),
    sigma: Metres(0.0025),
    status: RangeStatus::Valid,
    signal: CountRate(3.0),
    ambient: CountRate(0.5),
};

#[test]
fn a_board_may_be_given_to_another_thread() {
    fn is_send<T: Send>(_: &T) {}
    is_send(&Bench::new().board);
}

#[test]
fn every_address_answers_that_has_a_device_and_no_other() {
    let mut bench = Bench::new();
    bench.wait(5 * MS);
    assert_eq!(bench.addresses(SENSORS), [0x18, 0x69, 0x77]);
    assert_eq!(bench.addresses(DECKS), [0x20, 0x29, 0x50]);
    assert!(bench.addresses(I2cBus::I2c2).is_empty());
    assert_eq!(bench.board.i2c_lines(I2cBus::I2c2), (true, true));
}

#[test]
fn a_deck_that_is_not_there_answers_nothing() {
    let without = |flow_deck, multi_ranger| {
        let config = Config { flow_deck, multi_ranger, ..Config::default() };
        let mut bench = Bench::with(&config);
        bench.wait(5 * MS);
        bench.drive('B', 4, Level::Low);
        bench.board.spi_exchange(SpiBus::Spi1, 0x00);
        bench.wait(50 * US);
        let id = bench.board.spi_exchange(SpiBus::Spi1, 0x00);
        (bench.addresses(DECKS), id)
    };
    assert_eq!(without(true, true), (vec![0x20, 0x29, 0x50], 0x49));
    assert_eq!(without(true, false), (vec![0x29, 0x50], 0x49));
    assert_eq!(without(false, true), (vec![0x20, 0x29, 0x50], 0xFF));
    assert_eq!(without(false, false), (vec![0x50], 0xFF));
}

#[test]
fn the_expander_holds_five_rangers_in_reset_and_lets_them_out_one_by_one() {
    let mut bench = Bench::new();
    bench.wait(5 * MS);
    // All lines low: only the Flow deck's is left, and moves away.
    assert!(bench.write(DECKS, 0x20, &[0x01, 0x00]));
    assert!(bench.write(DECKS, 0x20, &[0x03, 0xA8]));
    assert!(bench.write(DECKS, 0x29, &[0x00, 0x01, 0x6A]));
    assert_eq!(bench.addresses(DECKS), [0x20, 0x50, 0x6A]);
    let lines = [(0x10, 0x6B), (0x02, 0x6C), (0x01, 0x6D), (0x40, 0x6E), (0x04, 0x6F)];
    let mut high = 0;
    for (line, address) in lines {
        high |= line;
        assert!(bench.write(DECKS, 0x20, &[0x01, high]));
        // It takes a millisecond to boot.
        bench.wait(MS / 2);
        assert!(!bench.answers(DECKS, 0x29));
        bench.wait(MS);
        assert!(bench.write(DECKS, 0x29, &[0x00, 0x01, address]));
    }
    assert_eq!(bench.addresses(DECKS), [0x20, 0x50, 0x6A, 0x6B, 0x6C, 0x6D, 0x6E, 0x6F]);
    // One that is reset is back where it began.
    assert!(bench.write(DECKS, 0x20, &[0x01, high & !0x01]));
    assert!(bench.write(DECKS, 0x20, &[0x01, high]));
    bench.wait(2 * MS);
    assert_eq!(bench.addresses(DECKS), [0x20, 0x29, 0x50, 0x6A, 0x6B, 0x6C, 0x6E, 0x6F]);
}

/// The moments at which "data ready" rises and falls.
fn edges(bench: &mut Bench, until: Nanos) -> Vec<(Nanos, bool)> {
    let mut edges = Vec::new();
    let mut was = bench.is_high('C', 14);
    while bench.board.due() <= until {
        bench.run_to(bench.board.due());
        let is = bench.is_high('C', 14);
        if is != was {
            edges.push((bench.now, is));
        }
        was = is;
    }
    edges
}

#[test]
fn data_ready_rises_every_millisecond_for_300_us_and_never_drifts() {
    let mut bench = Bench::new();
    assert!(
        !edges(&mut bench, 20 * MS).iter().any(|(_, high)| *high),
        "no measurement was started"
    );
    bench.start_imu();
    let edges = edges(&mut bench, 10_000 * MS);
    let rises: Vec<_> = edges.iter().filter(|(_, high)| *high).map(|(at, _)| *at).collect();
    assert!(rises.len() > 9_900);
    assert!(rises.windows(2).all(|pair| pair[1] - pair[0] == MS));
    let pulses = edges.windows(2).filter(|pair| pair[0].1);
    assert!(pulses.into_iter().all(|pair| pair[1].0 - pair[0].0 == 300 * US));
}

#[test]
fn looking_at_odd_moments_moves_no_sample() {
    let rises = |step: Nanos| {
        let mut bench = Bench::new();
        bench.start_imu();
        let begin = bench.now;
        let mut rises = Vec::new();
        while bench.now < 50 * MS {
            let next = (bench.now + step).min(bench.board.due());
            bench.run_to(next);
            let _ = bench.read(SENSORS, 0x69, &[0x0A], 1);
            if bench.board.due() == Nanos::MAX {
                break;
            }
            rises.push(bench.board.due() % MS);
        }
        assert!(bench.now > begin);
        rises.sort_unstable();
        rises.dedup();
        rises
    };
    // Rises and falls are at two phases of the millisecond, whenever the pin is read.
    assert_eq!(rises(137_731).len(), 2);
    assert_eq!(rises(137_731), rises(1_003));
}

#[test]
fn an_inertial_sample_is_what_the_world_set_before_it() {
    let mut bench = Bench::new();
    bench.start_imu();
    bench.wait(2 * MS);
    let turn = |rate: f32| AngularVelocity([rate, -rate, 2.0 * rate]);
    let still = Acceleration([0.0, 0.0, 9.806_65]);
    bench.board.set_inertia(turn(1.0), still);
    bench.wait(MS);
    let step = 2000.0_f32.to_radians() / 32768.0;
    let steps = |rate: f32| (rate / step).round() as i16;
    let one = steps(1.0);
    assert_eq!(bench.axes(0x69, 0x02), Some([one, -one, steps(2.0)]));
    bench.board.set_inertia(turn(2.0), still);
    // Set just now, measured at the next sample.
    assert_eq!(bench.axes(0x69, 0x02).unwrap()[0], one);
    bench.wait(MS);
    assert_eq!(bench.axes(0x69, 0x02).unwrap()[0], steps(2.0));
    let g = (32768.0_f32 / 24.0).round() as i16;
    assert_eq!(bench.axes(0x18, 0x12), Some([0, 0, g]));
}

#[test]
fn noise_is_added_to_every_sample_and_is_the_seeds() {
    let samples = |seed| {
        let noise = Some(InertialNoise { seed, gyro: 3, accel: 2 });
        let mut bench = Bench::with(&Config { noise, ..Config::default() });
        bench.start_imu();
        (0..200)
            .map(|_| {
                bench.wait(MS);
                bench.axes(0x69, 0x02).unwrap()
            })
            .collect::<Vec<_>>()
    };
    let first = samples(5);
    assert_eq!(first, samples(5));
    assert_ne!(first, samples(6));
    assert!(first.iter().flatten().all(|axis| axis.abs() <= 3));
    assert!(first.windows(2).filter(|pair| pair[0] == pair[1]).count() < 10);
}

#[test]
fn a_ranger_says_when_it_wants_to_know_and_then_reports_just_that() {
    let mut bench = Bench::new();
    bench.wait(5 * MS);
    assert!(bench.write(DECKS, 0x20, &[0x01, 0x00]) && bench.write(DECKS, 0x20, &[0x03, 0xA8]));
    assert!(!bench.board.wants_range(Beam::Down, 1_000 * MS), "it does not range");
    bench.start_ranger(0x29);
    let begin = bench.now;
    assert!(bench.board.wants_range(Beam::Down, 100 * MS));
    assert!(!bench.board.wants_range(Beam::Front, 1_000 * MS), "it is in reset");
    while !bench.board.wants_range(Beam::Down, MS) {
        bench.wait(MS);
    }
    let took = bench.now - begin;
    assert!((9 * MS..12 * MS).contains(&took), "{took}");
    bench.board.set_range(Beam::Down, SIGHT);
    // The interrupt line is active low, as after a reset: it falls for a result.
    assert_eq!(bench.read(DECKS, 0x29, &[0x00, 0x31], 1), Some(vec![0x03]));
    bench.wait(MS);
    assert_eq!(bench.read(DECKS, 0x29, &[0x00, 0x31], 1), Some(vec![0x02]));
    let result = bench.result(0x29);
    assert_eq!((result[0], result[2]), (9, 0));
    assert_eq!(result[7..9], [0x00, 0x40]);
    assert_eq!(result[9..11], [0x00, 0x0A]);
    // The device's own steps, of which ST's driver takes 2011/2048 for millimetres: 1234 mm.
    assert_eq!(result[13..15], 1257_u16.to_be_bytes());
    assert_eq!(result[15..17], [0x01, 0x80]);
}

#[test]
fn every_status_of_a_ranger_arrives_as_the_devices_code() {
    let codes = [
        (RangeStatus::SigmaFail, 6),
        (RangeStatus::SignalFail, 4),
        (RangeStatus::MinRangeClipped, 8),
        (RangeStatus::OutOfBounds, 5),
        (RangeStatus::WrapTarget, 7),
        (RangeStatus::Crosstalk, 12),
        (RangeStatus::Synchronisation, 18),
        (RangeStatus::Unchecked, 19),
        (RangeStatus::MergedPulse, 22),
        (RangeStatus::LackOfSignal, 23),
        (RangeStatus::MinRangeFail, 13),
        (RangeStatus::Hardware(17), 17),
        (RangeStatus::Other(21), 21),
    ];
    let config = Config { multi_ranger: false, ..Config::default() };
    let mut bench = Bench::with(&config);
    bench.wait(5 * MS);
    bench.start_ranger(0x29);
    for (status, code) in codes {
        bench.board.set_range(Beam::Down, Sight { status, ..SIGHT });
        bench.wait(30 * MS);
        assert_eq!(bench.result(0x29)[0], code, "{status:?}");
    }
}

#[test]
fn results_keep_their_period_however_long_they_are_not_read() {
    let config = Config { multi_ranger: false, ..Config::default() };
    let stream = |looks: u64| {
        let mut bench = Bench::with(&config);
        bench.wait(5 * MS);
        bench.start_ranger(0x29);
        for look in 1..=looks {
            bench.run_to(look * 900 * MS / looks);
            bench.result(0x29);
        }
        bench.run_to(1_000 * MS);
        bench.result(0x29)[2]
    };
    assert_eq!(stream(1), stream(300));
}

#[test]
fn the_flow_sensor_is_spoken_to_while_it_is_selected() {
    let mut bench = Bench::new();
    let burst = |bench: &mut Bench| {
        bench.drive('B', 4, Level::Low);
        bench.wait(50 * US);
        bench.board.spi_exchange(SpiBus::Spi1, 0x16);
        bench.wait(50 * US);
        let bytes: Vec<u8> = (0..12)
            .map(|_| {
                bench.wait(6 * US);
                bench.board.spi_exchange(SpiBus::Spi1, 0)
            })
            .collect();
        bench.drive('B', 4, Level::High);
        bench.wait(100 * US);
        bytes
    };
    let flow = Flow {
        dx: -5,
        dy: 300,
        squal: 77,
        shutter: 0x0123,
        raw_sum: 90,
        raw_max: 180,
        raw_min: 20,
    };
    bench.board.push_flow(flow);
    bench.board.push_flow(Flow { dx: -1, dy: 0, ..flow });
    // Without the maker's settings it finds no features.
    let seen = burst(&mut bench);
    assert_eq!(seen, [0xB0, 0xBF, 0xFA, 0xFF, 0x2C, 0x01, 0, 90, 180, 20, 0x01, 0x23]);
    assert_eq!(burst(&mut bench)[..6], [0x30, 0xBF, 0, 0, 0, 0]);
    assert_eq!(bench.board.spi_exchange(SpiBus::Spi1, 0x16), 0xFF, "not selected");
    assert_eq!(bench.board.flow_violations(), 0);
    bench.drive('B', 4, Level::Low);
    bench.board.spi_exchange(SpiBus::Spi1, 0x00);
    bench.board.spi_exchange(SpiBus::Spi1, 0x00);
    assert_eq!(bench.board.flow_violations(), 1, "35 us between address and data");
}

#[test]
fn the_eeprom_begins_as_configured_and_keeps_what_is_written() {
    let config = Config { eeprom: vec![1, 2, 3], ..Config::default() };
    let mut bench = Bench::with(&config);
    assert_eq!(bench.read(DECKS, 0x50, &[0, 0], 5), Some(vec![1, 2, 3, 0xFF, 0xFF]));
    assert!(bench.write(DECKS, 0x50, &[0x00, 0x40, 7, 8]));
    assert!(!bench.answers(DECKS, 0x50), "it is busy with the page");
    bench.wait(5 * MS);
    assert_eq!(bench.read(DECKS, 0x50, &[0x00, 0x40], 2), Some(vec![7, 8]));
    assert_eq!(bench.board.eeprom()[0x40..0x42], [7, 8]);
}

#[test]
fn leds_are_written_down_with_their_moments_and_polarity() {
    let mut bench = Bench::new();
    let pins = [('D', 2), ('C', 1), ('C', 0), ('C', 2), ('C', 3)];
    for (port, number) in pins {
        bench.drive(port, number, Level::High);
    }
    assert_eq!(bench.board.take_blinks(), [Blink { at: 0, led: Led::BlueLeft, on: true }]);
    bench.wait(3 * US);
    bench.drive('C', 0, Level::Low);
    bench.drive('C', 0, Level::Low);
    bench.wait(2 * US);
    bench.drive('C', 0, Level::Released);
    bench.drive('D', 2, Level::Low);
    let log = bench.board.take_blinks();
    let red = |at, on| Blink { at, led: Led::RedLeft, on };
    let blue = Blink { at: 5 * US, led: Led::BlueLeft, on: false };
    assert_eq!(log, [red(3 * US, true), red(5 * US, false), blue]);
    assert!(bench.board.is_lit(Led::Radio) && !bench.board.is_lit(Led::GreenLeft));
    for n in 0..6_000 {
        bench.drive('C', 3, if n % 2 == 0 { Level::Low } else { Level::High });
    }
    assert_eq!(bench.board.take_blinks().len(), 4_096, "the latest are kept");
}

#[test]
fn unconnected_pins_are_not_driven() {
    let bench = Bench::new();
    for pin in [Pin::new('A', 0), Pin::new('B', 4), Pin::new('C', 13), Pin::new('I', 15)] {
        assert_eq!(bench.board.level(pin), Level::Released);
    }
    for (port, number) in [('B', 6), ('B', 7), ('A', 8), ('C', 9)] {
        assert!(bench.is_high(port, number), "pulled up");
    }
}

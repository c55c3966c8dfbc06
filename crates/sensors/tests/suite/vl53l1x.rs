//! One ranger: its configuration registers, the value and rate of its readings, and the errors that
//! its failures end in.

use std::cell::RefCell;

use crate::common::{Recorder, block_on, seeded, with_ranger};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use proptest::prelude::*;
use sensors::Error;
use sensors::models::{Fault, I2cModel, ModelBus, ModelDelay, Vl53l1xFault, Vl53l1xModel, Wires};
use sensors::vl53l1x::{Config, DEFAULT_ADDRESS, DistanceMode, RangeStatus, Reading, Vl53l1x};
use units::{Duration, Metres};

const NO_ACKNOWLEDGE: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn await_reading(
    sensor: &mut Vl53l1x<ModelBus<'_>>,
    wires: &Wires<'_>,
) -> Result<Reading, Error<ErrorKind>> {
    for _ in 0..1_000 {
        if let Some(reading) = block_on(sensor.poll())? {
            return Ok(reading);
        }
        wires.advance(1_000);
    }
    Err(Error::Timeout)
}

/// The image is ST's default but for the registers of the distance mode, the budget and the
/// period.
#[test]
fn initialisation_writes_sts_image_with_the_configuration() {
    with_ranger(|bus, mut delay, _, wires| {
        wires.advance(2_000);
        let mut bus = Recorder::new(bus);
        block_on(Vl53l1x::new(&mut bus, DEFAULT_ADDRESS).init(&mut delay, &Config::SIDE)).unwrap();
        let expected = "\
29 w 00 87 00
29 w 00 2d 00 01 01 01 02 00 02 08 00 08 10 01 01 00 00 00 00 ff 00 0f 00 00 00 00 00 20 0b 00 00 02 0a 21
29 w 00 4d 00 00 05 00 00 00 00 c8 00 00 38 ff 01 00 08 00 00 00 60 0f 00 6e 0d 01 68 00 80 08 b8 00 00 00
29 w 00 6d 00 6e dc 00 00 00 00 00 00 00 01 0f 0d 0e 0e 00 00 02 c7 ff 9b 00 00 00 01 00 00
29 w 00 86 01
29 w 00 87 40
29 w 00 86 01
29 w 00 87 00
29 w 00 08 09
29 w 00 0b 00
";
        assert_eq!(bus.writes(), expected);
        let reads: Vec<_> = bus.log.lines().filter(|line| line.contains(" r")).collect();
        assert_eq!(reads[..3], ["29 w 00 e5 r 03", "29 w 01 0f r ea cc", "29 w 00 de r 03 20"]);
        assert!(reads[3..].iter().all(|read| read.starts_with("29 w 00 31 r")));
    });
}

#[test]
fn the_short_mode_sets_its_own_register_values() {
    let ms = Duration::from_millis;
    let config = Config { mode: DistanceMode::Short, budget: ms(20), period: ms(50) };
    with_ranger(|bus, mut delay, model, _| {
        block_on(Vl53l1x::new(bus, DEFAULT_ADDRESS).init(&mut delay, &config)).unwrap();
        for (register, value) in [
            (0x4B, 0x14),
            (0x5E, 0x00),
            (0x5F, 0x51),
            (0x60, 0x07),
            (0x61, 0x00),
            (0x62, 0x6E),
            (0x63, 0x05),
            (0x69, 0x38),
            (0x78, 0x07),
            (0x79, 0x05),
            (0x7A, 0x06),
            (0x7B, 0x06),
        ] {
            assert_eq!(model.borrow().register(register), value, "{register:#04x}");
        }
    });
}

#[test]
fn a_reading_holds_the_measurement_of_the_sensor() {
    with_ranger(|bus, mut delay, model, wires| {
        let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
        block_on(sensor.init(&mut delay, &Config::DOWN)).unwrap();
        block_on(sensor.start()).unwrap();
        let first = await_reading(&mut sensor, wires).unwrap();
        assert_eq!((first.status, first.stream, first.range()), (RangeStatus::Unchecked, 0, None));
        for (stream, mm) in [(1, 40), (2, 1_234), (3, 3_999)] {
            let truth = Metres(mm as f32 * 1e-3);
            model.borrow_mut().distance = truth;
            model.borrow_mut().sigma = Metres(0.007_5);
            let reading = await_reading(&mut sensor, wires).unwrap();
            assert_eq!((reading.status, reading.stream), (RangeStatus::Valid, stream));
            assert_eq!(reading.range(), Some(reading.distance));
            // A step is a little less than a millimetre.
            assert!((reading.distance - truth).abs() < Metres(0.55e-3));
            assert!((reading.sigma.0 - 0.007_5).abs() < 1e-6);
            assert_eq!((reading.signal.0, reading.ambient.0), (8.0, 0.25));
        }
    });
}

#[test]
fn a_reading_is_given_once() {
    with_ranger(|bus, mut delay, _, wires| {
        let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
        block_on(sensor.init(&mut delay, &Config::SIDE)).unwrap();
        block_on(sensor.start()).unwrap();
        await_reading(&mut sensor, wires).unwrap();
        assert_eq!(block_on(sensor.poll()), Ok(None));
    });
}

#[test]
fn a_side_ranger_ranges_thirty_times_a_second_and_the_one_that_looks_down_forty() {
    for (config, rate) in [(Config::SIDE, 30), (Config::DOWN, 40)] {
        with_ranger(|bus, mut delay, _, wires| {
            let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
            block_on(sensor.init(&mut delay, &config)).unwrap();
            block_on(sensor.start()).unwrap();
            let (begin, mut readings) = (wires.now(), 0);
            while wires.now().since(begin) < Duration::from_secs(10) {
                readings += u32::from(block_on(sensor.poll()).unwrap().is_some());
                wires.advance(2_000);
            }
            assert!(readings >= 10 * rate - 1, "{readings} in 10 s");
        });
    }
}

#[test]
fn the_status_codes_of_the_device_are_decoded() {
    with_ranger(|bus, mut delay, model, wires| {
        let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
        block_on(sensor.init(&mut delay, &Config::SIDE)).unwrap();
        block_on(sensor.start()).unwrap();
        await_reading(&mut sensor, wires).unwrap();
        for (code, status) in [
            (2, RangeStatus::Hardware(2)),
            (4, RangeStatus::SignalFail),
            (6, RangeStatus::SigmaFail),
            (7, RangeStatus::WrapTarget),
        ] {
            model.borrow_mut().ranging_fault = Vl53l1xFault::Status(code);
            let reading = await_reading(&mut sensor, wires).unwrap();
            assert_eq!((reading.status, reading.range()), (status, None));
        }
        model.borrow_mut().ranging_fault = Vl53l1xFault::None;
        model.borrow_mut().distance = Metres(9.0);
        let reading = await_reading(&mut sensor, wires).unwrap();
        assert_eq!(reading.status, RangeStatus::SignalFail);
    });
}

#[test]
fn another_device_is_refused() {
    with_ranger(|bus, mut delay, model, _| {
        model.borrow_mut().model_id = 0xEAAA;
        model.borrow_mut().reset();
        let outcome = block_on(Vl53l1x::new(bus, DEFAULT_ADDRESS).init(&mut delay, &Config::SIDE));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0xEAAA }));
    });
}

#[test]
fn every_wait_ends() {
    for (fault, ranging_fault, error, most) in [
        (Fault::Absent, Vl53l1xFault::None, Error::Bus(NO_ACKNOWLEDGE), 25),
        (Fault::Stuck(0x00), Vl53l1xFault::None, Error::Timeout, 25),
        (Fault::None, Vl53l1xFault::NeverBoots, Error::Timeout, 25),
        (Fault::None, Vl53l1xFault::NeverReady, Error::Timeout, 150),
    ] {
        with_ranger(|bus, mut delay, model, wires| {
            model.borrow_mut().fault = fault;
            model.borrow_mut().ranging_fault = ranging_fault;
            let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
            assert_eq!(block_on(sensor.init(&mut delay, &Config::SIDE)), Err(error), "{fault:?}");
            assert!(wires.transactions() <= most, "{} transactions", wires.transactions());
        });
    }
}

#[test]
fn an_unsupported_configuration_is_refused_before_it_is_written() {
    let (ms, mode) = (Duration::from_millis, DistanceMode::Long);
    for config in [
        Config { mode, budget: ms(15), period: ms(100) },
        Config { mode, budget: ms(501), period: ms(600) },
        Config { mode, budget: ms(33), period: ms(32) },
        Config { mode, budget: ms(33), period: Duration::MAX },
    ] {
        with_ranger(|bus, mut delay, _, _| {
            let mut bus = Recorder::new(bus);
            let outcome =
                block_on(Vl53l1x::new(&mut bus, DEFAULT_ADDRESS).init(&mut delay, &config));
            assert_eq!(outcome, Err(Error::Unsupported), "{config:?}");
            assert_eq!(bus.writes().matches(" w 00 ").count(), bus.writes().matches('!').count());
        });
    }
}

#[test]
fn the_address_changes_only_to_one_that_is_free() {
    let (one, other) = (RefCell::new(Vl53l1xModel::alone()), RefCell::new(Vl53l1xModel::alone()));
    let devices: [&RefCell<dyn I2cModel + '_>; 2] = [&one, &other];
    let wires = Wires::new(&devices);
    let mut delay = ModelDelay::new(&wires);
    one.borrow_mut().fault = Fault::Absent;
    wires.advance(2_000);
    let mut sensor = Vl53l1x::new(ModelBus::new(&wires), DEFAULT_ADDRESS);
    block_on(sensor.set_address(0x6A)).unwrap();
    assert_eq!((sensor.address(), other.borrow().address()), (0x6A, 0x6A));
    block_on(sensor.init(&mut delay, &Config::SIDE)).unwrap();

    one.borrow_mut().fault = Fault::None;
    wires.advance(2_000);
    let mut second = Vl53l1x::new(ModelBus::new(&wires), DEFAULT_ADDRESS);
    wires.advance(2_000);
    assert_eq!(block_on(second.set_address(0x6A)), Err(Error::AddressTaken));
    for reserved in [0x00, 0x07, 0x78, 0xFF] {
        assert_eq!(block_on(second.set_address(reserved)), Err(Error::Unsupported));
    }
    assert_eq!((second.address(), one.borrow().address()), (DEFAULT_ADDRESS, DEFAULT_ADDRESS));
    block_on(second.set_address(0x6B)).unwrap();
    assert_eq!((one.borrow().address(), other.borrow().address()), (0x6B, 0x6A));
}

#[test]
fn a_sensor_that_was_absent_can_be_initialised_again() {
    with_ranger(|bus, mut delay, model, wires| {
        let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
        for _ in 0..3 {
            block_on(sensor.init(&mut delay, &Config::SIDE)).unwrap();
            block_on(sensor.start()).unwrap();
            await_reading(&mut sensor, wires).unwrap();
            model.borrow_mut().fault = Fault::Absent;
            assert_eq!(block_on(sensor.poll()), Err(Error::Bus(NO_ACKNOWLEDGE)));
            model.borrow_mut().fault = Fault::None;
        }
    });
}

proptest! {
    #![proptest_config(seeded())]

    /// If any one transaction fails, the initialisation ends. If it succeeds the sensor ranges, and
    /// if it fails the next initialisation succeeds.
    #[test]
    fn a_failed_transaction_is_reported_or_has_no_effect(failing in 0u32..60) {
        with_ranger(|bus, mut delay, _, wires| {
            let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
            wires.refuse_after(Some(failing));
            let first = block_on(sensor.init(&mut delay, &Config::SIDE));
            wires.refuse_after(None);
            prop_assert!(matches!(first, Ok(()) | Err(Error::Bus(_))), "{:?}", first);
            if first.is_err() {
                prop_assert_eq!(block_on(sensor.init(&mut delay, &Config::SIDE)), Ok(()));
            }
            block_on(sensor.start()).unwrap();
            prop_assert!(await_reading(&mut sensor, wires).is_ok());
            Ok(())
        })?;
    }

    /// A device that acknowledges so many bytes and then none makes the initialisation fail, and
    /// the next one succeeds.
    #[test]
    fn a_device_that_stops_acknowledging_is_reported(bytes in 0u32..160) {
        with_ranger(|bus, mut delay, model, _| {
            let mut sensor = Vl53l1x::new(bus, DEFAULT_ADDRESS);
            model.borrow_mut().fault = Fault::NackAfter(bytes);
            let first = block_on(sensor.init(&mut delay, &Config::SIDE));
            prop_assert!(matches!(first, Err(Error::Bus(_))), "{:?}", first);
            model.borrow_mut().fault = Fault::None;
            prop_assert_eq!(block_on(sensor.init(&mut delay, &Config::SIDE)), Ok(()));
            Ok(())
        })?;
    }
}

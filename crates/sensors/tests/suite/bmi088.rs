//! The inertial sensor's drivers: their register accesses in order, the values of samples, and the
//! independence of the two dies.

use std::cell::RefCell;

use crate::common::{Recorder, block_on, seeded};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use proptest::prelude::*;
use sensors::Error;
use sensors::bmi088::{ACCEL, Accel, Bmi088, GYRO, Gyro, Keeper};
use sensors::models::{Bmi088Model, Fault, I2cModel, ModelBus, ModelDelay, Wires};
use units::{Acceleration, AngularVelocity};

const NO_ACKNOWLEDGE: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn with_imu<R>(
    test: impl FnOnce(ModelBus<'_>, ModelDelay<'_>, &RefCell<Bmi088Model>, &Wires<'_>) -> R,
) -> R {
    let model = RefCell::new(Bmi088Model::new());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    test(ModelBus::new(&wires), ModelDelay::new(&wires), &model, &wires)
}

/// The drivers of both dies, initialised.
fn initialised<'a>(
    bus: ModelBus<'a>,
    delay: &mut ModelDelay<'_>,
) -> (Bmi088<ModelBus<'a>, Gyro>, Bmi088<ModelBus<'a>, Accel>) {
    let (mut gyro, mut accel) = (Bmi088::new(bus), Bmi088::new(bus));
    block_on(gyro.init(delay)).unwrap();
    block_on(accel.init(delay)).unwrap();
    (gyro, accel)
}

#[test]
fn initialising_the_gyroscope_makes_these_transactions() {
    with_imu(|bus, mut delay, _, _| {
        let mut bus = Recorder::new(bus);
        block_on(Bmi088::<_, Gyro>::new(&mut bus).init(&mut delay)).unwrap();
        let expected = "\
69 w 14 b6
69 w 00 r 0f
69 w 11 00
69 w 0f 00
69 w 10 02
69 w 16 0d
69 w 18 01
69 w 15 80
69 w 0f r 00
69 w 10 r 82
69 w 0a r 00
69 w 0a r 00
69 w 0a r 00
69 w 0a r 80
";
        assert_eq!(bus.log, expected);
    });
}

#[test]
fn initialising_the_accelerometer_makes_these_transactions() {
    with_imu(|bus, mut delay, _, _| {
        let mut bus = Recorder::new(bus);
        block_on(Bmi088::<_, Accel>::new(&mut bus).init(&mut delay)).unwrap();
        let expected = "\
18 w 7e b6
18 w 00 r 1e
18 w 7c 00
18 w 7d 04
18 w 40 8c
18 w 41 03
18 w 40 r 8c
18 w 41 r 03
18 w 7d r 04
18 w 03 r 80
";
        assert_eq!(bus.log, expected);
    });
}

#[test]
fn a_drone_at_rest_measures_one_g_upwards_and_no_rate() {
    with_imu(|bus, mut delay, _, _| {
        let (mut gyro, mut accel) = initialised(bus, &mut delay);
        assert_eq!(block_on(gyro.read()), Ok(AngularVelocity::default()));
        let Acceleration([x, y, z]) = block_on(accel.read()).unwrap();
        assert!(x == 0.0 && y == 0.0 && (z - 9.806_65).abs() < 0.004, "{x} {y} {z}");
    });
}

#[test]
fn a_sample_of_both_takes_less_than_half_a_millisecond() {
    with_imu(|bus, mut delay, _, wires| {
        let (mut gyro, mut accel) = initialised(bus, &mut delay);
        let before = wires.now();
        block_on(gyro.read()).unwrap();
        block_on(accel.read()).unwrap();
        let took = wires.now().since(before).as_micros();
        assert!(took < 500, "{took} us");
    });
}

#[test]
fn there_is_a_new_sample_every_millisecond() {
    with_imu(|bus, mut delay, model, wires| {
        let (mut gyro, mut accel) = initialised(bus, &mut delay);
        for step in 1..50_i16 {
            let truth = f32::from(step) * 0.1;
            let rates = AngularVelocity([truth, 0.0, 0.0]);
            model.borrow_mut().set(rates, Acceleration([0.0, truth, 0.0]));
            wires.advance(1_000);
            let [rate, ..] = block_on(gyro.read()).unwrap().0;
            let [_, force, _] = block_on(accel.read()).unwrap().0;
            assert!((rate - truth).abs() < 0.001, "{rate} of {truth}");
            assert!((force - truth).abs() < 0.004, "{force} of {truth}");
        }
    });
}

#[test]
fn a_die_with_another_identification_is_refused() {
    with_imu(|bus, mut delay, model, _| {
        model.borrow_mut().set_ids(0x0E, 0x1F);
        let outcome = block_on(Bmi088::<_, Gyro>::new(bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0x0E }));
        let outcome = block_on(Bmi088::<_, Accel>::new(bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0x1F }));
    });
}

#[test]
fn an_absent_die_is_an_error_of_the_bus_and_the_other_works() {
    with_imu(|bus, mut delay, model, _| {
        let (mut gyro, mut accel) = initialised(bus, &mut delay);
        model.borrow_mut().accel_fault = Fault::Absent;
        assert_eq!(block_on(accel.read()), Err(Error::Bus(NO_ACKNOWLEDGE)));
        assert_eq!(block_on(accel.init(&mut delay)), Err(Error::Bus(NO_ACKNOWLEDGE)));
        assert!(block_on(gyro.read()).is_ok());
        assert_eq!(block_on(gyro.init(&mut delay)), Ok(()));
        model.borrow_mut().accel_fault = Fault::None;
        model.borrow_mut().gyro_fault = Fault::Absent;
        assert_eq!(block_on(gyro.read()), Err(Error::Bus(NO_ACKNOWLEDGE)));
        assert_eq!(block_on(gyro.init(&mut delay)), Err(Error::Bus(NO_ACKNOWLEDGE)));
        assert!(block_on(accel.read()).is_ok());
        assert_eq!(block_on(accel.init(&mut delay)), Ok(()));
    });
}

#[test]
fn a_die_that_lost_its_configuration_is_detected() {
    with_imu(|bus, mut delay, model, _| {
        let (mut gyro, mut accel) = initialised(bus, &mut delay);
        assert_eq!((block_on(gyro.verify()), block_on(accel.verify())), (Ok(()), Ok(())));
        model.borrow_mut().reset_gyro();
        assert!(block_on(gyro.read()).is_ok(), "the die does not answer any more");
        assert_eq!(block_on(gyro.verify()), Err(Error::NotKept { register: 0x10 }));
        assert_eq!(block_on(accel.verify()), Ok(()));
        model.borrow_mut().reset_accel();
        assert!(block_on(accel.read()).is_ok(), "the die does not answer any more");
        assert_eq!(block_on(accel.verify()), Err(Error::NotKept { register: 0x40 }));
        block_on(gyro.init(&mut delay)).unwrap();
        block_on(accel.init(&mut delay)).unwrap();
        assert_eq!((block_on(gyro.verify()), block_on(accel.verify())), (Ok(()), Ok(())));
    });
}

#[test]
fn initialising_a_die_that_never_has_a_sample_is_a_timeout() {
    with_imu(|bus, mut delay, _, wires| {
        let mut bus = Recorder::new(bus);
        bus.replacement = Some((GYRO, vec![0x0A], 0x00));
        let outcome = block_on(Bmi088::<_, Gyro>::new(&mut bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::Timeout));
        bus.replacement = Some((ACCEL, vec![0x03], 0x00));
        let outcome = block_on(Bmi088::<_, Accel>::new(&mut bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::Timeout));
        assert!(wires.transactions() < 130, "{} transactions", wires.transactions());
    });
}

/// The two dies with their keepers, as in the firmware.
struct KeptDies<'a> {
    gyro: Keeper<ModelBus<'a>, Gyro>,
    accel: Keeper<ModelBus<'a>, Accel>,
    delay: ModelDelay<'a>,
    wires: &'a Wires<'a>,
    model: &'a RefCell<Bmi088Model>,
}

impl KeptDies<'_> {
    /// Runs so many rounds of a millisecond with changing values, and returns the number of samples
    /// of each die.
    fn run(&mut self, rounds: u32) -> (u32, u32) {
        let (mut rates, mut forces) = (0, 0);
        let clock = || self.wires.now();
        for round in 0..rounds {
            let noise = 0.05 * f32::from(u8::try_from(round % 7).unwrap());
            let (x, y) = (AngularVelocity([noise; 3]), Acceleration([noise, 0.0, 9.8]));
            self.model.borrow_mut().set(x, y);
            self.wires.advance(1_000);
            if self.gyro.is_lost(clock()) {
                block_on(self.gyro.bring_up(clock, &mut self.delay));
            } else {
                rates += u32::from(block_on(self.gyro.read(clock)).is_some());
            }
            if self.accel.is_lost(clock()) {
                block_on(self.accel.bring_up(clock, &mut self.delay));
            } else {
                forces += u32::from(block_on(self.accel.read(clock)).is_some());
            }
        }
        (rates, forces)
    }
}

fn with_keepers<R>(test: impl FnOnce(&mut KeptDies<'_>) -> R) -> R {
    let model = RefCell::new(Bmi088Model::new());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    let (bus, now) = (ModelBus::new(&wires), wires.now());
    let (gyro, accel) = (Keeper::new(bus, now), Keeper::new(bus, now));
    let delay = ModelDelay::new(&wires);
    let mut dies = KeptDies { gyro, accel, delay, wires: &wires, model: &model };
    dies.run(2);
    test(&mut dies)
}

#[test]
fn a_failed_accelerometer_costs_the_gyroscope_no_sample_and_recovers() {
    for fault in [Fault::Absent, Fault::NackAfter(40), Fault::Stuck(0x00)] {
        with_keepers(|dies| {
            assert_eq!(dies.run(100), (100, 100));
            dies.model.borrow_mut().accel_fault = fault;
            let (rates, forces) = dies.run(2_000);
            assert_eq!(rates, 2_000, "{fault:?}");
            assert!(forces < 20, "{fault:?}: {forces} samples");
            assert_eq!(dies.accel.losses(), 1);
            dies.model.borrow_mut().accel_fault = Fault::None;
            dies.run(1_100);
            assert_eq!(dies.run(100), (100, 100), "{fault:?}");
            assert_eq!((dies.gyro.errors(), dies.gyro.losses()), (0, 0));
        });
    }
}

#[test]
fn a_failed_gyroscope_costs_the_accelerometer_no_sample_and_recovers() {
    for fault in [Fault::Absent, Fault::Stuck(0xFF)] {
        with_keepers(|dies| {
            dies.run(100);
            dies.model.borrow_mut().gyro_fault = fault;
            let (rates, forces) = dies.run(2_000);
            assert!(rates < 10 && forces == 2_000, "{fault:?}: {rates} {forces}");
            dies.model.borrow_mut().gyro_fault = Fault::None;
            dies.run(110);
            assert_eq!(dies.run(100), (100, 100), "{fault:?}");
            assert_eq!((dies.accel.errors(), dies.accel.losses()), (0, 0));
        });
    }
}

/// A sleeping accelerometer still answers, with the same sample every time.
#[test]
fn an_accelerometer_that_fell_asleep_is_woken() {
    with_keepers(|dies| {
        dies.run(100);
        dies.model.borrow_mut().reset_accel();
        dies.run(50);
        assert_eq!(dies.accel.losses(), 1);
        assert_eq!(dies.run(100), (100, 100));
    });
}

#[test]
fn samples_of_a_gyroscope_that_a_dip_reset_to_another_range_are_refused() {
    with_keepers(|dies| {
        dies.run(100);
        dies.model.borrow_mut().reset_gyro();
        // Only a missed sample reveals that the die was reset.
        dies.gyro.missed(dies.wires.now());
        let clock = || dies.wires.now();
        assert_eq!(block_on(dies.gyro.read(clock)), None);
        assert!(dies.gyro.is_lost(clock()));
        dies.run(10);
        assert_eq!(dies.run(100), (100, 100));
    });
}

#[test]
fn attempts_at_a_failed_die_become_less_frequent() {
    with_keepers(|dies| {
        dies.model.borrow_mut().accel_fault = Fault::Absent;
        dies.model.borrow_mut().gyro_fault = Fault::Absent;
        dies.run(1_000);
        let (gyro, accel) = (dies.gyro.errors(), dies.accel.errors());
        dies.run(10_000);
        let (gyro, accel) = (dies.gyro.errors() - gyro, dies.accel.errors() - accel);
        assert!((90..=110).contains(&gyro) && (9..=11).contains(&accel), "{gyro} {accel}");
    });
}

proptest! {
    #![proptest_config(seeded())]

    /// A sample is the true value to half a step, and saturates at the end of the range.
    #[test]
    fn a_sample_is_the_truth_to_half_a_step(
        rates in prop::array::uniform3(-45.0f32..45.0),
        force in prop::array::uniform3(-300.0f32..300.0),
    ) {
        with_imu(|bus, mut delay, model, _| {
            model.borrow_mut().set(AngularVelocity(rates), Acceleration(force));
            let (mut gyro, mut accel) = initialised(bus, &mut delay);
            let (read, accel_read) = (block_on(gyro.read()).unwrap(), block_on(accel.read()).unwrap());
            let near = |sample: [f32; 3], truth: [f32; 3], step: f32, most: f32| {
                sample.iter().zip(truth).all(|(sample, truth)| {
                    (sample - truth.clamp(-most, most)).abs() <= 1.5 * step
                })
            };
            prop_assert!(near(read.0, rates, 0.001_066, 34.906), "{:?}", read);
            prop_assert!(near(accel_read.0, force, 0.007_183, 235.36), "{:?}", accel_read);
            Ok(())
        })?;
    }

    /// If any one transaction fails, the initialisation reports it and the next one succeeds.
    #[test]
    fn a_failed_transaction_is_reported_and_the_next_initialisation_succeeds(failing in 0u32..10) {
        with_imu(|bus, mut delay, _, wires| {
            let mut gyro = Bmi088::<_, Gyro>::new(bus);
            wires.refuse_after(Some(failing));
            prop_assert_eq!(block_on(gyro.init(&mut delay)), Err(Error::Bus(NO_ACKNOWLEDGE)));
            // The die may still be in the reset that the failed initialisation has requested.
            wires.advance(30_000);
            prop_assert_eq!(block_on(gyro.init(&mut delay)), Ok(()));
            let mut accel = Bmi088::<_, Accel>::new(bus);
            wires.refuse_after(Some(failing));
            prop_assert_eq!(block_on(accel.init(&mut delay)), Err(Error::Bus(NO_ACKNOWLEDGE)));
            wires.advance(1_000);
            prop_assert_eq!(block_on(accel.init(&mut delay)), Ok(()));
            Ok(())
        })?;
    }

    /// A single failed transaction costs one sample and loses no die.
    #[test]
    fn a_failed_transaction_in_flight_costs_one_sample(failing in 0u32..190) {
        with_keepers(|dies| {
            dies.wires.refuse_after(Some(failing));
            let (rates, forces) = dies.run(100);
            prop_assert_eq!(rates + forces, 199);
            prop_assert_eq!((dies.gyro.losses(), dies.accel.losses()), (0, 0));
            Ok(())
        })?;
    }
}

#[test]
fn a_sample_between_the_reads_of_two_bytes_does_not_mix_with_the_last() {
    let mut model = Bmi088Model::new();
    model.set(AngularVelocity([1.0, 0.0, 0.0]), Acceleration([0.0; 3]));
    model.advance(1_000);
    assert!(model.start(0x69, false) && model.write(0x02) && model.start(0x69, true));
    let low = model.read();
    model.set(AngularVelocity([-1.0, 0.0, 0.0]), Acceleration([0.0; 3]));
    model.advance(1_000);
    let step = 2000.0_f32.to_radians() / 32768.0;
    let raw = i16::from_le_bytes([low, model.read()]);
    assert!((f32::from(raw) * step - 1.0).abs() < step);
}

#[test]
fn data_ready_is_on_the_pin_that_it_is_mapped_to_with_the_configured_polarity() {
    let mut model = Bmi088Model::new();
    let set = |model: &mut Bmi088Model, register, value| {
        assert!(model.start(0x69, false) && model.write(register) && model.write(value));
    };
    model.advance(500);
    assert_eq!(
        (model.int3(), model.int3_changes_in()),
        (Some(false), None),
        "data ready is signalled before it is enabled"
    );
    for (register, value) in [(0x10, 0x02), (0x16, 0x0D), (0x18, 0x01), (0x15, 0x80)] {
        set(&mut model, register, value);
    }
    model.advance(1_000);
    let pulse = model.int3_changes_in().unwrap();
    assert_eq!((model.int3(), pulse <= 400), (Some(true), true));
    set(&mut model, 0x16, 0x0F);
    assert_eq!(model.int3(), None, "an open drain releases the line");
    model.advance(pulse);
    assert_eq!((model.int3(), model.gyro_register(0x0A)), (Some(false), 0x00));
    set(&mut model, 0x16, 0x0D);
    assert_eq!(model.int3(), Some(false));
    set(&mut model, 0x16, 0x0C);
    assert_eq!(model.int3(), Some(true), "active low");
}

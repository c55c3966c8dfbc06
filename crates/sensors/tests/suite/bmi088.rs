//! The inertial sensor's drivers against their registers: what they write, in which order, what
//! they make of the samples, and that one die that does not do its part does not cost the other.

use std::cell::RefCell;

use crate::common::{Recorder, block_on, seeded};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use proptest::prelude::*;
use sensors::Error;
use sensors::bmi088::{ACCEL, Accel, Bmi088, GYRO, Gyro, Keeper};
use sensors::models::{Bmi088Model, Fault, I2cModel, ModelBus, ModelDelay, Wires};
use units::{Acceleration, AngularVelocity};

const NOBODY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn with_imu<R>(
    test: impl FnOnce(ModelBus<'_>, ModelDelay<'_>, &RefCell<Bmi088Model>, &Wires<'_>) -> R,
) -> R {
    let model = RefCell::new(Bmi088Model::new());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    test(ModelBus::new(&wires), ModelDelay::new(&wires), &model, &wires)
}

/// Both dies, brought up.
fn brought_up<'a>(
    bus: ModelBus<'a>,
    delay: &mut ModelDelay<'_>,
) -> (Bmi088<ModelBus<'a>, Gyro>, Bmi088<ModelBus<'a>, Accel>) {
    let (mut gyro, mut accel) = (Bmi088::new(bus), Bmi088::new(bus));
    block_on(gyro.init(delay)).unwrap();
    block_on(accel.init(delay)).unwrap();
    (gyro, accel)
}

#[test]
fn bringing_the_gyroscope_up_is_this_conversation() {
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
fn bringing_the_accelerometer_up_is_this_conversation() {
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
fn a_drone_at_rest_feels_one_g_upwards_and_does_not_turn() {
    with_imu(|bus, mut delay, _, _| {
        let (mut gyro, mut accel) = brought_up(bus, &mut delay);
        assert_eq!(block_on(gyro.read()), Ok(AngularVelocity::default()));
        let Acceleration([x, y, z]) = block_on(accel.read()).unwrap();
        assert!(x == 0.0 && y == 0.0 && (z - 9.806_65).abs() < 0.004, "{x} {y} {z}");
    });
}

#[test]
fn a_sample_of_both_takes_less_than_half_a_millisecond() {
    with_imu(|bus, mut delay, _, wires| {
        let (mut gyro, mut accel) = brought_up(bus, &mut delay);
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
        let (mut gyro, mut accel) = brought_up(bus, &mut delay);
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
fn a_die_with_another_name_is_refused() {
    with_imu(|bus, mut delay, model, _| {
        model.borrow_mut().set_ids(0x0E, 0x1F);
        let outcome = block_on(Bmi088::<_, Gyro>::new(bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0x0E }));
        let outcome = block_on(Bmi088::<_, Accel>::new(bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0x1F }));
    });
}

#[test]
fn an_absent_die_is_an_error_of_the_bus_and_the_other_is_there() {
    with_imu(|bus, mut delay, model, _| {
        let (mut gyro, mut accel) = brought_up(bus, &mut delay);
        model.borrow_mut().accel_fault = Fault::Absent;
        assert_eq!(block_on(accel.read()), Err(Error::Bus(NOBODY)));
        assert_eq!(block_on(accel.init(&mut delay)), Err(Error::Bus(NOBODY)));
        assert!(block_on(gyro.read()).is_ok());
        assert_eq!(block_on(gyro.init(&mut delay)), Ok(()));
        model.borrow_mut().accel_fault = Fault::None;
        model.borrow_mut().gyro_fault = Fault::Absent;
        assert_eq!(block_on(gyro.read()), Err(Error::Bus(NOBODY)));
        assert_eq!(block_on(gyro.init(&mut delay)), Err(Error::Bus(NOBODY)));
        assert!(block_on(accel.read()).is_ok());
        assert_eq!(block_on(accel.init(&mut delay)), Ok(()));
    });
}

#[test]
fn a_die_that_forgot_its_configuration_is_found_out() {
    with_imu(|bus, mut delay, model, _| {
        let (mut gyro, mut accel) = brought_up(bus, &mut delay);
        assert_eq!((block_on(gyro.verify()), block_on(accel.verify())), (Ok(()), Ok(())));
        model.borrow_mut().reset_gyro();
        assert!(block_on(gyro.read()).is_ok(), "it still answers");
        assert_eq!(block_on(gyro.verify()), Err(Error::NotKept { register: 0x10 }));
        assert_eq!(block_on(accel.verify()), Ok(()));
        model.borrow_mut().reset_accel();
        assert!(block_on(accel.read()).is_ok(), "it still answers");
        assert_eq!(block_on(accel.verify()), Err(Error::NotKept { register: 0x40 }));
        block_on(gyro.init(&mut delay)).unwrap();
        block_on(accel.init(&mut delay)).unwrap();
        assert_eq!((block_on(gyro.verify()), block_on(accel.verify())), (Ok(()), Ok(())));
    });
}

#[test]
fn a_die_that_never_has_a_sample_is_not_waited_for_for_ever() {
    with_imu(|bus, mut delay, _, wires| {
        let mut bus = Recorder::new(bus);
        bus.instead = Some((GYRO, vec![0x0A], 0x00));
        let outcome = block_on(Bmi088::<_, Gyro>::new(&mut bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::Timeout));
        bus.instead = Some((ACCEL, vec![0x03], 0x00));
        let outcome = block_on(Bmi088::<_, Accel>::new(&mut bus).init(&mut delay));
        assert_eq!(outcome, Err(Error::Timeout));
        assert!(wires.transactions() < 130, "{} transactions", wires.transactions());
    });
}

/// The two dies as the firmware keeps them.
struct Kept<'a> {
    gyro: Keeper<ModelBus<'a>, Gyro>,
    accel: Keeper<ModelBus<'a>, Accel>,
    delay: ModelDelay<'a>,
    wires: &'a Wires<'a>,
    model: &'a RefCell<Bmi088Model>,
}

impl Kept<'_> {
    /// So many rounds of a millisecond, noise and all; how many samples of each die there were.
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

fn with_kept<R>(test: impl FnOnce(&mut Kept<'_>) -> R) -> R {
    let model = RefCell::new(Bmi088Model::new());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    let (bus, now) = (ModelBus::new(&wires), wires.now());
    let (gyro, accel) = (Keeper::new(bus, now), Keeper::new(bus, now));
    let delay = ModelDelay::new(&wires);
    let mut kept = Kept { gyro, accel, delay, wires: &wires, model: &model };
    kept.run(2);
    test(&mut kept)
}

#[test]
fn a_dead_accelerometer_costs_the_gyroscope_no_sample_and_comes_back() {
    for fault in [Fault::Absent, Fault::NackAfter(40), Fault::Stuck(0x00)] {
        with_kept(|kept| {
            assert_eq!(kept.run(100), (100, 100));
            kept.model.borrow_mut().accel_fault = fault;
            let (rates, forces) = kept.run(2_000);
            assert_eq!(rates, 2_000, "{fault:?}");
            assert!(forces < 20, "{fault:?}: {forces} samples");
            assert_eq!(kept.accel.losses(), 1);
            kept.model.borrow_mut().accel_fault = Fault::None;
            kept.run(1_100);
            assert_eq!(kept.run(100), (100, 100), "{fault:?}");
            assert_eq!((kept.gyro.errors(), kept.gyro.losses()), (0, 0));
        });
    }
}

#[test]
fn a_dead_gyroscope_leaves_the_accelerometer_alone_and_comes_back() {
    for fault in [Fault::Absent, Fault::Stuck(0xFF)] {
        with_kept(|kept| {
            kept.run(100);
            kept.model.borrow_mut().gyro_fault = fault;
            let (rates, forces) = kept.run(2_000);
            assert!(rates < 10 && forces == 2_000, "{fault:?}: {rates} {forces}");
            kept.model.borrow_mut().gyro_fault = Fault::None;
            kept.run(110);
            assert_eq!(kept.run(100), (100, 100), "{fault:?}");
            assert_eq!((kept.accel.errors(), kept.accel.losses()), (0, 0));
        });
    }
}

/// It answers as before, and always the same.
#[test]
fn an_accelerometer_that_fell_asleep_is_woken() {
    with_kept(|kept| {
        kept.run(100);
        kept.model.borrow_mut().reset_accel();
        kept.run(50);
        assert_eq!(kept.accel.losses(), 1);
        assert_eq!(kept.run(100), (100, 100));
    });
}

#[test]
fn a_gyroscope_that_comes_back_from_a_dip_with_another_range_is_not_believed() {
    with_kept(|kept| {
        kept.run(100);
        kept.model.borrow_mut().reset_gyro();
        // That it was gone for a moment is all that gives it away.
        kept.gyro.missed(kept.wires.now());
        let clock = || kept.wires.now();
        assert_eq!(block_on(kept.gyro.read(clock)), None);
        assert!(kept.gyro.is_lost(clock()));
        kept.run(10);
        assert_eq!(kept.run(100), (100, 100));
    });
}

#[test]
fn attempts_at_a_dead_die_become_ever_rarer() {
    with_kept(|kept| {
        kept.model.borrow_mut().accel_fault = Fault::Absent;
        kept.model.borrow_mut().gyro_fault = Fault::Absent;
        kept.run(1_000);
        let (gyro, accel) = (kept.gyro.errors(), kept.accel.errors());
        kept.run(10_000);
        let (gyro, accel) = (kept.gyro.errors() - gyro, kept.accel.errors() - accel);
        assert!((90..=110).contains(&gyro) && (9..=11).contains(&accel), "{gyro} {accel}");
    });
}

proptest! {
    #![proptest_config(seeded())]

    /// What is measured is what is, to half a step, and stays at the end of the range beyond it.
    #[test]
    fn a_sample_is_the_truth_to_half_a_step(
        rates in prop::array::uniform3(-45.0f32..45.0),
        force in prop::array::uniform3(-300.0f32..300.0),
    ) {
        with_imu(|bus, mut delay, model, _| {
            model.borrow_mut().set(AngularVelocity(rates), Acceleration(force));
            let (mut gyro, mut accel) = brought_up(bus, &mut delay);
            let (read, felt) = (block_on(gyro.read()).unwrap(), block_on(accel.read()).unwrap());
            let near = |is: [f32; 3], should: [f32; 3], step: f32, most: f32| {
                is.iter().zip(should).all(|(is, should)| {
                    (is - should.clamp(-most, most)).abs() <= 1.5 * step
                })
            };
            prop_assert!(near(read.0, rates, 0.001_066, 34.906), "{:?}", read);
            prop_assert!(near(felt.0, force, 0.007_183, 235.36), "{:?}", felt);
            Ok(())
        })?;
    }

    /// Whichever transaction is lost, the initialisation says so and the next one succeeds.
    #[test]
    fn a_lost_transaction_is_reported_and_made_good(lost in 0u32..10) {
        with_imu(|bus, mut delay, _, wires| {
            let mut gyro = Bmi088::<_, Gyro>::new(bus);
            wires.refuse_after(Some(lost));
            prop_assert_eq!(block_on(gyro.init(&mut delay)), Err(Error::Bus(NOBODY)));
            // The one after may come while the die is still in the reset that was asked of it.
            wires.advance(30_000);
            prop_assert_eq!(block_on(gyro.init(&mut delay)), Ok(()));
            let mut accel = Bmi088::<_, Accel>::new(bus);
            wires.refuse_after(Some(lost));
            prop_assert_eq!(block_on(accel.init(&mut delay)), Err(Error::Bus(NOBODY)));
            wires.advance(1_000);
            prop_assert_eq!(block_on(accel.init(&mut delay)), Ok(()));
            Ok(())
        })?;
    }

    /// Single transactions that are lost cost a sample each and no die.
    #[test]
    fn a_lost_transaction_in_flight_costs_one_sample(lost in 0u32..190) {
        with_kept(|kept| {
            kept.wires.refuse_after(Some(lost));
            let (rates, forces) = kept.run(100);
            prop_assert_eq!(rates + forces, 199);
            prop_assert_eq!((kept.gyro.losses(), kept.accel.losses()), (0, 0));
            Ok(())
        })?;
    }
}

#[test]
fn a_sample_that_comes_between_the_bytes_of_an_axis_does_not_tear_it_apart() {
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
fn data_ready_is_on_the_pin_when_it_was_led_there_with_the_polarity_asked_for() {
    let mut model = Bmi088Model::new();
    let set = |model: &mut Bmi088Model, register, value| {
        assert!(model.start(0x69, false) && model.write(register) && model.write(value));
    };
    model.advance(500);
    assert_eq!((model.int3(), model.int3_changes_in()), (Some(false), None), "nobody asked");
    for (register, value) in [(0x10, 0x02), (0x16, 0x0D), (0x18, 0x01), (0x15, 0x80)] {
        set(&mut model, register, value);
    }
    model.advance(1_000);
    let pulse = model.int3_changes_in().unwrap();
    assert_eq!((model.int3(), pulse <= 400), (Some(true), true));
    set(&mut model, 0x16, 0x0F);
    assert_eq!(model.int3(), None, "an open drain lets go of the line");
    model.advance(pulse);
    assert_eq!((model.int3(), model.gyro_register(0x0A)), (Some(false), 0x00));
    set(&mut model, 0x16, 0x0D);
    assert_eq!(model.int3(), Some(false));
    set(&mut model, 0x16, 0x0C);
    assert_eq!(model.int3(), Some(true), "active low");
}

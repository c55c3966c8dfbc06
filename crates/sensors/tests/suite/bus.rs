//! Recovery of a bus that a device holds, and the decision when a device is lost.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;

use crate::common::{block_on, seeded};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use proptest::prelude::*;
use sensors::bus::{Health, HealthConfig, recover};
use sensors::models::{ModelDelay, Wires};
use units::{Duration, Instant};

/// Two open-drain lines and a device that was interrupted while it sent: it holds SDA low until SCL
/// has risen `held_for` times more.
struct Lines {
    scl: Cell<bool>,
    sda: Cell<bool>,
    held_for: Cell<u32>,
    clocks: Cell<u32>,
    stops: Cell<u32>,
    log: RefCell<String>,
}

impl Lines {
    fn held_for(clocks: u32) -> Self {
        Self {
            scl: Cell::new(true),
            sda: Cell::new(true),
            held_for: Cell::new(clocks),
            clocks: Cell::new(0),
            stops: Cell::new(0),
            log: RefCell::default(),
        }
    }

    fn sda_level(&self) -> bool {
        self.sda.get() && self.held_for.get() == 0
    }
}

struct Scl<'a>(&'a Lines);
struct Sda<'a>(&'a Lines);

impl ErrorType for Scl<'_> {
    type Error = Infallible;
}

impl OutputPin for Scl<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.scl.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        if !self.0.scl.replace(true) {
            self.0.clocks.set(self.0.clocks.get() + 1);
            self.0.held_for.set(self.0.held_for.get().saturating_sub(1));
            self.0.log.borrow_mut().push('c');
        }
        Ok(())
    }
}

impl ErrorType for Sda<'_> {
    type Error = Infallible;
}

impl OutputPin for Sda<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.sda.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let rises = !self.0.sda.replace(true) && self.0.held_for.get() == 0;
        if rises && self.0.scl.get() {
            self.0.stops.set(self.0.stops.get() + 1);
            self.0.log.borrow_mut().push('P');
        }
        Ok(())
    }
}

impl InputPin for Sda<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.sda_level())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.sda_level())
    }
}

fn run(lines: &Lines) -> bool {
    let wires = Wires::new(&[]);
    let mut delay = ModelDelay::new(&wires);
    let free = block_on(recover(&mut Scl(lines), &mut Sda(lines), &mut delay));
    assert!(wires.now().as_micros() < 200);
    free
}

#[test]
fn sda_is_freed_with_as_many_clocks_as_the_device_needs_and_a_stop() {
    for held in 0..=9 {
        let lines = Lines::held_for(held);
        assert!(run(&lines), "held for {held} clocks");
        assert!(lines.scl.get() && lines.sda.get(), "a line is not released");
        assert_eq!(
            lines.clocks.get(),
            held + 1,
            "one clock more than the device needs belongs to the stop"
        );
        assert_eq!(lines.stops.get(), 1, "{}", lines.log.borrow());
    }
}

#[test]
fn recovery_of_a_shorted_line_ends_after_nine_clocks() {
    let lines = Lines::held_for(u32::MAX);
    assert!(!run(&lines));
    assert_eq!(lines.clocks.get(), 10);
}

const CONFIG: HealthConfig = HealthConfig::DEFAULT;

fn at(ms: u64) -> Instant {
    Instant::from_millis(ms)
}

#[test]
fn a_device_is_lost_after_more_errors_in_a_row_than_are_tolerated() {
    let mut health = Health::new(CONFIG, at(0));
    health.started(at(0));
    for round in 0..10 {
        for _ in 0..CONFIG.tolerated {
            health.bad(at(round));
        }
        assert!(!health.is_lost(at(round)));
        health.good(at(round));
    }
    for _ in 0..=CONFIG.tolerated {
        health.bad(at(10));
    }
    assert!(health.is_lost(at(10)));
    assert_eq!((health.losses(), health.errors()), (1, 23));
}

#[test]
fn a_device_that_delivers_nothing_is_lost_even_without_an_error() {
    let mut health = Health::new(CONFIG, at(0));
    health.started(at(100));
    assert!(!health.is_lost(at(349)));
    assert!(health.is_lost(at(350)));
    assert!(!health.may_retry(at(399)));
    assert!(health.may_retry(at(400)));
}

#[test]
fn the_time_between_attempts_doubles_up_to_a_limit() {
    let mut health = Health::new(CONFIG, at(0));
    assert!(health.may_retry(at(0)), "a device that was never tried is not due");
    let mut waits = Vec::new();
    let mut now = 0;
    for _ in 0..9 {
        health.lose(at(now));
        let since = now;
        while !health.may_retry(at(now)) {
            now += 1;
        }
        waits.push(now - since);
    }
    assert_eq!(waits, [50, 100, 200, 400, 800, 1_600, 2_000, 2_000, 2_000]);
    health.started(at(now));
    health.lose(at(now));
    assert!(!health.may_retry(at(now + 1_999)), "a start without data has made the wait short");
    health.good(at(now));
    health.lose(at(now));
    assert!(health.may_retry(at(now + 50)), "a device that delivered data is not tried soon again");
}

proptest! {
    #![proptest_config(seeded())]

    /// After any sequence of events a lost device is due again within the longest wait.
    #[test]
    fn every_lost_device_is_tried_again(
        events in prop::collection::vec((0u8..5, 0u64..500), 1..200),
    ) {
        let mut now = at(0);
        let mut health = Health::new(CONFIG, now);
        for (event, ms) in events {
            now = now + Duration::from_millis(ms);
            match event {
                0 => health.started(now),
                1 => health.good(now),
                2 => health.bad(now),
                3 => health.lose(now),
                _ => {
                    health.is_lost(now);
                }
            }
            let later = now + CONFIG.longest_retry;
            let mut then = health;
            prop_assert!(!then.is_lost(now) || then.may_retry(later));
        }
    }
}

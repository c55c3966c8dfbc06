//! Helpers of the drivers' tests: an executor for futures that never wait, a bus that records its
//! transactions, and models of the two decks.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::future::Future;
use std::pin::pin;
use std::sync::atomic::AtomicU8;
use std::task::{Context, Poll, Waker};

use embedded_hal::i2c::{ErrorKind, ErrorType, Operation};
use embedded_hal_async::i2c::I2c;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sensors::expander::Lines;
use sensors::models::{ExpanderModel, I2cModel, ModelBus, ModelDelay, Vl53l1xModel, Wires};
use sensors::multi_ranger::Beam;
use units::Metres;

/// Runs a future on models, which is always ready because a model's delay returns at once.
pub(crate) fn block_on<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    match future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => panic!("a model made its driver wait"),
    }
}

pub(crate) fn seeded() -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        cases: 64,
        ..Default::default()
    }
}

/// A bus that records every transaction: `18 w 7e b6` is a write, `18 w 00 r 1e` a write and a
/// read, and `!` ends one that failed. It can replace the bytes that are read.
pub(crate) struct Recorder<I2C> {
    bus: I2C,
    pub(crate) log: String,
    /// Device, register and byte: reads of this register give this byte.
    pub(crate) replacement: Option<(u8, Vec<u8>, u8)>,
}

impl<I2C> Recorder<I2C> {
    pub(crate) fn new(bus: I2C) -> Self {
        Self { bus, log: String::new(), replacement: None }
    }

    /// The record of the writes alone, which configure a device.
    pub(crate) fn writes(&self) -> String {
        self.log
            .lines()
            .filter(|line| !line.contains(" r"))
            .map(|line| format!("{line}\n"))
            .collect()
    }
}

impl<I2C: ErrorType> ErrorType for Recorder<I2C> {
    type Error = I2C::Error;
}

impl<I2C: I2c<Error = ErrorKind>> I2c for Recorder<I2C> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        let outcome = self.bus.transaction(address, operations).await;
        let mut written = Vec::new();
        write!(self.log, "{address:02x}").unwrap();
        for operation in operations {
            let (direction, bytes) = match operation {
                Operation::Write(bytes) => {
                    written = bytes.to_vec();
                    ("w", written.clone())
                }
                Operation::Read(bytes) => {
                    if let Some((of, register, byte)) = &self.replacement
                        && *of == address
                        && *register == written
                    {
                        bytes.fill(*byte);
                    }
                    ("r", bytes.to_vec())
                }
            };
            write!(self.log, " {direction}").unwrap();
            for byte in bytes {
                write!(self.log, " {byte:02x}").unwrap();
            }
        }
        self.log.push_str(if outcome.is_ok() { "\n" } else { " !\n" });
        outcome
    }
}

/// A loose contact in the supply of a ranger: a device on the bus that never answers, and that
/// resets a ranger after a set time, even in the middle of a transaction.
pub(crate) struct LooseContact<'a> {
    rangers: [&'a RefCell<Vl53l1xModel<&'a AtomicU8>>; 6],
    due: Option<(u32, usize)>,
}

impl LooseContact<'_> {
    /// Resets the ranger with this index after so many µs.
    pub(crate) fn reset_later(&mut self, ranger: usize, after_micros: u32) {
        self.due = Some((after_micros, ranger));
    }
}

impl I2cModel for LooseContact<'_> {
    fn start(&mut self, _address: u8, _read: bool) -> bool {
        false
    }

    fn write(&mut self, _byte: u8) -> bool {
        false
    }

    fn read(&mut self) -> u8 {
        0xFF
    }

    fn stop(&mut self) {}

    fn advance(&mut self, micros: u32) {
        match self.due {
            Some((left, ranger)) if left <= micros => {
                self.rangers[ranger].borrow_mut().reset();
                self.due = None;
            }
            Some((left, ranger)) => self.due = Some((left - micros, ranger)),
            None => {}
        }
    }
}

/// Models of both decks, each ranger of which sees a wall at a distance of its own.
pub(crate) struct Decks<'a> {
    pub(crate) wires: &'a Wires<'a>,
    pub(crate) lines: &'a AtomicU8,
    pub(crate) expander: &'a RefCell<ExpanderModel<&'a AtomicU8>>,
    pub(crate) contact: &'a RefCell<LooseContact<'a>>,
    rangers: [&'a RefCell<Vl53l1xModel<&'a AtomicU8>>; 6],
}

impl<'a> Decks<'a> {
    pub(crate) fn bus(&self) -> ModelBus<'a> {
        ModelBus::new(self.wires)
    }

    pub(crate) fn ranger(&self, beam: Beam) -> &'a RefCell<Vl53l1xModel<&'a AtomicU8>> {
        self.rangers[index(beam)]
    }
}

fn index(beam: Beam) -> usize {
    Beam::ALL.iter().position(|other| *other == beam).unwrap()
}

/// The distance to the wall that a ranger sees.
pub(crate) fn wall(beam: Beam) -> Metres {
    Metres(0.5 + 0.25 * index(beam) as f32)
}

/// Runs a test with both decks switched on and booted. The reset lines float high, which is the
/// worse case, because all six rangers are then at 0x29.
pub(crate) fn with_decks<R>(test: impl FnOnce(&Decks<'_>) -> R) -> R {
    let lines = AtomicU8::new(0);
    let expander = RefCell::new(ExpanderModel::new(&lines, 0xFF));
    let ranger = |beam| {
        let line = match beam {
            Beam::Down => None,
            Beam::Front => Some(Lines::FRONT),
            Beam::Back => Some(Lines::BACK),
            Beam::Up => Some(Lines::UP),
            Beam::Left => Some(Lines::LEFT),
            Beam::Right => Some(Lines::RIGHT),
        };
        let mut model = Vl53l1xModel::new(line.map(|line| (&lines, line)));
        model.distance = wall(beam);
        RefCell::new(model)
    };
    let [down, front, back, up, left, right] = Beam::ALL.map(ranger);
    let rangers = [&down, &front, &back, &up, &left, &right];
    let contact = RefCell::new(LooseContact { rangers, due: None });
    let devices: [&RefCell<dyn I2cModel + '_>; 8] =
        [&expander, &down, &front, &back, &up, &left, &right, &contact];
    let wires = Wires::new(&devices);
    wires.advance(5_000);
    test(&Decks { wires: &wires, lines: &lines, expander: &expander, contact: &contact, rangers })
}

/// Runs a test with one ranger that has just been switched on.
pub(crate) fn with_ranger<R>(
    test: impl FnOnce(ModelBus<'_>, ModelDelay<'_>, &RefCell<Vl53l1xModel<&AtomicU8>>, &Wires<'_>) -> R,
) -> R {
    let model = RefCell::new(Vl53l1xModel::alone());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    test(ModelBus::new(&wires), ModelDelay::new(&wires), &model, &wires)
}

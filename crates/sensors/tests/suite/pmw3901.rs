//! The optical flow sensor's driver: the pauses that the chip needs, the manufacturer's settings,
//! the axes, and an absent chip.

use std::cell::RefCell;

use crate::common::{block_on, seeded};
use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_async::spi::SpiDevice;
use proptest::prelude::*;
use sensors::Error;
use sensors::models::{Fault, ModelDelay, ModelSpi, Pmw3901Model, SpiModel, Wires};
use sensors::pmw3901::Pmw3901;

fn with_flow<R>(
    test: impl FnOnce(ModelSpi<'_>, ModelDelay<'_>, &RefCell<Pmw3901Model>, &Wires<'_>) -> R,
) -> R {
    let model = RefCell::new(Pmw3901Model::new());
    let wires = Wires::new(&[]);
    test(ModelSpi::new(&model, &wires), ModelDelay::new(&wires), &model, &wires)
}

/// A bus that fails at one transaction, and records the bytes that are sent.
struct RecordingSpi<S> {
    spi: S,
    fail_at: Option<usize>,
    sent: Vec<Vec<u8>>,
}

impl<S: ErrorType> ErrorType for RecordingSpi<S> {
    type Error = S::Error;
}

impl<S: SpiDevice<Error = ErrorKind>> SpiDevice for RecordingSpi<S> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let sent = operations.iter().flat_map(|operation| match operation {
            Operation::Write(bytes) => bytes.to_vec(),
            _ => Vec::new(),
        });
        self.sent.push(sent.collect());
        if self.fail_at == Some(self.sent.len() - 1) {
            return Err(ErrorKind::Other);
        }
        self.spi.transaction(operations).await
    }
}

#[test]
fn initialisation_configures_the_chip_and_keeps_its_pauses() {
    with_flow(|spi, mut delay, model, wires| {
        block_on(Pmw3901::new(spi).init(&mut delay)).unwrap();
        assert!(model.borrow().is_configured());
        assert_eq!(model.borrow().violations(), 0);
        let took = wires.now().as_micros();
        assert!((60_000..120_000).contains(&took), "{took} us");
    });
}

/// The table has a register of each bank that the vendor's table writes to, and the registers that
/// it writes twice: bank, register, value.
#[test]
fn the_settings_are_written_to_their_banks() {
    with_flow(|spi, mut delay, model, _| {
        block_on(Pmw3901::new(spi).init(&mut delay)).unwrap();
        for (bank, register, value) in [
            (0x00, 0x61, 0xAD),
            (0x00, 0x5B, 0xA0),
            (0x00, 0x5A, 0x10),
            (0x00, 0x40, 0x80),
            (0x05, 0x5F, 0x34),
            (0x06, 0x62, 0xF0),
            (0x07, 0x32, 0x44),
            (0x07, 0x40, 0x40),
            (0x08, 0x6A, 0x18),
            (0x09, 0x63, 0x50),
            (0x0A, 0x45, 0x60),
            (0x0D, 0x48, 0xC0),
            (0x10, 0x5B, 0x02),
            (0x14, 0x65, 0x67),
            (0x15, 0x48, 0x48),
        ] {
            let read = model.borrow().register(bank, register);
            assert_eq!(read, value, "bank {bank:#04x}, register {register:#04x}");
        }
    });
}

#[test]
fn initialisation_begins_with_these_transactions() {
    with_flow(|spi, mut delay, _, _| {
        let mut spi = RecordingSpi { spi, fail_at: None, sent: Vec::new() };
        block_on(Pmw3901::new(&mut spi).init(&mut delay)).unwrap();
        let expected: [&[u8]; 12] = [
            &[],
            &[0xFF, 0x00],
            &[0x00],
            &[0x5F],
            &[0xBA, 0x5A],
            &[0x02],
            &[0x03],
            &[0x04],
            &[0x05],
            &[0x06],
            &[0xFF, 0x00],
            &[0xE1, 0xAD],
        ];
        assert_eq!(&spi.sent[..12], &expected);
        assert_eq!(spi.sent.len(), 10 + 59 + 17);
    });
}

#[test]
fn counts_are_converted_to_the_boards_axes_and_read_once() {
    with_flow(|spi, mut delay, model, _| {
        let mut flow = Pmw3901::new(spi);
        block_on(flow.init(&mut delay)).unwrap();
        model.borrow_mut().push(3, -7);
        let motion = block_on(flow.read_motion(&mut delay)).unwrap();
        assert_eq!((motion.x, motion.y, motion.moved), (7, -3, true));
        assert_eq!((motion.squal, motion.shutter), (80, 1_200));
        let still = block_on(flow.read_motion(&mut delay)).unwrap();
        assert_eq!((still.x, still.y, still.moved), (0, 0, false));
        assert_eq!(model.borrow().violations(), 0);
    });
}

#[test]
fn a_read_takes_less_than_a_third_of_a_millisecond() {
    with_flow(|spi, mut delay, _, wires| {
        let mut flow = Pmw3901::new(spi);
        block_on(flow.init(&mut delay)).unwrap();
        let before = wires.now();
        block_on(flow.read_motion(&mut delay)).unwrap();
        let took = wires.now().since(before).as_micros();
        assert!(took < 333, "{took} us");
    });
}

#[test]
fn a_line_that_no_device_drives_is_an_error() {
    for fault in [Fault::Absent, Fault::Stuck(0x00), Fault::Stuck(0xFF)] {
        with_flow(|spi, mut delay, model, _| {
            let mut flow = Pmw3901::new(spi);
            model.borrow_mut().fault = fault;
            assert_eq!(block_on(flow.init(&mut delay)), Err(Error::Silent));
            model.borrow_mut().fault = Fault::None;
            block_on(flow.init(&mut delay)).unwrap();
            model.borrow_mut().fault = fault;
            assert_eq!(block_on(flow.read_motion(&mut delay)), Err(Error::Silent));
            model.borrow_mut().fault = Fault::None;
            assert!(block_on(flow.read_motion(&mut delay)).is_ok());
        });
    }
}

#[test]
fn a_chip_with_another_identification_is_refused() {
    with_flow(|spi, mut delay, model, _| {
        model.borrow_mut().set_id([0x49, 0x00]);
        let outcome = block_on(Pmw3901::new(spi).init(&mut delay));
        assert_eq!(outcome, Err(Error::WrongDevice { found: 0x4900 }));
    });
}

proptest! {
    #![proptest_config(seeded())]

    /// All counts are converted without overflow, the extremes of the chip included.
    #[test]
    fn any_counts_are_read(dx in any::<i16>(), dy in any::<i16>()) {
        with_flow(|spi, mut delay, model, _| {
            let mut flow = Pmw3901::new(spi);
            model.borrow_mut().push(dx, dy);
            let motion = block_on(flow.read_motion(&mut delay)).unwrap();
            prop_assert_eq!(motion.x, dy.saturating_neg());
            prop_assert_eq!(motion.y, dx.saturating_neg());
            Ok(())
        })?;
    }

    /// If any one transaction fails, the initialisation reports it, and the next one succeeds from
    /// any bank that was left selected.
    #[test]
    fn a_failed_transaction_is_reported_and_the_next_initialisation_succeeds(failed in 0usize..86) {
        with_flow(|spi, mut delay, model, _| {
            let mut spi = RecordingSpi { spi, fail_at: Some(failed), sent: Vec::new() };
            let outcome = block_on(Pmw3901::new(&mut spi).init(&mut delay));
            prop_assert_eq!(outcome, Err(Error::Bus(ErrorKind::Other)));
            prop_assert_eq!(block_on(Pmw3901::new(&mut spi).init(&mut delay)), Ok(()));
            prop_assert!(model.borrow().is_configured());
            prop_assert_eq!(model.borrow().violations(), 0);
            Ok(())
        })?;
    }
}

#[test]
fn counts_can_be_read_one_register_at_a_time_and_are_latched_by_the_first() {
    let mut model = Pmw3901Model::new();
    model.push(0x0102, -2);
    let mut read = |register| {
        model.select();
        model.advance(50_000);
        model.transfer(register);
        model.advance(50_000);
        let byte = model.transfer(0);
        model.deselect();
        if register == 0x02 {
            model.push(5, 5);
        }
        byte
    };
    assert_eq!([0x02, 0x03, 0x04, 0x05, 0x06].map(&mut read), [0xB0, 0x02, 0x01, 0xFE, 0xFF]);
    assert_eq!([0x02, 0x03].map(&mut read), [0xB0, 0x05]);
}

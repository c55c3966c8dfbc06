//! The EEPROM's driver: page boundaries, a memory that does not acknowledge while it stores a page,
//! and one that never acknowledges again.

use std::cell::RefCell;

use crate::common::{block_on, seeded};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use proptest::prelude::*;
use sensors::Error;
use sensors::eeprom::{Eeprom, SIZE};
use sensors::models::{EepromModel, Fault, I2cModel, ModelBus, ModelDelay, Wires};

fn with_memory<R>(
    test: impl FnOnce(ModelBus<'_>, ModelDelay<'_>, &RefCell<EepromModel>, &Wires<'_>) -> R,
) -> R {
    let model = RefCell::new(EepromModel::new());
    let devices: [&RefCell<dyn I2cModel + '_>; 1] = [&model];
    let wires = Wires::new(&devices);
    test(ModelBus::new(&wires), ModelDelay::new(&wires), &model, &wires)
}

proptest! {
    #![proptest_config(seeded())]

    /// A write across any number of pages stores its bytes, changes no others, and writes each page
    /// once.
    #[test]
    fn a_write_stores_its_bytes_and_changes_no_others(
        at in 0u16..SIZE,
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        with_memory(|bus, mut delay, model, _| {
            let mut memory = Eeprom::new(bus);
            let from = usize::from(at);
            if from + bytes.len() > SIZE.into() {
                let refused = block_on(memory.write(at, &bytes, &mut delay));
                prop_assert_eq!(refused, Err(Error::Unsupported));
                prop_assert_eq!(model.borrow().pages_written(), 0);
                return Ok(());
            }
            block_on(memory.write(at, &bytes, &mut delay)).unwrap();
            prop_assert_eq!(block_on(memory.verify(at, &bytes)), Ok(()));
            let mut expected = [0xFF; SIZE as usize];
            expected[from..from + bytes.len()].copy_from_slice(&bytes);
            prop_assert!(model.borrow().bytes() == &expected);
            let pages = match bytes.len() {
                0 => 0,
                length => (from + length - 1) / 32 - from / 32 + 1,
            };
            prop_assert_eq!(model.borrow().pages_written() as usize, pages);
            let mut read = vec![0; bytes.len()];
            block_on(memory.read(at, &mut read)).unwrap();
            prop_assert_eq!(read, bytes);
            Ok(())
        })?;
    }

    /// A byte that differs from the one written is found, with its address.
    #[test]
    fn a_byte_that_differs_is_found(
        at in 0u16..8_000,
        bytes in prop::collection::vec(any::<u8>(), 1..150),
        changed in any::<prop::sample::Index>(),
    ) {
        with_memory(|bus, mut delay, model, _| {
            let mut memory = Eeprom::new(bus);
            block_on(memory.write(at, &bytes, &mut delay)).unwrap();
            let register = at + changed.index(bytes.len()) as u16;
            model.borrow_mut().bytes_mut()[usize::from(register)] ^= 0x10;
            prop_assert_eq!(
                block_on(memory.verify(at, &bytes)), Err(Error::NotKept { register }));
            Ok(())
        })?;
    }

    /// If any one transaction fails, the write reports it or has stored all bytes, and the memory
    /// can be written afterwards.
    #[test]
    fn a_failed_transaction_never_loses_bytes_silently(failing in 0u32..30) {
        with_memory(|bus, mut delay, _, wires| {
            let mut memory = Eeprom::new(bus);
            let bytes = [0x5A; 100];
            wires.refuse_after(Some(failing));
            let outcome = block_on(memory.write(16, &bytes, &mut delay));
            wires.refuse_after(None);
            wires.advance(5_000);
            if outcome.is_ok() {
                prop_assert_eq!(block_on(memory.verify(16, &bytes)), Ok(()));
            }
            prop_assert_eq!(block_on(memory.write(16, &bytes, &mut delay)), Ok(()));
            prop_assert_eq!(block_on(memory.verify(16, &bytes)), Ok(()));
            Ok(())
        })?;
    }
}

#[test]
fn the_driver_waits_for_the_slowest_page_that_the_data_sheet_allows() {
    with_memory(|bus, mut delay, model, wires| {
        model.borrow_mut().write_micros = 5_000;
        let mut memory = Eeprom::new(bus);
        block_on(memory.write(0, &[1; 64], &mut delay)).unwrap();
        let took = wires.now().as_micros();
        assert!((10_000..14_000).contains(&took), "{took} us for two pages");
    });
}

#[test]
fn a_memory_that_never_acknowledges_again_is_a_timeout() {
    with_memory(|bus, mut delay, model, wires| {
        model.borrow_mut().write_micros = u32::MAX;
        let outcome = block_on(Eeprom::new(bus).write(0, &[1; 64], &mut delay));
        assert_eq!(outcome, Err(Error::Timeout));
        assert!(wires.transactions() <= 12, "{} transactions", wires.transactions());
    });
}

#[test]
fn an_absent_memory_is_an_error_of_the_bus() {
    with_memory(|bus, mut delay, model, _| {
        model.borrow_mut().fault = Fault::Absent;
        let no_acknowledge = Error::Bus(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        let mut memory = Eeprom::new(bus);
        assert_eq!(block_on(memory.read(0, &mut [0; 4])), Err(no_acknowledge));
        assert_eq!(block_on(memory.write(0, &[0; 4], &mut delay)), Err(no_acknowledge));
    });
}

#[test]
fn no_address_reaches_beyond_the_end() {
    with_memory(|bus, _, _, wires| {
        let mut memory = Eeprom::new(bus);
        for (at, length) in [(8_192, 1), (8_191, 2), (u16::MAX, 1), (0, 8_193)] {
            let mut bytes = vec![0; length];
            assert_eq!(block_on(memory.read(at, &mut bytes)), Err(Error::Unsupported));
            assert_eq!(block_on(memory.verify(at, &bytes)), Err(Error::Unsupported));
        }
        assert_eq!(wires.transactions(), 0);
        block_on(memory.read(8_191, &mut [0])).unwrap();
    });
}

//! Starts the radio chip's firmware up to the moment at which it lets the flight processor run.

use std::fmt;
use std::sync::Arc;

use nrf51_chip::core::Fault;
use nrf51_chip::image::Program;
use nrf51_chip::{Chip, Config, Cycles, MICROSECOND, PinLevel};
use units::Volts;

use super::firmware::{BATTERY, pin};

/// The longest that a firmware may take until it lets the flight processor run. The vendor's takes
/// 357 ms, and five seconds more with an AI deck.
const LONGEST: Cycles = 10_000_000 * MICROSECOND;
/// The steps in which the start is looked at.
const STEP: Cycles = 100 * MICROSECOND;
/// The number of the exception of an SVC.
const SUPERVISOR_CALL: u8 = 11;

/// The reason why a file with the radio chip's firmware cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unbootable {
    /// The program does what the chip cannot.
    Fault(Fault),
    /// The program calls Nordic's SoftDevice, which is not there: it was built with Bluetooth.
    CallsSoftDevice,
    /// The program has not let the flight processor run after ten seconds.
    KeepsProcessor,
}

impl fmt::Display for Unbootable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => write!(f, "the radio chip faults: {fault}"),
            Self::CallsSoftDevice => write!(
                f,
                "is a build with Bluetooth, which calls Nordic's SoftDevice; that is not emulated"
            ),
            Self::KeepsProcessor => {
                write!(f, "does not let the flight processor run within ten seconds")
            }
        }
    }
}

impl std::error::Error for Unbootable {}

/// The radio chip's firmware, started once: every board begins where it lets the flight processor
/// run.
#[derive(Clone, Debug)]
pub struct RadioFirmware(Arc<Chip>);

impl RadioFirmware {
    /// Starts a program, without decks, on a battery of 4 V.
    ///
    /// # Errors
    ///
    /// An [`Unbootable`] where it does not come to let the flight processor run.
    pub fn start(program: Program) -> Result<Self, Unbootable> {
        let program = Arc::new(program);
        let mut chip = Chip::new(program, Config::default()).map_err(Unbootable::Fault)?;
        chip.set_analog(BATTERY.0, Volts(4.0 / BATTERY.1));
        let mut has_held = false;
        while chip.now() < LONGEST {
            // Instruction by instruction where the moment counts.
            let step = if has_held { 1 } else { STEP };
            chip.run_until(chip.now() + step).map_err(Unbootable::Fault)?;
            if chip.exception() == SUPERVISOR_CALL {
                return Err(Unbootable::CallsSoftDevice);
            }
            let reset = chip.pin(pin::RESET);
            if has_held && reset == PinLevel::Released {
                chip.take_pin_changes();
                return Ok(Self(Arc::new(chip)));
            }
            has_held = reset == PinLevel::Low && chip.pin(pin::SUPPLY) == PinLevel::High;
        }
        Err(Unbootable::KeepsProcessor)
    }

    /// The chip, which has just let the flight processor run.
    pub(super) fn chip(&self) -> Chip {
        Chip::clone(&self.0)
    }
}

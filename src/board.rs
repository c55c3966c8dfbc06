//! The board that this firmware is built for, chosen by a feature of the package, and its clocks,
//! pins and buses.
//!
//! | feature | board | |
//! |---|---|---|
//! | `crazyflie-2-1` | Crazyflie 2.1 with its first propellers | `board/crazyflie_2_1.rs` |
//! | `crazyflie-2-1-plus` | the same with the propellers of the 2.1+ | `board/crazyflie_2_1.rs` |
//!
//! Another board is another module with the same names in it: [`init`], which divides the chip's
//! peripherals into the parts of the tasks; [`motor`], the motors' pins and timers; [`FLIGHT`], the
//! configuration of the flight code; and the interrupt of the control executor. A Bolt differs in
//! the bus of its inertial sensor (SPI2 instead of I2C3), the pin of its fourth motor and the signal
//! for its speed controllers. It cannot be mistaken for a Crazyflie: [`identity`] reads the name that
//! the vendor has written into each board, and on another board the motors get no signal.

#[cfg(any(
    all(feature = "crazyflie-2-1", feature = "crazyflie-2-1-plus"),
    not(any(feature = "crazyflie-2-1", feature = "crazyflie-2-1-plus")),
))]
compile_error!("choose exactly one board: feature crazyflie-2-1 or crazyflie-2-1-plus");

pub(crate) mod bus;
pub(crate) mod ccm;
pub(crate) mod clock;
mod crazyflie_2_1;
pub(crate) mod deadline;
pub(crate) mod flow_control;
pub(crate) mod identity;
pub(crate) mod motors;
pub(crate) mod page;
pub(crate) mod random;

pub(crate) use crazyflie_2_1::{
    CONTROL, DeckParts, Edge, FLIGHT, FlowParts, ImuParts, Lamps, RadioParts, crystal_starts, init,
    motor,
};

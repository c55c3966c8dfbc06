//! The board that this firmware is built for, chosen by a feature of the package, and its clocks,
//! pins and buses.
//!
//! | feature | board | |
//! |---|---|---|
//! | `crazyflie-2-1` | Crazyflie 2.1 with its first propellers | `board/crazyflie_2_1.rs` |
//! | `crazyflie-2-1-plus` | the same with the propellers of the 2.1+ | `board/crazyflie_2_1.rs` |
//!
//! Another board is another module with the same names in it: [`init`], which takes the chip's
//! peripherals apart into parts; [`motor`], what [`motors`] must know of its pins and timers;
//! [`FLIGHT`], what flies; and the interrupt of the control executor. The tasks know parts, not
//! boards. A Bolt differs in its inertial sensor's bus (SPI2 instead of I2C3), its fourth motor's
//! pin and the signal its speed controllers take, so in those three.

#[cfg(any(
    all(feature = "crazyflie-2-1", feature = "crazyflie-2-1-plus"),
    not(any(feature = "crazyflie-2-1", feature = "crazyflie-2-1-plus")),
))]
compile_error!("choose exactly one board: feature crazyflie-2-1 or crazyflie-2-1-plus");

pub(crate) mod bus;
pub(crate) mod clock;
mod crazyflie_2_1;
pub(crate) mod deadline;
pub(crate) mod motors;
pub(crate) mod page;

pub(crate) use crazyflie_2_1::{
    CONTROL, DeckParts, Edge, FLIGHT, FlowParts, ImuParts, Lamps, RadioParts, crystal_starts, init,
    motor,
};

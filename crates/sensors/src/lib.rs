//! Async drivers over `embedded-hal-async` 1.0 for the sensors of a Crazyflie 2.1 with a Flow deck
//! v2 and a Multi-ranger deck, and for its EEPROM.
//!
//! | module | device | bus |
//! |---|---|---|
//! | [`bmi088`] | gyroscope and accelerometer | I²C 0x69, 0x18 |
//! | [`pmw3901`] | optical flow | SPI, mode 0 |
//! | [`vl53l1x`] | one time-of-flight ranger | I²C 0x29, can be changed |
//! | [`multi_ranger`] | all six rangers: bring-up, polling, recovery | I²C |
//! | [`expander`] | the reset lines of five rangers | I²C 0x20 |
//! | [`eeprom`] | the memory of the configuration block | I²C 0x50 |
//! | [`bus`] | recovery of a hung I²C bus; when a device counts as lost and is retried | |
//! | [`Level`] | the vendor's trim of the accelerometer | |
//!
//! Every wait in a driver is bounded by a number of tries, every failure is a value of [`Error`],
//! and a driver whose call failed, or whose future was dropped half-way, may be initialised again
//! any number of times. A driver cannot bound a transaction that the bus never finishes: the owner
//! of the bus limits the time of each transaction (`with_timeout`) and frees the bus with
//! [`bus::recover`].
//!
//! With the feature `models` the module `models` has register-level models of all five kinds of
//! device, which an emulated peripheral can drive byte by byte.
#![no_std]

pub mod bmi088;
pub mod bus;
pub mod eeprom;
mod error;
pub mod expander;
mod level;
#[cfg(feature = "models")]
pub mod models;
pub mod multi_ranger;
pub mod pmw3901;
pub mod vl53l1x;

pub use error::Error;
pub use level::Level;

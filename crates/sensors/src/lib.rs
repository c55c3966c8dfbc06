//! Async drivers over `embedded-hal-async` 1.0 for what a Crazyflie 2.1 with a Flow deck v2 and a
//! Multi-ranger deck senses with.
//!
//! | module | device | bus |
//! |---|---|---|
//! | [`bmi088`] | gyroscope and accelerometer | I²C 0x69, 0x18 |
//! | [`pmw3901`] | optical flow | SPI, mode 0 |
//! | [`vl53l1x`] | one time-of-flight ranger | I²C 0x29, movable |
//! | [`multi_ranger`] | the six of them: bring-up, polling, recovery | I²C |
//! | [`expander`] | the lines that hold five of them in reset | I²C 0x20 |
//! | [`eeprom`] | the configuration block's memory | I²C 0x50 |
//! | [`bus`] | a hung I²C bus, and when to give a device up and try it again | |
//! | [`Level`] | the vendor's trim of the accelerometer | |
//!
//! Every wait here is bounded by a number of tries, every failure is a value of [`Error`], and a
//! driver whose call failed, or was dropped half-way, may be initialised again as often as one
//! likes. What a driver cannot bound is a bus that never finishes a transaction: the owner of the
//! bus puts a limit on each (`with_timeout`) and mends it with [`bus::recover`].
//!
//! With the feature `models` the module `models` has register-level models of all five devices,
//! which an emulated peripheral can drive byte by byte.
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

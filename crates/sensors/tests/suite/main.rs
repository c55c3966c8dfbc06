//! The drivers against register-level models of their devices.

mod bmi088;
mod bus;
mod common;
mod eeprom;
mod multi_ranger;
mod pmw3901;
mod vl53l1x;

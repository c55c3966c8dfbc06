//! The tasks: each waits for an event, steps a type of a crate, and publishes the result.
//!
//! | module | holds |
//! |---|---|
//! | [`control`] | the task that runs `flight::Flight`, 1 kHz, and feeds the watchdog |
//! | [`imu`] | the tasks that read the inertial sensor's two dies, 1 kHz |
//! | [`flow`] | the task that reads the optic flow, 100 Hz |
//! | [`rangers`] | the task that reads the rangers |
//! | [`drone`] | the one `onboard::Drone`, which the tasks of the thread share |
//! | [`mission`] | the task that steps it, 5 Hz |
//! | [`exploration`] | the memory of a drone that explores |
//! | [`replay`] | the task that replays recorded packets for a debug probe |
//! | [`radio`] | the tasks that talk to the radio chip |
//! | [`store`] | the task that keeps settings, keys and epochs in the EEPROM |
//! | [`lamps`] | the task that shows the drone's state on the LEDs |
//! | [`health`] | the check that every task still runs, and the task that logs, 1 Hz |
//! | [`latest`] | a cell for the latest value, by which tasks exchange values |

pub(crate) mod control;
pub(crate) mod drone;
pub(crate) mod exploration;
pub(crate) mod flow;
pub(crate) mod health;
pub(crate) mod imu;
pub(crate) mod lamps;
pub(crate) mod latest;
pub(crate) mod mission;
pub(crate) mod radio;
pub(crate) mod rangers;
pub(crate) mod replay;
pub(crate) mod store;

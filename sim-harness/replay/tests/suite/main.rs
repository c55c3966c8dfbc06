//! Replays of logs, through the library.

mod flights;
mod real_flights;
mod simulated_flights;
mod usd_log;

//! The world the drones fly in when there are none.
pub mod input_error;
pub mod output;
pub mod replay;
pub mod metrics;
pub mod mission;
pub mod random;
pub mod scenario;
pub mod trace;
pub mod vehicle;
pub mod world;

//! The world the drones fly in when there are none.
pub mod input_error;
pub mod trace;

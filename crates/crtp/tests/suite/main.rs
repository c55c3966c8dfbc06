//! The CRTP server as a client meets it.

mod any_bytes;
mod client;
mod common;
mod log;

//! The CRTP server as a client meets it.

mod any_bytes;
mod cfclient;
mod client;
mod common;
mod log;

//! The crate's tests, in one program: it is built and linked once.

mod board_name;
mod common;
mod epoch;
mod keys;
mod power_cut;
mod settings;

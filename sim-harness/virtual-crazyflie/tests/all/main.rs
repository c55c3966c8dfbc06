//! All tests of the emulator that use it from outside, in one binary: each binary would link the
//! whole of it again.

mod board;
mod core;
mod firmware;
mod gdb;
mod image;
mod image_tiny;
mod log;
mod oracle;
mod profile;
mod sequences;
mod serial;
mod soc;

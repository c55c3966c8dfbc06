//! Defines the door to a chip with a debug probe: one channel of bytes in each direction.

use std::fmt;

use units::{Duration, Instant};

/// The channel to the firmware, and the one from it, in its RTT control block (`src/rtt.rs`).
#[cfg(any(feature = "virtual", feature = "probe"))]
pub(super) const DOWN: u32 = 0;
/// See [`DOWN`].
#[cfg(any(feature = "virtual", feature = "probe"))]
pub(super) const UP: u32 = 1;

/// How to get a firmware that can replay.
pub(super) const BUILD: &str = "build the firmware with `cargo fw`, and name it with --elf";

/// A chip that runs the firmware, with a debugger attached.
pub trait Target {
    /// The word for it on the command line.
    const NAME: &'static str;

    /// Writes into the down-channel as many of the bytes as it has room for, and returns how many.
    ///
    /// # Errors
    /// When the chip cannot be reached, or no longer runs.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Lost>;

    /// Takes what the firmware has written into the up-channel.
    ///
    /// # Errors
    /// As for [`write`](Self::write).
    fn read(&mut self) -> Result<Vec<u8>, Lost>;

    /// Lets the chip run for about this long, by its own clock.
    ///
    /// # Errors
    /// As for [`write`](Self::write).
    fn run(&mut self, span: Duration) -> Result<(), Lost>;

    /// The time by the chip's clock, since any moment.
    fn now(&self) -> Instant;
}

/// The chip cannot be reached any more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lost(pub String);

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

//! What the chip has counted.

/// Counts since the chip was last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Good frames from the flight processor.
    pub good: u32,
    /// Frames whose first sum was wrong,
    pub bad_first_sums: u32,
    /// or their second.
    pub bad_second_sums: u32,
    /// Frames that said they were longer than any is.
    pub too_long: u32,
    /// Bytes for which there was no room.
    pub dropped_bytes: u32,
    /// Bytes that were none: sent at another speed, or without a stop bit.
    pub broken_bytes: u32,
    /// Frames of a type or with data that this model does not know what to do with. The chip may
    /// do something with some of them.
    pub not_understood: u32,
    /// The type of the latest of these.
    pub last_not_understood: Option<u8>,
    /// Packets that came off the air while the radio did not listen.
    pub deaf: u32,
    /// Packets that came off the air while the queue was full.
    pub overruns: u32,
    /// Packets to the ground for which there was no room.
    pub refused: u32,
    /// Commands from the air, to the radio or to the chip's loader, that this model does not know.
    pub commands: u32,
}

//! The host's end of SEGGER's RTT: reads and writes the channels of a control block in the memory
//! of a machine, as a debug probe does (SEGGER UM08001, "RTT implementation").
//!
//! A control block is an identifier of 16 bytes, the numbers of up- and down-channels, and then
//! their descriptors, of 24 bytes each, the up-channels first. Each channel is a ring in RAM; the
//! firmware writes the up-channels and reads the down-channels.

use crate::bus::Width;
use crate::image::Image;
use crate::memory::{Memory, map};

/// The beginning of a control block's identifier.
const IDENTIFIER: &[u8] = b"SEGGER RTT\0";
/// Offsets in a control block: the numbers of channels, and the first descriptor.
mod block {
    pub(super) const UP: u32 = 16;
    pub(super) const DOWN: u32 = 20;
    pub(super) const CHANNELS: u32 = 24;
}
/// Offsets in a descriptor, and its size.
mod descriptor {
    pub(super) const BUFFER: u32 = 4;
    pub(super) const SIZE: u32 = 8;
    pub(super) const WRITE: u32 = 12;
    pub(super) const READ: u32 = 16;
    pub(super) const FLAGS: u32 = 20;
    pub(super) const LENGTH: u32 = 24;
}
/// More channels than this no firmware has: the block's memory holds something else.
const MOST_CHANNELS: u32 = 16;
/// The symbol of the control block.
const SYMBOL: &str = "_SEGGER_RTT";

/// A control block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlBlock(u32);

impl ControlBlock {
    /// The block that the image names.
    #[must_use]
    pub fn of(image: &Image) -> Option<Self> {
        image.address_of(SYMBOL).map(Self)
    }

    /// The block with the lowest address of those that the RAM holds, as a probe without the image
    /// searches for it.
    #[must_use]
    pub fn find(memory: &Memory) -> Option<Self> {
        let ram = memory.bytes(map::RAM, map::RAM_SIZE)?;
        let at = (0..ram.len()).step_by(4).find(|at| ram[*at..].starts_with(IDENTIFIER))?;
        #[expect(clippy::cast_possible_truncation, reason = "the RAM has 128 KiB")]
        Some(Self(map::RAM + at as u32))
    }

    /// The up-channel of this number; `None` where the firmware has not written the block yet, or
    /// has no such channel.
    #[must_use]
    pub fn up(self, memory: &Memory, number: u32) -> Option<Channel> {
        let [up, _] = self.counts(memory)?;
        (number < up).then(|| self.channel(memory, number))?
    }

    /// The down-channel of this number; `None` as for [`up`](Self::up).
    #[must_use]
    pub fn down(self, memory: &Memory, number: u32) -> Option<Channel> {
        let [up, down] = self.counts(memory)?;
        (number < down).then(|| self.channel(memory, up + number))?
    }

    /// The address of the first up-channel's writing position.
    pub(crate) const fn first_write(self) -> u32 {
        self.0 + block::CHANNELS + descriptor::WRITE
    }

    /// The numbers of up- and down-channels.
    fn counts(self, memory: &Memory) -> Option<[u32; 2]> {
        let is_written = memory.bytes(self.0, IDENTIFIER.len() as u32)? == IDENTIFIER;
        let word = |offset| memory.load(self.0.wrapping_add(offset), Width::Word);
        let counts = [word(block::UP)?, word(block::DOWN)?];
        (is_written && counts.iter().all(|count| *count <= MOST_CHANNELS)).then_some(counts)
    }

    fn channel(self, memory: &Memory, index: u32) -> Option<Channel> {
        let at = self.0 + block::CHANNELS + descriptor::LENGTH * index;
        let word = |offset| memory.load(at.wrapping_add(offset), Width::Word);
        let channel = Channel {
            at,
            buffer: word(descriptor::BUFFER)?,
            size: word(descriptor::SIZE)?,
            write: word(descriptor::WRITE)?,
            read: word(descriptor::READ)?,
            flags: word(descriptor::FLAGS)?,
        };
        let is_sensible = channel.write < channel.size
            && channel.read < channel.size
            && memory.bytes(channel.buffer, channel.size).is_some();
        is_sensible.then_some(channel)
    }
}

/// A channel of a control block, with the positions that it had when it was looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    at: u32,
    buffer: u32,
    pub(crate) size: u32,
    pub(crate) write: u32,
    read: u32,
    pub(crate) flags: u32,
}

impl Channel {
    /// Takes all bytes that the firmware has written into an up-channel.
    #[must_use]
    pub fn take(&self, memory: &mut Memory) -> Vec<u8> {
        let bytes = self.since(memory, self.read);
        self.set_read(memory);
        bytes
    }

    /// Writes into a down-channel as many of the bytes as it has room for, and returns how many.
    pub fn write(&self, memory: &mut Memory, bytes: &[u8]) -> usize {
        let room = (self.read + self.size - self.write - 1) % self.size;
        let mut at = self.write;
        let count = bytes.len().min(room as usize);
        for byte in &bytes[..count] {
            memory.store(self.buffer.wrapping_add(at), Width::Byte, u32::from(*byte));
            at = (at + 1) % self.size;
        }
        self.set(memory, descriptor::WRITE, at);
        count
    }

    /// The bytes of the ring from a position up to the end of what was written.
    pub(crate) fn since(&self, memory: &Memory, from: u32) -> Vec<u8> {
        let parts = if from <= self.write {
            [from..self.write, 0..0]
        } else {
            [from..self.size, 0..self.write]
        };
        let bytes = |part: &std::ops::Range<u32>| {
            memory.bytes(self.buffer + part.start, part.end - part.start)
        };
        parts.iter().filter_map(bytes).flatten().copied().collect()
    }

    /// Notes for the firmware that all was read.
    pub(crate) fn set_read(&self, memory: &mut Memory) {
        self.set(memory, descriptor::READ, self.write);
    }

    /// Sets the channel's flags.
    pub(crate) fn set_flags(&self, memory: &mut Memory, flags: u32) {
        self.set(memory, descriptor::FLAGS, flags);
    }

    fn set(&self, memory: &mut Memory, offset: u32, value: u32) {
        memory.store(self.at + offset, Width::Word, value);
    }
}

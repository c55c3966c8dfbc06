//! A DMA controller: eight streams, of which an arbiter serves one item at a time (RM0090, "DMA
//! controller (DMA)").
//!
//! An item takes [`ITEM`] cycles from the request on, whatever its size and whichever bus it comes
//! over: about what ST counts for a peripheral of an APB (AN4031, "DMA latency": arbitration and
//! addresses, an access over the bridge, one to memory). That the core waits when both want the
//! same memory is not modelled. A stream enabled for a peripheral that is not modelled, the
//! peripheral as flow controller and bursts of the peripheral are refused; bursts of memory move
//! the same bytes as single accesses, and do that here.

mod ports;
mod requests;
mod stream;

use crate::bus::Refused;
use crate::memory::Memory;
use crate::soc::context::{Reach, Transfers};
use stream::Stream;

/// Cycles of the core for an item.
const ITEM: u64 = 10;

/// An item that is on its way.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    stream: usize,
    until: u64,
}

/// One of the two.
pub(crate) struct Dma {
    /// DMA1 is 0.
    controller: usize,
    streams: [Stream; 8],
    /// Which are enabled, one bit each.
    enabled: u8,
    /// Which of them have been enabled and not looked at since.
    fresh: u8,
    /// Which of them are to be disabled.
    closing: u8,
    lines: u8,
    transfer: Option<Transfer>,
}

impl Dma {
    pub(crate) const fn new(controller: usize) -> Self {
        Self {
            controller,
            streams: [Stream::new(controller); 8],
            enabled: 0,
            fresh: 0,
            closing: 0,
            lines: 0,
            transfer: None,
        }
    }

    /// LISR and HISR: four streams of six bits each, in two halves.
    fn status(&self, first: usize) -> u32 {
        (0..4).fold(0, |all, n| all | u32::from(self.streams[first + n].flags) << position(n))
    }

    /// LIFCR and HIFCR: ones clear.
    fn clear(&mut self, first: usize, value: u32) {
        for n in 0..4 {
            let flags = (value >> position(n) & 0x3D) as u8;
            if flags != 0 {
                self.streams[first + n].flags &= !flags;
                self.note(first + n);
            }
        }
    }

    /// Updates the sets of streams, by the state of this one.
    fn note(&mut self, stream: usize) {
        let bit = 1 << stream;
        let set = |mask: u8, is_set: bool| if is_set { mask | bit } else { mask & !bit };
        self.enabled = set(self.enabled, self.streams[stream].is_enabled());
        self.closing = set(self.closing, self.streams[stream].is_closing());
        self.lines = set(self.lines, self.streams[stream].line());
    }

    /// The requesting stream with the highest priority, or of equals the lowest number.
    fn arbitrate(&self, reach: &impl Reach) -> Option<usize> {
        let mut best: Option<usize> = None;
        for stream in each(self.enabled) {
            let first = best
                .is_none_or(|best| self.streams[stream].priority() > self.streams[best].priority());
            if first && self.streams[stream].requests(reach) {
                best = Some(stream);
            }
        }
        best
    }

    /// A stream to a peripheral fetches from memory as soon as it is enabled.
    fn preload(&mut self, memory: &Memory) {
        for stream in each(std::mem::take(&mut self.fresh)) {
            self.streams[stream].preload(memory);
            self.note(stream);
        }
    }

    /// Those whose EN was cleared and which have nothing on its way.
    fn close(&mut self, memory: &mut Memory, reach: &mut impl Reach) -> bool {
        let mut closed = false;
        for stream in each(self.closing) {
            let is_busy = self.transfer.is_some_and(|transfer| transfer.stream == stream);
            if !is_busy {
                self.streams[stream].close(memory, reach);
                self.note(stream);
                closed = true;
            }
        }
        closed
    }
}

/// The streams whose bit is set, lowest first.
fn each(mut streams: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let stream = streams.trailing_zeros() as usize;
        let more = streams != 0;
        streams &= streams.wrapping_sub(1);
        more.then_some(stream)
    })
}

/// The place of a stream's six bits in its status register.
const fn position(stream: usize) -> usize {
    [0, 6, 16, 22][stream % 4]
}

/// The stream and the register that lie there.
const fn place(offset: u32) -> Option<(usize, u32)> {
    let Some(above) = offset.checked_sub(0x10) else { return None };
    let stream = (above / 0x18) as usize;
    if stream < 8 { Some((stream, above % 0x18)) } else { None }
}

impl Transfers for Dma {
    fn read(&mut self, offset: u32, _now: u64) -> Result<u32, Refused> {
        match (offset, place(offset)) {
            (0x00, _) => Ok(self.status(0)),
            (0x04, _) => Ok(self.status(4)),
            // Write-only.
            (0x08 | 0x0C, _) => Ok(0),
            (_, Some((stream, register))) => Ok(self.streams[stream].load(register)),
            _ => Err(Refused::Unmodelled { what: "DMA: a register that is not there" }),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _now: u64) -> Result<(), Refused> {
        match (offset, place(offset)) {
            // Read-only.
            (0x00 | 0x04, _) => {}
            (0x08, _) => self.clear(0, value),
            (0x0C, _) => self.clear(4, value),
            (_, Some((stream, register))) => {
                let before = self.enabled;
                let result = self.streams[stream].store(stream, register, value);
                self.note(stream);
                self.fresh |= self.enabled & !before;
                result?;
            }
            _ => return Err(Refused::Unmodelled { what: "DMA: a register that is not there" }),
        }
        Ok(())
    }

    fn due(&self) -> u64 {
        self.transfer.map_or(u64::MAX, |transfer| transfer.until)
    }

    fn advance<R: Reach>(&mut self, now: u64, memory: &mut Memory, reach: &mut R) -> bool {
        if self.enabled == 0 {
            self.transfer = None;
            return false;
        }
        if self.fresh != 0 {
            self.preload(memory);
        }
        let mut moved = false;
        let mut at = now;
        loop {
            if let Some(transfer) = self.transfer {
                if transfer.until > now {
                    return moved | self.close(memory, reach);
                }
                self.transfer = None;
                at = transfer.until;
                if self.streams[transfer.stream].is_enabled() {
                    self.streams[transfer.stream].transfer(memory, reach);
                    self.note(transfer.stream);
                    moved = true;
                }
            }
            moved |= self.close(memory, reach);
            let Some(stream) = self.arbitrate(reach) else { return moved };
            self.transfer = Some(Transfer { stream, until: at + ITEM });
        }
    }

    fn lines(&self) -> u8 {
        self.lines
    }

    fn reset(&mut self) {
        *self = Self::new(self.controller);
    }
}

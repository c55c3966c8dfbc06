//! The radio chip's end of the serial line: bytes that wait to be looked at, and bytes on their way
//! out.

use std::collections::VecDeque;

use super::super::serial::{BIT, Received, SerialLine};
use crate::soc::{Nanos, UartByte};

/// Start, eight bits, stop.
const BITS: Nanos = 10 * BIT as Nanos;
/// From one byte that the chip sends to the next: it waits for the end of one, and fetches the next
/// only then.
pub const BYTE: Nanos = 12_700;

/// Bytes that the chip's program keeps (`uart.c`: `Q_LENGTH` less the one that stays empty). The
/// interrupt drops what comes when they are full, and the pin does not tell.
const KEPT: usize = 127;
/// Bytes that the peripheral keeps until an interrupt reads them (nRF51 reference manual, UART).
const FIFO: usize = 6;
/// The pin says "wait" when the peripheral has room for no more than so many bytes (the same, RTS).
const HEADROOM: usize = 4;

/// When the chip's interrupts read no bytes: for `busy` in each `every`, from `since` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Busy {
    pub(super) since: Nanos,
    pub(super) every: Nanos,
    pub(super) busy: Nanos,
}

impl Busy {
    /// The end of the span at `now`, if it is busy then.
    fn until(&self, now: Nanos) -> Option<Nanos> {
        let phase = now.checked_sub(self.since)? % self.every.max(1);
        (phase < self.busy).then(|| now - phase + self.busy)
    }
}

/// Counts of received bytes that were lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Losses {
    /// Bytes for which there was no room, in the peripheral or in the program.
    pub(super) dropped: u32,
    /// Bytes at another speed, or without a stop bit.
    pub(super) broken: u32,
}

/// Both directions.
#[derive(Debug)]
pub(super) struct Line {
    fifo: VecDeque<u8>,
    kept: VecDeque<u8>,
    pub(super) busy: Option<Busy>,
    out: VecDeque<UartByte>,
    pub(super) wire: SerialLine,
    pub(super) losses: Losses,
}

impl Line {
    pub(super) const fn new() -> Self {
        Self {
            fifo: VecDeque::new(),
            kept: VecDeque::new(),
            busy: None,
            out: VecDeque::new(),
            wire: SerialLine::clear(),
            losses: Losses { dropped: 0, broken: 0 },
        }
    }

    /// The chip was reset, or has lost its power: what has not left it never will.
    pub(super) fn fall_silent(&mut self, now: Nanos) {
        self.fifo.clear();
        self.kept.clear();
        self.out.retain(|byte| byte.at < now);
    }

    /// A byte from the flight processor, whose stop bit passes now.
    pub(super) fn take(&mut self, now: Nanos, byte: u8, bit: u32) {
        let byte = match self.wire.receive(byte, bit) {
            Received::Byte(byte) => byte,
            Received::Nothing => return,
            Received::Broken => {
                self.losses.broken += 1;
                return;
            }
        };
        self.read_fifo(now);
        if self.fifo.len() < FIFO {
            self.fifo.push_back(byte);
        } else {
            self.losses.dropped += 1;
        }
        self.read_fifo(now);
    }

    /// The interrupt reads the peripheral, unless the chip is busy.
    pub(super) fn read_fifo(&mut self, now: Nanos) {
        if self.is_busy(now) {
            return;
        }
        for byte in self.fifo.drain(..) {
            if self.kept.len() < KEPT {
                self.kept.push_back(byte);
            } else {
                self.losses.dropped += 1;
            }
        }
    }

    pub(super) fn is_busy(&self, now: Nanos) -> bool {
        self.busy.is_some_and(|busy| busy.until(now).is_some())
    }

    /// When the chip's program runs: now, or at the end of a busy span.
    pub(super) fn free_at(&self, now: Nanos) -> Nanos {
        self.busy.and_then(|busy| busy.until(now)).unwrap_or(now)
    }

    /// When the interrupt reads bytes that have waited in the peripheral.
    pub(super) fn reads_at(&self, now: Nanos) -> Nanos {
        if self.fifo.is_empty() { Nanos::MAX } else { self.free_at(now) }
    }

    /// The next byte that came in.
    pub(super) fn next(&mut self) -> Option<u8> {
        self.kept.pop_front()
    }

    pub(super) fn has_bytes(&self) -> bool {
        !self.kept.is_empty()
    }

    /// Whether the chip asks for a pause.
    pub(super) fn is_full(&self) -> bool {
        self.fifo.len() + HEADROOM >= FIFO
    }

    /// Sends from a moment on. Returns when the last stop bit is over.
    pub(super) fn send(&mut self, from: Nanos, bytes: &[u8]) -> Nanos {
        let moments = (from..).step_by(BYTE as usize);
        let bytes_out = bytes.iter().zip(moments).map(|(byte, at)| UartByte {
            at,
            bit: BIT,
            data: *byte,
            noise: false,
            broken: false,
        });
        self.out.extend(bytes_out);
        from + (bytes.len() as Nanos).saturating_sub(1) * BYTE + BITS
    }

    /// When the next byte begins.
    pub(super) fn due(&self) -> Nanos {
        self.out.front().map_or(Nanos::MAX, |byte| byte.at)
    }

    /// The next byte, if it has begun by now. One that is lost never begins.
    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        while self.due() <= now {
            let byte = self.out.pop_front()?;
            if let Some(byte) = self.wire.send(byte) {
                return Some(byte);
            }
        }
        None
    }
}

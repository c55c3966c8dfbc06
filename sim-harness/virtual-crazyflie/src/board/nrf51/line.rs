//! The radio chip's end of the serial line: bytes that wait to be looked at, and bytes on their way
//! out.

use std::collections::VecDeque;

use super::super::noise::{Fate, Noise};
use crate::soc::{Nanos, UartByte};

/// A bit at 1 Mbaud.
const BIT: u32 = 1_000;
/// Start, eight bits, stop.
const BYTE: Nanos = 10 * BIT as Nanos;
/// A receiver follows a sender whose bits are longer or shorter by so many ns: half a bit in ten.
const TOLERANCE: u32 = BIT / 20;

/// Bytes that the chip's program keeps (`Q_LENGTH` less the one that stays empty).
const KEPT: usize = 127;
/// Bytes that the peripheral keeps beyond these (nRF51 reference manual, UART).
const FIFO: usize = 6;

/// Counts of received bytes that were lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Losses {
    /// Bytes for which there was no room.
    pub(super) dropped: u32,
    /// Bytes at another speed, or without a stop bit.
    pub(super) broken: u32,
}

/// Both directions.
#[derive(Debug)]
pub(super) struct Line {
    kept: VecDeque<u8>,
    out: VecDeque<UartByte>,
    pub(super) noise: (Noise, Noise),
    pub(super) losses: Losses,
}

impl Line {
    pub(super) const fn new() -> Self {
        Self {
            kept: VecDeque::new(),
            out: VecDeque::new(),
            noise: (Noise::none(), Noise::none()),
            losses: Losses { dropped: 0, broken: 0 },
        }
    }

    /// The chip was reset, or has lost its power: what has not left it never will.
    pub(super) fn fall_silent(&mut self, now: Nanos) {
        self.kept.clear();
        self.out.retain(|byte| byte.at < now);
    }

    /// A byte from the flight processor.
    pub(super) fn take(&mut self, byte: u8, bit: u32) {
        let fits = BIT.abs_diff(bit) <= TOLERANCE;
        let byte = match self.noise.0.pass(byte) {
            Fate::Intact(byte) | Fate::Noisy(byte) if fits => byte,
            Fate::Lost => return,
            _ => {
                self.losses.broken += 1;
                return;
            }
        };
        if self.kept.len() < KEPT + FIFO {
            self.kept.push_back(byte);
        } else {
            self.losses.dropped += 1;
        }
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
        self.kept.len() >= KEPT
    }

    /// Sends from a moment on, without a gap. Returns when the last stop bit is over.
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
        from + bytes.len() as Nanos * BYTE
    }

    /// When the next byte begins.
    pub(super) fn due(&self) -> Nanos {
        self.out.front().map_or(Nanos::MAX, |byte| byte.at)
    }

    /// The next byte, if it has begun by now. One that is lost never begins.
    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        while self.due() <= now {
            let byte = self.out.pop_front()?;
            match self.noise.1.pass(byte.data) {
                Fate::Intact(data) => return Some(UartByte { data, ..byte }),
                Fate::Noisy(data) => return Some(UartByte { data, noise: true, ..byte }),
                Fate::Broken(data) => return Some(UartByte { data, broken: true, ..byte }),
                Fate::Lost => {}
            }
        }
        None
    }
}

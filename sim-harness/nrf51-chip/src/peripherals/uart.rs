//! UART0: a receiver with six bytes and RTS, a transmitter with one.

use std::collections::VecDeque;

use super::interrupts::Events;
use crate::{Cycles, NEVER};

/// The offsets of the registers.
mod offset {
    pub(super) const STARTRX: u32 = 0x000;
    pub(super) const STOPRX: u32 = 0x004;
    pub(super) const STARTTX: u32 = 0x008;
    pub(super) const STOPTX: u32 = 0x00C;
    pub(super) const SUSPEND: u32 = 0x01C;
    pub(super) const ERRORSRC: u32 = 0x480;
    pub(super) const ENABLE: u32 = 0x500;
    pub(super) const PSELRTS: u32 = 0x508;
    pub(super) const PSELTXD: u32 = 0x50C;
    pub(super) const PSELCTS: u32 = 0x510;
    pub(super) const PSELRXD: u32 = 0x514;
    pub(super) const RXD: u32 = 0x518;
    pub(super) const TXD: u32 = 0x51C;
    pub(super) const BAUDRATE: u32 = 0x524;
    pub(super) const CONFIG: u32 = 0x56C;
}

/// The events, by their place.
mod event {
    pub(super) const CTS: u32 = 0;
    pub(super) const NCTS: u32 = 1;
    pub(super) const RXDRDY: u32 = 2;
    pub(super) const TXDRDY: u32 = 7;
    pub(super) const ERROR: u32 = 9;
    pub(super) const RXTO: u32 = 17;
    pub(super) const ALL: u32 =
        1 << CTS | 1 << NCTS | 1 << RXDRDY | 1 << TXDRDY | 1 << ERROR | 1 << RXTO;
}

/// The value of ENABLE that enables it.
const ENABLED: u32 = 4;
/// The bytes that the receiver holds, the one in RXD included.
const FIFO: usize = 6;
/// RTS is high while the receiver has room for no more than so many bytes.
const HEADROOM: usize = 4;
/// ERRORSRC: a byte came while the receiver was full; a byte had no stop bit.
const OVERRUN: u32 = 1;
const FRAMING: u32 = 4;
/// Start, eight bits, stop.
const BITS: u64 = 10;

/// A byte that the chip sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentByte {
    /// When its start bit begins, in cycles since the chip's start.
    pub at: Cycles,
    /// Its value.
    pub byte: u8,
}

/// The UART.
#[derive(Clone, Debug)]
pub(super) struct Uart {
    events: Events,
    enabled: bool,
    receives: bool,
    transmits: bool,
    errors: u32,
    /// The byte in RXD, and those behind it.
    fifo: VecDeque<u8>,
    /// The last byte that was in RXD.
    last: u8,
    /// The end of the byte that is being sent, and the byte that waits behind it.
    sending: Option<Cycles>,
    waiting: Option<u8>,
    sent: VecDeque<SentByte>,
    pins: [u32; 4],
    baud: u32,
    configuration: u32,
}

impl Uart {
    pub(super) const fn new() -> Self {
        Self {
            events: Events::new(event::ALL),
            enabled: false,
            receives: false,
            transmits: false,
            errors: 0,
            fifo: VecDeque::new(),
            last: 0,
            sending: None,
            waiting: None,
            sent: VecDeque::new(),
            pins: [u32::MAX; 4],
            baud: 0x0400_0000,
            configuration: 0,
        }
    }

    /// The duration of a byte: BAUDRATE is the rate × 2³² / 16 MHz.
    fn byte_time(&self) -> Cycles {
        (BITS << 32) / u64::from(self.baud.max(1))
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    pub(super) fn due(&self) -> Cycles {
        self.sending.unwrap_or(NEVER)
    }

    /// Whether RTS asks for a pause; `None` while the pin is not the UART's.
    pub(super) fn rts(&self) -> Option<bool> {
        let is_used = self.enabled && self.configuration & 1 != 0 && self.pins[0] != u32::MAX;
        is_used.then(|| !self.receives || self.fifo.len() + HEADROOM >= FIFO)
    }

    /// Bytes that have been begun, in order.
    pub(super) const fn sent(&mut self) -> &mut VecDeque<SentByte> {
        &mut self.sent
    }

    /// A byte's stop bit has passed. `None` is a byte without a stop bit, or at another rate.
    pub(super) fn receive(&mut self, byte: Option<u8>) {
        if !self.enabled || !self.receives {
            return;
        }
        match byte {
            Some(byte) if self.fifo.len() < FIFO => {
                self.fifo.push_back(byte);
                if self.fifo.len() == 1 {
                    self.events.raise(event::RXDRDY);
                }
            }
            Some(_) => self.fail(OVERRUN),
            None => self.fail(FRAMING),
        }
    }

    fn fail(&mut self, error: u32) {
        self.errors |= error;
        self.events.raise(event::ERROR);
    }

    /// Begins to send a byte.
    fn send(&mut self, now: Cycles, byte: u8) {
        self.sent.push_back(SentByte { at: now, byte });
        self.sending = Some(now + self.byte_time());
    }

    pub(super) fn advance(&mut self, now: Cycles) {
        while let Some(end) = self.sending.filter(|end| *end <= now) {
            self.sending = None;
            self.events.raise(event::TXDRDY);
            if let Some(byte) = self.waiting.take() {
                self.send(end, byte);
            }
        }
    }

    /// RXD is read: the next byte moves into it, and tells by RXDRDY.
    fn take(&mut self) -> u32 {
        if let Some(byte) = self.fifo.pop_front() {
            self.last = byte;
        }
        if !self.fifo.is_empty() {
            self.events.raise(event::RXDRDY);
        }
        self.last.into()
    }

    pub(super) fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::ERRORSRC => self.errors,
            offset::ENABLE => u32::from(self.enabled) * ENABLED,
            offset::PSELRTS..=offset::PSELRXD => self.pins[(offset - offset::PSELRTS) as usize / 4],
            offset::RXD => self.take(),
            offset::BAUDRATE => self.baud,
            offset::CONFIG => self.configuration,
            _ => return self.events.read(offset),
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        match offset {
            offset::STARTRX => self.receives = true,
            offset::STOPRX => self.receives = false,
            offset::STARTTX => self.transmits = true,
            offset::STOPTX => self.transmits = false,
            offset::SUSPEND => (self.receives, self.transmits) = (false, false),
            offset::ERRORSRC => self.errors &= !value,
            offset::ENABLE => self.enable(value == ENABLED),
            offset::PSELRTS | offset::PSELTXD | offset::PSELCTS | offset::PSELRXD => {
                self.pins[(offset - offset::PSELRTS) as usize / 4] = value;
            }
            offset::TXD if !self.enabled || !self.transmits => {}
            offset::TXD if self.sending.is_some() => self.waiting = Some(value as u8),
            offset::TXD => self.send(now, value as u8),
            offset::BAUDRATE => self.baud = value,
            offset::CONFIG => self.configuration = value,
            _ => self.events.write(offset, value)?,
        }
        Some(())
    }

    fn enable(&mut self, on: bool) {
        self.enabled = on;
        if !on {
            self.fifo.clear();
            (self.sending, self.waiting) = (None, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uart() -> Uart {
        let mut uart = Uart::new();
        let set = [
            (offset::PSELRTS, 14),
            (offset::CONFIG, 1),
            (offset::BAUDRATE, 0x1000_0000),
            (offset::ENABLE, ENABLED),
            (offset::STARTTX, 1),
            (offset::STARTRX, 1),
        ];
        for (offset, value) in set {
            uart.write(0, offset, value).unwrap();
        }
        uart
    }

    fn is(uart: &mut Uart, event: u32) -> bool {
        uart.read(0x100 + event * 4) == Some(1)
    }

    #[test]
    fn a_byte_at_one_megabaud_takes_ten_microseconds() {
        let mut uart = uart();
        uart.write(1000, offset::TXD, 0x5A).unwrap();
        assert_eq!(uart.due(), 1160);
        uart.advance(1159);
        assert!(!is(&mut uart, event::TXDRDY));
        uart.advance(1160);
        assert!(is(&mut uart, event::TXDRDY));
        assert_eq!(uart.sent().pop_front(), Some(SentByte { at: 1000, byte: 0x5A }));
    }

    #[test]
    fn the_receiver_keeps_six_bytes_and_says_so_from_the_second_on() {
        let mut uart = uart();
        let mut pauses = Vec::new();
        for byte in 0..7 {
            uart.receive(Some(byte));
            pauses.push(uart.rts().unwrap());
        }
        assert_eq!(pauses, [false, true, true, true, true, true, true]);
        assert_eq!(uart.read(offset::ERRORSRC), Some(OVERRUN));
        for byte in 0..6 {
            assert!(is(&mut uart, event::RXDRDY));
            uart.write(0, 0x108, 0).unwrap();
            assert_eq!(uart.read(offset::RXD), Some(byte));
        }
        assert!(!is(&mut uart, event::RXDRDY));
    }
}

//! Buffers the lines of the console until a client's packets carry them.

use heapless::Deque;
use wire::crtp::MAX_DATA;

/// The size of the buffer: about eight lines.
const ROOM: usize = 512;

/// The text that was not sent yet.
#[derive(Debug)]
pub(crate) struct Console {
    waiting: Deque<u8, ROOM>,
}

impl Console {
    pub(crate) const fn new() -> Self {
        Self { waiting: Deque::new() }
    }

    /// Adds a line, as a whole or, when there is no room for it, not at all. Clients decode each
    /// packet by itself, so nothing may take more than a byte: what does becomes `?`.
    pub(crate) fn say(&mut self, line: &str) -> bool {
        let length = line.chars().count() + 1;
        if length > ROOM - self.waiting.len() {
            return false;
        }
        let bytes = line.chars().map(|c| if c.is_ascii() { c as u8 } else { b'?' });
        for byte in bytes.chain([b'\n']) {
            let _ = self.waiting.push_back(byte);
        }
        true
    }

    /// Takes as much text as fits into a packet.
    pub(crate) fn next(&mut self, out: &mut [u8; MAX_DATA]) -> usize {
        let mut length = 0;
        for place in out.iter_mut() {
            let Some(byte) = self.waiting.pop_front() else { break };
            *place = byte;
            length += 1;
        }
        length
    }
}

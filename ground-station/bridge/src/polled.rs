//! Queues the packets of a client for a drone that is polled: one packet each time, repeated until
//! the drone acknowledges it, and the packets that come back in acknowledgements.
//!
//! A Crazyradio polls a drone, because the drone's radio chip sends nothing but acknowledgements.
//! Between a client and an emulated drone this queue is the Crazyradio. It sends one packet every
//! 10 ms, a hundred a second: the rate that leaves room for the chain's packets on the same channel.
//! Between a client and a real drone it is what the [`bridge`](crate) sends through a Crazyradio.

use std::collections::VecDeque;
use std::mem;

/// The null packet by which a Crazyradio asks for an acknowledgement, and a client looks for a
/// drone: port 15, channel 3.
pub const NULL: u8 = 0xFF;
/// The bits of a header that make a packet null; the others count acknowledgements.
const NULL_MASK: u8 = 0xF3;

/// Whether a packet is null. One without a header is none at all.
pub fn is_null(packet: &[u8]) -> bool {
    packet.first().is_some_and(|header| header & NULL_MASK == NULL & NULL_MASK)
}

/// The most packets of a client that wait; more are lost, as datagrams may be.
const WAITING: usize = 64;

/// The packets between a client and one polled drone.
#[derive(Debug, Default)]
pub struct Polled {
    waiting: VecDeque<Vec<u8>>,
    /// The packet that was sent last and is not acknowledged.
    unacknowledged: Option<Vec<u8>>,
    received: Vec<Vec<u8>>,
}

impl Polled {
    /// Takes a packet of the client.
    pub fn give(&mut self, packet: &[u8]) {
        if self.waiting.len() < WAITING {
            self.waiting.push_back(packet.to_owned());
        }
    }

    /// Takes an acknowledgement of the drone's radio chip.
    pub fn acknowledged(&mut self, answer: &[u8]) {
        self.unacknowledged = None;
        if !answer.is_empty() && !is_null(answer) {
            self.received.push(answer.to_owned());
        }
    }

    /// The packet to send in this step.
    pub fn next(&mut self) -> &[u8] {
        let Self { waiting, unacknowledged, .. } = self;
        unacknowledged.get_or_insert_with(|| waiting.pop_front().unwrap_or_else(|| vec![NULL]))
    }

    /// The packets of the drone that have come since the last call.
    pub fn take_received(&mut self) -> Vec<Vec<u8>> {
        mem::take(&mut self.received)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_is_repeated_until_it_is_acknowledged() {
        let mut polled = Polled::default();
        polled.give(&[0x3C, 1]);
        polled.give(&[0x3C, 2]);
        assert_eq!(polled.next(), [0x3C, 1]);
        assert_eq!(polled.next(), [0x3C, 1]);
        polled.acknowledged(&[0xF3]);
        assert_eq!(polled.next(), [0x3C, 2]);
    }

    #[test]
    fn a_drone_is_polled_with_null_packets_and_its_empty_answers_are_dropped() {
        let mut polled = Polled::default();
        assert_eq!(polled.next(), [NULL]);
        polled.acknowledged(&[0xF7]);
        polled.acknowledged(&[0x2D, 7]);
        assert_eq!(polled.take_received(), [[0x2D, 7]]);
        assert!(polled.take_received().is_empty());
    }

    #[test]
    fn a_client_that_floods_its_drone_loses_packets() {
        let mut polled = Polled::default();
        for n in 0..=u8::MAX {
            polled.give(&[0x3C, n]);
        }
        let mut sent = 0;
        while polled.next() != [NULL] {
            polled.acknowledged(&[0xF3]);
            sent += 1;
        }
        assert_eq!(sent, WAITING);
    }
}

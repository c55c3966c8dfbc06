//! Packets of robots that explore: what is accepted is byte for byte what would have been sent.

use frontier::{MOST_BYTES, Packet};

/// Decodes the bytes as a packet.
pub fn check(data: &[u8]) {
    if let Ok(packet) = Packet::decode(data) {
        assert!(data.len() <= MOST_BYTES);
        assert_eq!(&packet.encode()[..], data, "{packet:?}");
    }
}

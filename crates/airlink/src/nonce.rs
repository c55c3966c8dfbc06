//! Makes the nonces of packets (hops) and of sealed orders and telemetry (capsules), each of which
//! is used only once, and the associated data of a command.

use units::NodeId;
use wire::p2p::{Counter, Epoch, HEADER};

use crate::seal::NONCE;

/// The nonce of a packet's hop: the header, which holds sender and counter.
pub(crate) fn hop(header: [u8; HEADER]) -> [u8; NONCE] {
    let [a, b, c, d, e, f, g, h] = header;
    [a, b, c, d, e, f, g, h, 0, 0, 0, 0, 0, 0, 0, 0]
}

/// The nonce of an order to `node`, with the base's counter.
pub(crate) const fn command(node: NodeId, counter: Counter) -> [u8; NONCE] {
    end_to_end(*b"cmd", node, counter)
}

/// The nonce of telemetry from `node`, with the node's counter.
pub(crate) const fn telemetry(node: NodeId, counter: Counter) -> [u8; NONCE] {
    end_to_end(*b"tel", node, counter)
}

const fn end_to_end([x, y, z]: [u8; 3], node: NodeId, counter: Counter) -> [u8; NONCE] {
    let [a, b, c, d, e, f] = counter.to_bytes();
    [x, y, z, node.0, a, b, c, d, e, f, 0, 0, 0, 0, 0, 0]
}

/// The associated data of an order to `node`. It names the node's epoch, so that a reboot of the
/// node makes earlier orders void.
pub(crate) fn command_aad(node: NodeId, epoch: Epoch) -> [u8; 4] {
    let [a, b, c, _] = epoch.get().to_le_bytes();
    [node.0, a, b, c]
}

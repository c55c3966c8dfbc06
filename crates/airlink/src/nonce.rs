//! What each thing that is sealed is sealed under: a nonce that never comes again, and what is
//! authenticated beside it.

use units::NodeId;
use wire::p2p::{Counter, Epoch, HEADER};

use crate::seal::NONCE;

/// A packet's: the header says whose it is and which.
pub(crate) fn hop(clear: [u8; HEADER]) -> [u8; NONCE] {
    let [a, b, c, d, e, f, g, h] = clear;
    [a, b, c, d, e, f, g, h, 0, 0, 0, 0, 0, 0, 0, 0]
}

/// An order's to `node`, by the base's counter.
pub(crate) const fn command(node: NodeId, counter: Counter) -> [u8; NONCE] {
    end(*b"cmd", node, counter)
}

/// `node`'s telemetry's, by its own counter.
pub(crate) const fn telemetry(node: NodeId, counter: Counter) -> [u8; NONCE] {
    end(*b"tel", node, counter)
}

const fn end([x, y, z]: [u8; 3], node: NodeId, counter: Counter) -> [u8; NONCE] {
    let [a, b, c, d, e, f] = counter.to_bytes();
    [x, y, z, node.0, a, b, c, d, e, f, 0, 0, 0, 0, 0, 0]
}

/// An order is for one life of a node: after a reboot those of before are void.
pub(crate) fn command_aad(node: NodeId, epoch: Epoch) -> [u8; 4] {
    let [a, b, c, _] = epoch.get().to_le_bytes();
    [node.0, a, b, c]
}

//! A drone's end of the radio link: its time slots, its encryption and authentication, and the
//! relaying of orders and telemetry from hop to hop.
//!
//! [`Airlink`] takes the data of received P2P packets and the messages that the drone has to send,
//! and gives events and packets. It has no clock and does no I/O: the caller passes the time to
//! every method, asks [`due`] when to call next, and calls [`transmit`] then. The packet formats
//! are those of [`wire::p2p`].
//!
//! # Terms
//! - A **hop** is one transmission, from the sender to each node that hears it.
//! - The **far end** of an order is the node that it is for; the far end of telemetry is the node
//!   that it is from. The base is always the other end. A packet that carries an order is a
//!   **command**.
//! - A **capsule** is an order or telemetry, sealed for its two ends alone. The nodes between them
//!   pass it on but can neither read nor make one.
//! - An **epoch** is one life of a node, from switching on to switching off; it has a number that
//!   never comes again.
//! - A node is **fresh** to a receiver once it has named the receiver's present epoch, which proves
//!   that its packets are not a recording.
//!
//! # The frame
//! A frame lasts 100 ms, and each of 16 nodes (8 at 250 kbit/s) has two turns of one slot in it.
//! `o` is a turn of the outward wave, `i` one of the inward wave, by the node's number:
//!
//! ```text
//! slot   0    1    2    3    4    5         26   27   28   29   30   31
//!      ┌────┬────┬────┬────┬────┬────┬─ … ─┬────┬────┬────┬────┬────┬────┐
//!      │o15 │ i0 │o14 │ i1 │o13 │ i2 │     │ o2 │i13 │ o1 │i14 │ o0 │i15 │
//!      └────┴────┴────┴────┴────┴────┴─ … ─┴────┴────┴────┴────┴────┴────┘
//!        └─ o15, o14, … o0: an order runs from the base to the head in one frame
//!             └─ i0, i1, … i15: telemetry runs from the head to the base in one frame
//!
//! one slot at 2 Mbit/s, 3.125 ms:
//!      │ jitter │ line and chip │ air │                 │
//!      │        │         1.36        │ line and chip │ air │
//!        ≤ 0.3       ≤ 1.02      ≤ 0.43    0.5 for a late start
//! ```
//!
//! There is no common clock. Each packet tells when its sender's frame began, and each node aligns
//! its own frame to that of the largest node number that it hears, so that the whole chain follows
//! the base. A node that hears no larger number keeps time by its own clock.
//!
//! In a chain that is stretched, where a node hears only nodes up to two numbers away, it sends in the
//! turns of the numbers 6 and 12 from its own as well.
//!
//! # Receiving
//! A packet passes these checks in this order, and each kind of refusal is counted apart
//! ([`Refused`]). Until the tag is found right, a packet changes nothing but a count:
//!
//! 1. Its length, version and kind are valid.
//! 2. The sender's number has turns in the frame.
//! 3. The tag of the hop is right.
//! 4. The sender's number is not this node's own. If it is, the packet is an echo, or two nodes
//!    have that number: of the two the newcomer falls silent, or, when both have been members for a
//!    while, the one with the later epoch.
//! 5. Its counter is higher than that of the sender's last packet, and the packet is no more than
//!    [`LinkConfig::held_after`] later than the sender's fastest, by the time stamp in the counter.
//!    The strength and the phase of one that is later than [`LinkConfig::prompt_within`], or off the
//!    turn that its header names, are not used.
//! 6. The sender is fresh, or this packet proves that it is.
//! 7. The body decodes to a message.
//! 8. If the message is a capsule for this end, the capsule's counter is higher than that of the
//!    last one, the capsule's own tag is right, and an order other than to stop is not too late
//!    either.
//!
//! # Sending
//! The most urgent message goes first: membership (join, leave, refusal); then commands; in an
//! outward turn the report, then messages of the mission and then telemetry; in an inward turn
//! telemetry, then messages of the mission and then the report, which always gets the last packet of
//! that turn; at last the beacon. Of several commands, or
//! several pieces of telemetry, the one that was sent the fewest times goes first, and the head's
//! before the others'; a command that was sent already counts like one for a node a few hops nearer. A
//! turn that begins with a command to the head sends it twice.
//!
//! A node sends a capsule in turn after turn until it hears a node farther along send it, until a
//! newer capsule of the same far end comes, or until it has sent it ten times
//! ([`LinkConfig::tries`]). A node that has stopped and hears the capsule from upstream again sends it
//! once more.
//!
//! A node that [leaves](Airlink::leave) announces it in each packet of one turn and then falls
//! silent. A node that hears the announcement forgets the sender until it comes back with another
//! epoch.
//!
//! # Nonces
//! The nonce of a hop is the header, which holds sender and counter; the nonce of a capsule holds
//! which of the two ends sealed it, the node's number and the counter. A counter is the epoch and a
//! count within it, which is the time since boot or one more than the last; when the count is used up,
//! after 38 hours, the node falls silent. So no nonce is used
//! twice under one key as long as no epoch is, and as long as one node number alone has the base's
//! key.
//!
//! # What stolen keys allow
//! A thief with one drone's keys can send reports, beacons and membership in any node's name, can
//! hold capsules back, and can make other nodes deaf to a node number by counting that number's
//! counter up: a jammer that also lies about its position. The thief can neither give orders to
//! another drone, nor read another drone's orders, nor send another drone's telemetry to the base.
//! A thief with the base's keys can do everything that the base can.
//!
//! [`due`]: Airlink::due
//! [`transmit`]: Airlink::transmit
#![no_std]

#[cfg(test)]
extern crate std;

mod clock_sync;
mod config;
mod counters;
pub mod keys;
mod lateness;
mod link;
mod nonce;
mod order_distribution;
mod peers;
mod relay_queue;
mod schedule;
mod seal;
mod telemetry_sender;

pub use config::LinkConfig;
pub use counters::{Counters, Kinds, Refused};
pub use link::{Airlink, Event, Identity, Opened, Standing, Status};
pub use schedule::{FRAME, Full, Schedule};
pub use seal::{Scope, Seal, Sealed};

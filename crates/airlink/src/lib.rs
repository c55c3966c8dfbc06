//! A drone's end of the radio link: who speaks when, sealed with what, and who passes it on.
//!
//! [`Airlink`] takes the data of P2P packets and what the drone has to say, and gives events and
//! packets. It has no clock and does no I/O: it is told the time, says when it is [`due`] and is
//! asked then. The bytes are [`wire::p2p`]'s.
//!
//! # Words
//! - A **hop** is from a sender to whoever hears it. The **end** of an order is the node that it is
//!   for, that of telemetry the base.
//! - A **capsule** is an order or telemetry, sealed for its two ends alone. Those between pass it on
//!   but can neither read nor make one.
//! - An **epoch** is one life of a node, from switching on to switching off; it has a number that
//!   never comes again.
//! - A node is **fresh** to another when it has named that one's present epoch.
//!
//! # The frame
//! 100 ms, in which each of 16 nodes (8 at 250 kbit/s) has two turns of one slot. `o` is a turn of
//! the outward wave, `i` one of the inward wave, by the node's number:
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
//!      │ jitter │ serial line │ air │                    │
//!      │        │        │ serial line │ air │           │
//!        ≤ 0.3      ≤ 0.67    ≤ 0.43            ≥ 0.8 left, 0.5 for a late start
//! ```
//!
//! There is no common clock. A packet tells when its sender's frame began, and everybody follows the
//! node with the largest number that it hears, so at last the base. Whoever hears none larger goes
//! on by its own clock.
//!
//! # What comes in
//! In this order, each refusal counted apart ([`Refused`]); nothing but a count changes before the
//! tag is right:
//!
//! 1. length, version, kind;
//! 2. the sender's number has turns;
//! 3. the tag of the hop;
//! 4. it is not this node's own number. If it is, it is an echo, or there are two of that number: of
//!    two the newcomer falls silent, or, when both have spoken for a while, the later epoch;
//! 5. its counter is higher than the sender's last;
//! 6. the sender is fresh, or just proves that it is;
//! 7. the body is a message;
//! 8. of a capsule for this end: its counter is higher than the last, and its own tag is right.
//!
//! # What goes out
//! Most urgent first: who comes, goes or is refused; orders; in an outward turn the report and then
//! telemetry, in an inward turn telemetry and the report, which has the last packet of that turn
//! whatever else waits; then the beacon. Of orders and of telemetry what was said least comes first,
//! and the head's before the others'. The head's order is said twice in an outward turn.
//!
//! A capsule is said in turn after turn until somebody farther on has said it, a newer one has come,
//! or it has been said ten times ([`LinkConfig::tries`]).
//!
//! Whoever [leaves](Airlink::leave) says so once in each packet of one turn, and then nothing more.
//! Who hears it forgets the node until that comes back with another epoch.
//!
//! # Nonces
//! The nonce of a hop is the header, which holds sender and counter; that of a capsule holds which
//! of the two ends sealed it, the node's number and the counter. A counter is the epoch and a count
//! of packets within it; when the count is used up the node falls silent. So no nonce is used twice
//! under one key as long as no epoch is, and as long as one node number alone has the base's key.
//!
//! # Who may lie
//! Whoever has a drone's keys can send reports, beacons and membership in everybody's name, can keep
//! capsules back, and can make others deaf to a number by counting it up: a jammer that also lies
//! about where it is. It can neither order another drone about, nor read its orders, nor speak as
//! another to the base. Whoever has the base's keys has everything.
//!
//! [`due`]: Airlink::due
#![no_std]

#[cfg(test)]
extern crate std;

mod config;
mod counters;
mod follow;
pub mod keys;
mod link;
mod nonce;
mod orders;
mod peers;
mod relay;
mod schedule;
mod seal;
mod teller;

pub use config::LinkConfig;
pub use counters::{Counters, Kinds, Refused};
pub use link::{Airlink, Event, Identity, Standing, Status};
pub use schedule::{FRAME, Full, Schedule};
pub use seal::{Scope, Seal, Sealed};

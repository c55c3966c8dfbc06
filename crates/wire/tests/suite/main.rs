//! The formats: every value survives its encoding, and no bytes break a parser.

mod crtp;
mod docs;
mod messages;
mod p2p;
mod syslink;

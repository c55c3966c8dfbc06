//! U-Chain: how a relay between two links knows which way to fly, and when the next one starts.
//!
//! After P. Laclau et al., *Signal-based self-organization of a chain of UAVs for subterranean
//! exploration* (2020); equation and section numbers below are that paper's. Where the paper can
//! be read two ways, the book's chapter "The paper, resolved" says which way is taken and why.
//!
//! | module | paper | what it holds |
//! |---|---|---|
//! | [`filter`] | IV-C, (13)–(16) | what a link's strength is, from noisy packets and known motion |
//! | [`policy`] | IV-A, (11), Algorithm 1 | the forward velocity that makes two links equal |
//! | [`launch`] | IV-D | when a waiting relay takes off |
//! | [`retreat`] | IV-D | when a drone backs up towards the base |
//! | [`neighbours`] | III-A | who is in front, who is behind, and what they last said |
//! | [`report`] | — | what every drone says of itself at each round |
//!
//! # Terms
//! **Front** is towards the head, **back** towards the base. A **link** joins two neighbours of
//! the chain. Within the maths a link is a *loss* (positive dB, larger is worse), as in equation
//! (19); at every API it is an RSSI in dBm.
//!
//! Nothing here reads a clock, draws a random number, allocates or panics.
#![no_std]

pub mod filter;
pub mod launch;
pub mod neighbours;
pub mod policy;
pub mod report;
pub mod retreat;

//! U-Chain: the rules by which a relay chooses its speed along the tunnel, and by which the next
//! relay takes off.
//!
//! The method is that of P. Laclau et al., *Signal-based self-organization of a chain of UAVs for
//! subterranean exploration* (2020); equation and section numbers below are that paper's. Where the
//! paper can be read in two ways, the book's chapter "The paper, resolved" says which reading is
//! followed here, and why.
//!
//! | module | paper | contents |
//! |---|---|---|
//! | [`filter`] | IV-C, (13)–(16) | the strength of a link, from noisy packets and known motion |
//! | [`policy`] | IV-A, (11), Algorithm 1 | the forward velocity that makes two links equal; the registry of policies |
//! | [`governor`] | — | how fast the head may fly by its links, and its call for a relay |
//! | [`edge`] | — | the place behind which the head's link falls, and the way that the chain lacks there |
//! | [`launch`] | IV-D | the moment at which a waiting relay takes off |
//! | [`retirement`] | — | the moment at which a launched relay is no longer needed |
//! | [`retreat`] | IV-D | the conditions under which a drone backs up towards the base |
//! | [`perching`] | — | the conditions under which a drone relays from the ground |
//! | [`search`] | — | the search for a better place where equal links are not the best ones |
//! | [`route`] | VI | the pilot's choices at junctions, from the head to every relay |
//! | [`astray`] | — | the signs by which a relay notices that it took a wrong branch |
//! | [`neighbours`] | III-A | the neighbours in front and behind, with their last reports |
//! | [`report`] | — | the report that every drone sends in each round |
//!
//! # Terms
//! **Front** is towards the head, **back** towards the base. A **link** joins two neighbours of
//! the chain. Within the maths a link is a *loss* (positive dB, larger is worse), as in equation
//! (19); at every API it is an RSSI in dBm.
//!
//! No code of this crate reads a clock, draws a random number, allocates or panics.
#![no_std]

pub mod astray;
pub mod chain_wide;
pub mod edge;
pub mod filter;
pub mod governor;
pub mod launch;
pub mod neighbours;
pub mod perching;
pub mod policy;
pub mod report;
pub mod retirement;
pub mod retreat;
pub mod route;
pub mod search;

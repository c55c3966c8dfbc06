//! Plans on paper, before any drone flies: where relays would stand along a route, where they would be put
//! down in a place, and what explorers are given of it.
//!
//! | module | holds |
//! |---|---|
//! | [`plan`] | relays that hover along the route of a scenario |
//! | [`drops`] | relays that land for good, on a map |
//! | [`mod@explored`] | a place for explorers, made of a map |
//! | [`situations`] | the figures of the paper on placing communication nodes |

pub mod drops;
pub mod explored;
pub mod plan;
pub mod situations;

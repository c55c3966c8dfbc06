//! Measures missions: computes the metrics and the verdict of one mission, and the figures of many.
//!
//! | module | holds |
//! |---|---|
//! | [`metrics`] | the figures of one mission's chain |
//! | `truth` | the true plan in the cells of a map: where a drone's body can come to |
//! | [`verdict`] | whether a mission succeeded, and why it ended |
//! | [`intervals`] | intervals of shares, of medians, and of differences between two policies |
//! | [`claim`] | what such an interval says of a paper's claim |
//! | [`mod@campaign`] | many seeded missions on all cores, with intervals of confidence |
//! | [`mod@figures`] | the paper's figure 3 |
//! | [`mod@oracle`] | how far a head can get, for one who knows the world, the radio and the pilot |

pub mod campaign;
pub mod claim;
pub mod figures;
pub mod intervals;
pub mod metrics;
pub mod oracle;
mod truth;
pub mod verdict;

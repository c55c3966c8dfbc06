//! What must be true whatever bytes come in. One check for each door; the targets in
//! `fuzz_targets/` run them with bytes that libFuzzer makes up, and tests of the crates, by path,
//! with those that it has found so far.

pub mod airlink;
pub mod crtp;
pub mod wire;

//! The byte formats of the crate `wire`.

pub mod capsule;
pub mod p2p;
pub mod settings;
pub mod syslink;

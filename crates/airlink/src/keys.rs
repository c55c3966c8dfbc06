//! Derives the keys of all nodes from one fleet secret, which never leaves the host.
//!
//! ```text
//! fleet secret ─┬─ "group", generation ─▶ group key   every drone: seals each packet, hop by hop
//!               └─ "base", generation ──▶ base key    the base alone
//!                                           └─ "node", number ─▶ node key
//!                                                that node, and the base, which derives it:
//!                                                seals orders and telemetry, end to end
//! ```
//!
//! A derived key does not reveal its parent: it is the ciphertext of 16 zero bytes by Ascon-AEAD128
//! under the parent key, with the label as the nonce. Without the parent key, only an attack that
//! breaks the cipher (NIST SP 800-232) could distinguish it from random bytes. No parent key ever
//! encrypts anything else.

use core::fmt;

use ascon_aead::AsconAead128;
use ascon_aead::aead::{AeadInOut, KeyInit};
use units::NodeId;

/// Bytes of a key.
pub const KEY: usize = 16;

/// A key, whose bytes `Debug` does not print.
#[derive(Clone)]
pub struct Key([u8; KEY]);

impl Key {
    /// The key of these bytes.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; KEY]) -> Self {
        Self(bytes)
    }

    /// The bytes of the key, to be stored.
    #[must_use]
    pub const fn expose(&self) -> &[u8; KEY] {
        &self.0
    }

    /// Derives the key for `purpose` and `number` from this one.
    fn derive<const N: usize>(&self, purpose: &[u8; N], number: u8) -> Self {
        const { assert!(N < KEY, "purpose and number are one nonce") };
        let mut label = [0; KEY];
        for (place, byte) in label.iter_mut().zip(purpose.iter().chain([&number])) {
            *place = *byte;
        }
        let mut derived = [0; KEY];
        let cipher = AsconAead128::new((&self.0).into());
        // The cipher refuses only a text longer than it can count. The tag is not needed.
        let _ = cipher.encrypt_inout_detached((&label).into(), &[], derived.as_mut_slice().into());
        Self(derived)
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

/// The secret that all keys of a fleet are derived from. It is stored on the host only, never on a
/// drone.
#[derive(Clone, Debug)]
pub struct FleetSecret(Key);

impl FleetSecret {
    /// The secret of these bytes, which must come from a source of randomness.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; KEY]) -> Self {
        Self(Key(bytes))
    }

    /// The key that every drone of this generation has.
    #[must_use]
    pub fn group(&self, generation: u8) -> Key {
        self.0.derive(b"group", generation)
    }

    /// The base's key. It must be given to one node number only: two bases with the same counter
    /// would use a nonce twice.
    #[must_use]
    pub fn base(&self, generation: u8) -> Key {
        self.0.derive(b"base", generation)
    }
}

/// The key that the base shares with `node`.
#[must_use]
pub fn node(base: &Key, node: NodeId) -> Key {
    base.derive(b"node", node.0)
}

/// The keys of one drone.
#[derive(Clone, Debug)]
pub struct Keys {
    /// The key that all drones of the fleet have.
    pub group: Key,
    /// The key that no other drone has.
    pub own: Own,
}

/// The key that a drone shares with no other drone.
#[derive(Clone, Debug)]
pub enum Own {
    /// The key of a head or a relay, which the base can derive.
    Node(Key),
    /// The base's key, from which it derives the key of each node.
    Base(Key),
}

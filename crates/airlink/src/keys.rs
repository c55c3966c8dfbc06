//! Keys: from one fleet secret, which never leaves the host, everybody's own.
//!
//! ```text
//! fleet secret ─┬─ "group", generation ─▶ group key   every drone: seals each packet, hop by hop
//!               └─ "base", generation ──▶ base key    the base alone
//!                                           └─ "node", number ─▶ node key
//!                                                that node, and the base, which derives it:
//!                                                seals orders and telemetry, end to end
//! ```
//!
//! A step down cannot be undone: a derived key is what Ascon-AEAD128 under the parent key makes of
//! 16 zero bytes, with the label as the nonce; to tell that from chance without the parent key is
//! to break the cipher (NIST SP 800-232). No parent key ever encrypts anything else.

use core::fmt;

use ascon_aead::AsconAead128;
use ascon_aead::aead::{AeadInOut, KeyInit};
use units::NodeId;

/// Bytes of a key.
pub const KEY: usize = 16;

/// A key. What it is cannot be printed.
#[derive(Clone)]
pub struct Key([u8; KEY]);

impl Key {
    /// The key of these bytes.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; KEY]) -> Self {
        Self(bytes)
    }

    /// Its bytes, for whoever stores them.
    #[must_use]
    pub const fn expose(&self) -> &[u8; KEY] {
        &self.0
    }

    /// The key that follows from this one for `purpose` and `number`.
    fn derive<const N: usize>(&self, purpose: &[u8; N], number: u8) -> Self {
        const { assert!(N < KEY, "purpose and number are one nonce") };
        let mut label = [0; KEY];
        for (place, byte) in label.iter_mut().zip(purpose.iter().chain([&number])) {
            *place = *byte;
        }
        let mut derived = [0; KEY];
        let cipher = AsconAead128::new((&self.0).into());
        // Fails only for more bytes than can be counted. The tag is not needed.
        let _ = cipher.encrypt_inout_detached((&label).into(), &[], derived.as_mut_slice().into());
        Self(derived)
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

/// What everything else follows from. It belongs on the host alone.
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

    /// The base's key. Give it to one node number alone: two bases that count alike would use a
    /// nonce twice.
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

/// What one drone has.
#[derive(Clone, Debug)]
pub struct Keys {
    /// Everybody's.
    pub group: Key,
    /// Its own.
    pub own: Own,
}

/// What one drone shares with nobody, or with the base alone.
#[derive(Clone, Debug)]
pub enum Own {
    /// A head's or a relay's.
    Node(Key),
    /// The base's.
    Base(Key),
}

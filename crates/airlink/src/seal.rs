//! Sealing of packets and capsules: encryption and authentication with Ascon-AEAD128 (NIST SP
//! 800-232), with tags cut to 8 bytes.
//!
//! An attacker needs 2⁶⁴ tries on average to guess a tag of 8 bytes, which takes 100 million years
//! at the few thousand packets a second that the radio channel can carry. Header and tag leave 44
//! of 60 bytes for the message.

use ascon_aead::aead::consts::U8;
use ascon_aead::aead::{AeadInOut, KeyInit};
use ascon_aead::{Tag, TruncatedAsconAead128};
use units::NodeId;
use wire::p2p::TAG;

use crate::keys::{self, Key, Keys, Own};

/// Bytes of a nonce.
pub(crate) const NONCE: usize = 16;

type Cipher = TruncatedAsconAead128<U8>;

/// The nodes that can open sealed bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Scope {
    /// Every drone of the fleet can open it: a packet, sealed for one hop.
    Fleet,
    /// The base and this node can open it: an order or telemetry, sealed from end to end.
    EndToEnd(NodeId),
}

/// A method to seal packets. [`Sealed`] is the only one that a real drone may use.
pub trait Seal {
    /// Encrypts `body` in place and returns the tag of it and of `aad`.
    fn seal(&self, scope: Scope, nonce: &[u8; NONCE], aad: &[u8], body: &mut [u8]) -> [u8; TAG];

    /// Decrypts `body` in place and returns whether `body`, `aad` and `tag` are those of a
    /// [`Seal::seal`] under this nonce and the same key. If they are not, `body` holds no plaintext
    /// and must not be used.
    fn open(
        &self,
        scope: Scope,
        nonce: &[u8; NONCE],
        aad: &[u8],
        body: &mut [u8],
        tag: &[u8; TAG],
    ) -> bool;
}

/// The [`Seal`] that encrypts and authenticates with a drone's keys.
#[derive(Clone, Debug)]
pub struct Sealed {
    keys: Keys,
}

impl Sealed {
    /// Makes a seal with these keys.
    #[must_use]
    pub const fn new(keys: Keys) -> Self {
        Self { keys }
    }

    fn cipher(&self, scope: Scope) -> Cipher {
        let with = |key: &Key| Cipher::new(key.expose().into());
        match (scope, &self.keys.own) {
            (Scope::Fleet, _) => with(&self.keys.group),
            (Scope::EndToEnd(_), Own::Node(key)) => with(key),
            (Scope::EndToEnd(node), Own::Base(base)) => with(&keys::node(base, node)),
        }
    }
}

impl Seal for Sealed {
    fn seal(&self, scope: Scope, nonce: &[u8; NONCE], aad: &[u8], body: &mut [u8]) -> [u8; TAG] {
        let sealed =
            self.cipher(scope).encrypt_inout_detached(nonce.into(), aad, (&mut *body).into());
        match sealed {
            Ok(tag) => tag.into(),
            // The cipher refuses only a body longer than it can count. Such a body must not go out
            // in clear.
            Err(_) => {
                body.fill(0);
                [0; TAG]
            }
        }
    }

    fn open(
        &self,
        scope: Scope,
        nonce: &[u8; NONCE],
        aad: &[u8],
        body: &mut [u8],
        tag: &[u8; TAG],
    ) -> bool {
        let tag: &Tag<Cipher> = tag.into();
        self.cipher(scope).decrypt_inout_detached(nonce.into(), aad, body.into(), tag).is_ok()
    }
}

//! How packets are sealed in the simulator: at flight level as on board, at point level not at
//! all, as thousands of missions a minute have other things to do with their time. Lengths, counters
//! and every check but that of the tag are the same.

use airlink::keys::{FleetSecret, Keys, Own, node};
use airlink::{Scope, Seal, Sealed};
use units::NodeId;
use wire::p2p::TAG;

use crate::random::{Purpose, Stream};
use crate::scenario::Fidelity;

/// What a member's packets are sealed with.
pub(super) enum Cipher {
    /// Nothing: text in clear, a tag of zeros.
    Clear,
    /// What the firmware uses.
    Sealed(Sealed),
}

impl Cipher {
    /// For this member of the chain, with the keys of the fleet that this seed makes.
    pub(super) fn of(fidelity: Fidelity, seed: u64, id: NodeId, base: bool) -> Self {
        const GENERATION: u8 = 1;
        if fidelity == Fidelity::Point {
            return Self::Clear;
        }
        let secret = FleetSecret::from_bytes(Stream::new(seed, Purpose::Keys).bytes());
        let base_key = secret.base(GENERATION);
        let own = if base { Own::Base(base_key) } else { Own::Node(node(&base_key, id)) };
        Self::Sealed(Sealed::new(Keys { group: secret.group(GENERATION), own }))
    }

    pub(super) const fn is_sealed(fidelity: Fidelity) -> bool {
        fidelity.is_rigid()
    }
}

impl Seal for Cipher {
    fn seal(&self, scope: Scope, nonce: &[u8; 16], aad: &[u8], body: &mut [u8]) -> [u8; TAG] {
        match self {
            Self::Clear => [0; TAG],
            Self::Sealed(sealed) => sealed.seal(scope, nonce, aad, body),
        }
    }

    fn open(
        &self,
        scope: Scope,
        nonce: &[u8; 16],
        aad: &[u8],
        body: &mut [u8],
        tag: &[u8; TAG],
    ) -> bool {
        match self {
            Self::Clear => *tag == [0; TAG],
            Self::Sealed(sealed) => sealed.open(scope, nonce, aad, body, tag),
        }
    }
}

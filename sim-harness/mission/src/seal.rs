//! Seals packets in the simulator: at flight level as on board, at point level not at all, to save
//! time. Lengths, counters and every check but that of the tag are the same.

use airlink::keys::{FleetSecret, Keys, Own, node};
use airlink::{Scope, Seal, Sealed};
use random::{Purpose, Stream};
use units::NodeId;
use wire::p2p::TAG;

use scenario::Fidelity;

/// The cipher of a member's packets.
pub(super) enum Cipher {
    /// No cipher: bodies in clear, tags of zeros.
    Clear,
    /// The cipher of the firmware.
    Sealed(Sealed),
}

impl Cipher {
    /// The cipher of this member of the chain, with the keys of the fleet that this seed makes.
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

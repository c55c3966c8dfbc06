//! Helpers of the tests: a simulated radio channel with nodes, a seeded random generator, and keys.
#![allow(unreachable_pub, reason = "a module of the tests")]

pub mod net;
pub mod unsealed;

use airlink::keys::{self, FleetSecret, Keys, Own};
use airlink::{Identity, Sealed};
use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;
use units::{LinkSum, Metres, MetresPerSecond, NodeId, Phase, Role};
use wire::p2p::{Report, Telemetry};

pub fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// The random generator SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// A random number from 0 to `n` − 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// True with probability `p`.
    pub fn hits(&mut self, p: f64) -> bool {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64 <= p && p > 0.0
    }
}

pub const SECRET: [u8; 16] = *b"a fleet's secret";

pub fn fleet() -> FleetSecret {
    FleetSecret::from_bytes(SECRET)
}

/// The keys of `identity` in generation 1.
pub fn keys_of(identity: Identity) -> Keys {
    let base = fleet().base(1);
    let own = match identity.role {
        Role::Base => Own::Base(base),
        Role::Head | Role::Relay => Own::Node(keys::node(&base, identity.node)),
    };
    Keys { group: fleet().group(1), own }
}

pub fn sealed(identity: Identity) -> Sealed {
    Sealed::new(keys_of(identity))
}

/// The identity of number `node` in a chain of `nodes`, of which the base has the largest.
pub fn identity(node: usize, nodes: usize) -> Identity {
    let role = match node {
        0 => Role::Head,
        n if n + 1 == nodes => Role::Base,
        _ => Role::Relay,
    };
    Identity { node: NodeId(node as u8), role }
}

pub fn report() -> Report {
    Report {
        phase: Phase::Linked,
        recall: false,
        calls: false,
        is_uneven: false,
        velocity: MetresPerSecond(0.25),
        odometer: Metres(12.0),
        links: None,
        sums: [LinkSum::NONE; 2],
        waiting: 1,
        head_velocity: MetresPerSecond(0.25),
        signpost: None,
        heard: heapless::Vec::new(),
    }
}

pub fn telemetry() -> Telemetry {
    Telemetry {
        state: 3,
        fault: 0,
        battery: None,
        endurance: None,
        front: None,
        back: None,
        odometer: Metres(0.0),
        velocity: MetresPerSecond(0.0),
        height: None,
        heeded: 0,
    }
}

/// The quantile `p` of `all`.
pub fn quantile(all: &mut [u64], p: f64) -> u64 {
    all.sort_unstable();
    all[((all.len() - 1) as f64 * p).round() as usize]
}

//! Makes the keys and settings of a drone before its first flight. The keys are made as `uchain
//! keys provision` makes them.

use agent::{AgentConfig, SwarmConfig};
use airlink::keys::{FleetSecret, node as node_key};
use chain::policy::{Policy, REGISTRY};
use onboard::Config;
use storage::epoch::Issue;
use storage::keys::{KeysRecord, Secret};
use storage::settings::{Limits, Radio, Settings, SwarmPlan};
use storage::{Record, Slot};
use units::{Dbm, MissionKind, NodeId, Radians, Role};

use crate::random::{Purpose, Stream};
use crate::scenario::Scenario;

/// The memories of a drone that is switched on for the first time.
pub(super) struct Provisions {
    /// The page that the firmware takes over at its first boot.
    pub(super) page: Vec<u8>,
    /// The EEPROM from its first byte.
    pub(super) eeprom: Vec<u8>,
}

/// Makes them. The keys are those that the seed makes for the drones of the host.
pub(super) fn provision(scenario: &Scenario, node: NodeId, seed: u64) -> Provisions {
    const GENERATION: u8 = 1;
    let secret = FleetSecret::from_bytes(Stream::new(seed, Purpose::Keys).bytes());
    let role = scenario.drones.role(node.0.into());
    let base_key = secret.base(GENERATION);
    let own = if role == Role::Base { base_key } else { node_key(&base_key, node) };
    let keys = KeysRecord {
        fleet: 1,
        generation: GENERATION,
        issue: Issue::new(1 + node.0).expect("a chain has fewer members than a fleet has issues"),
        node,
        role,
        may_fly: role == Role::Base,
        group: Secret::new(*secret.group(GENERATION).expose()),
        own: Secret::new(*own.expose()),
    };
    let page = keys.encode(0).expect("only a base's record lets clients fly the head");
    let record = settings(scenario, node, role).encode(1);
    let record = record.expect("the scenario was looked at before");
    let mut eeprom = vec![0xFF; usize::from(Settings::address(Slot::A))];
    eeprom.extend(record);
    Provisions { page: page.to_vec(), eeprom }
}

fn settings(scenario: &Scenario, node: NodeId, role: Role) -> Settings {
    let agent = &scenario.agent;
    let default = AgentConfig::DEFAULT;
    let changed = |is: Dbm, default: Dbm| (is != default).then_some(is);
    Settings {
        node,
        role,
        radio: Radio { datarate: scenario.radio.datarate, ..Settings::DEFAULT.radio },
        height: (agent.flight.height != default.flight.height).then_some(agent.flight.height),
        policy: policy(agent).filter(|_| agent.policy != default.policy).map(|policy| policy.code),
        limits: Limits {
            launch: changed(agent.launch.limit, default.launch.limit),
            retreat: changed(agent.retreat.limit, default.retreat.limit),
        },
        mission: scenario.mission,
        fetched: scenario.drones.fetched,
        swarm: (scenario.mission == MissionKind::Swarm).then(|| plan(&agent.swarm)),
        ..Settings::DEFAULT
    }
}

/// The plan of a swarm, as a drone stores it.
fn plan(swarm: &SwarmConfig) -> SwarmPlan {
    let SwarmConfig { drones, corner, area, passage, .. } = *swarm;
    SwarmPlan {
        drones: u8::try_from(drones).unwrap_or(u8::MAX),
        corner,
        area,
        entrance: passage.entrance,
        width: passage.width,
        direction: Radians(libm::atan2f(passage.way.y, passage.way.x)),
        length: passage.length,
    }
}

/// Whether a drone that has stored the plan of this swarm flies just that.
fn is_kept(swarm: &SwarmConfig) -> bool {
    let settings = Settings { swarm: Some(plan(swarm)), ..Settings::DEFAULT };
    let stored = settings.encode(1).and_then(|bytes| Settings::decode(&bytes));
    stored.is_ok_and(|(stored, _)| {
        Config::DEFAULT.with_settings(&stored, |_| {}).agent.swarm == *swarm
    })
}

/// The policy of the registry that the agent flies.
fn policy(agent: &AgentConfig) -> Option<&'static Policy> {
    REGISTRY.iter().find(|policy| policy.config == agent.policy)
}

/// The reason why the firmware cannot fly this scenario, if it cannot: some constants are compiled
/// in.
#[must_use]
pub fn unfit(scenario: &Scenario) -> Option<&'static str> {
    let agent = &scenario.agent;
    let default =
        AgentConfig::DEFAULT.with_limits(Some(agent.launch.limit), Some(agent.retreat.limit));
    let range = Limits::RANGE;
    let kept = |limit: Dbm| limit >= range[0] && limit <= range[1];
    if policy(agent).is_none() {
        Some("another loss over the first metre than the one that is compiled in")
    } else if agent.launch != default.launch {
        Some("another launch policy: only launch.limit_dbm can be set on a drone")
    } else if agent.retreat != default.retreat {
        Some("another retreat: only retreat.limit_dbm can be set on a drone")
    } else if !kept(agent.launch.limit) || !kept(agent.retreat.limit) {
        Some("a limit that no drone keeps")
    } else if scenario.mission == MissionKind::Swarm && !is_kept(&agent.swarm) {
        Some("a swarm with another speed, or a plan that is finer than a centimetre or too large")
    } else if scenario.mission == MissionKind::Explore && agent.explore != default.explore {
        Some("another area to explore")
    } else if agent.nav != default.nav {
        Some("side rangers with another reach")
    } else if !matches!(scenario.drones.start, crate::scenario::Start::Mouth) {
        Some("drones that begin in the air")
    } else if scenario.drones.explorers > 1 {
        Some("a second explorer: only drone 0 is given the head's keys")
    } else {
        None
    }
}

//! Makes the keys and settings of a drone before its first flight. The keys are made as `uchain
//! keys provision` makes them, and a mission as it writes it.

use agent::AgentConfig;
use airlink::keys::{FleetSecret, node as node_key};
use chain::policy::{Policy, REGISTRY};
use fleet_keys::{self, stored_plan};
use random::{Purpose, Stream};
use storage::epoch::Issue;
use storage::keys::{KeysRecord, PageMission, Secret};
use storage::settings::{Limits, Radio, Settings};
use storage::{Record, Slot};
use units::{Dbm, MissionKind, NodeId, Role};

use scenario::Scenario;

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
    let record = KeysRecord {
        fleet: 1,
        generation: GENERATION,
        issue: Issue::new(1 + node.0).expect("a chain has fewer members than a fleet has issues"),
        node,
        role,
        may_fly: role == Role::Base,
        group: Secret::new(*secret.group(GENERATION).expose()),
        own: Secret::new(*own.expose()),
    };
    let page = record.encode(0).expect("only a base's record lets clients fly the head");
    let page = fleet_keys::page(&page, None, None, mission(scenario).as_ref());
    let page = page.expect("the scenario was looked at before");
    let record = settings(scenario, node, role).encode(1);
    let record = record.expect("the scenario was looked at before");
    let mut eeprom = vec![0xFF; usize::from(Settings::address(Slot::A))];
    eeprom.extend(record);
    Provisions { page, eeprom }
}

/// The mission for the page: the chain is what a drone flies anyway.
fn mission(scenario: &Scenario) -> Option<PageMission> {
    let kind = scenario.mission;
    let swarm = stored_plan(&scenario.agent.swarm).filter(|_| kind == MissionKind::Swarm);
    let fetched = scenario.drones.fetched;
    (kind != MissionKind::Chain).then_some(PageMission { kind, swarm, fetched })
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
        fetched: scenario.drones.fetched,
        ..Settings::DEFAULT
    }
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
    } else if scenario.mission == MissionKind::Swarm && stored_plan(&agent.swarm).is_none() {
        Some("a swarm with another speed, or a plan that is finer than a centimetre or too large")
    } else if scenario.mission == MissionKind::Explore && agent.explore != default.explore {
        Some("another area to explore, or side rangers that see rays")
    } else if agent.nav != default.nav {
        Some("side rangers with another reach")
    } else if !matches!(scenario.drones.start, scenario::Start::Mouth) {
        Some("drones that begin in the air")
    } else if scenario.drones.explorers > 1 {
        Some("a second explorer: only drone 0 is given the head's keys")
    } else {
        None
    }
}

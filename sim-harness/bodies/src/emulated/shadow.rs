//! Follows a firmware's agent by the same agent on the host: the map of a drone that explores, which
//! is in the memory of the chip, is then the map of the agent on the host, as long as both decide alike.

use agent::{Agent, AgentConfig, Exploration};
use units::{MissionKind, NodeId, Role};
use virtual_crazyflie::memory::Memory;

use super::Firmware;
use scenario::Scenario;

/// The agent on the host that is given the inputs of the one on the chip.
pub(super) struct Shadow {
    agent: Agent,
    config: AgentConfig,
    exploration: Box<Exploration>,
    /// The probe's count of rounds at the last look.
    count: u32,
    /// The rounds in which the two decided alike, and those in which they did not.
    rounds: [u32; 2],
}

impl Shadow {
    /// The agent of a drone of this scenario, where the drones explore.
    pub(super) fn of(scenario: &Scenario, node: NodeId) -> Option<Self> {
        let role = if node == NodeId::HEAD { Role::Head } else { Role::Relay };
        let limits = [scenario.agent.launch.limit, scenario.agent.retreat.limit].map(Some);
        let [launch, retreat] = limits;
        (scenario.mission == MissionKind::Explore).then(|| Self {
            agent: Agent::new(node, role, MissionKind::Explore),
            config: AgentConfig::DEFAULT.with_limits(launch, retreat),
            exploration: Box::new(Exploration::NEW),
            count: 0,
            rounds: [0; 2],
        })
    }

    /// Takes a new round, if there is one. To be called more often than there are rounds.
    pub(super) fn look(&mut self, firmware: &Firmware, memory: &Memory) {
        if firmware.rounds(memory) == self.count {
            return;
        }
        // A round that is being written is whole at the next look.
        let Some((count, round)) = firmware.round(memory) else { return };
        self.count = count;
        let (inputs, exploration) = (round.inputs.borrow(), Some(&mut *self.exploration));
        let here = self.agent.step_exploring(&self.config, round.now, &inputs, exploration);
        // The text of a float is exact.
        let is_alike = format!("{here:?}") == format!("{:?}", round.outputs);
        self.rounds[usize::from(!is_alike)] += 1;
    }

    /// The drone's map.
    pub(super) fn exploration(&self) -> &Exploration {
        &self.exploration
    }

    /// The rounds in which chip and host decided alike, and those in which they did not.
    pub(super) const fn rounds(&self) -> [u32; 2] {
        self.rounds
    }
}

//! Begins an agent's run anew in the memory that it has.

use units::{MissionKind, NodeId, Role};

use crate::Agent;
use crate::mission::{Mission, Outbox};
use crate::odometry::Odometry;
use crate::state::State;

impl Agent {
    /// Makes this agent what [`Agent::new`] returns, part by part, so that only one part at a time is on the
    /// stack. The compiler may hold a whole agent there twice.
    pub fn renew(&mut self, id: NodeId, role: Role, mission: MissionKind) {
        let Self {
            id: old_id,
            role: old_role,
            state,
            mission: old_mission,
            outbox,
            navigator,
            heeded,
            recalled,
            fit,
            odometry,
            last_step,
            sequence,
        } = self;
        (*old_id, *old_role, *state) = (id, role, State::Idle);
        put(old_mission, || Mission::new(mission));
        put(outbox, Outbox::new);
        navigator.renew();
        put(odometry, Odometry::new);
        (*heeded, *last_step) = (None, None);
        (*recalled, *fit, *sequence) = (false, true, 0);
    }
}

/// Replaces a part of the agent, in a function of its own, whose stack is free again before the next part.
#[inline(never)]
fn put<T>(part: &mut T, new: impl FnOnce() -> T) {
    *part = new();
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::format;

    use units::Instant;

    use super::*;

    #[test]
    fn an_agent_made_anew_is_a_new_one_whatever_it_was() {
        for mission in [MissionKind::Chain, MissionKind::Swarm, MissionKind::Explore] {
            let (relay, base) = (NodeId(2), NodeId(0));
            let mut agent =
                Agent::new_linked(relay, Role::Relay, MissionKind::Explore, Instant::ZERO);
            (agent.recalled, agent.fit, agent.sequence) = (true, false, 7);
            agent.last_step = Some(Instant::ZERO);
            agent.renew(base, Role::Base, mission);
            assert_eq!(
                format!("{agent:?}"),
                format!("{:?}", Agent::new(base, Role::Base, mission))
            );
        }
    }
}

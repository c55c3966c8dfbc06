//! Where a drone of a swarm is to be, for observers.

use virtual_forces::{Member, Target};

use crate::Agent;
use crate::mission::Mission;

impl Agent {
    /// Where a drone of a swarm is to be, for observers; `None` in other missions, before the mission, in the
    /// passage, and at the end of the mission.
    #[must_use]
    pub fn target(&self) -> Option<Target> {
        match &self.mission {
            Mission::Swarm(swarm) => swarm.member.as_ref().and_then(Member::target),
            Mission::Chain(_) | Mission::Explore(_) => None,
        }
    }
}

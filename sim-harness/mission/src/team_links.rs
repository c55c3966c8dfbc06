//! Records who hears whom in a swarm or an exploration, which keep no links as a chain does.

use units::{Dbm, MissionKind};

use super::Mission;

/// A pair of members that hear each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeamLink {
    /// The places of both in the list of members, the lesser first.
    pub ends: [u8; 2],
    /// The true strength at which the weaker end receives the other one, dBm.
    pub strength: Dbm,
}

impl Mission<'_> {
    /// All pairs of members that hear each other, in order; none in a chain, whose drones record their links
    /// themselves.
    pub(super) fn team_links(&self) -> Vec<TeamLink> {
        if self.scenario.mission == MissionKind::Chain {
            return Vec::new();
        }
        let least = self.scenario.radio.reception.sensitivity;
        let count = self.members.len();
        let pairs = (0..count).flat_map(|one| (one + 1..count).map(move |other| (one, other)));
        let link = |(one, other): (usize, usize)| {
            let ways = [self.true_strength(one, other), self.true_strength(other, one)];
            let strength = Dbm(ways[0].0.min(ways[1].0));
            let is_heard = strength >= least && !self.is_gone(one) && !self.is_gone(other);
            is_heard.then_some(TeamLink { ends: [one as u8, other as u8], strength })
        };
        pairs.filter_map(link).collect()
    }

    /// Whether the scenario has taken this member from the mission, so that it sends no more.
    fn is_gone(&self, member: usize) -> bool {
        self.members.get(member).is_some_and(|member| member.is_silenced())
    }
}

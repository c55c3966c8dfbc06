//! The search of a drone of the chain for a spot at which to land for good, as a duty of the chain.

use tunnel_nav::{NavCommand, SpotSearch, SpotView};

use super::{Chain, ChainDuty};
use crate::AgentConfig;
use crate::mission::Round;

impl Chain {
    /// Carries out a round of the search, at the duty to do so, and returns whether the drone is at
    /// the place at which it is to land.
    pub(super) fn is_sited(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> bool {
        let ChainDuty::Siting { since } = duty else {
            self.spot = None;
            return false;
        };
        let view = self.spot_view(config, round);
        let begin = || SpotSearch::begin(since, view.way, view.pose);
        let search = self.spot.unwrap_or_else(begin);
        let next = search.step(&config.spot, round.now, &view);
        // A drone that is there stays there until it lands.
        self.spot = Some(next.unwrap_or(search));
        next.is_none()
    }

    /// How the drone flies at the duty to look for a spot; `None` at another.
    pub(super) fn siting_command(
        &self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> Option<NavCommand> {
        let ChainDuty::Siting { .. } = duty else { return None };
        let view = self.spot_view(config, round);
        Some(self.spot?.command(&config.spot, &config.nav, &view))
    }

    /// What the drone senses of its place.
    fn spot_view(&self, config: &AgentConfig, round: &Round) -> SpotView {
        let links = self.links(config, round.role);
        SpotView {
            ranges: self.ranges,
            height: self.height,
            way: round.way(),
            pose: round.here.pose,
            over: links.over_ground.map(|over| over.map(|over| over - config.perch.reserve)),
            may_land: links.bear_ground,
            has_room: [!links.is_front_near, !links.is_back_near],
        }
    }
}

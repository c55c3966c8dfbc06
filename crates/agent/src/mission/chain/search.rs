//! The search of a relay for a better place, as a duty of the chain.

use chain::neighbours::Neighbour;
use chain::policy::SpeedLaw;
use chain::search::{Place, Prospect, Scene};
use units::{Dbm, Duration, MetresPerSecond, Order, Phase};

use super::{Chain, ChainDuty};
use crate::AgentConfig;
use crate::mission::Round;

/// As its neighbours move to their new places, the best place of a drone that has found one moves as
/// well: it searches again where its links become too weak, but no more often than this.
const MOST_RENEWALS: u8 = 3;

/// A drone that flies no faster than this stands still, m/s: three times the noise of its velocity.
pub(super) const STILL: f32 = 0.06;

impl Chain {
    /// Whether this relay, at its `duty`, should look for a better place now.
    pub(super) fn searches(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> bool {
        let law = &config.policy.law;
        let (ChainDuty::Relaying { .. }, SpeedLaw::ChainWide(_)) = (duty, law) else {
            return false;
        };
        let ends = self.front().zip(self.back());
        let (Some((front, back)), Some(Order::Explore(..))) = (ends, round.order()) else {
            self.search.rest();
            return false;
        };
        let weaker = Dbm(front.rssi().0.min(back.rssi().0));
        let may_renew = self.found.is_some() && self.renewals < MOST_RENEWALS;
        if may_renew && weaker < config.launch.limit && ![front, back].into_iter().any(is_searching)
        {
            self.renewals += 1;
            return true;
        }
        let velocities =
            [self.velocity, self.head_velocity, front.report.velocity, back.report.velocity];
        // All relays of a chain that is too weak know it at the same time, whichever of them has the
        // weaker links of the moment: their turns decide which of them looks first.
        let level = self.chain_wide.level().map_or(weaker, Dbm::after_loss);
        let is_still = velocities.iter().all(|velocity| velocity.0.abs() < STILL);
        let scene = Scene {
            place: Place { way: round.way(), weaker },
            neighbours: [front.report.odometer, back.report.odometer],
            is_calm: is_still && ![front, back].into_iter().any(is_searching),
            is_help_near: self.waiting(config, round) > 0,
            limit: config.launch.limit,
            weakest: Dbm(weaker.0.min(level.0)),
            prospect: self.prospect(),
        };
        // Of three relays the one in the middle begins: its neighbours can share what it gains.
        let turn = if round.id.0.is_multiple_of(2) { Duration::ZERO } else { config.search.turn };
        self.search.step(&config.search, round.now, turn, &scene)
    }

    /// Whether a link of this drone to any other became stronger as it was lengthened, now or before,
    /// or the drone in front says so of those ahead.
    pub(super) fn has_uneven_links(&self, config: &AgentConfig) -> bool {
        self.is_uneven
            || self.front().is_some_and(|front| front.report.is_uneven)
            || self.neighbours.states().any(|link| link.hump >= config.search.hump)
    }

    /// The relay's reason to expect a better place than the one at which its links are equal.
    const fn prospect(&self) -> Prospect {
        if self.is_uneven {
            Prospect::Hump
        } else if self.home_rssi.is_none() {
            Prospect::Unknown
        } else {
            Prospect::None
        }
    }

    /// The velocity of a relay that stays at a place that it has found, while that place is worth it.
    pub(super) fn staying_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
    ) -> Option<MetresPerSecond> {
        let place = self.found?;
        let (front, back) = (self.front()?, self.back()?);
        let weaker = Dbm(front.rssi().0.min(back.rssi().0));
        let lasts = weaker >= config.launch.limit || self.renewals < MOST_RENEWALS;
        let is_good =
            lasts && ![front, back].into_iter().any(|n| config.policy.is_too_near(n.rssi()));
        if !is_good {
            (self.found, self.renewals) = (None, 0);
            return None;
        }
        Some(config.search.towards(place, round.way()))
    }

    /// Notes the places of this drone and its neighbours while it searches.
    pub(super) fn note_search(&mut self, round: &Round) {
        let ends = self.front().zip(self.back());
        if let Some((front, back)) = ends {
            let ways = [front.report.odometer, back.report.odometer];
            self.search.end(round.way(), ways);
        }
    }
}

/// Whether a neighbour has left its place to look for a better one.
pub(super) fn is_searching(neighbour: &Neighbour) -> bool {
    neighbour.report.phase == Phase::Searching
}

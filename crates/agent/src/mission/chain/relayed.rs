//! What a drone's report passes on along the chain: sums over links, the relays that wait, and the
//! head's velocity.

use chain::chain_wide::Side;
use chain::neighbours::Neighbour;
use chain::policy::SpeedLaw;
use units::{Dbm, Duration, LinkSpan, LinkSum, MetresPerSecond, Phase, Role};

use super::Chain;
use super::search::is_searching;
use crate::AgentConfig;
use crate::mission::{PassedOn, Round};

impl Chain {
    /// The sums over the links towards the head, and over those towards the base.
    pub(super) fn sums(&self, config: &AgentConfig, round: &Round) -> [LinkSum; 2] {
        let SpeedLaw::ChainWide(law) = &config.policy.law else { return [LinkSum::NONE; 2] };
        if self.is_retiring || self.found.is_some() && !self.is_searching {
            return [LinkSum::NONE; 2];
        }
        let sum = |neighbour: Option<&Neighbour>, beyond: usize| {
            // A search moves one drone: the others need not know how its links change.
            if self.is_searching || neighbour.is_some_and(is_searching) {
                return self.sums.get(beyond).copied().unwrap_or(LinkSum::NONE);
            }
            let side = neighbour.and_then(|n| side(n, beyond));
            side.map_or(LinkSum::NONE, |side| self.chain_wide.sum(law, &side))
        };
        // An explorer is an end of the chain, also where it hears another one.
        let front = self.front().filter(|_| round.role != Role::Head);
        [sum(front, AHEAD), sum(self.back(), BEHIND)]
    }

    /// What the drone's report passes on along the chain.
    pub(crate) fn passed_on(&mut self, config: &AgentConfig, round: &Round) -> PassedOn {
        PassedOn {
            links: self.span(),
            sums: self.sums(config, round),
            waiting: self.waiting(config, round),
            head_velocity: self.head_velocity,
            signpost: self.route.say(),
        }
    }

    /// How many relays wait on the ground or climb: the base and the last drone in the air hear them, all
    /// others are told by the drone behind.
    pub(super) fn waiting(&self, config: &AgentConfig, round: &Round) -> u8 {
        let heard = || self.neighbours.heard(round.now, config.retreat.lost_after);
        let is_coming = |n: &&Neighbour| matches!(n.report.phase, Phase::Waiting | Phase::Transit);
        let on_ground = heard().filter(is_coming).count();
        let told = heard().filter(|n| n.report.from > round.id).map(|n| n.report.waiting).max();
        u8::try_from(on_ground).unwrap_or(u8::MAX).max(told.unwrap_or(0)).min(3)
    }

    /// The strength that all links would have if they were equal, and the links' span, as the base
    /// reports them to a relay on the ground.
    pub(super) fn told_by_base(&self) -> Option<(Dbm, LinkSpan)> {
        let base = self.back().filter(|n| n.report.phase == Phase::Base)?;
        let ahead = base.report.sums[0];
        (ahead.links > 0).then_some(())?;
        let level = LinkSum::REFERENCE + ahead.level()?;
        Some((Dbm::after_loss(level), base.report.links?))
    }

    /// The span of the links from the head down to this drone; `None` where it hears no drone in
    /// front.
    fn span(&self) -> Option<LinkSpan> {
        let front = self.front()?;
        Some(LinkSpan::extended(front.report.links, front.rssi()))
    }

    /// The head's velocity, smoothed by the head itself and told to every other node by the drone in
    /// front of it.
    pub(super) fn head_velocity(&self, round: &Round) -> MetresPerSecond {
        match round.role {
            Role::Head => smoothed(self.head_velocity, self.velocity, self.dt),
            Role::Relay | Role::Base => {
                let front = self.front();
                front.map_or(MetresPerSecond::ZERO, |front| front.report.head_velocity)
            }
        }
    }
}

/// The places of both directions in a report's sums.
pub(super) const AHEAD: usize = 0;
pub(super) const BEHIND: usize = 1;

/// A neighbour as one side of this drone, for a smoothing that estimates slopes.
pub(super) fn side(neighbour: &Neighbour, beyond: usize) -> Option<Side> {
    Some(Side { link: neighbour.state()?, beyond: *neighbour.report.sums.get(beyond)? })
}

/// The head's velocity, smoothed: its noise would move every relay.
fn smoothed(before: MetresPerSecond, measured: MetresPerSecond, dt: Duration) -> MetresPerSecond {
    let part = dt.as_secs_f32() / (dt.as_secs_f32() + 1.0);
    before + (measured - before) * part
}

//! What a drone's report passes on along the chain: sums over links, the relays that wait, and the
//! head's velocity.

use chain::chain_wide::Side;
use chain::launch::ChainNews;
use chain::neighbours::Neighbour;
use chain::policy::SpeedLaw;
use chain::retirement::AtLaunch;
use units::{Db, Dbm, Duration, LinkSpan, LinkSum, Metres, MetresPerSecond, Phase, Role};

use super::Chain;
use super::search::is_searching;
use crate::AgentConfig;
use crate::mission::{PassedOn, Round};

/// What one drone lacks at an edge makes the level of the chain no weaker than this below the limit; what
/// several lack adds up. Chosen of 0 and 10 dB by drawn places (seeds from 500,000): with 0 dB fewer heads
/// pass an edge, and without a bound the level was up to 100 dB below all links.
const MOST_LACK: Db = Db(10.0);

impl Chain {
    /// The sums over the links towards the head, and over those towards the base.
    pub(super) fn sums(&self, config: &AgentConfig, round: &Round) -> [LinkSum; 2] {
        let SpeedLaw::ChainWide(law) = &config.policy.law else { return [LinkSum::NONE; 2] };
        if self.is_retiring || self.found.is_some() && !self.is_searching {
            return [LinkSum::NONE; 2];
        }
        // A search moves one drone: the others need not know how its links change.
        let is_held = |neighbour: Option<&Neighbour>| {
            self.is_searching || neighbour.is_some_and(is_searching)
        };
        let sum = |neighbour: Option<&Neighbour>, beyond: usize| {
            if is_held(neighbour) {
                return self.sums.get(beyond).copied().unwrap_or(LinkSum::NONE);
            }
            let side = neighbour.and_then(|n| side(n, beyond));
            side.map_or(LinkSum::NONE, |side| self.chain_wide.sum(law, &side))
        };
        let behind = sum(self.back(), BEHIND);
        let ahead = match round.role {
            // An explorer is an end of the chain, also where it hears another one.
            Role::Head => LinkSum { surplus: self.lacks(config, behind), ..LinkSum::NONE },
            Role::Relay => {
                let front = sum(self.front(), AHEAD);
                // Sums that are held during a search have it already.
                let is_known = is_held(self.front());
                let lacks = if is_known { Metres::ZERO } else { self.lacks(config, behind) };
                LinkSum { surplus: front.surplus + lacks, ..front }
            }
            Role::Base => sum(self.front(), AHEAD),
        };
        [ahead, behind]
    }

    /// The way by which the chain `behind` this head or relay is too short for it to pass an edge, as far
    /// as the links can be longer before their level is [`MOST_LACK`] below the limit. Where one of them
    /// falls steeply, the way that the drone needs would else stand for a level far below all links.
    fn lacks(&self, config: &AgentConfig, behind: LinkSum) -> Metres {
        let known = self.chain_wide.level().map(Dbm::after_loss);
        let known = known.zip(self.back().and_then(Neighbour::state)).zip(behind.level());
        let Some(((level, own), alone)) = known else { return Metres::ZERO };
        let spare = config.launch.limit.loss() - (LinkSum::REFERENCE + alone);
        let most = (spare.0.max(0.0) + MOST_LACK.0) * behind.compliance.0;
        Metres(self.edge.lacks(&config.launch, level, &own).0.min(most))
    }

    /// What the drone's report passes on along the chain.
    pub(crate) fn passed_on(&mut self, config: &AgentConfig, round: &Round) -> PassedOn {
        PassedOn {
            links: self.span(),
            sums: self.sums(config, round),
            waiting: self.waiting(config, round),
            head_velocity: self.head_velocity,
            calls: self.calls(round.role),
            is_uneven: self.is_uneven,
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

    /// What the base tells a relay on the ground of the chain.
    pub(super) fn told_by_base(&self) -> Option<ChainNews> {
        let base = self.back().filter(|n| n.report.phase == Phase::Base)?;
        let [ahead, _] = base.report.sums;
        (ahead.links > 0).then_some(())?;
        let level = LinkSum::REFERENCE + ahead.level()?;
        let last_relay = self.front().filter(|_| ahead.links > 1);
        Some(ChainNews {
            level: Dbm::after_loss(level),
            links: base.report.links?,
            calls: base.report.calls,
            last_relay: last_relay.map(|relay| relay.report.velocity),
        })
    }

    /// The chain that a relay on the ground joins, by what the base tells of it.
    pub(super) fn chain_at_launch(&self) -> Option<AtLaunch> {
        let base = self.back().filter(|n| n.report.phase == Phase::Base)?;
        let [ahead, _] = base.report.sums;
        let level = Dbm::after_loss(LinkSum::REFERENCE + ahead.level()?);
        Some(AtLaunch { level, compliance: ahead.compliance })
    }

    /// Whether the head calls for a relay, as far as this drone knows.
    pub(super) fn calls(&self, role: Role) -> bool {
        match role {
            Role::Head => self.governor.calls(),
            Role::Relay | Role::Base => self.front().is_some_and(|front| front.report.calls),
        }
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

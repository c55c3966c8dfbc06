//! How fast a drone of a chain flies along the tunnel.

use chain::chain_wide::HeadNews;
use chain::governor::{Governor, HeadLinks};
use chain::launch::LaunchConfig;
use chain::neighbours::Neighbour;
use chain::policy::SpeedLaw;
use chain::retirement::RetirementWatch;
use units::{Course, Dbm, Duration, Metres, MetresPerSecond, Order, Role};

use super::relayed::{AHEAD, BEHIND, side};
use super::search::is_searching;
use super::turn::CLEAR;
use super::{Chain, ChainDuty};
use crate::mission::{Round, Task};
use crate::{AgentConfig, LinkView};

/// A drone that is nearer than this to where it took off is above the row, m: [`CLEAR`], and what odometers
/// are off by. Links do not hold a head there, since the relay that is called next does not take off below it.
pub(super) const PAST_ROW: Metres = Metres(CLEAR.0 + 0.2);

impl Chain {
    /// How fast the drone is to fly along the tunnel at a duty of the chain.
    pub(crate) fn speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> MetresPerSecond {
        self.note_duty(round, duty);
        if round.role == Role::Relay {
            self.edge.rest();
        }
        let [front, back] = self.views();
        let speed = match duty {
            ChainDuty::Leading { .. } => self.leading_speed(config, round, back),
            ChainDuty::Relaying { .. } => self.relaying_speed(config, round, front, back),
            ChainDuty::Reconnecting { since, from } => {
                let waited = round.now.since(since);
                reconnecting_speed(config, waited, round.way() - from, back)
            }
            ChainDuty::Searching { search } => search.velocity(&config.search, round.way()),
            ChainDuty::Rejoining { .. } => homeward(config, back),
            ChainDuty::Retiring => self.homeward_speed(config, round, back) * RETIRING,
            ChainDuty::Homing => self.homing_speed(config, round, front, back),
            // The search for a spot has its own command.
            ChainDuty::Siting { .. } => MetresPerSecond::ZERO,
            ChainDuty::BackingUp { .. } => -config.retreat.speed,
        };
        if round.role == Role::Head {
            self.note_call(config, round, duty, speed);
        }
        self.kept_clear(round, duty, self.kept_short(config, round, duty, speed))
    }

    /// `speed`, but not so that a link becomes longer than the longest by the odometers of both its
    /// ends. A strength alone does not tell how far the other drone is: a radio between the two that
    /// repeats their packets is heard as well.
    fn kept_short(
        &self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
        speed: MetresPerSecond,
    ) -> MetresPerSecond {
        let way = |n: &Neighbour| (round.way() - n.report.odometer) * speed.0.signum();
        let relays = matches!(duty, ChainDuty::Relaying { .. });
        let left = if speed.0 > 0.0 { self.back() } else { self.front().filter(|_| relays) };
        let is_long = left.is_some_and(|n| way(n) > config.retreat.longest);
        if is_long { MetresPerSecond::ZERO } else { speed }
    }

    /// `speed`, but not into a drone that has fallen silent, and not back over the drones that stand
    /// behind the place at which this one took off.
    fn kept_clear(
        &self,
        round: &Round,
        duty: ChainDuty,
        speed: MetresPerSecond,
    ) -> MetresPerSecond {
        let [ahead, behind] = self.neighbours.may_collide(round.id, round.now, self.ends);
        let goes_home = matches!(duty, ChainDuty::Homing | ChainDuty::Retiring);
        let is_at_home = !goes_home && self.home_rssi.is_some() && round.way() <= Metres::ZERO;
        match speed {
            MetresPerSecond(v) if v > 0.0 && ahead => MetresPerSecond::ZERO,
            MetresPerSecond(v) if v < 0.0 && (behind || is_at_home) => MetresPerSecond::ZERO,
            speed => speed,
        }
    }

    /// Notes the duty of this round.
    fn note_duty(&mut self, round: &Round, duty: ChainDuty) {
        self.is_searching = matches!(duty, ChainDuty::Searching { .. });
        if self.is_retiring && duty != ChainDuty::Retiring {
            // It is needed after all: the head has to come back as far again.
            self.retirement = RetirementWatch::after_failure();
        }
        self.is_retiring = duty == ChainDuty::Retiring;
        let relays = matches!(duty, ChainDuty::Relaying { .. }) && round.explores();
        self.found = self.found.filter(|_| relays);
        if let ChainDuty::Searching { search } = duty {
            self.note_search(round);
            self.found = search.found();
        }
    }

    /// The speed that the pilot asks for. A head whose link is only reckoned does not fly on: what it
    /// would come to, a corner or a leaking wall, is in no reckoning.
    fn asked_speed(&self, config: &AgentConfig, round: &Round) -> MetresPerSecond {
        let asked = pilots_speed(config, round);
        let is_blind = self.back().is_some_and(Neighbour::is_reckoned);
        MetresPerSecond(if is_blind { asked.0.min(0.0) } else { asked.0 })
    }

    /// The pilot's stick while it is alive and the link can spare it.
    fn leading_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let asked = self.asked_speed(config, round);
        if asked.0 < 0.0 {
            return behind_clear(config, back, asked);
        }
        if asked == MetresPerSecond::ZERO {
            let may_ease = round.explores() && self.waiting(config, round) == 0;
            let links = self.head_links().filter(|_| may_ease);
            let sound = self.edge.behind(round.way());
            let eased = links.map_or(asked, |links| Governor::eased(&config.launch, &links, sound));
            return behind_clear(config, back, eased);
        }
        let freedom = config.retreat.freedom(back.map(|link| link.rssi));
        let asked = asked * freedom;
        if round.way() < PAST_ROW && self.waiting(config, round) > 0 {
            return asked;
        }
        // A head that has passed an edge is held there, but not where its links do not bear it.
        let [held, borne] =
            [self.edge.speed(round.way(), asked), self.speed_at_limit(&config.launch, asked)];
        MetresPerSecond(if borne < held { borne.0 } else { held.0 })
    }

    /// The forward `speed` as far as the level of the chain and the head's own link can spare it.
    /// While the relay behind the head searches the head stays.
    fn speed_at_limit(&self, config: &LaunchConfig, speed: MetresPerSecond) -> MetresPerSecond {
        let Some(links) = self.head_links() else { return speed };
        if self.back().is_some_and(is_searching) {
            return MetresPerSecond::ZERO;
        }
        Governor::speed(config, speed, &links)
    }

    /// The links that bear this head; `None` without a chain-wide policy.
    fn head_links(&self) -> Option<HeadLinks> {
        let level = Dbm::after_loss(self.chain_wide.level()?);
        let [ahead, behind] = self.sums;
        let compliance = ahead.and(behind).compliance;
        Some(HeadLinks { level, compliance, own: self.back().and_then(Neighbour::state) })
    }

    /// Notes at the head what its links leave of the speed that the pilot asks for. A head that flies
    /// back to a junction is not held by its links.
    fn note_call(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
        left: MetresPerSecond,
    ) {
        let asked = match duty {
            ChainDuty::Rejoining { .. } => MetresPerSecond::ZERO,
            _ => self.asked_speed(config, round),
        };
        let nears_limit = self
            .head_links()
            .is_some_and(|links| Governor::nears_limit(&config.launch, self.velocity, &links));
        self.governor.note(self.dt, asked, left, nears_limit);
        if let Some(own) = self.back().and_then(Neighbour::state) {
            let flown = (round.way(), self.velocity);
            let (own, is_pushed) = (Dbm::after_loss(own.loss), asked > MetresPerSecond::ZERO);
            self.edge.note(&config.launch, self.dt, flown, own, is_pushed);
        }
    }

    /// The velocity by Algorithm 1.
    pub(super) fn relaying_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        match (front, back) {
            (Some(front), Some(back)) => self
                .staying_speed(config, round)
                .or_else(|| self.chain_wide_speed(config, round))
                .unwrap_or_else(|| config.policy.velocity(front.end(), back.end())),
            _ => MetresPerSecond::ZERO,
        }
    }

    /// The speed by the chain-wide policy; `None` where another one flies, and where a neighbour is
    /// too near.
    fn chain_wide_speed(&mut self, config: &AgentConfig, round: &Round) -> Option<MetresPerSecond> {
        let SpeedLaw::ChainWide(law) = &config.policy.law else { return None };
        let (front, back) = (self.front()?, self.back()?);
        if [front, back].into_iter().any(is_searching) {
            return Some(MetresPerSecond::ZERO);
        }
        if [front, back].into_iter().any(|n| config.policy.is_too_near(n.rssi())) {
            return None;
        }
        // A neighbour without sums is an end of the chain: the base, an explorer, or a relay of
        // another policy, between which and the base the chain is equal at least.
        let (ahead, behind) = (side(front, AHEAD)?, side(back, BEHIND)?);
        let head = HeadNews { velocity: self.head_velocity, calls: self.calls(round.role) };
        let speed = self.chain_wide.step(law, self.dt, [&ahead, &behind], head);
        let speed = speed.limited_to(config.policy.max_speed);
        let (flown, own) = ((round.way(), self.velocity), Dbm::after_loss(behind.link.loss));
        let is_sent = speed > MetresPerSecond::ZERO;
        self.edge.note(&config.launch, self.dt, flown, own, is_sent);
        Some(self.edge.relay_speed(round.way(), speed, config.retreat.speed))
    }
}

/// The speed along the tunnel that the pilot asks the head for, while the stick is alive.
fn pilots_speed(config: &AgentConfig, round: &Round) -> MetresPerSecond {
    match round.task {
        Some(Task { order: Order::Explore(Course { speed, .. }), given })
            if round.now.since(given) <= config.flight.pilot_timeout =>
        {
            speed.limited_to(config.policy.max_speed)
        }
        _ => MetresPerSecond::ZERO,
    }
}

/// The part of the speed home at which a relay flies that may be needed again: a corner can take 10 dB
/// from the link in front within the second that the filter needs to notice.
const RETIRING: f32 = 0.5;

/// Flying home, but not into the next drone that has not landed yet.
pub(super) fn homeward(config: &AgentConfig, back: Option<LinkView>) -> MetresPerSecond {
    behind_clear(config, back, -config.flight.return_speed)
}

/// `speed`, a backward one, unless a drone is too near behind.
fn behind_clear(
    config: &AgentConfig,
    back: Option<LinkView>,
    speed: MetresPerSecond,
) -> MetresPerSecond {
    match back {
        Some(back) if !back.is_base && is_too_near(config, back) => MetresPerSecond::ZERO,
        _ => speed,
    }
}

fn is_too_near(config: &AgentConfig, link: LinkView) -> bool {
    config.policy.is_too_near(link.rssi)
}

/// With the front neighbour lost, a relay advances while its own back link can spare it, and
/// waits where that, or the bound on its advance, ends. Half of all relays that only hover are
/// found after 20 s, of those that advance after 12 s (the book, "Lost neighbours").
fn reconnecting_speed(
    config: &AgentConfig,
    waited: Duration,
    advanced: Metres,
    back: Option<LinkView>,
) -> MetresPerSecond {
    let retreat = &config.retreat;
    let spare = !retreat.wanted(None, back.map(|link| link.rssi), true);
    if spare && waited <= retreat.max_time && advanced < retreat.max_distance {
        retreat.speed
    } else {
        MetresPerSecond::ZERO
    }
}

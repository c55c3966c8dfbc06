//! How fast a drone of a chain flies along the tunnel.

use chain::launch::LaunchConfig;
use chain::neighbours::Neighbour;
use chain::policy::SpeedLaw;
use chain::retirement::RetirementWatch;
use units::{Course, Dbm, Duration, Metres, MetresPerSecond, Order};

use super::relayed::{AHEAD, BEHIND, side};
use super::search::is_searching;
use super::{Chain, ChainDuty};
use crate::mission::{Round, Task};
use crate::{AgentConfig, LinkView};

impl Chain {
    /// How fast the drone is to fly along the tunnel at a duty of the chain.
    pub(crate) fn speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> MetresPerSecond {
        self.note_duty(round, duty);
        let [front, back] = self.views();
        match duty {
            ChainDuty::Leading { .. } => self.leading_speed(config, round, back),
            ChainDuty::Relaying { .. } => self.relaying_speed(config, round, front, back),
            ChainDuty::Reconnecting { since, from } => {
                let waited = round.now.since(since);
                reconnecting_speed(config, waited, round.way() - from, back)
            }
            ChainDuty::Searching { search } => search.velocity(&config.search, round.way()),
            ChainDuty::Retiring | ChainDuty::Rejoining { .. } => homeward(config, back),
            // The search for a spot has its own command.
            ChainDuty::Siting { .. } => MetresPerSecond::ZERO,
            ChainDuty::BackingUp { .. } => -config.retreat.speed,
        }
    }

    /// Notes the duty of this round.
    fn note_duty(&mut self, round: &Round, duty: ChainDuty) {
        self.is_searching = matches!(duty, ChainDuty::Searching { .. });
        if self.is_retiring && duty != ChainDuty::Retiring {
            // It is needed after all: the head has to come back as far again.
            self.retirement = RetirementWatch::new();
        }
        self.is_retiring = duty == ChainDuty::Retiring;
        let relays = matches!(duty, ChainDuty::Relaying { .. }) && round.explores();
        self.found = self.found.filter(|_| relays);
        if let ChainDuty::Searching { search } = duty {
            self.note_search(round);
            self.found = search.found();
        }
    }

    /// The pilot's stick while it is alive and the link can spare it, or the way home.
    fn leading_speed(
        &self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let Some(Task { order, given }) = round.task else { return MetresPerSecond::ZERO };
        match order {
            Order::Explore(Course { speed, .. })
                if round.now.since(given) <= config.flight.pilot_timeout =>
            {
                let speed = speed.limited_to(config.policy.max_speed);
                if speed.0 >= 0.0 {
                    let freedom = config.retreat.freedom(back.map(|link| link.rssi));
                    self.speed_at_limit(&config.launch, speed * freedom, back)
                } else {
                    behind_clear(config, back, speed)
                }
            }
            Order::Return => homeward(config, back),
            Order::Explore(..) | Order::Wait | Order::Land | Order::Perch | Order::Stop => {
                MetresPerSecond::ZERO
            }
        }
    }

    /// The pilot's forward `speed` as far as the links can spare it. The head slows down as the
    /// links, were they equal, come near to the launch limit, and where its own link falls steeply
    /// flies no faster than what is spare lasts for [`LaunchConfig::foresight`]; at the limit it
    /// waits for the next relay, and from where the links are weaker it comes back at half the speed.
    /// While the relay behind it searches the head stays.
    fn speed_at_limit(
        &self,
        config: &LaunchConfig,
        speed: MetresPerSecond,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let Some(level) = self.chain_wide.level() else { return speed };
        if self.back().is_some_and(is_searching) {
            return MetresPerSecond::ZERO;
        }
        let level = Dbm::after_loss(level);
        let weakest = back.map_or(level, |link| Dbm(link.rssi.0.min(level.0)));
        let spare = weakest - config.limit;
        let fall = self.back().and_then(Neighbour::state).map_or(0.0, |link| {
            let [own, other] = link.slopes;
            own.0.max(other.0) * speed.0 * config.foresight.as_secs_f32()
        });
        speed * (spare.0 / config.slows_from.0.max(fall)).clamp(-0.5, 1.0)
    }

    /// The velocity by Algorithm 1; a relay that is called home and has no drone in front any more flies
    /// home.
    fn relaying_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let called_home = round.order() == Some(Order::Return);
        match (front, back) {
            (None, _) if called_home => homeward(config, back),
            // The base is not to be kept clear of by who goes home to it.
            (_, Some(back)) if called_home && back.is_base && is_too_near(config, back) => {
                homeward(config, Some(back))
            }
            (Some(front), Some(back)) => self
                .staying_speed(config, round)
                .or_else(|| self.chain_wide_speed(config))
                .unwrap_or_else(|| config.policy.velocity(front.end(), back.end())),
            _ => MetresPerSecond::ZERO,
        }
    }

    /// The speed by the chain-wide policy; `None` where another one flies, and where a neighbour is
    /// too near.
    fn chain_wide_speed(&mut self, config: &AgentConfig) -> Option<MetresPerSecond> {
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
        let speed = self.chain_wide.step(law, self.dt, [&ahead, &behind], self.head_velocity);
        Some(speed.limited_to(config.policy.max_speed))
    }
}

/// Flying home, but not into the next drone that has not landed yet.
fn homeward(config: &AgentConfig, back: Option<LinkView>) -> MetresPerSecond {
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

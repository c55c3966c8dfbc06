//! The turns of the relays: which of those on the ground flies next, and which of those in the air is
//! no longer needed.

use chain::launch::LaunchWatch;
use chain::neighbours::Neighbour;
use chain::retirement::{Need, with_one_link_less};
use units::{Duration, Instant, Metres, MetresPerSecond, Phase, Role};

use super::search::{STILL, is_searching};
use super::{Chain, ChainDuty};
use crate::AgentConfig;
use crate::mission::{Call, Round};

/// A drone of the chain that has flown no farther than this from where it took off may be above
/// another one of the row: what its odometer may be off by after some minutes. Our own number.
pub(super) const CLEAR: Metres = Metres(0.3);

impl Chain {
    /// Whether the chain calls for this drone, which is on the ground and was armed at `armed`, if it
    /// is.
    pub(crate) fn call(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        armed: Option<Instant>,
    ) -> Call {
        self.forget_route(round);
        // One that a fade hides for some seconds still takes off first.
        let lower_waits = self.neighbours.known(round.now).any(|n| {
            n.report.from < round.id && matches!(n.report.phase, Phase::Waiting | Phase::Transit)
        });
        let lower_linked = self
            .neighbours
            .heard(round.now, config.retreat.lost_after)
            .any(|n| n.report.from < round.id && n.report.phase.is_link());
        let is_ready = |since| round.now.since(since) >= config.launch.arm_delay;
        let launches = if armed.is_some_and(is_ready) {
            self.launches(config, round)
        } else {
            self.launch = LaunchWatch::new();
            false
        };
        let head = round.role == Role::Head;
        Call {
            arms: head || (!lower_waits && lower_linked),
            stays_armed: head || !lower_waits,
            takes_off: head
                || launches
                    && !self.has_chain_landed(config, round)
                    && self.is_clear_above(config, round),
        }
    }

    /// Whether every drone in front that this one hears is on the ground and out of the mission, or was when
    /// it was heard last where none is heard: that there is no link calls for no relay then. A head that
    /// flies on unheard comes back until it is heard.
    pub(crate) fn has_chain_landed(&self, config: &AgentConfig, round: &Round) -> bool {
        let has_landed = |within| {
            let heard = self.neighbours.heard(round.now, within);
            let mut ahead = heard.filter(|n| n.report.from < round.id).peekable();
            ahead.peek()?;
            Some(ahead.all(|n| n.report.phase == Phase::Out))
        };
        let now = has_landed(config.retreat.lost_after);
        now.or_else(|| has_landed(Duration::MAX)).unwrap_or(false)
    }

    /// Whether no drone of the chain may be above this one, which is on the ground.
    fn is_clear_above(&self, config: &AgentConfig, round: &Round) -> bool {
        let mut heard = self.neighbours.heard(round.now, config.retreat.lost_after);
        let is_near = |n: &Neighbour| {
            // In the air it would be heard stronger.
            config.policy.is_too_near(n.rssi() + config.perch.ground_loss)
        };
        heard.all(|n| n.report.phase != Phase::Linked || n.report.odometer >= CLEAR || !is_near(n))
    }

    /// Whether the links call for this relay, which is the next to fly.
    fn launches(&mut self, config: &AgentConfig, round: &Round) -> bool {
        if let Some(chain) = self.told_by_base() {
            return self.launch.step_level(round.now, &config.launch, &chain);
        }
        let front = self.front().map(|front| (front.rssi(), front.report.links));
        let (rssi, ahead) = front.unzip();
        self.launch.step(round.now, &config.launch, rssi, ahead.flatten())
    }

    /// Whether the chain no longer needs this drone at its `duty`: the relay next to the base that was
    /// launched in this mission.
    pub(super) fn retires(&mut self, config: &AgentConfig, round: &Round, duty: ChainDuty) -> bool {
        let is_last = self.back().is_some_and(|back| back.report.phase == Phase::Base);
        let is_free = matches!(duty, ChainDuty::Relaying { .. })
            && round.explores()
            && self.front().is_some_and(|front| !is_searching(front))
            && self.found.is_none();
        let [ahead, behind] = self.sums;
        let without = with_one_link_less(ahead.and(behind))
            .filter(|_| is_last && is_free && self.home_rssi.is_some());
        let is_still = |velocity: MetresPerSecond| velocity.0.abs() < STILL;
        let need = Need {
            without,
            limit: config.launch.limit,
            is_at_rest: is_still(self.head_velocity)
                && is_still(self.velocity)
                && !self.calls(round.role),
        };
        self.retirement.step(&config.retirement, round.now, &need)
    }
}

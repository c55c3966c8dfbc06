//! The launch policy, section IV-D: it decides when a waiting relay takes off.
//!
//! The paper gives two rules. Its text launches "when the other flying UAVs converged to an equal
//! links configuration" and that configuration is too weak; its experiments launch as soon as "the
//! last active link reaches the fixed limit". Both rules exist here: the second is the first
//! without a [`settled`](LaunchConfig::settled) spread and without a [`hold`](LaunchConfig::hold)
//! time. A launch at once may waste a relay because of a single weak packet; a launch after the
//! chain has settled leaves the links weaker than the limit for longer. The book has measurements
//! of both.

use units::{Db, Dbm, Duration, Instant, LinkSpan, MetresPerSecond};

/// The constants of the launch policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchConfig {
    /// The limit −s_min: when the last link is weaker, a relay takes off.
    pub limit: Dbm,
    /// The chain counts as equal while its strongest and weakest links differ by less; with `None`
    /// every chain does.
    pub settled: Option<Db>,
    /// The time for which the chain must have been equal and its last link too weak.
    pub hold: Duration,
    /// After the last link has been too weak for this long, a relay is launched even if the chain
    /// has not settled: behind a corner its links may stay unequal whatever the relays do, and the
    /// head and the waiting relay would wait for each other without end.
    pub patience: Duration,
    /// With a chain-wide policy, a head that flies on calls for a relay when its motion will have
    /// brought all links, if they were equal, to the limit within this time: early, since the
    /// relay flies hardly faster than the head and comes to its place only then. Where the gallery ends
    /// before, the relay may come home again ([`RetirementWatch`](crate::retirement::RetirementWatch)).
    pub lead: Duration,
    /// However fast it flies, the head calls for no relay while all links, if they were equal, would
    /// be farther from the limit than this.
    pub margin: Db,
    /// With a chain-wide policy, the head slows down when all links, if they were equal, would be
    /// this near to the limit.
    pub slows_from: Db,
    /// The head also slows down when its own link falls so steeply that it would reach the limit
    /// within this time, which is the delay of the filter and of the reports along the chain.
    pub foresight: Duration,
    /// The least time between the moment at which the drone before becomes a link and the launch:
    /// TUNNEL_ARM_DELAY of the authors' firmware, 3 s, in which the new link is still forming.
    pub arm_delay: Duration,
}

impl LaunchConfig {
    /// The rule of the paper's experiments: the last link alone decides, at once. The limit is
    /// RSSI_ARMED of the authors' firmware with its penalty of 10 dB for an antenna on the ground. Lead
    /// and margin were chosen of 5 s and 1 dB, 20 s and 4 dB, and 60 s and 12 dB by drawn places
    /// (seeds from 300,000), the foresight of 0, 1 and 2 s by the demonstration.
    pub const AT_ONCE: Self = Self {
        limit: Dbm(-60.0),
        settled: None,
        hold: Duration::ZERO,
        patience: Duration::ZERO,
        lead: Duration::from_secs(60),
        margin: Db(12.0),
        slows_from: Db(0.6),
        foresight: Duration::from_secs(1),
        arm_delay: Duration::from_secs(3),
    };

    /// The rule of the paper's text: the chain has been equal to within 4 dB, and too weak, for 2
    /// s. A relay waits no longer than 10 s, the time it needs for 4 m, for a chain that does not
    /// settle.
    pub const WHEN_SETTLED: Self = Self {
        settled: Some(Db(4.0)),
        hold: Duration::from_secs(2),
        patience: Duration::from_secs(10),
        ..Self::AT_ONCE
    };
}

/// For so long the level must have been too weak: two seconds of packets average its noise.
const LEVEL_HOLD_S: f32 = 2.0;
/// For so long a single link must have been too weak, s: a link that steps may stay weaker than the
/// level.
const WEAKEST_HOLD_S: f32 = 10.0;
/// For so long the head must have called while the last relay stood still, s: what that relay has
/// brought comes to the head over the relays between. The head itself calls only after a second, and
/// without a relay in the air that is enough.
const CALL_HOLD_S: f32 = 1.2;
/// For so long the head must have called while the last relay moved to and fro, s. While that relay
/// flies out to its place the call counts less, by the part of [`FLIES_OUT`] at which it flies, since
/// what it brings will be seen.
const CALL_PATIENCE_S: f32 = 20.0;
/// The speed of a relay that flies out to its place, m/s: nearly the largest of all policies.
const FLIES_OUT: f32 = 0.35;
/// A relay that is slower has come to its place, m/s: three times the noise of its optic flow over the
/// ground of a cave.
const AT_PLACE: f32 = 0.06;

/// Decides in each round, for the relay that waits beside the base, whether it should take off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaunchWatch {
    weak_since: Option<Instant>,
    settled_since: Option<Instant>,
    last_step: Option<Instant>,
    /// For how long the level, and the weakest link, were too weak, s: less the time for which they
    /// were not.
    level_s: f32,
    weakest_s: f32,
    /// For how long the head has called in all, and while the last relay stood still, s.
    called_s: f32,
    called_at_rest_s: f32,
}

/// What the base tells a relay on the ground of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainNews {
    /// The strength that all links would have if they were equal.
    pub level: Dbm,
    /// The span of the links as they are.
    pub links: LinkSpan,
    /// Whether the head calls for a relay.
    pub calls: bool,
    /// The velocity of the last drone of the chain, towards the head, if it is a relay.
    pub last_relay: Option<MetresPerSecond>,
}

impl LaunchWatch {
    /// The watch before the first round.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            weak_since: None,
            settled_since: None,
            last_step: None,
            level_s: 0.0,
            weakest_s: 0.0,
            called_s: 0.0,
            called_at_rest_s: 0.0,
        }
    }

    /// Whether a relay should take off now. `last_link` is the strength of the link between the
    /// base and the last flying drone, `None` while no flying drone is heard, which counts as the
    /// weakest link. `ahead` is the span of all the links beyond it.
    pub fn step(
        &mut self,
        now: Instant,
        config: &LaunchConfig,
        last_link: Option<Dbm>,
        ahead: Option<LinkSpan>,
    ) -> bool {
        let weak = last_link.is_none_or(|link| link < config.limit);
        let settled = weak
            && last_link.is_none_or(|link| {
                let chain = LinkSpan::extended(ahead, link);
                config.settled.is_none_or(|most| chain.strongest - chain.weakest < most)
            });
        let for_long = |since: &mut Option<Instant>, holds: bool, long| {
            if !holds {
                *since = None;
                return false;
            }
            now.since(*since.get_or_insert(now)) >= long
        };
        let waited = for_long(&mut self.weak_since, weak, config.patience);
        let held = for_long(&mut self.settled_since, settled, config.hold);
        waited || held
    }

    /// Whether a relay should take off now, by the rule of a chain-wide policy: because the head has
    /// called for it since the last relay came to its place, or the chain as it is is too weak.
    pub fn step_level(&mut self, now: Instant, config: &LaunchConfig, chain: &ChainNews) -> bool {
        let dt = self.last_step.map_or(0.0, |last| now.since(last).as_secs_f32()).min(1.0);
        self.last_step = Some(now);
        let ChainNews { level, links, calls, last_relay } = *chain;
        let level = level.0.max(links.weakest.0).min(links.strongest.0);
        let is_at_place = last_relay.is_none_or(|velocity| velocity.0.abs() < AT_PLACE);
        // A counter and not a moment: one weak packet the other way does not begin the wait anew.
        let for_long = |counted: &mut f32, holds: bool, pace: f32, long: f32| {
            *counted = (*counted + if holds { pace * dt } else { -dt }).max(0.0).min(long);
            *counted >= long
        };
        let is_level_weak = for_long(&mut self.level_s, level < config.limit.0, 1.0, LEVEL_HOLD_S);
        let outward = last_relay.map_or(0.0, |velocity| velocity.0 / FLIES_OUT);
        // Written so that NaN counts in full.
        let counted = if outward > 0.0 { 1.0 - outward.min(1.0) } else { 1.0 };
        let is_link_weak =
            for_long(&mut self.weakest_s, links.weakest < config.limit, counted, WEAKEST_HOLD_S);
        let is_called = for_long(&mut self.called_s, calls, counted, CALL_PATIENCE_S);
        let at_rest = for_long(&mut self.called_at_rest_s, calls && is_at_place, 1.0, CALL_HOLD_S);
        let is_first = calls && last_relay.is_none();
        is_level_weak || is_link_weak || is_called || is_first || at_rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEAK: Option<Dbm> = Some(Dbm(-61.0));
    const GOOD: Option<Dbm> = Some(Dbm(-59.0));

    fn span(weakest: f32, strongest: f32) -> Option<LinkSpan> {
        Some(LinkSpan { weakest: Dbm(weakest), strongest: Dbm(strongest) })
    }

    /// The second at which a watch that sees these links at 5 Hz launches, within 20 s.
    fn launches(config: &LaunchConfig, link: Option<Dbm>, ahead: Option<LinkSpan>) -> Option<u64> {
        let mut watch = LaunchWatch::new();
        let mut at = (0..100).map(|n| n * 200);
        at.find(|&ms| watch.step(Instant::from_millis(ms), config, link, ahead)).map(|ms| ms / 1000)
    }

    #[test]
    fn at_once_looks_at_the_last_link_alone() {
        assert_eq!(launches(&LaunchConfig::AT_ONCE, WEAK, span(-80.0, -40.0)), Some(0));
        assert_eq!(launches(&LaunchConfig::AT_ONCE, GOOD, span(-80.0, -40.0)), None);
    }

    #[test]
    fn a_settled_chain_is_held_for_two_seconds_an_unsettled_one_for_ten() {
        let config = &LaunchConfig::WHEN_SETTLED;
        assert_eq!(launches(config, WEAK, span(-62.0, -60.0)), Some(2));
        assert_eq!(launches(config, WEAK, span(-62.0, -50.0)), Some(10));
        assert_eq!(launches(config, GOOD, span(-62.0, -60.0)), None);
        // No drone in the air is heard.
        assert_eq!(launches(config, None, None), Some(2));
    }

    #[test]
    fn one_good_packet_begins_the_hold_anew() {
        let config = &LaunchConfig::WHEN_SETTLED;
        let mut watch = LaunchWatch::new();
        for ms in (0..60_000).step_by(200) {
            let link = if ms % 1_800 == 0 { GOOD } else { WEAK };
            assert!(!watch.step(Instant::from_millis(ms), config, link, None));
        }
    }
}

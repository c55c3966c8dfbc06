//! Decides when a relay that was launched is no longer needed.
//!
//! A relay is launched where the head is too far for the relays in the air. Once the head has come
//! back from there, the relay nearest to the base is no longer needed, and can save its battery on
//! the ground. The strength of the links without that relay is only an estimate by the log-distance
//! law, which ignores corners; the head's distance at the launch is a measurement. A relay retires
//! when both say so. It also retires from a chain at rest whose level at the launch, less what the
//! head's way since then costs, still bears the limit, since it was launched a little early; and from
//! one in which the estimate alone is far above the limit. On its way home the others close the gap
//! behind it, and it comes back where they cannot; after such a trial that failed, only the head's way
//! counts.

use units::{Db, Dbm, Duration, Instant, LinkSum, Metres, MetresPerDb};

use crate::chain_wide::FOLD_DB;

/// The constants of the watch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RetirementConfig {
    /// The head must have come back by this much from where it was at the launch.
    pub back_by: Metres,
    /// The links without the relay must be estimated this much stronger than those that call for a
    /// relay.
    pub spare: Db,
    /// Both conditions must have held for this long.
    pub hold: Duration,
    /// The chain must have been at rest for this long before the estimate alone counts.
    pub rest: Duration,
}

impl RetirementConfig {
    /// Two metres are a hundred times what the head's odometer drifts in a hold of a minute, and
    /// four decibels at 4 m: so a head that moves to and fro at the limit does not make relays take
    /// off and land in turn. Chosen by simulation.
    pub const DEFAULT: Self = Self {
        back_by: Metres(2.0),
        spare: Db(2.0),
        hold: Duration::from_secs(5),
        rest: Duration::from_secs(30),
    };
}

/// The strength that all links of a chain would have if they were equal and one fewer. Links of the
/// length d have the sum of lengths n·d; n − 1 of them are longer by a factor of n/(n − 1), which
/// costs FOLD_DB · ln(n/(n − 1)).
///
/// It is `None` for a chain of a single link.
#[must_use]
pub fn with_one_link_less(chain: LinkSum) -> Option<Dbm> {
    let links = f32::from(chain.links);
    if links < 2.0 {
        return None;
    }
    let level = Dbm::after_loss(LinkSum::REFERENCE + chain.level()?);
    Some(level - Db(FOLD_DB * libm::logf(links / (links - 1.0))))
}

/// A relay tries to go home where the estimate is up to this much below the limit, dB: it is too low by
/// as much where the links are unequal, and behind a corner, where another relay gains little. In a
/// long chain at the limit the trial ends at once.
const TRIED: Db = Db(1.0);

/// The same for the level at the launch, dB: the standard deviation of a level, twice.
const MEASURED: Db = Db(0.5);

/// A relay of a chain at rest is surplus, whatever the level at the launch was, where the estimate is so
/// far above the limit, dB: a corner that the law ignores costs a link about as much. Our own number.
const SURELY: Db = Db(3.5);

/// Decides in each round whether a relay is still needed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RetirementWatch {
    /// The way of the head since the launch, positive away from the base.
    head_way: Metres,
    unneeded_since: Option<Instant>,
    rest_since: Option<Instant>,
    /// The chain without this relay, as it was at the launch.
    at_launch: Option<AtLaunch>,
    /// Whether the relay has tried to go home and was needed after all.
    has_failed: bool,
}

/// A chain just before a relay joins it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtLaunch {
    /// The strength that all links would have if they were equal.
    pub level: Dbm,
    /// By how much the chain may grow longer for each decibel of the level.
    pub compliance: MetresPerDb,
}

impl AtLaunch {
    /// The level after the head has flown `way` farther.
    fn after(&self, way: Metres) -> Dbm {
        self.level - Db(way.0.max(0.0) / self.compliance.0)
    }
}

/// What the last relay knows of whether it is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// The strength that the links are estimated to have without the relay; `None` where that cannot
    /// be told, or another duty comes first.
    pub without: Option<Dbm>,
    /// The limit below which links call for a relay.
    pub limit: Dbm,
    /// Whether the head and the relay stand still, and the head does not call for a relay.
    pub is_at_rest: bool,
}

impl RetirementWatch {
    /// The watch for a relay that is launched now, into the chain `at_launch` if it knows that.
    #[must_use]
    pub const fn new(at_launch: Option<AtLaunch>) -> Self {
        Self {
            head_way: Metres::ZERO,
            unneeded_since: None,
            rest_since: None,
            at_launch,
            has_failed: false,
        }
    }

    /// The watch for a relay that was on its way home, and is needed after all.
    #[must_use]
    pub const fn after_failure() -> Self {
        Self { has_failed: true, ..Self::new(None) }
    }

    /// Notes that the head has flown `way` farther.
    pub fn follow_head(&mut self, way: Metres) {
        self.head_way += way;
    }

    /// Whether the relay should retire.
    pub fn step(&mut self, config: &RetirementConfig, now: Instant, need: &Need) -> bool {
        let for_long = |since: &mut Option<Instant>, holds: bool, long| {
            if !holds {
                *since = None;
                return false;
            }
            now.since(*since.get_or_insert(now)) >= long
        };
        let bears = |spare: Db| need.without.is_some_and(|without| without >= need.limit + spare);
        let has_come_back = self.head_way <= -config.back_by && bears(config.spare);
        let bore =
            self.at_launch.is_some_and(|chain| chain.after(self.head_way) >= need.limit - MEASURED);
        let is_surplus =
            !self.has_failed && need.is_at_rest && (bore && bears(-TRIED) || bears(SURELY));
        let is_over = for_long(&mut self.unneeded_since, has_come_back, config.hold);
        let is_rest_over = for_long(&mut self.rest_since, is_surplus, config.rest);
        is_over || is_rest_over
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of `links` equal links of this strength.
    fn chain(links: u8, strength: f32) -> LinkSum {
        let compliance = f32::from(links) / 3.0;
        let level = Dbm(strength).loss() - LinkSum::REFERENCE;
        LinkSum {
            surplus: Metres(level.0 * compliance),
            compliance: MetresPerDb(compliance),
            links,
        }
    }

    #[test]
    fn one_link_less_costs_what_the_longer_links_lose() {
        // Two links of 4 m become one of 8 m: 25 dB for a factor of ten are 7.5 dB for two.
        let without = with_one_link_less(chain(2, -55.0)).unwrap();
        assert!((without.0 - -62.53).abs() < 0.02, "{without:?}");
        let without = with_one_link_less(chain(10, -55.0)).unwrap();
        assert!((without.0 - -56.14).abs() < 0.02, "{without:?}");
        assert_eq!(with_one_link_less(chain(1, -55.0)), None);
        assert_eq!(with_one_link_less(LinkSum::NONE), None);
    }

    #[test]
    fn a_relay_retires_once_the_head_has_come_back_and_the_links_bear_it() {
        let config = RetirementConfig::DEFAULT;
        // The head flies 3 m on in 10 s, then back at the same speed.
        let first = |without: f32| {
            let mut watch = RetirementWatch::new(None);
            (0..300u64).find(|round| {
                let way = if *round < 50 { 0.06 } else { -0.06 };
                let now = Instant::from_millis(200 * round);
                watch.follow_head(Metres(way));
                let need =
                    Need { without: Some(Dbm(without)), limit: Dbm(-60.0), is_at_rest: false };
                watch.step(&config, now, &need)
            })
        };
        // It is back at the launch's place after 100 rounds, 2 m behind it after 134, and 5 s pass.
        assert_eq!(first(-57.0), Some(158));
        assert_eq!(first(-59.0), None, "the links would be too weak");
    }

    #[test]
    fn a_surplus_relay_of_a_chain_at_rest_retires_and_does_not_try_twice() {
        let config = RetirementConfig::DEFAULT;
        let first = |mut watch: RetirementWatch, without: f32, rests: bool| {
            let need = Need { without: Some(Dbm(without)), limit: Dbm(-60.0), is_at_rest: rests };
            (0..300u64).find(|round| watch.step(&config, Instant::from_millis(200 * round), &need))
        };
        let early = |level| {
            let compliance = MetresPerDb(1.0);
            RetirementWatch::new(Some(AtLaunch { level: Dbm(level), compliance }))
        };
        assert_eq!(first(early(-59.0), -59.0, true), Some(150));
        assert_eq!(first(early(-59.0), -62.0, true), None, "it is needed by the law");
        assert_eq!(first(early(-61.0), -59.0, true), None, "it was needed at the launch");
        assert_eq!(first(early(-59.0), -59.0, false), None, "the chain moves");
        let mut far = early(-59.0);
        far.follow_head(Metres(2.0));
        assert_eq!(first(far, -59.0, true), None, "it is needed where the head is now");
        assert_eq!(first(RetirementWatch::new(None), -59.0, true), None, "nothing is known");
        assert_eq!(first(RetirementWatch::new(None), -56.0, true), Some(150), "by far too strong");
        assert_eq!(first(RetirementWatch::after_failure(), -59.0, true), None);
    }
}

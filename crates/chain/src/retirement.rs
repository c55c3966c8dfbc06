//! Decides when a relay that was launched is no longer needed.
//!
//! A relay is launched where the head is too far for the relays in the air. Once the head has come
//! back from there, the relay nearest to the base is no longer needed, and can save its battery on
//! the ground. The strength of the links without that relay is only an estimate by the log-distance
//! law, which ignores corners; the head's distance at the launch is a measurement. A relay retires
//! only when both say so.

use units::{Db, Dbm, Duration, Instant, LinkSum, Metres};

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
}

impl RetirementConfig {
    /// Two metres are a hundred times what the head's odometer drifts in a hold of a minute, and
    /// four decibels at 4 m: so a head that moves to and fro at the limit does not make relays take
    /// off and land in turn. Chosen by simulation.
    pub const DEFAULT: Self =
        Self { back_by: Metres(2.0), spare: Db(2.0), hold: Duration::from_secs(5) };
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

/// Decides in each round whether a relay is still needed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RetirementWatch {
    /// The way of the head since the launch, positive away from the base.
    head_way: Metres,
    unneeded_since: Option<Instant>,
}

impl RetirementWatch {
    /// The watch for a relay that is launched now.
    #[must_use]
    pub const fn new() -> Self {
        Self { head_way: Metres::ZERO, unneeded_since: None }
    }

    /// Notes that the head has flown `way` farther.
    pub fn follow_head(&mut self, way: Metres) {
        self.head_way += way;
    }

    /// Whether the relay should retire. `without` is the strength that the links would have without
    /// the relay, and `wanted` the one below which links call for a relay.
    pub fn step(
        &mut self,
        config: &RetirementConfig,
        now: Instant,
        without: Option<Dbm>,
        wanted: Dbm,
    ) -> bool {
        let is_unneeded = self.head_way <= -config.back_by
            && without.is_some_and(|without| without >= wanted + config.spare);
        if !is_unneeded {
            self.unneeded_since = None;
            return false;
        }
        now.since(*self.unneeded_since.get_or_insert(now)) >= config.hold
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::MetresPerDb;

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
            let mut watch = RetirementWatch::new();
            (0..300u64).find(|round| {
                let way = if *round < 50 { 0.06 } else { -0.06 };
                let now = Instant::from_millis(200 * round);
                watch.follow_head(Metres(way));
                watch.step(&config, now, Some(Dbm(without)), Dbm(-60.0))
            })
        };
        // It is back at the launch's place after 100 rounds, 2 m behind it after 134, and 5 s pass.
        assert_eq!(first(-57.0), Some(158));
        assert_eq!(first(-59.0), None, "the links would be too weak");
    }
}

//! The search of a relay for a better place where making links equal does not help.
//!
//! Equal links are the best ones only where the signal falls steadily along the tunnel. Where a
//! link is stronger at a larger distance, as through a wall or across a chamber, the links of a
//! relay can be equal at two places, and a rule that only compares the two links stays at the first
//! of them. When the links of a chain are too weak, the chain stands still, no further relay can
//! join, and the relay has reason to expect a better place ([`Prospect`]), the relays search: one
//! flies towards the head and then towards the base, remembers
//! where the weaker of its two links is strongest, and flies there if the gain is large enough. Its
//! two neighbours hold their places meanwhile, so two neighbours never search at once. The search
//! is bounded in distance, in time and in the weakness of the links, and a relay that found no
//! better place returns to where it began.

use units::{Db, Dbm, Duration, Instant, Metres, MetresPerSecond};

/// The constants of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchConfig {
    /// The speed of the search.
    pub speed: MetresPerSecond,
    /// The time for which the chain must have stood still with links that are too weak.
    pub calm: Duration,
    /// The time between the turns of two neighbours to begin a search, long enough for the chain to
    /// come to rest after the search of the other.
    pub turn: Duration,
    /// The longest distance from where the search began, in either direction.
    pub most_way: Metres,
    /// The longest time that one leg of the search may take.
    pub most_time: Duration,
    /// The largest loss that the weaker link may gain, compared with where the search began.
    pub most_loss: Db,
    /// The weaker link is never made weaker than this.
    pub weakest: Dbm,
    /// A relay flies to the best place that it found only if that place is better than where the
    /// search began by this much.
    pub gain: Db,
    /// A place that is better by this much is taken as soon as the drone is past it.
    pub sure: Db,
    /// A link that became stronger by this much as it was lengthened shows that the signal does not
    /// fall evenly, so that another place may be better.
    pub hump: Db,
    /// Links are near to the launch limit, as a head leaves them that keeps to it, up to this much
    /// over it.
    pub near: Db,
    /// Links are clearly too weak that are weaker than the launch limit by this much.
    pub clearly: Db,
    /// A relay that has searched does so again when it or one of its neighbours has moved this far.
    pub again_after: Metres,
}

impl SearchConfig {
    /// The speed at which the filter of both slopes follows a corner of 30 dB/m to 2 dB. A wall of
    /// one metre of rock, across which a link may recover, costs 18 dB at 7 m by equation (19). The
    /// Crazyradio and the nRF51 receive packets at 2 Mbit/s down to about −90 dBm.
    /// The turn was chosen by simulation of the demonstration, of 1, 3, 6 and 10 s. Shadows of 3.5 dB
    /// differ between two places by a standard deviation of 5 dB, half of the hump.
    pub const DEFAULT: Self = Self {
        speed: MetresPerSecond(0.4),
        calm: Duration::from_secs(2),
        turn: Duration::from_secs(6),
        most_way: Metres(10.0),
        most_time: Duration::from_secs(60),
        most_loss: Db(20.0),
        weakest: Dbm(-90.0),
        gain: Db(3.0),
        sure: Db(6.0),
        hump: Db(10.0),
        near: Db(1.5),
        clearly: Db(1.5),
        again_after: Metres(1.0),
    };
}

impl SearchConfig {
    /// The velocity that brings a drone at `way` to `place`; over the last half second it slows
    /// down.
    #[must_use]
    pub fn towards(&self, place: Metres, way: Metres) -> MetresPerSecond {
        MetresPerSecond((place - way).0 / 0.5).limited_to(self.speed)
    }
}

/// The measurements of a relay that searches: the strength of its weaker link, and whether its
/// neighbours are near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The strength of the weaker link; `None` while one of the neighbours is lost.
    pub weaker: Option<Dbm>,
    /// Whether the drone in front is too near to fly on towards it.
    pub is_front_near: bool,
    /// Whether the drone behind is too near to fly back towards it.
    pub is_back_near: bool,
}

/// A place on the relay's way, with the strength of the weaker link there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Place {
    /// The way since take-off.
    pub way: Metres,
    /// The strength of the weaker link.
    pub weaker: Dbm,
}

/// The legs of a search, in their order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Leg {
    /// The relay flies towards the head.
    Ahead,
    /// The relay flies back towards the base.
    Behind,
    /// The relay flies to the best place.
    ToBest,
    /// The relay flies to where the search began.
    Back,
}

/// A search that is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Search {
    /// The place where the search began.
    pub from: Place,
    /// The best place so far.
    pub best: Place,
    /// The leg that the relay is flying.
    pub leg: Leg,
    /// The moment at which this leg began.
    pub since: Instant,
}

impl Search {
    /// The drone is at a place that is nearer than this, m: a round of flight.
    const NEAR: f32 = 0.06;
    /// A place is past once the weaker link has lost this much again, dB.
    const PAST: f32 = 3.0;

    /// A search that begins now at `from`.
    #[must_use]
    pub const fn begin(now: Instant, from: Place) -> Self {
        Self { from, best: from, leg: Leg::Ahead, since: now }
    }

    /// Returns the search after another round, at `way` since take-off; `None` once the search is
    /// over.
    #[must_use]
    pub fn step(
        mut self,
        config: &SearchConfig,
        now: Instant,
        way: Metres,
        view: &View,
    ) -> Option<Self> {
        if let (Leg::Ahead | Leg::Behind, Some(weaker)) = (self.leg, view.weaker)
            && weaker > self.best.weaker
        {
            self.best = Place { way, weaker };
        }
        let is_worth_it = self.best.weaker - self.from.weaker >= config.gain;
        let next = match self.leg {
            Leg::Ahead if self.is_leg_over(config, now, way, view) => {
                if self.is_sure(config) {
                    Leg::ToBest
                } else {
                    Leg::Behind
                }
            }
            Leg::Behind if self.is_leg_over(config, now, way, view) => {
                if is_worth_it {
                    Leg::ToBest
                } else {
                    Leg::Back
                }
            }
            Leg::ToBest if self.has_come_to(config, now, way, self.best.way) => {
                let is_better = view.weaker.is_some_and(|weaker| weaker > self.from.weaker);
                if is_better {
                    return None;
                }
                Leg::Back
            }
            Leg::Back if self.has_come_to(config, now, way, self.from.way) => return None,
            leg @ (Leg::Ahead | Leg::Behind | Leg::ToBest | Leg::Back) => leg,
        };
        if next != self.leg {
            (self.leg, self.since) = (next, now);
        }
        Some(self)
    }

    /// The better place to which the relay flies, if it has found one.
    #[must_use]
    pub fn found(&self) -> Option<Metres> {
        (self.leg == Leg::ToBest).then_some(self.best.way)
    }

    /// Returns the search with a relay that flies back to where it began.
    #[must_use]
    pub fn given_up(mut self, now: Instant) -> Self {
        if self.leg != Leg::Back {
            (self.leg, self.since) = (Leg::Back, now);
        }
        self
    }

    /// The velocity along the tunnel at `way` since take-off.
    #[must_use]
    pub fn velocity(&self, config: &SearchConfig, way: Metres) -> MetresPerSecond {
        match self.leg {
            Leg::Ahead => config.speed,
            Leg::Behind => -config.speed,
            Leg::ToBest => config.towards(self.best.way, way),
            Leg::Back => config.towards(self.from.way, way),
        }
    }

    /// Whether the best place so far is good enough to go there at once.
    fn is_sure(&self, config: &SearchConfig) -> bool {
        self.best.weaker - self.from.weaker >= config.sure
    }

    /// Whether a leg away from the beginning has come to its end.
    fn is_leg_over(&self, config: &SearchConfig, now: Instant, way: Metres, view: &View) -> bool {
        let away = (way - self.from.way).0;
        let (out, is_blocked) = match self.leg {
            Leg::Behind => (-away, view.is_back_near),
            Leg::Ahead | Leg::ToBest | Leg::Back => (away, view.is_front_near),
        };
        if now.since(self.since) >= config.most_time {
            return true;
        }
        // On its way back past the beginning the relay has been everywhere already.
        if out <= 0.0 {
            return is_blocked && out < -Self::NEAR;
        }
        let least = Dbm((self.from.weaker - config.most_loss).0.max(config.weakest.0));
        is_blocked
            || out >= config.most_way.0
            || view.weaker.is_none_or(|weaker| {
                let is_past = (self.best.weaker - weaker).0 >= Self::PAST;
                weaker < least || self.is_sure(config) && is_past
            })
    }

    fn has_come_to(&self, config: &SearchConfig, now: Instant, way: Metres, place: Metres) -> bool {
        (place - way).0.abs() <= Self::NEAR || now.since(self.since) >= config.most_time
    }
}

/// The situation by which a relay decides whether to begin a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// The place of the relay.
    pub place: Place,
    /// The ways of the drones in front and behind since their take-offs.
    pub neighbours: [Metres; 2],
    /// Whether the relay, its neighbours and the head stand still, and no neighbour searches.
    pub is_calm: bool,
    /// Whether another relay waits to be launched.
    pub is_help_near: bool,
    /// The launch limit.
    pub limit: Dbm,
    /// The weaker one of the relay's links, or the level of the chain where that is weaker.
    pub weakest: Dbm,
    /// The relay's reason to expect a better place.
    pub prospect: Prospect,
}

/// A relay's reason to expect that its links are stronger at another place than at the one at which
/// they are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prospect {
    /// A link of the relay, or of a drone ahead, became stronger as it was lengthened.
    Hump,
    /// The relay has not flown here in this mission, and knows nothing of the way.
    Unknown,
    /// All links of the relay, on its way from the base to here, fell evenly: at another place the
    /// weaker one is weaker still.
    None,
}

impl Scene {
    /// Whether the links are so weak that the relay has reason to search: a head that keeps to the
    /// limit leaves them there, and where nothing promises a better place that is where they stay.
    fn is_weak(&self, config: &SearchConfig) -> bool {
        match self.prospect {
            Prospect::Hump => self.weakest < self.limit + config.near,
            Prospect::Unknown => self.weakest < self.limit - config.clearly,
            Prospect::None => false,
        }
    }
}

/// Decides in each round whether a relay should search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchWatch {
    weak_since: Option<Instant>,
    /// The ways of the relay and of its neighbours when it last ended a search.
    searched: Option<[Metres; 3]>,
}

impl SearchWatch {
    /// The watch for a relay that has not searched.
    #[must_use]
    pub const fn new() -> Self {
        Self { weak_since: None, searched: None }
    }

    /// Whether the relay should search now: `turn` after the moment at which the chain has been calm
    /// for long enough, so that neighbours do not begin at once.
    pub fn step(
        &mut self,
        config: &SearchConfig,
        now: Instant,
        turn: Duration,
        scene: &Scene,
    ) -> bool {
        let [front, back] = scene.neighbours;
        let ways = [scene.place.way, front, back];
        let moved = |before: [Metres; 3]| {
            before
                .iter()
                .zip(&ways)
                .any(|(then, now)| (*now - *then).0.abs() > config.again_after.0)
        };
        let is_new = self.searched.is_none_or(moved);
        if !(scene.is_weak(config) && is_new && scene.is_calm && !scene.is_help_near) {
            self.weak_since = None;
            return false;
        }
        now.since(*self.weak_since.get_or_insert(now)) >= config.calm + turn
    }

    /// Records that there is nothing to search for.
    pub const fn rest(&mut self) {
        self.weak_since = None;
    }

    /// Records that a search has ended.
    pub const fn end(&mut self, way: Metres, [front, back]: [Metres; 2]) {
        self.weak_since = None;
        self.searched = Some([way, front, back]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: SearchConfig = SearchConfig::DEFAULT;

    /// A relay that searches where the weaker link has this strength by its way: the ways at which
    /// it was, and the last of its searches' places.
    fn fly(strength: impl Fn(f32) -> f32) -> (Vec<f32>, f32) {
        let mut way = 0.0;
        let mut ways = Vec::new();
        let place = |way: f32| Place { way: Metres(way), weaker: Dbm(strength(way)) };
        let mut search = Some(Search::begin(Instant::ZERO, place(way)));
        for round in 0..2_000 {
            let Some(now) = search else { break };
            way += now.velocity(&CONFIG, Metres(way)).0 * 0.2;
            ways.push(way);
            let weaker = Some(Dbm(strength(way)));
            let view = View { weaker, is_front_near: way > 8.0, is_back_near: way < -8.0 };
            search = now.step(&CONFIG, Instant::from_millis(200 * round), Metres(way), &view);
        }
        assert_eq!(search, None, "a search ends");
        (ways, way)
    }

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn a_better_place_beyond_a_worse_one_is_found_and_taken() {
        // A hill of 15 dB, and beyond it a place that is 12 dB better.
        let found = |way: f32| match way {
            way if (0.3..1.5).contains(&way) => -85.0,
            way if (2.0..3.0).contains(&way) => -58.0,
            _ => -70.0,
        };
        let (ways, end) = fly(found);
        assert!((2.0..3.0).contains(&end), "{end}");
        // It is sure of it: no need to look behind.
        assert!(ways.iter().all(|way| *way > -0.1));
        // The same behind it.
        let (_, end) = fly(|way| found(-way));
        assert!((-3.0..-2.0).contains(&end), "{end}");
    }

    #[test]
    fn where_nothing_is_better_the_search_ends_where_it_began() {
        let (ways, end) = fly(|way| -70.0 - 10.0 * way.abs());
        assert!(end.abs() < 0.1, "{end}");
        // Not farther than the links bear.
        assert!(ways.iter().all(|way| way.abs() < 2.2));
        let (_, end) = fly(|way| -70.0 + 0.2 * way);
        assert!(end.abs() < 0.1, "two decibels are not worth it: {end}");
    }

    #[test]
    fn a_weak_chain_at_rest_searches_once() {
        let scene = Scene {
            place: Place { way: Metres(3.0), weaker: Dbm(-75.0) },
            neighbours: [Metres(6.0), Metres::ZERO],
            is_calm: true,
            is_help_near: false,
            limit: Dbm(-70.0),
            weakest: Dbm(-72.0),
            prospect: Prospect::Unknown,
        };
        let mut watch = SearchWatch::new();
        let begins = |from: u64, scene: &Scene, watch: &mut SearchWatch| {
            (from..from + 20_000)
                .step_by(200)
                .find(|ms| watch.step(&CONFIG, Instant::from_millis(*ms), Duration::ZERO, scene))
        };
        assert_eq!(begins(0, &scene, &mut watch), Some(2_000));
        for not in [
            Scene { is_calm: false, ..scene },
            Scene { is_help_near: true, ..scene },
            Scene { weakest: Dbm(-71.0), ..scene },
            Scene { prospect: Prospect::None, ..scene },
        ] {
            assert_eq!(begins(20_000, &not, &mut SearchWatch::new()), None);
        }
        watch.end(Metres(3.2), scene.neighbours);
        assert_eq!(begins(40_000, &scene, &mut watch), None, "nothing has changed");
        let moved = Scene { neighbours: [Metres(7.5), Metres::ZERO], ..scene };
        assert_eq!(begins(60_000, &moved, &mut watch), Some(62_000));
    }
}

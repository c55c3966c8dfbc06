//! The way home of a drone of a chain, and the spot at which it lands there.
//!
//! A drone that is called home flies on homeward whatever it hears: it knows its odometer, its trail and
//! its walls, and a drone that comes down in the cave is left there. Only home or its battery ends
//! the way.
//!
//! Drones come home in the order in which they stood, the last relay first, and each odometer is off
//! by some decimetres, as much as the row is spaced. No beam sees a drone on the ground, which is
//! 3 cm high, but its radio is heard: a drone lands before it comes nearer to one that is down than
//! the row was spaced. How strong a signal is at that distance, each drone has measured at its take-off.

use chain::neighbours::{Heard, MAX_NEIGHBOURS};
use heapless::Vec;
use units::{Db, Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Order, Phase, Role};

use super::Chain;
use super::duty::Standing;
use super::speed::homeward;
use crate::mission::Round;
use crate::{AgentConfig, LinkView, odometer_deviation};

/// A drone lands where one that is down behind it is heard no weaker than this below the strongest that
/// it heard in the row: 1.6 times the row's spacing in free space, 0.55 m of 0.35 m. Our own number: more
/// makes the row of those that are home longer, less leaves too little for noise.
const NEAR: Db = Db(4.0);
/// One that is down in front is passed where it is heard stronger than in the row by this: the
/// drone is over it, and its own place is behind. Our own number, above the noise of a mean of four.
const OVER: Db = Db(1.0);
/// So much below that strength a drone slows down: twice the distance.
const SLOW: Db = Db(6.0);
/// The part of its speed that is left then: a mean of four packets is 0.1 m late at 0.2 m/s.
const SLOW_PACE: f32 = 0.5;
/// A drone that reports a landing has landed after this long: 0.3 m at 0.2 m/s, the last of it without
/// thrust, and a lost report or two. Until then it counts as one in the air.
const COMES_DOWN: Duration = Duration::from_secs(4);
/// One that comes down is kept clear of from where it is weaker by this than one that is too near in
/// the air: of its first packet the strength has a deviation of 1.7 dB.
const DOUBT: Db = Db(3.0);
/// A drone is at the row within this distance of its own place, and what its odometer may be off by.
const ROW: Metres = Metres(1.0);
/// A drone near home that hears nothing behind it waits for so long. Our own number, twice a long fade.
const WAITS: Duration = Duration::from_secs(20);
/// The next drone on the ground is not heard after so long: two lost packets, or the beginning of a fade.
const HIDDEN: Duration = Duration::from_millis(600);
/// Packets in the mean of a strength in flight, and of one at the take-off.
const IN_FLIGHT: u8 = 4;
const AT_TAKE_OFF: u8 = 8;

/// A drone on the ground, or on its way down to it.
#[derive(Clone, Copy, Debug)]
struct OnGround {
    id: NodeId,
    /// When it was first heard to come down; the beginning of time for one that has not flown.
    since: Instant,
    heard_at: Instant,
    /// The mean strength of its last packets as they came, and how many they are.
    level: Dbm,
    packets: u8,
}

/// The drones on the ground, as a drone in the air hears them.
#[derive(Clone, Debug)]
pub(super) struct Parked {
    all: Vec<OnGround, MAX_NEIGHBOURS>,
    /// The strength of the nearest drone behind where this one took off, from the air.
    at_take_off: Option<Dbm>,
    /// The same of the take-offs before this one.
    before: Option<Dbm>,
    /// The farthest that this drone has been from its take-off.
    farthest: Metres,
    /// When its odometer came home.
    home_since: Option<Instant>,
    was_high: bool,
}

/// Which drones on the ground are near.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Near {
    /// One on the base's side is as near as this drone may come.
    behind: bool,
    /// This drone is over one that has its place farther in.
    ahead: bool,
    /// One on the base's side is not far.
    is_close: bool,
    /// One on the base's side comes down nearby.
    comes_down: bool,
    /// The next on the base's side, near home, is not heard at the moment.
    is_hidden: bool,
}

impl Parked {
    pub(super) const fn new() -> Self {
        Self {
            all: Vec::new(),
            at_take_off: None,
            before: None,
            farthest: Metres::ZERO,
            home_since: None,
            was_high: false,
        }
    }

    /// The farthest that this drone has been from its take-off.
    pub(super) const fn farthest(&self) -> Metres {
        self.farthest
    }

    /// When its odometer came home, if it is there.
    pub(super) const fn home_since(&self) -> Option<Instant> {
        self.home_since
    }

    /// Takes in the reports of a round, as strong as they came.
    pub(super) fn listen(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        height: Option<Metres>,
        heard: &[Heard],
    ) {
        let is_climbing = round.phase == Phase::Transit;
        let is_high = round.phase != Phase::Waiting && config.flight.sees_walls(height);
        if is_high != self.was_high {
            // The antenna has left the floor, or come back to it.
            self.all.iter_mut().for_each(|one| one.packets = 0);
        }
        self.was_high = is_high;
        let is_farther = round.way() > self.farthest;
        self.farthest = if is_climbing || is_farther { round.way() } else { self.farthest };
        let is_home = !round.phase.is_low() && round.way() <= config.flight.home;
        self.home_since = is_home.then(|| self.home_since.unwrap_or(round.now));
        let most = if is_climbing { AT_TAKE_OFF } else { IN_FLIGHT };
        heard.iter().for_each(|heard| self.hear(round.now, most, heard));
        if is_climbing && is_high {
            let behind = self.heard(config, round).filter(|one| one.id > round.id);
            let strongest = behind.map(|one| one.level.0).chain(self.before.map(|level| level.0));
            self.at_take_off = strongest.reduce(f32::max).map(Dbm);
        } else {
            // A drone that takes off again may stand farther from the next than in the row.
            self.before = self.at_take_off;
        }
    }

    fn hear(&mut self, now: Instant, most: u8, heard: &Heard) {
        let Heard { report, rssi, .. } = heard;
        let known = self.all.iter().position(|one| one.id == report.from);
        let since = match report.phase {
            Phase::Waiting => Instant::ZERO,
            Phase::Out => now,
            Phase::Transit | Phase::Linked | Phase::Base | Phase::Searching | Phase::Perched => {
                self.all.retain(|one| one.id != report.from);
                return;
            }
        };
        if !rssi.0.is_finite() {
            return;
        }
        let Some(one) = known.and_then(|known| self.all.get_mut(known)) else {
            let (level, heard_at) = (*rssi, now);
            // There are no more drones than there is room for.
            let one = OnGround { id: report.from, since, heard_at, level, packets: 1 };
            _ = self.all.push(one);
            return;
        };
        one.packets = one.packets.saturating_add(1).min(most);
        one.level = one.level + (*rssi - one.level) * (1.0 / f32::from(one.packets));
        one.heard_at = now;
    }

    /// Whether the drone may be at the row by its odometer.
    fn is_near_home(&self, way: Metres) -> bool {
        way <= ROW + odometer_deviation(self.farthest) * 2.0
    }

    /// Those that are heard.
    fn heard<'a>(
        &'a self,
        config: &'a AgentConfig,
        round: &'a Round,
    ) -> impl Iterator<Item = &'a OnGround> {
        let is_heard = |one: &&OnGround| round.now.since(one.heard_at) <= config.retreat.lost_after;
        self.all.iter().filter(is_heard)
    }

    /// Which of them are near.
    pub(super) fn near(&self, config: &AgentConfig, round: &Round) -> Near {
        // A drone that heard none at its take-off knows nothing of losses on the ground.
        let too_near = config.policy.clearance.map(|clearance| clearance.too_near);
        let mut near = Near::default();
        let Some(least) = self.at_take_off.map(|level| level - NEAR).or(too_near) else {
            return near;
        };
        let behind = self.all.iter().filter(|one| one.id > round.id);
        near.is_hidden = behind.min_by_key(|one| one.id.0).is_some_and(|next| {
            let silent = round.now.since(next.heard_at);
            self.is_near_home(round.way()) && silent > HIDDEN && silent <= WAITS
        });
        for one in self.heard(config, round) {
            if one.id < round.id {
                near.ahead |= self.at_take_off.is_some_and(|level| one.level > level + OVER);
            } else if round.now.since(one.since) < COMES_DOWN {
                near.comes_down |= too_near.is_some_and(|least| one.level > least - DOUBT);
            } else {
                near.behind |= one.level >= least;
                near.is_close |= one.level >= least - SLOW;
            }
        }
        near
    }
}

/// Whether the drone is to land as at home, or before one that is down there.
///
/// It is where it took off by odometer or by signal: ways flown round bends differ out and back, and
/// the base is nowhere stronger than at home. Where nothing is heard behind it waits for a while, as a
/// link fades and drones on the ground are not heard either.
pub(super) fn is_home(at: &Standing<'_>) -> bool {
    let (way, links) = (at.round.way(), &at.links);
    let doubt = odometer_deviation(at.farthest) * 2.0;
    if at.near.behind && way <= ROW + doubt {
        return true;
    }
    // It waits until the one is down or heard again, or flies on until it is past the other.
    if (at.near.comes_down || at.near.is_hidden || at.near.ahead) && way > -doubt {
        return false;
    }
    let has_waited = at.home_since.is_some_and(|since| at.round.now.since(since) >= WAITS);
    let by_way = way <= at.config.flight.home
        && (links.base.is_some() || links.back.is_none() && has_waited);
    let by_signal = links.base.zip(links.home_rssi).is_some_and(|(base, home)| base >= home);
    by_way || by_signal
}

impl Chain {
    /// How fast a drone flies that is called home. A relay goes on relaying while it hears a drone in
    /// front and its own back link is no weaker than it must be: the drones in front drive it home.
    pub(super) fn homing_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let [front_rssi, back_rssi] = [front, back].map(|link| link.map(|link| link.rssi));
        // The base is not to be kept clear of by a drone that goes home to it.
        let is_at_base =
            back.is_some_and(|back| back.is_base && config.policy.is_too_near(back.rssi));
        let relays = round.role == Role::Relay
            && round.order() == Some(Order::Return)
            && front.is_some()
            && !is_at_base
            && !config.retreat.wanted(front_rssi, back_rssi, false);
        if relays {
            let speed = self.relaying_speed(config, round, front, back);
            self.past_the_parked(config, round, back, speed)
        } else {
            self.homeward_speed(config, round, back)
        }
    }

    /// Flying home.
    pub(super) fn homeward_speed(
        &self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        self.past_the_parked(config, round, back, homeward(config, back))
    }

    /// `speed`, but homeward no faster than fits the drones that are down, or come down, behind.
    fn past_the_parked(
        &self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
        speed: MetresPerSecond,
    ) -> MetresPerSecond {
        let near = self.parked.near(config, round);
        // At home it waits for the base.
        if back.is_none() && round.way() <= config.flight.home && !near.ahead {
            return if speed < MetresPerSecond::ZERO { MetresPerSecond::ZERO } else { speed };
        }
        let homeward = config.flight.return_speed;
        let most = match near {
            Near { comes_down: true, .. } | Near { is_hidden: true, .. } => MetresPerSecond::ZERO,
            Near { is_close: true, .. } => homeward * SLOW_PACE,
            _ => homeward,
        };
        if speed < -most { -most } else { speed }
    }
}

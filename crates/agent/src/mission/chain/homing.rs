//! The way home of a drone of a chain, and the spot at which it lands there.
//!
//! A drone that is called home flies on homeward whatever it hears: it knows its odometer, its trail and
//! its walls, and a drone that comes down in the cave is left there. Only home or its battery ends
//! the way.
//!
//! Drones come home in the order in which they stood, the last relay first, and each lands before the
//! outermost drone that is down. No beam sees that one, as a drone on the ground is 3 cm high. Two
//! things tell where it is. One is the odometers of both drones, which are off by decimetres, as much as
//! the row is spaced, and in winding galleries by metres. The other is the strength of its signal, beside
//! that which the landing drone measured at its take-off; of a single packet it tells the distance to a
//! half. But on the last metres an odometer is right to a centimetre, and so [`Fit`] finds the one place
//! that suits all packets of the way.
//!
//! A drone that has landed there knows where it is better than its odometer did, and corrects it, so
//! that the errors of one are not the next one's.

use chain::neighbours::{Heard, MAX_NEIGHBOURS};
use heapless::Vec;
use units::{Db, Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Order, Phase, Role};

use super::Chain;
use super::duty::Standing;
use super::speed::homeward;
use crate::mission::Round;
use crate::{AgentConfig, LinkView};

/// The drones of the row stand so far apart at the take-off, as the operator is told to place them.
const SPACING: Metres = Metres(0.35);
/// A drone lands so far before the outermost one that is down. Our own number, chosen by simulation: more
/// makes the row of those that are home longer, less leaves too little for errors.
const LANDS_BEFORE: Metres = Metres(0.65);
/// Nearer than this it flies out again before it lands. Our own number.
const TOO_NEAR: Metres = Metres(0.4);
/// Within so much of the outermost one, or of the next in the air, a drone flies slowly.
const NEAR: Metres = Metres(1.3);
/// The part of its speed that is left then: a drone that brakes from 0.1 m/s flies on for 3 cm.
const SLOW_PACE: f32 = 0.5;
/// A drone that reports a landing has landed after this long: 1.6 s for the step aside, 0.3 m at 0.2 m/s,
/// the last of it without thrust, and a lost report or two. Until then it counts as one in the air.
const COMES_DOWN: Duration = Duration::from_secs(4);
/// One that is down is in the row, and not left on the way, when its odometer is back to this, and so
/// much more for each drone behind it: a row in which drones have landed is wider spaced.
const IN_ROW: Metres = Metres(1.0);
const WIDER: Metres = Metres(0.4);
/// A drone at home waits for one that it does not hear for so long: of fades that last 10 s on average,
/// one in twenty lasts longer. Our own number.
const WAITS: Duration = Duration::from_secs(30);
/// The next drone in the air is not heard after so long: two lost packets, or the beginning of a fade.
const HIDDEN: Duration = Duration::from_millis(600);
/// The most packets in the mean of a strength at the take-off.
const AT_TAKE_OFF: u8 = 16;

/// Another drone or the base, as this drone last heard it.
#[derive(Clone, Copy, Debug)]
struct Other {
    id: NodeId,
    heard_at: Instant,
    /// When it was first heard to come down, if it is down; the beginning of time for one that has not
    /// flown.
    down_since: Option<Instant>,
    odometer: Metres,
    /// The strengths over this drone's take-off, of its packets here and of this drone's there.
    levels: [Level; 2],
}

/// A mean of strengths, and how many they are.
#[derive(Clone, Copy, Debug)]
struct Level {
    mean: Dbm,
    packets: u8,
}

impl Level {
    const NONE: Self = Self { mean: Dbm(0.0), packets: 0 };

    fn take_in(&mut self, rssi: Option<Dbm>) {
        if let Some(rssi) = rssi.filter(|rssi| rssi.0.is_finite()) {
            self.packets = self.packets.saturating_add(1).min(AT_TAKE_OFF);
            self.mean = self.mean + (rssi - self.mean) * (1.0 / f32::from(self.packets));
        }
    }
}

impl Other {
    /// Whether this drone has measured at its take-off how strong it is.
    fn is_measured(&self) -> bool {
        self.levels.iter().any(|level| level.packets > 0)
    }
}

/// The strengths that a report comes with: that of this packet, and that of this drone's last one where
/// the sender is.
const fn both(heard: &Heard) -> [Option<Dbm>; 2] {
    [heard.rssi, heard.reverse]
}

/// The others, as a drone knows them that looks for a spot at which to land.
#[derive(Clone, Debug)]
pub(super) struct Row {
    all: Vec<Other, MAX_NEIGHBOURS>,
    outermost: Option<Fit>,
    /// Whether the drone has left its take-off, whose strengths it keeps.
    has_left: bool,
    /// When its odometer came home.
    home_since: Option<Instant>,
    /// For how long a relay has waited for the one in front on its way home.
    waited: Duration,
}

/// What the row at home leaves a drone to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Berth {
    /// No drone is heard that is down at home.
    Unknown,
    /// The next drone comes down or flies nearby, or it is not heard.
    Awaited,
    /// The outermost drone that is down is so far behind, less the room that it is to be left.
    Before(Metres),
}

impl Row {
    pub(super) const fn new() -> Self {
        Self {
            all: Vec::new(),
            outermost: None,
            has_left: false,
            home_since: None,
            waited: Duration::ZERO,
        }
    }

    /// When this drone's odometer came home, if it is there.
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
        let is_high = config.flight.sees_walls(height);
        let is_climbing = round.phase == Phase::Transit && is_high && !self.has_left;
        self.has_left |= !round.phase.is_low();
        let is_home = !round.phase.is_low() && round.way() <= config.flight.home;
        self.home_since = is_home.then(|| self.home_since.unwrap_or(round.now));
        if round.phase.is_low() {
            self.waited = Duration::ZERO;
        }
        heard.iter().for_each(|heard| self.hear(round.now, is_climbing, heard));
        if is_high && !round.phase.is_low() {
            self.fit(round, heard);
        } else {
            self.outermost = None;
        }
    }

    fn hear(&mut self, now: Instant, is_climbing: bool, heard: &Heard) {
        let report = &heard.report;
        let known = self.all.iter().position(|one| one.id == report.from);
        if known.is_none() {
            // There are no more drones than there is room for.
            _ = self.all.push(Other {
                id: report.from,
                heard_at: now,
                down_since: None,
                odometer: report.odometer,
                levels: [Level::NONE; 2],
            });
        }
        let Some(one) = self.all.iter_mut().find(|one| one.id == report.from) else { return };
        one.heard_at = now;
        one.odometer = report.odometer;
        one.down_since = match report.phase {
            Phase::Waiting | Phase::Base => Some(Instant::ZERO),
            Phase::Out => Some(one.down_since.unwrap_or(now)),
            Phase::Transit | Phase::Linked | Phase::Searching | Phase::Perched => None,
        };
        if is_climbing && one.down_since.is_some() {
            one.levels.iter_mut().zip(both(heard)).for_each(|(level, rssi)| level.take_in(rssi));
        }
    }

    /// How many places behind this drone's another one had its own in the row.
    fn rank(&self, own: NodeId, other: NodeId) -> f32 {
        let between = |one: &&Other| {
            if other > own {
                one.id > own && one.id <= other
            } else {
                one.id < own && one.id >= other
            }
        };
        let count = self.all.iter().filter(between).count() as f32;
        if other > own { count } else { -count }
    }

    /// Where another one is by its odometer and this drone's.
    fn reckoned(&self, own: NodeId, other: &Other) -> Metres {
        other.odometer - SPACING * self.rank(own, other.id)
    }

    /// The outermost drone that is down at home, or the base.
    fn outermost(&self, round: &Round) -> Option<&Other> {
        let is_in_row = |one: &&Other| {
            let behind = self.all.iter().filter(|other| other.id > one.id).count() as f32;
            one.down_since.is_some_and(|since| round.now.since(since) >= COMES_DOWN)
                && round.now.since(one.heard_at) <= WAITS
                && one.odometer <= IN_ROW + WIDER * behind
        };
        let reckoned = |one: &Other| self.reckoned(round.id, one).0;
        self.all.iter().filter(is_in_row).max_by(|a, b| reckoned(a).total_cmp(&reckoned(b)))
    }

    /// Fits the place of the outermost one to what came from it.
    fn fit(&mut self, round: &Round, heard: &[Heard]) {
        let Some(&other) = self.outermost(round) else {
            self.outermost = None;
            return;
        };
        // What was measured of another one is better than nothing.
        let known = Some(&other).into_iter().chain(&self.all).find(|one| one.is_measured());
        let begun = Fit {
            id: other.id,
            is_measured: known.is_some(),
            begun: round.way(),
            reckoned: self.reckoned(round.id, &other),
            packets: 0,
            sums: [[0.0; 2]; PLACES + 1],
        };
        let is_same = |fit: &Fit| fit.id == other.id && !fit.is_spent(round.way());
        let mut fit = self.outermost.filter(is_same).unwrap_or(begun);
        let known = known.map_or([None; 2], |known| {
            let at_1_m = gain(SPACING * self.rank(round.id, known.id));
            known.levels.map(|level| (level.packets > 0).then(|| level.mean - at_1_m))
        });
        for one in heard.iter().filter(|heard| heard.report.from == other.id) {
            for (rssi, level) in both(one).into_iter().zip(known) {
                if let Some((rssi, level)) = rssi.zip(level) {
                    fit.hear(round.way(), rssi - level);
                }
            }
        }
        self.outermost = Some(fit);
    }

    /// Where this drone is by the outermost one that is down, which has landed in its place of the row.
    pub(super) fn settled(&self, way: Metres) -> Metres {
        self.outermost.map_or(Metres::ZERO, |fit| fit.reckoned + fit.apart(way))
    }

    /// What the row leaves this drone to do.
    pub(super) fn berth(&self, round: &Round) -> Berth {
        let way = round.way();
        let apart = self.outermost.map(|fit| fit.apart(way));
        let next = self.all.iter().filter(|one| one.id > round.id).min_by_key(|one| one.id.0);
        let is_awaited = next.is_some_and(|next| {
            let silent = round.now.since(next.heard_at);
            let at = self.reckoned(round.id, next);
            let is_near = (way - at).0.abs() <= NEAR.0;
            // One that is not heard may have come home meanwhile.
            let is_in_place = apart.is_some_and(|apart| apart <= NEAR);
            match next.down_since {
                Some(since) => is_near && round.now.since(since) < COMES_DOWN,
                None => (is_near || is_in_place) && silent > HIDDEN && silent <= WAITS,
            }
        });
        let Some((fit, apart)) = self.outermost.zip(apart) else {
            return if is_awaited { Berth::Awaited } else { Berth::Unknown };
        };
        // The odometers alone are no reason to land, where something can be heard: but not for ever, as
        // packets that are held back bring no strength.
        let has_waited = self.home_since.is_some_and(|since| round.now.since(since) >= WAITS);
        let is_doubtful =
            fit.is_measured && fit.packets < ENOUGH && apart <= LANDS_BEFORE && !has_waited;
        if is_awaited || is_doubtful { Berth::Awaited } else { Berth::Before(apart) }
    }
}

/// The variance of one packet, dB²: between the 1 and the 20 of quiet and of noisy receivers.
const NOISE: f32 = 10.0;
/// The variance of what all packets have in common, dB²: that of the mean at the take-off, and what the
/// place itself does. This and the next two are our own numbers, chosen by simulation.
const BIAS: f32 = 2.5;
/// The deviation of a place by two odometers, most of the time.
const RECKONING: f32 = 0.4;
/// The logarithm of how likely a place is that contradicts them, beside one that does not.
const CONTRADICTS: f32 = -3.0;
/// The places of a fit, and how far they are apart.
const PLACES: usize = 16;
const STEP: f32 = 0.2;
/// All that are farther stand at this distance, m.
const FAR: f32 = 5.0;
/// After so many packets, or so many metres of the way, a fit that finds the other farther than this begins
/// anew.
const ENOUGH: u16 = 12;
const FARTHER: f32 = 1.0;
const WITHIN: Metres = Metres(2.2);
/// After so many packets half their weight is forgotten, as the odometer of a drone that hovers drifts.
const MOST: u16 = 128;

/// By how much a signal is stronger than at 1 m that comes from an antenna on the ground so far behind
/// one at flying height, in free space.
fn gain(apart: Metres) -> Db {
    Db(-10.0 * libm::log10f(apart.0 * apart.0 + 0.09))
}

/// A fit of the place of another drone to the packets that came from it: how likely is each of some
/// places before the drone, by odometers and by what was heard.
#[derive(Clone, Copy, Debug)]
struct Fit {
    id: NodeId,
    /// Whether the drone knows how strong any signal is in the row.
    is_measured: bool,
    /// The place of this drone at the beginning, and that of the other, by odometers.
    begun: Metres,
    reckoned: Metres,
    packets: u16,
    /// For each place the sum of what packets from there were stronger, and that of the squares.
    sums: [[f32; 2]; PLACES + 1],
}

impl Fit {
    /// The distances at the beginning.
    fn distances() -> impl Iterator<Item = f32> {
        (1..=PLACES).map(|n| n as f32 * STEP).chain([FAR])
    }

    /// Takes in a packet that was so much stronger than one at 1 m.
    fn hear(&mut self, way: Metres, stronger: Db) {
        if !stronger.0.is_finite() {
            return;
        }
        for ([sum, squares], distance) in self.sums.iter_mut().zip(Self::distances()) {
            let off = (stronger - gain(way - self.begun + Metres(distance))).0;
            *sum += off;
            *squares += off * off;
        }
        self.packets += 1;
        if self.packets >= MOST {
            self.packets /= 2;
            self.sums.iter_mut().flatten().for_each(|sum| *sum *= 0.5);
        }
    }

    /// The distance to the other, the mean of all that it may be.
    fn apart(&self, way: Metres) -> Metres {
        let reckoned = (self.begun - self.reckoned).0;
        if !self.is_measured || self.packets == 0 {
            return way - self.reckoned;
        }
        let most = PLACES as f32 * STEP;
        let shared = f32::from(self.packets) + NOISE / BIAS;
        let likely = |([sum, squares], distance): (&[f32; 2], f32)| {
            let is_beyond = distance > most && reckoned > most;
            let off = if is_beyond { 0.0 } else { (reckoned - distance) / RECKONING };
            let heard = (squares - sum * sum / shared) / NOISE;
            (-0.5 * off * off).max(CONTRADICTS) - 0.5 * heard
        };
        let all = || self.sums.iter().zip(Self::distances()).map(likely);
        let highest = all().fold(f32::NEG_INFINITY, f32::max);
        let (total, sum) = all().zip(Self::distances()).fold((0.0, 0.0), |(total, sum), it| {
            let weight = libm::expf(it.0 - highest);
            (total + weight, sum + weight * it.1)
        });
        way - self.begun + Metres(sum / total)
    }

    /// Whether the fit is to begin anew here: the other was or is at the end of its places, or nothing was
    /// heard. An odometer that is right over metres is not so over the whole way.
    fn is_spent(&self, way: Metres) -> bool {
        let is_enough = self.packets >= ENOUGH || (self.begun - way).0.abs() > FARTHER;
        let farthest = if way > self.begun { way } else { self.begun };
        self.packets == 0 || is_enough && self.apart(farthest) > WITHIN
    }
}

/// A drone that is so far behind its take-off by its odometer has flown past all others. Our own number,
/// above what odometers are off by that way.
const LOST: Metres = Metres(15.0);

/// Whether the drone is to land as at home, or before one that is down there.
///
/// Where nothing is known of any that is down, it is where it took off by odometer or by signal: ways
/// flown round bends differ out and back, and the base is nowhere stronger than at home.
pub(super) fn is_home(at: &Standing<'_>) -> bool {
    let (way, links) = (at.round.way(), &at.links);
    match at.berth {
        Berth::Awaited => false,
        Berth::Before(apart) => (TOO_NEAR..=LANDS_BEFORE).contains(&apart) || way < -LOST,
        Berth::Unknown => {
            let has_waited = at.home_since.is_some_and(|since| at.round.now.since(since) >= WAITS);
            let by_way = way <= at.config.flight.home
                && (links.base.is_some() || links.back.is_none() && has_waited);
            let signals = links.base.zip(links.home_rssi);
            by_way || signals.is_some_and(|(base, home)| base >= home)
        }
    }
}

/// A relay on its way home waits for the drone in front for so long in all: a battery that is spent on
/// waiting for one that does not come leaves the relay in the cave as well. Our own number.
const PATIENCE: Duration = Duration::from_secs(30);

impl Chain {
    /// How fast a drone flies that is called home. All fly at once, so that their links stay as long as
    /// they are; a relay waits while the front link is hardly one any more.
    pub(super) fn homing_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let least = config.retreat.limit + config.retreat.hysteresis;
        let is_weak = |link: Option<LinkView>| link.is_some_and(|link| link.rssi < least);
        let waits = round.role == Role::Relay
            && round.order() == Some(Order::Return)
            && is_weak(front)
            && !is_weak(back)
            && self.row.waited < PATIENCE;
        if waits {
            self.row.waited = self.row.waited + self.dt;
            MetresPerSecond::ZERO
        } else {
            self.homeward_speed(config, round, back)
        }
    }

    /// Flying home, but no faster than fits the drones that are down, or come down, behind.
    pub(super) fn homeward_speed(
        &self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let speed = homeward(config, back);
        match self.row.berth(round) {
            Berth::Awaited => MetresPerSecond::ZERO,
            Berth::Before(apart) if apart < TOO_NEAR => -config.flight.return_speed * -SLOW_PACE,
            Berth::Before(apart) if apart < NEAR => speed * SLOW_PACE,
            Berth::Unknown if back.is_none() && round.way() <= config.flight.home => {
                MetresPerSecond::ZERO
            }
            Berth::Before(_) | Berth::Unknown => speed,
        }
    }
}

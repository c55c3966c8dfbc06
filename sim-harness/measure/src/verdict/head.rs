//! Follows the head of a chain: how far it comes, where the pilot's stick would have brought it, and
//! for how long it stands while the pilot pushes.

use std::collections::VecDeque;

use units::{Branch, Course, Order};

use super::Ended;
use super::branch::Passing;
use crate::metrics::ROUND_S;
use mission::Linked;
use scenario::{SLOWER, Scenario};

/// A head that has come so much farther has advanced, m: more than it is moved by the noise of its
/// sensors at a place that it holds. Ours.
const ADVANCE: f32 = 0.1;
/// A head stands when it advances slower than by this part of the pilot's speed. Ours.
const STANDS: f32 = 0.1;
/// The longest time for which links bear with being too weak before a relay is called, s: the
/// `patience` of [`LaunchConfig::WHEN_SETTLED`](chain::launch::LaunchConfig), and that of the policy
/// `chain`.
const PATIENCE_S: f32 = 10.0;
/// The chain rests when the head has stayed within [`RESTS_WITHIN`] for so long, s.
const REST_S: f32 = 10.0;
/// The way that a head at rest flies at most, m.
const RESTS_WITHIN: f32 = 0.5;
/// A choice that changed less than this before the head passed a junction was perhaps not meant for
/// it, s: a metre at 0.2 m/s.
const CHOICE_S: f32 = 5.0;

/// The constants of a scenario that say how long a relay needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// The speed of a relay on its way, m/s.
    pub(super) relay_mps: f32,
    /// The time of a take-off, s.
    pub(super) rise_s: f32,
    /// The time until a relay that is needed is up, s.
    pub(super) call_s: f32,
    /// The largest speed of the head, m/s.
    pub(super) head_mps: f32,
}

impl Pace {
    pub(super) fn of(scenario: &Scenario) -> Self {
        let flight = &scenario.agent.flight;
        Self {
            relay_mps: flight.return_speed.0,
            rise_s: flight.rise_s(),
            call_s: scenario.call_s(),
            head_mps: scenario.agent.policy.max_speed.0,
        }
    }

    /// The time that a relay needs to come to a head at this distance from the base, with the time
    /// until it is called, s.
    fn arrival_s(&self, way: f32) -> f32 {
        way / self.relay_mps + self.rise_s + PATIENCE_S
    }
}

/// What is seen of the chain in one round.
pub(super) struct Moment {
    pub(super) now_s: f32,
    /// The pilot's order.
    pub(super) order: Order,
    /// Whether a battery has called the chain home.
    pub(super) is_recalled: bool,
    /// The head, where it is a link of a chain.
    pub(super) head: Option<Linked>,
    /// Whether the head is at the end of a gallery.
    pub(super) is_at_end: bool,
    /// Whether a relay stands at the base that could be called.
    pub(super) relay_waits: bool,
    /// Whether a relay takes off.
    pub(super) relay_rises: bool,
    /// The relays in the chain, less those that the best chain needs.
    pub(super) surplus: f32,
    /// The junctions that the head has passed, without choices; empty where none was ordered.
    pub(super) passed: Vec<Passing>,
}

/// A head that stood, while relays waited uncalled on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stood {
    /// Where it stood, m from the base.
    pub at_m: f32,
    /// The time since it last advanced by more than at a tenth of the pilot's speed, or a relay was
    /// called, s.
    pub for_s: f32,
}

/// The head at the last moment at which the pilot pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pushed {
    /// It advanced, was at the end of a gallery, or waited for a relay that was on its way.
    On,
    /// It stood although relays waited, for longer than a relay needs.
    Stuck,
    /// It stood, and no relay was left.
    AtLimit,
}

/// One time for which the pilot pushes.
#[derive(Clone, Copy, Debug)]
struct Push {
    /// The farthest place, m from the base.
    best: f32,
    /// When the head last advanced, or began, s.
    advanced_s: f32,
    /// A place, m, and a time, s, since which the head has come farther at less than a tenth of the
    /// pilot's speed, and no relay was called.
    idle: (f32, f32),
}

/// The record of a head.
#[derive(Debug)]
pub(super) struct HeadRecord {
    pace: Pace,
    push: Option<Push>,
    pushed: Option<Pushed>,
    is_recalled: bool,
    /// Whether the head has left the chain before the pilot ended the exploration.
    has_fallen: bool,
    /// The choice at junctions that stands, and since when, s.
    choice: (Option<Branch>, f32),
    passed: Vec<Passing>,
    came_m: f32,
    /// Where the pilot's stick would have brought the head, m from the base, and the most of it.
    wished: Option<(f32, f32)>,
    /// The first place of the head, m from the base.
    began_m: f32,
    fastest_mps: f32,
    stood_s: f32,
    stuck: Option<Stood>,
    /// The ways of the head and the surplus of relays in the last [`REST_S`] of the exploration.
    rest: VecDeque<(f32, f32)>,
}

/// What became of the head's exploration.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadFlight {
    /// The farthest place of the head in the branches that it took last, m from the base; `None`
    /// where it never was a link of a chain.
    pub came_m: Option<f32>,
    /// The farthest place to which the pilot's stick would have brought it by then, m from the base.
    pub wished_m: f32,
    /// The first place from which that counts, m from the base.
    pub began_m: f32,
    /// The fastest speed of the pilot's stick, m/s.
    pub fastest_mps: f32,
    /// The time for which the pilot pushed, relays waited and the head stood, s.
    pub stood_s: f32,
    /// The longest time for which it stood and no relay was called, where that was longer than a
    /// relay needs to come.
    pub stuck: Option<Stood>,
    /// The relays beyond need in the last 10 s of the exploration; NaN where the head did not rest.
    pub surplus_at_rest: f32,
    /// Why the exploration ended; `None` without one. One that ended by the radio ended with too
    /// few relays where the head is as far as it could be.
    pub ended: Option<Ended>,
    /// Whether the head left the chain before the pilot had ended the exploration.
    pub has_fallen: bool,
    /// The junctions that it has passed.
    pub passed: Vec<Passing>,
    /// The last choice at junctions.
    pub choice: Option<Branch>,
}

impl HeadFlight {
    /// Where the head should have come by the pilot's stick, if it had to wait for so many relays,
    /// m from the base.
    pub(super) fn due_m(&self, relays: f32, pace: &Pace) -> f32 {
        let waited = relays * pace.call_s * self.fastest_mps;
        self.began_m + ((self.wished_m - self.began_m) / SLOWER - waited).max(0.0)
    }
}

impl HeadRecord {
    pub(super) fn new(pace: Pace) -> Self {
        Self {
            pace,
            push: None,
            pushed: None,
            is_recalled: false,
            has_fallen: false,
            choice: (None, 0.0),
            passed: Vec::new(),
            came_m: 0.0,
            wished: None,
            began_m: 0.0,
            fastest_mps: 0.0,
            stood_s: 0.0,
            stuck: None,
            rest: VecDeque::new(),
        }
    }

    /// Takes in one round.
    pub(super) fn take(&mut self, moment: Moment) {
        let Order::Explore(course) = moment.order else {
            self.push = None;
            return;
        };
        if moment.is_recalled {
            self.is_recalled |= self.wished.is_some();
            self.push = None;
            return;
        }
        let Some(head) = moment.head else {
            self.has_fallen = self.wished.is_some();
            self.push = None;
            return;
        };
        self.has_fallen = false;
        if course.branch != self.choice.0 {
            self.choice = (course.branch, moment.now_s);
            self.begin_anew(head.way);
        }
        self.note_way(&moment, head.way, course);
        self.note_rest(head.way, moment.surplus);
        if course.speed.0 > 0.0 {
            self.note_push(&moment, head.way, course);
        } else {
            self.push = None;
        }
    }

    /// From here on counts the way to another end.
    fn begin_anew(&mut self, way: f32) {
        if self.wished.is_some() {
            (self.came_m, self.began_m, self.wished) = (way, way, Some((way, way)));
        }
    }

    fn note_way(&mut self, moment: &Moment, way: f32, course: Course) {
        let same = self.passed.iter().zip(&moment.passed).take_while(|(a, b)| a.is_same(b)).count();
        let (branch, since_s) = self.choice;
        if self.passed.get(same).is_some_and(|left| left.ordered != branch) {
            // The head has come out of a branch that is no longer ordered.
            self.begin_anew(way);
        }
        self.passed.truncate(same);
        let ordered = branch.filter(|_| moment.now_s - since_s >= CHOICE_S || since_s == 0.0);
        let new = moment.passed.iter().skip(same).map(|passing| passing.under(ordered));
        self.passed.extend(new);
        self.came_m = self.came_m.max(way);

        let (at, most) = *self.wished.get_or_insert_with(|| {
            self.began_m = way;
            (way, way)
        });
        let speed = course.speed.0.min(self.pace.head_mps);
        self.fastest_mps = self.fastest_mps.max(speed);
        let at = (at + speed * ROUND_S).max(0.0);
        self.wished = Some((at, most.max(at)));
    }

    fn note_rest(&mut self, way: f32, surplus: f32) {
        if self.rest.len() == (REST_S / ROUND_S) as usize {
            self.rest.pop_front();
        }
        self.rest.push_back((way, surplus));
    }

    fn note_push(&mut self, moment: &Moment, way: f32, course: Course) {
        let now = moment.now_s;
        let speed = course.speed.0.min(self.pace.head_mps);
        let push = self.push.get_or_insert(Push { best: way, advanced_s: now, idle: (way, now) });
        if way > push.best + ADVANCE {
            (push.best, push.advanced_s) = (way, now);
        }
        let (from, since_s) = push.idle;
        let is_fair = way > from + ADVANCE + STANDS * speed * (now - since_s);
        if is_fair || moment.relay_rises || !moment.relay_waits {
            push.idle = (way, now);
        }
        let stands = now - push.advanced_s > ADVANCE / (STANDS * speed) && !moment.is_at_end;
        let for_s = now - push.idle.1;
        if stands && moment.relay_waits {
            self.stood_s += ROUND_S;
        }
        self.pushed = Some(if for_s > self.pace.arrival_s(way) && !moment.is_at_end {
            if self.stuck.is_none_or(|stuck| stuck.for_s < for_s) {
                self.stuck = Some(Stood { at_m: way, for_s });
            }
            Pushed::Stuck
        } else if stands && !moment.relay_waits {
            Pushed::AtLimit
        } else {
            Pushed::On
        });
    }

    /// The surplus at the end of the exploration, where the head rested.
    fn surplus_at_rest(&self) -> f32 {
        let ways = self.rest.iter().map(|(way, _)| *way);
        let (low, high) = ways.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), way| {
            (low.min(way), high.max(way))
        });
        let is_long = self.rest.len() == (REST_S / ROUND_S) as usize;
        if !is_long || high - low > RESTS_WITHIN {
            return f32::NAN;
        }
        self.rest.iter().map(|(_, surplus)| *surplus).sum::<f32>() / self.rest.len() as f32
    }

    /// What was recorded.
    pub(super) fn flight(&self) -> HeadFlight {
        let (_, wished_m) = self.wished.unwrap_or_default();
        let ended = self.pushed.map(|pushed| match pushed {
            _ if self.is_recalled => Ended::Battery,
            Pushed::On => Ended::Pilot,
            Pushed::Stuck => Ended::Stuck,
            Pushed::AtLimit => Ended::Radio,
        });
        HeadFlight {
            came_m: self.wished.map(|_| self.came_m),
            wished_m,
            began_m: self.began_m,
            fastest_mps: self.fastest_mps,
            stood_s: self.stood_s,
            stuck: self.stuck,
            surplus_at_rest: self.surplus_at_rest(),
            ended,
            has_fallen: self.has_fallen,
            passed: self.passed.clone(),
            choice: self.choice.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use units::{MetresPerSecond, NodeId};

    use super::*;
    use world::SkeletonPlace;

    const PACE: Pace = Pace { relay_mps: 0.2, rise_s: 2.5, call_s: 7.5, head_mps: 0.4 };

    /// The head's flight where the pilot pushes at 0.2 m/s for so long; `way`, `waits` and `rises` by
    /// the time.
    fn flown(
        until_s: u32,
        way: impl Fn(f32) -> f32,
        waits: impl Fn(f32) -> bool,
        rises: impl Fn(f32) -> bool,
    ) -> HeadFlight {
        let mut record = HeadRecord::new(PACE);
        for n in 1..=5 * until_s {
            let now_s = n as f32 * ROUND_S;
            let (place, way) = (SkeletonPlace::default(), way(now_s));
            record.take(Moment {
                now_s,
                order: Order::explore(MetresPerSecond(0.2)),
                is_recalled: false,
                head: Some(Linked { id: NodeId::HEAD, place, way }),
                is_at_end: false,
                relay_waits: waits(now_s),
                relay_rises: rises(now_s),
                surplus: 1.0,
                passed: Vec::new(),
            });
        }
        record.flight()
    }

    /// 10 m in 50 s, and no farther.
    fn to_the_corner(now: f32) -> f32 {
        (0.2 * now).min(10.0)
    }

    #[test]
    fn a_head_that_stands_at_a_corner_with_relays_left_is_stuck() {
        let flight = flown(200, to_the_corner, |_| true, |_| false);
        assert_eq!(flight.ended, Some(Ended::Stuck));
        let stuck = flight.stuck.unwrap();
        assert!((149.0..=151.0).contains(&stuck.for_s) && stuck.at_m == 10.0, "{stuck:?}");
        assert!((144.0..=146.0).contains(&flight.stood_s), "{}", flight.stood_s);
        assert_eq!(flight.surplus_at_rest, 1.0);
        assert!((flight.wished_m - 40.0).abs() < 0.1, "{}", flight.wished_m);
    }

    #[test]
    fn a_head_that_waits_for_a_called_relay_is_not_stuck() {
        // A relay needs 10 m / 0.2 m/s + 2.5 s + 10 s.
        let flight = flown(111, to_the_corner, |_| true, |_| false);
        assert_eq!((flight.stuck, flight.ended), (None, Some(Ended::Pilot)));
        let called = |now: f32| (100.0..102.0).contains(&now);
        let flight = flown(160, to_the_corner, |_| true, called);
        assert_eq!((flight.stuck, flight.ended), (None, Some(Ended::Pilot)));
    }

    #[test]
    fn a_head_that_dithers_stands() {
        let dithers = |now| to_the_corner(now) - 0.4 * libm::sinf(now).abs();
        let flight = flown(200, dithers, |_| true, |_| false);
        assert_eq!(flight.ended, Some(Ended::Stuck));
    }

    #[test]
    fn a_head_that_creeps_is_stuck() {
        let creeps = |now| to_the_corner(now) + 0.005 * now;
        let flight = flown(200, creeps, |_| true, |_| false);
        assert_eq!(flight.ended, Some(Ended::Stuck));
    }

    #[test]
    fn without_a_relay_left_the_limit_ends_the_exploration() {
        let flight = flown(200, to_the_corner, |_| false, |_| false);
        assert_eq!((flight.stuck, flight.ended), (None, Some(Ended::Radio)));
        assert_eq!(flight.stood_s, 0.0);
        let advances = flown(100, |now| 0.2 * now, |_| false, |_| false);
        assert_eq!(advances.ended, Some(Ended::Pilot));
        assert!(advances.surplus_at_rest.is_nan());
        // 20 m in 100 s are 13.3 m in two thirds of it; a relay is up after 7.5 s.
        let due = [0.0, 2.0].map(|relays| advances.due_m(relays, &PACE));
        assert!((due[0] - 13.4).abs() < 0.1 && (due[1] - 10.4).abs() < 0.1, "{due:?}");
    }
}

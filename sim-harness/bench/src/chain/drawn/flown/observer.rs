//! Looks at one mission in a drawn place from outside.

use agent::{LandReason, State};
use input::InputError;
use units::{Db, Metres, MissionKind, Order, Role};
use world::{Known, SkeletonPlace, World};

use super::push::Push;
use super::rest::Rest;
use super::{APART_M, Cause, DEEP, Flown, Left, QUICK, WEAK};
use crate::chain::Contender;
use crate::chain::drawn::drawing::Drawn;
use measure::oracle::{Commanded, Oracle};
use measure::verdict::WIDER_M;
use mission::{Gains, Linked, Mission, ROUND_US};
use scenario::{Scenario, Stretch};

/// A link is weaker than the limit when it is so by more than this, dB.
const VIOLATION: f32 = 0.5;
/// A drone is at home within this of the row in which the drones took off, m, beside what the row in which they
/// land is longer: an arm's length.
const HOME_M: f32 = 1.0;

/// Flies a policy in a drawn place.
///
/// # Errors
/// [`InputError`] for a policy that there is not.
pub fn fly(drawn: &Drawn, policy: &Contender) -> Result<Flown, InputError> {
    let scenario = policy.flies(&drawn.scenario)?;
    debug_assert!(scenario.mission == MissionKind::Chain);
    let mission = Mission::new(&scenario, &drawn.world, drawn.seed);
    let mut mission = policy.begin(mission, drawn.seed);
    let case = Case {
        seed: drawn.seed,
        scenario: &scenario,
        world: &drawn.world,
        commanded: &drawn.commanded,
        oracle: &drawn.oracle,
    };
    let mut observer = Observer::of(case, policy.name());
    while !mission.is_over() {
        mission.round();
        observer.look(&mission);
    }
    Ok(observer.flown(&mission))
}

/// A mission to look at, and what could be reached in it.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    /// The seed of the mission.
    pub(crate) seed: u64,
    /// The mission as it is flown.
    pub(crate) scenario: &'a Scenario,
    /// The place and its radio.
    pub(crate) world: &'a World,
    /// Where the pilot's orders lead.
    pub(crate) commanded: &'a Commanded,
    /// What can be reached.
    pub(crate) oracle: &'a Oracle,
}

/// Collects what is seen of a mission.
pub(crate) struct Observer<'a> {
    case: Case<'a>,
    policy: &'a str,
    gains: Gains,
    begins_s: f32,
    /// When the exploration ends, s.
    explored_s: f32,
    depth_m: f32,
    deep_s: f32,
    /// Where the head was when it last was a link of the chain before it was called home, m.
    rests_m: Option<f32>,
    push: Push,
    rest: Rest,
    disordered: u32,
    explored: [u32; 2],
    chain: Vec<Linked>,
    wrong: Vec<(f32, Cause)>,
    /// The drones that have left the ground.
    flew: Vec<bool>,
}

impl<'a> Observer<'a> {
    /// Makes the observer of a mission before its first round.
    pub(crate) fn of(case: Case<'a>, policy: &'a str) -> Self {
        let scenario = case.scenario;
        let members = scenario.drones.members();
        let explores =
            |task: Order| matches!(task, Order::Explore(course) if course.speed.0 != 0.0);
        let steps = || scenario.pilot.iter();
        let begins = steps().find(|step| explores(step.task)).map_or(0, |step| step.at_us);
        let hold = scenario.hold();
        Self {
            case,
            policy,
            gains: Gains::of(&scenario.radio, members, case.seed),
            begins_s: seconds(begins),
            explored_s: hold.map_or(scenario.duration_s(), |hold| seconds(hold.from_us)),
            depth_m: 0.0,
            deep_s: f32::INFINITY,
            rests_m: None,
            push: Push::of(scenario),
            rest: Rest::of(hold, members),
            disordered: 0,
            explored: [0; 2],
            chain: Vec::new(),
            wrong: Vec::new(),
            flew: vec![false; scenario.drones.flying()],
        }
    }

    fn note(&mut self, at: f32, cause: Cause) {
        if !self.wrong.iter().any(|(_, known)| *known == cause) {
            self.wrong.push((at, cause));
        }
    }

    /// Ends the exploration now, before the scenario's own hold: the pilot lets the head hover for so
    /// long. What comes later does not count as its depth.
    pub(crate) fn end_exploration(&mut self, now_us: u64, holds_us: u64) {
        self.explored_s = self.explored_s.min(seconds(now_us));
        let hold = Stretch { from_us: now_us, until_us: now_us + holds_us };
        self.rest = Rest::of(Some(hold), self.case.scenario.drones.members());
    }

    /// Takes in one round.
    pub(crate) fn look(&mut self, mission: &Mission<'_>) {
        let now = seconds(mission.time_us());
        let world = self.case.world;
        let places: Vec<SkeletonPlace> = mission.places().collect();
        let states: Vec<State> = mission.states().collect();
        let head = places.first().map_or(0.0, |place| self.case.commanded.along(world, *place));
        if now <= self.explored_s + 0.1 {
            self.depth_m = self.depth_m.max(head);
            if head >= DEEP * self.case.oracle.depth_m && self.deep_s.is_infinite() {
                self.deep_s = now - self.begins_s;
            }
        }
        for (flew, body) in self.flew.iter_mut().zip(mission.bodies()) {
            *flew |= body.height() > 0.0;
        }
        let mut chain = std::mem::take(&mut self.chain);
        mission.chain(&mut chain);
        if is_disordered(world, &chain) {
            self.disordered += 1;
            self.note(now, Cause::Order);
        }
        let is_called = mission.is_recalled() || !matches!(mission.task(), Order::Explore(_));
        let has_head = chain.last().is_some_and(|last| last.id.0 == 0) && chain.len() > 1;
        if has_head && !is_called {
            let losses = self.links(&chain);
            let weakest = losses.iter().map(|(_, loss)| loss.0).fold(f32::MIN, f32::max);
            let limit = self.case.scenario.agent.launch.limit.loss().0;
            self.explored[0] += 1;
            self.explored[1] += u32::from(weakest - limit > VIOLATION);
            self.rest.look(mission.time_us(), &losses, mission.bodies());
            self.rests_m = Some(head);
        }
        let reach = DEEP * self.case.oracle.reach_m;
        if self.push.look(mission, &states, head, reach) && !is_called {
            self.note(now, Cause::Deadlock);
        }
        if mission.wall_contacts() > 0 {
            self.note(now, Cause::Wall);
        }
        if mission.drone_contacts() > 0 {
            self.note(now, Cause::Drones);
        }
        for state in &states {
            match state {
                State::Landing { why: LandReason::LinkLost, .. } => self.note(now, Cause::LinkLost),
                State::Landing {
                    why: LandReason::Unfit(_) | LandReason::TakeOffFailed, ..
                }
                | State::Landed { why: LandReason::Unfit(_) | LandReason::TakeOffFailed } => {
                    self.note(now, Cause::BroughtDown);
                }
                _ => {}
            }
        }
        self.chain = chain;
    }

    /// The ends and the losses of the chain's links, mean over both directions, without fades.
    fn links(&self, chain: &[Linked]) -> Vec<([u8; 2], Db)> {
        let radio = &self.case.world.radio;
        let link = |pair: &[Linked]| {
            let (back, front) = (&pair[0], &pair[1]);
            let gain = self.gains.of_link(usize::from(back.id.0), usize::from(front.id.0));
            let strength = radio.known_strength(back.place, front.place, Known::Shadows) + gain;
            ([back.id.0, front.id.0], strength.loss())
        };
        chain.windows(2).map(link).collect()
    }

    /// What was seen, at the end of the mission.
    pub(crate) fn flown(mut self, mission: &Mission<'_>) -> Flown {
        let ends = seconds(mission.time_us());
        let weak = self.explored[1] as f32 / self.explored[0].max(1) as f32;
        let oracle_s = self.case.oracle.time_to(DEEP * self.case.oracle.depth_m) - self.begins_s;
        if self.deep_s.is_infinite() {
            self.note(self.explored_s, Cause::Short);
        } else if self.deep_s > QUICK * oracle_s {
            self.note(self.explored_s, Cause::Late);
        }
        if weak > WEAK {
            self.note(self.explored_s, Cause::Weak);
        }
        let left = self.left(mission);
        let airborne = mission.states().zip(&self.flew).any(|(state, _)| state.is_airborne());
        if airborne {
            self.note(ends, Cause::Flying);
        }
        if left.iter().any(|left| !left.why.starts_with("flies")) {
            self.note(ends, Cause::Inside);
        }
        let beats_oracle = self.beats_oracle();
        let closest_m = self.closest(mission);
        if closest_m < APART_M {
            self.note(ends, Cause::Together);
        }
        self.wrong.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let head = self.rests_m;
        Flown {
            seed: self.case.seed,
            policy: self.policy.to_owned(),
            oracle_m: self.case.oracle.depth_m,
            oracle_s,
            ended: self.case.oracle.ended.name(),
            relays: [self.case.scenario.drones.relays, self.case.oracle.least_relays],
            depth_m: self.depth_m,
            deep_s: self.deep_s,
            launched: self.flew.iter().skip(1).filter(|flew| **flew).count(),
            stood_s: self.push.stood_s(),
            walls: mission.wall_contacts(),
            drones: mission.drone_contacts(),
            disordered: self.disordered,
            weak,
            surplus: head.and_then(|head| {
                let relays = self.rest.relays()? as i32;
                Some(relays - self.case.oracle.least_relays_at(head) as i32)
            }),
            rest_m: self.rest.path_m(),
            swing_db: self.rest.swing_db(),
            left,
            closest_m,
            beats_oracle,
            wrong: self.wrong,
        }
    }

    /// Whether an oracle that may be below the limit by as much as counts for nothing would get less
    /// far than the head of a chain that never was, or later.
    fn beats_oracle(&self) -> bool {
        /// The grid of the oracle, and the noise of a place beside the centre-line, m.
        const SLACK_M: f32 = 0.3;
        let is_sooner =
            self.deep_s < self.case.oracle.time_to(DEEP * self.case.oracle.depth_m) - self.begins_s;
        if self.explored[1] > 0
            || (!is_sooner && self.depth_m <= self.case.oracle.depth_m + SLACK_M)
        {
            return false;
        }
        let mut scenario = self.case.scenario.clone();
        let limit = scenario.agent.launch.limit - Db(VIOLATION);
        scenario.agent = scenario.agent.with_limits(Some(limit), None);
        let Case { world, commanded, seed, .. } = self.case;
        let oracle = Oracle::of(&scenario, world, commanded, seed);
        let at = DEEP * self.case.oracle.depth_m - SLACK_M;
        self.depth_m > oracle.depth_m + SLACK_M
            || self.deep_s + ROUND_S < oracle.time_to(at) - self.begins_s
    }

    /// The drones that flew and are not down at home.
    fn left(&self, mission: &Mission<'_>) -> Vec<Left> {
        let row = self.case.scenario.drones.row_m();
        let wider = WIDER_M * self.flew.iter().filter(|flew| **flew).count() as f32;
        let home = row + wider + HOME_M;
        let drones = mission.states().zip(mission.ways()).zip(&self.flew).enumerate();
        let left = drones.filter_map(|(drone, ((state, way_m), flew))| {
            let why = match state {
                _ if !flew => return None,
                state if state.is_airborne() => format!("flies, {}", state.name()),
                _ if way_m <= home => return None,
                State::Landed { why } => format!("landed, {}", reason(why)),
                state => format!("down, {}", state.name()),
            };
            Some(Left { drone, way_m, why })
        });
        left.collect()
    }

    /// The least distance between two drones on the ground of which one flew, m.
    fn closest(&self, mission: &Mission<'_>) -> f32 {
        let drones = mission.bodies().zip(&self.flew);
        let down: Vec<_> = drones
            .filter(|(body, _)| body.height() <= 0.05)
            .map(|(body, flew)| (body.position(), *flew))
            .collect();
        let mut closest = f32::INFINITY;
        for (n, (one, one_flew)) in down.iter().enumerate() {
            for (other, other_flew) in &down[n + 1..] {
                if *one_flew || *other_flew {
                    let Metres(apart) = one.distance(*other);
                    closest = closest.min(apart);
                }
            }
        }
        closest
    }
}

const fn reason(why: LandReason) -> &'static str {
    match why {
        LandReason::Ordered => "ordered",
        LandReason::Perched => "perched",
        LandReason::Home => "home",
        LandReason::Retired => "retired",
        LandReason::TakeOffFailed => "take-off failed",
        LandReason::LinkLost => "link lost",
        LandReason::Done => "done",
        LandReason::PositionLost => "position lost",
        LandReason::Unfit(_) => "unfit",
        LandReason::Restarted => "restarted",
    }
}

/// Whether a member is farther out than the next one towards the head. Drones in different branches
/// have no order.
fn is_disordered(world: &World, chain: &[Linked]) -> bool {
    let (base, skeleton) = (world.base.on, world.skeleton());
    chain.windows(2).any(|pair| {
        pair[1].way < pair[0].way && skeleton.in_line(base, pair[0].place, pair[1].place)
    })
}

/// Whether a drone stands on the ground and may be called.
pub(super) fn waits(scenario: &Scenario, drone: usize, state: &State) -> bool {
    scenario.drones.role(drone) == Role::Relay && matches!(state, State::Idle | State::Armed { .. })
}

fn seconds(us: u64) -> f32 {
    (us as f64 * 1e-6) as f32
}

/// Seconds in a round.
pub(super) const ROUND_S: f32 = ROUND_US as f32 * 1e-6;

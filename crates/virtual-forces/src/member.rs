//! Flies one drone of a swarm through the whole mission: the survey of the first area, the compact
//! formation before the passage, the passage itself, and the survey of the second area; or, once it is
//! recalled, back through the passage to where it took off.

use units::{Metres, Point2};

use crate::crossing::Side;
use crate::force::{attraction_to_goal, between_drones};
use crate::formation::{Formation, exchanged};
use crate::geometry::{along, moved};
use crate::pace::Pace;
use crate::room::Room;
use crate::takeover::Takeover;
use crate::team::{Heard, Team};
use crate::{Config, Obstacles, Passage, Plan, Resultant, Survey};

/// A part of the mission, with a survey and a passage of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leg {
    /// The first area, and the passage to the second one.
    First,
    /// The second area.
    Second,
    /// The way back through the passage, of a drone that was recalled.
    Back,
}

/// A drone that flies home is there within this distance, m: half of a step, with which two on neighbouring
/// places of a row of 0.35 m land 0.25 m apart.
const AT_HOME: Metres = Metres(0.05);

/// The progress of a drone that lands or has landed: the others do not wait for it, and it keeps its place.
pub const DOWN: u16 = u8::MAX as u16;

/// What a drone is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// It surveys an area, and has reached so many goals.
    Survey {
        /// The number of goals that it has reached.
        reached: u16,
        /// Whether it is on the way to the next one, and does not wait for others.
        underway: bool,
    },
    /// It goes to its place in the compact formation, or waits there.
    Gather {
        /// Its place.
        place: Point2,
        /// Rounds since it reached its place; 0 before.
        held: u16,
    },
    /// It goes through the passage, and makes room for the others behind it.
    Cross {
        /// Whether it is in the area behind the passage.
        out: bool,
        /// How it gets on.
        pace: Pace,
    },
    /// It was recalled, is on its own side of the passage, and flies to where it took off.
    Home,
    /// It is to land: it has surveyed the second area, or, where that has no goals, all drones that it
    /// waits for are in it, and it is twice D_int beyond the exit, so that a drone which was taken for
    /// lost can still come out; or it was recalled, and is as near to where it took off as it comes.
    Done,
}

/// One drone of a swarm of at most `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member<const N: usize> {
    pub(crate) config: Config,
    pub(crate) plan: Plan,
    pub(crate) number: u16,
    pub(crate) leg: Leg,
    pub(crate) task: Task,
    pub(crate) team: Team<N>,
    pub(crate) takeover: Takeover,
    /// Where the drone took off, once it is recalled.
    pub(crate) home: Point2,
    /// The side to which the drone last turned in the passage.
    pub(crate) side: Option<Side>,
    /// The rounds on the way to this goal or place in which the drone came no nearer to it, or in which it got no
    /// farther through the passage.
    pub(crate) still: u16,
    /// Where the drone last came a step farther through the passage than ever, m beyond its end.
    pub(crate) farthest: f32,
    /// The largest error of the drone's own position in this round.
    pub(crate) error: Metres,
}

impl<const N: usize> Member<N> {
    /// Returns drone `number` (from 0) of a swarm, which stands on its first goal.
    #[must_use]
    pub fn new(config: Config, plan: Plan, number: u16) -> Self {
        let task = Task::Survey { reached: 1, underway: false };
        Self {
            config,
            plan,
            number,
            leg: Leg::First,
            task,
            team: Team::new(number, plan.drones),
            takeover: Takeover::NONE,
            home: Point2::new(0.0, 0.0),
            side: None,
            still: 0,
            farthest: f32::NEG_INFINITY,
            error: Metres(0.0),
        }
    }

    /// Returns drone `number` (from 0) of a swarm, which first has to fly to its first goal.
    #[must_use]
    pub fn on_the_way(config: Config, plan: Plan, number: u16) -> Self {
        let task = Task::Survey { reached: 0, underway: true };
        Self { task, ..Self::new(config, plan, number) }
    }

    /// Returns what the drone is doing.
    #[must_use]
    pub fn task(&self) -> Task {
        self.task
    }

    /// Calls the drone, which is `here`, back to where it took off, at `home`. It comes back through the
    /// passage in formation, as it went.
    pub fn recall(&mut self, here: Point2, home: Point2) {
        if self.leg == Leg::Back {
            return;
        }
        let Passage { entrance, way, width, length } = self.plan.passage;
        let inside = along(way, entrance, here);
        let has_left =
            self.leg == Leg::Second || matches!(self.task, Task::Cross { .. } | Task::Done);
        (self.leg, self.home, self.still) = (Leg::Back, home, 0);
        self.plan.passage = Passage {
            entrance: moved(entrance, way, length.0),
            way: Point2::new(-way.x, -way.y),
            width,
            length,
        };
        self.task = if !has_left || inside <= 0.0 {
            Task::Home
        } else if inside > length.0 {
            Task::Gather { place: self.place(), held: 0 }
        } else {
            self.enter()
        };
    }

    /// Says whether the drone was recalled.
    #[must_use]
    pub fn is_recalled(&self) -> bool {
        self.leg == Leg::Back
    }

    /// Returns the survey of this part of the mission, or the last one on the way back.
    pub(crate) fn survey(&self) -> &Survey {
        let [first, second] = &self.plan.surveys;
        if self.leg == Leg::First { first } else { second }
    }

    /// Returns the number of goals in this part of the mission.
    pub(crate) fn goals(&self) -> u16 {
        if self.leg == Leg::Back { 0 } else { self.survey().goals() }
    }

    /// Returns the progress with which this part of the mission begins.
    fn begun(&self) -> u16 {
        let [first, second] = self.plan.surveys.map(|survey| survey.goals().saturating_add(2));
        match self.leg {
            Leg::First => 0,
            Leg::Second => first,
            Leg::Back => first.saturating_add(second),
        }
    }

    /// Returns how far the drone is, which it tells the others: the goals that it has reached, one
    /// more at its place in the formation, and another one behind the passage, with which the next part
    /// of the mission begins; or [`DOWN`]. A drone that flies over rows of lost ones has not reached its last
    /// goal.
    #[must_use]
    pub fn progress(&self) -> u16 {
        let goals = self.goals();
        let reached = match self.task {
            Task::Survey { reached, underway } => {
                reached.saturating_sub(u16::from(underway && reached == goals))
            }
            Task::Gather { held: 0, .. } => goals,
            Task::Gather { .. } | Task::Cross { out: false, .. } => goals + 1,
            Task::Cross { out: true, .. } | Task::Home => goals + 2,
            Task::Done => return DOWN,
        };
        self.begun().saturating_add(reached).min(DOWN - 1)
    }

    /// Says whether all for which the drone waits are as far in this part of the mission.
    pub(crate) fn ready(&self, reached: u16) -> bool {
        // As far as the others can tell it: no drone waits for more.
        let reached = self.begun().saturating_add(reached).min(DOWN - 1);
        self.team.all_reached(&self.config, reached)
    }

    /// Returns the goal of a drone that surveys and has reached so many: one of its own, or in a row of a
    /// lost drone.
    fn goal(&self, reached: u16) -> Point2 {
        let survey = self.survey();
        survey.goal(self.number, reached).unwrap_or_else(|| self.takeover.goal(survey))
    }

    /// Takes in what the drone at `here`, a position with an error of at most `error`, heard and sees
    /// in one round, and returns where it goes, with a step of at most `length`.
    pub fn step(
        &mut self,
        here: Point2,
        error: Metres,
        heard: impl IntoIterator<Item = Heard>,
        obstacles: &Obstacles,
        length: Metres,
    ) -> Point2 {
        self.error = error;
        self.team.hear(&self.config, here, heard);
        self.set_out(here);
        let end = match self.task {
            Task::Survey { reached, underway: true } => {
                let pulled = reached < self.goals() && self.is_whole();
                self.towards(here, self.goal(reached), obstacles, length, pulled)
            }
            Task::Gather { place, .. } => self.towards(here, place, obstacles, length, false),
            Task::Home => self.towards(here, self.home, obstacles, length, false),
            Task::Cross { pace, .. } => {
                let way = self.way_through(here, pace, obstacles);
                way.map_or(here, |way| self.guarded(here, way, obstacles, length))
            }
            Task::Survey { underway: false, .. } | Task::Done => here,
        };
        self.arrive(here, end);
        end
    }

    /// Begins the next task where the others are as far.
    fn set_out(&mut self, here: Point2) {
        let goals = self.goals();
        let task = self.task;
        self.task = match task {
            Task::Cross { out: true, pace } if self.is_through(here, pace) => {
                self.surveys_or_lands()
            }
            // A drone does not wait for the others before a row of a lost drone: those that fly over such a
            // row have not reached their last goals.
            Task::Survey { reached, underway: false }
                if reached == goals
                    && self.ready(goals.saturating_sub(1))
                    && self.takes_over(here) =>
            {
                Task::Survey { reached, underway: true }
            }
            Task::Survey { reached, underway: false } if self.ready(reached) => {
                if reached < goals {
                    Task::Survey { reached, underway: true }
                } else if self.leg == Leg::First {
                    Task::Gather { place: self.place(), held: 0 }
                } else {
                    Task::Done
                }
            }
            Task::Gather { held, .. }
                if self.is_late()
                    || held > 0 && (held > self.config.hold || self.ready(goals + 1)) =>
            {
                self.enter()
            }
            task => task,
        };
    }

    /// Says whether no drone of the swarm is taken for lost.
    fn is_whole(&self) -> bool {
        self.team.lost(&self.config).next().is_none()
    }

    /// Looks for a row that lost drones have left to this one, which is `here`; says whether there is one.
    fn takes_over(&mut self, here: Point2) -> bool {
        let (config, begun, survey) = (&self.config, self.begun(), *self.survey());
        let team = &self.team;
        let flying = team.flying(config);
        let drones = flying.clone().count() as u16;
        let me = flying.take_while(|number| *number < self.number).count() as u16;
        let is_left = |row| {
            team.lost(config).any(|(number, progress)| {
                let flown = progress.saturating_sub(begun) / 2;
                (flown..survey.goals() / 2).any(|sweep| survey.row(number, sweep) == row)
            })
        };
        self.takeover.next(&survey, (me, drones), here, is_left)
    }

    /// Counts what the drone has reached with a step from `start` to `here`.
    fn arrive(&mut self, start: Point2, here: Point2) {
        self.count_rounds_without_progress(start, here);
        let near = |goal: Point2| here.distance(goal) <= self.config.tolerance;
        self.task = match self.task {
            // Drones that wait for it in their formation may stand before an end of a row.
            Task::Survey { reached, underway: true }
                if reached == self.goals()
                    && self.still > self.config.hold
                    && !near(self.goal(reached))
                    && self.takeover.turn() =>
            {
                self.still = 0;
                Task::Survey { reached, underway: true }
            }
            Task::Survey { reached, underway: true }
                if near(self.goal(reached)) || self.is_kept_off(here, self.goal(reached)) =>
            {
                self.still = 0;
                if reached < self.goals() {
                    Task::Survey { reached: reached + 1, underway: false }
                } else {
                    Task::Survey { reached, underway: self.takeover.arrive() }
                }
            }
            Task::Gather { place, held }
                if held > 0 || near(place) || self.is_kept_off(here, place) =>
            {
                // Those that fly over the rows of lost drones are waited for.
                let waits = held == 0 || self.ready(self.goals());
                Task::Gather { place, held: held.saturating_add(u16::from(waits)) }
            }
            Task::Cross { pace, .. } => self.crossed(start, here, pace),
            // What a step that would end at home leaves is flown before the landing.
            Task::Home
                if start.distance(self.home) <= AT_HOME || self.is_kept_off(here, self.home) =>
            {
                Task::Done
            }
            task => task,
        };
    }

    /// Counts a round in which a drone came less than a quarter of a step nearer to its goal or its
    /// place.
    fn count_rounds_without_progress(&mut self, start: Point2, here: Point2) {
        let goal = match self.task {
            Task::Survey { reached, underway: true } => self.goal(reached),
            Task::Gather { place, held: 0 } => place,
            Task::Home => self.home,
            _ => return,
        };
        let nearer = start.distance(goal).0 - here.distance(goal).0;
        if nearer < 0.25 * self.config.longest_step.0 {
            self.still = self.still.saturating_add(1);
        }
    }

    /// Says whether a guarded drone at `here` is as near to its goal or place as it gets: two that were cut
    /// off from each other may have the same place, and an obstacle may stand at a goal. One that was held up
    /// lets go of links, and has some rounds more to come to its goal then.
    fn is_kept_off(&self, here: Point2, place: Point2) -> bool {
        let near = here.distance(place) < self.config.wanted_distance();
        let halves: u16 = if near { 3 } else { 8 };
        self.config.guard.is_some() && self.still > self.config.hold.saturating_mul(halves) / 2
    }

    /// Returns the formation of so many drones before the passage.
    pub(crate) fn formation(&self, drones: u16) -> Formation {
        Formation::fit(&self.config, self.plan.passage.width, drones)
    }

    /// Returns the drone's place in the formation of those that fly.
    fn place(&self) -> Point2 {
        let (config, plan) = (&self.config, &self.plan);
        let flying = self.team.flying(config);
        let drones = flying.clone().count() as u16;
        let me = flying.clone().take_while(|number| *number < self.number).count() as u16;
        let formation = self.formation(drones);
        let place = |index| formation.place(config, &plan.passage, index);
        match config.places {
            crate::Places::ByNumber => place(me),
            crate::Places::Exchanged => {
                let survey = self.survey();
                let last = survey.goals().saturating_sub(1);
                let starts = flying.map(|number| survey.goal(number, last).unwrap_or_default());
                place(exchanged::<N>(me, starts, place))
            }
        }
    }

    /// Returns where the drone goes that wants to be at `goal`. It is pushed away from neighbours,
    /// and with `pulled` also pulled towards them.
    fn towards(
        &self,
        here: Point2,
        goal: Point2,
        obstacles: &Obstacles,
        length: Metres,
        pulled: bool,
    ) -> Point2 {
        let left = here.distance(goal);
        let mut sum = Resultant::new(self.config.weight);
        sum.add(here, goal, left, attraction_to_goal(&self.config, left));
        let wanted = match self.task {
            Task::Gather { .. } => self.config.distance_in(self.formation(self.plan.drones)),
            Task::Home => self.config.safety_distance(),
            _ => self.config.wanted_distance(),
        };
        if left > self.config.straight_within {
            for other in self.team.neighbours() {
                let distance = here.distance(other.position);
                let force = between_drones(wanted, distance);
                let force = if pulled || force < 0.0 { force } else { 0.0 };
                sum.add(here, other.position, distance, force);
            }
        }
        let length = if self.config.stops_on_goals && left < length { left } else { length };
        sum.direction().map_or(here, |way| self.guarded(here, way, obstacles, length))
    }

    /// Returns the end of a step along `way` as far as the guard allows it.
    fn guarded(&self, here: Point2, way: Point2, obstacles: &Obstacles, length: Metres) -> Point2 {
        let config = &self.config;
        let Some(guard) = &config.guard else {
            return crate::geometry::moved(here, way, length.0);
        };
        let survey = matches!(self.task, Task::Survey { .. });
        // A drone that was cut off and came back may be a goal ahead of the others, or in their way.
        // It waits for them, so they neither keep their links to it for ever nor stand before it.
        let held_up = survey && self.is_held_up();
        // One that flies home, or over the rows of a lost drone, leaves the others, and all do that survey
        // without one: its row is a gap that is wider than a link is long. So does one in the
        // passage that got no farther for long: each of two on the sides of a pillar is kept by the other.
        let leaves = match self.task {
            Task::Survey { reached, .. } => reached == self.goals() || !self.is_whole(),
            Task::Cross { out: false, .. } => self.is_held_up(),
            task => task == Task::Home,
        };
        let lands = self.task == Task::Home;
        let lets_go_beyond = match (leaves, held_up) {
            (true, _) => 0,
            (false, true) => self.progress(),
            (false, false) => u16::MAX,
        };
        let others = self.team.neighbours().chain(self.team.landed());
        let turns = !survey || self.still > guard.blocked_rounds;
        Room::<N>::around(
            (here, self.error),
            config,
            guard,
            others,
            obstacles,
            (lets_go_beyond, lands),
        )
        .end(way, length, turns)
    }
}

//! Flies one drone of a swarm through the whole mission: the survey of the first area, the compact
//! formation before the passage, and the passage itself.

use units::{Metres, Point2};

use crate::force::{attraction_to_goal, between_drones};
use crate::formation::{Formation, exchanged};
use crate::geometry::along;
use crate::room::Room;
use crate::team::{Heard, Neighbour, Team};
use crate::{Config, Obstacles, Passage, Resultant, Survey, crossing};

/// What all drones of a swarm know before they set out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The number of drones.
    pub drones: u16,
    /// The goals in the first area.
    pub survey: Survey,
    /// The way to the second area.
    pub passage: Passage,
}

/// What a drone is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// It surveys the first area, and has reached so many goals.
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
        /// Whether it is in the second area.
        out: bool,
        /// How it gets on.
        pace: Pace,
    },
    /// All drones that it waits for are in the second area, and it is twice D_int beyond the exit,
    /// so that a drone which was taken for lost can still come out.
    Done,
}

/// How a drone gets on in a passage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// It goes ahead, but for so many rounds in which it got no farther.
    Ahead {
        /// Rounds without progress.
        blocked: u16,
    },
    /// It goes back for so many more rounds, so that a drone beside it can go first.
    Back {
        /// Rounds that are left.
        rounds: u16,
    },
}

/// One drone of a swarm of at most `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member<const N: usize> {
    config: Config,
    plan: Plan,
    number: u16,
    task: Task,
    team: Team<N>,
    /// The rounds on the way to this goal or place in which the drone came no nearer to it.
    still: u16,
    /// The largest error of the drone's own position in this round.
    error: Metres,
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
            task,
            team: Team::new(number, plan.drones),
            still: 0,
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

    /// Returns how far the drone is, which it tells the others: the goals that it has reached, one
    /// more at its place in the formation, and another one in the second area.
    #[must_use]
    pub fn progress(&self) -> u16 {
        let goals = self.plan.survey.goals();
        match self.task {
            Task::Survey { reached, .. } => reached,
            Task::Gather { held: 0, .. } => goals,
            Task::Gather { .. } | Task::Cross { out: false, .. } => goals + 1,
            Task::Cross { out: true, .. } | Task::Done => goals + 2,
        }
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
        self.set_out();
        let end = match self.task {
            Task::Survey { reached, underway: true } => {
                let goal = self.plan.survey.goal(self.number, reached);
                goal.map_or(here, |goal| self.towards(here, goal, obstacles, length, true))
            }
            Task::Gather { place, .. } => self.towards(here, place, obstacles, length, false),
            Task::Cross { pace, .. } => {
                let way = self.way_through(here, pace, obstacles);
                way.map_or(here, |way| self.guarded(here, way, obstacles, length))
            }
            Task::Survey { underway: false, .. } | Task::Done => here,
        };
        self.arrive(here, end);
        end
    }

    /// Begins the next part of the mission where the others are as far.
    fn set_out(&mut self) {
        let goals = self.plan.survey.goals();
        let ready = |progress| self.team.all_reached(&self.config, progress);
        self.task = match self.task {
            Task::Survey { reached, underway: false } if ready(reached) => {
                if reached < goals {
                    Task::Survey { reached, underway: true }
                } else {
                    Task::Gather { place: self.place(), held: 0 }
                }
            }
            Task::Gather { held, .. }
                if self.is_late() || held > 0 && (held > self.config.hold || ready(goals + 1)) =>
            {
                Task::Cross { out: false, pace: Pace::Ahead { blocked: 0 } }
            }
            task => task,
        };
    }

    /// Says whether a guarded drone on the way to its place has a neighbour in the passage: it follows
    /// that one then, which keeps its link and so cannot go far ahead of it.
    fn is_late(&self) -> bool {
        let Passage { entrance, way, .. } = self.plan.passage;
        let inside = |other: Neighbour| along(way, entrance, other.position) > 0.0;
        self.config.guard.is_some() && self.team.neighbours().any(inside)
    }

    /// Counts what the drone has reached with a step from `start` to `here`.
    fn arrive(&mut self, start: Point2, here: Point2) {
        self.count_rounds_without_progress(start, here);
        let near = |goal: Point2| here.distance(goal) <= self.config.tolerance;
        self.task = match self.task {
            Task::Survey { reached, underway: true }
                if self.plan.survey.goal(self.number, reached).is_some_and(near) =>
            {
                self.still = 0;
                Task::Survey { reached: reached + 1, underway: false }
            }
            Task::Gather { place, held }
                if held > 0 || near(place) || self.is_kept_off(here, place) =>
            {
                Task::Gather { place, held: held.saturating_add(1) }
            }
            Task::Cross { pace, .. } => {
                let Passage { entrance, way, length, .. } = self.plan.passage;
                let beyond = along(way, entrance, here) - length.0;
                let exit = 2.0 * self.config.wanted_distance().0;
                if beyond > exit && self.all_out() {
                    Task::Done
                } else {
                    let pace = self.next_pace(pace, here, along(way, start, here));
                    Task::Cross { out: beyond > self.error.0, pace }
                }
            }
            task => task,
        };
    }

    /// Counts a round in which a drone came less than a quarter of a step nearer to its goal or its
    /// place.
    fn count_rounds_without_progress(&mut self, start: Point2, here: Point2) {
        let goal = match self.task {
            Task::Survey { reached, underway: true } => self.plan.survey.goal(self.number, reached),
            Task::Gather { place, held: 0 } => Some(place),
            _ => None,
        };
        let nearer = |goal: Point2| start.distance(goal).0 - here.distance(goal).0;
        if goal.is_some_and(|goal| nearer(goal) < 0.25 * self.config.longest_step.0) {
            self.still = self.still.saturating_add(1);
        }
    }

    /// Says whether a guarded drone at `here` is as near to its place as it gets: two that were cut
    /// off from each other may have the same place.
    fn is_kept_off(&self, here: Point2, place: Point2) -> bool {
        self.config.guard.is_some()
            && self.still > self.config.hold
            && here.distance(place) < self.config.wanted_distance()
    }

    fn all_out(&self) -> bool {
        self.team.all_reached(&self.config, self.plan.survey.goals() + 2)
    }

    /// Returns the direction of a drone in the passage.
    fn way_through(&self, here: Point2, pace: Pace, obstacles: &Obstacles) -> Option<Point2> {
        let (config, passage) = (&self.config, &self.plan.passage);
        let others = self.team.neighbours().map(|other| other.position);
        match pace {
            Pace::Ahead { .. } => {
                let formation = self.formation(self.plan.drones);
                crossing::direction(config, passage, formation, here, others, obstacles)
            }
            Pace::Back { .. } => Some(Point2::new(-passage.way.x, -passage.way.y)),
        }
    }

    /// Returns how a drone at `here` gets on after a step that brought it `farther` ahead, in
    /// metres. A guarded drone that gets no farther goes back where another one is beside it and
    /// slightly ahead: without that, two drones before a narrow place wait for each other.
    fn next_pace(&self, pace: Pace, here: Point2, farther: f32) -> Pace {
        let Some(guard) = &self.config.guard else {
            return pace;
        };
        let beside = |other: Neighbour| {
            let ahead = along(self.plan.passage.way, here, other.position);
            let first = ahead > 0.0 || (ahead == 0.0 && other.number < self.number);
            let near = here.distance(other.position).0 < 2.0 * guard.drones.0;
            first && near && ahead < guard.drones.0
        };
        match pace {
            Pace::Back { rounds } if rounds > 1 => Pace::Back { rounds: rounds - 1 },
            Pace::Ahead { blocked } if farther < 0.25 * self.config.longest_step.0 => {
                let yields = blocked >= guard.blocked_rounds && self.team.neighbours().any(beside);
                if yields {
                    Pace::Back { rounds: guard.back_rounds }
                } else {
                    Pace::Ahead { blocked: blocked.saturating_add(1) }
                }
            }
            Pace::Ahead { .. } | Pace::Back { .. } => Pace::Ahead { blocked: 0 },
        }
    }

    /// Returns the formation of so many drones before the passage.
    fn formation(&self, drones: u16) -> Formation {
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
                let last = plan.survey.goals().saturating_sub(1);
                let starts =
                    flying.map(|number| plan.survey.goal(number, last).unwrap_or_default());
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
        let held_up = survey && self.still > self.config.hold;
        let lets_go_beyond = if held_up { self.progress() } else { u16::MAX };
        let others = self.team.neighbours();
        let turns = !survey || self.still > guard.blocked_rounds;
        Room::<N>::around((here, self.error), config, guard, others, obstacles, lets_go_beyond)
            .end(way, length, turns)
    }
}

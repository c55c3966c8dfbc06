//! Remembers what a drone has heard of the others of its swarm.

use units::{Metres, Point2};

use crate::member::DOWN;
use crate::{Config, Wait};

/// What a drone hears of another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// The number of the other drone, from 0.
    pub number: u16,
    /// Where the other drone is.
    pub position: Point2,
    /// The largest error of that position.
    pub error: Metres,
    /// Over how many hops it is heard; 1 is a drone in radio range itself.
    pub hops: u16,
    /// How far it is in the mission: [`crate::Member::progress`].
    pub progress: u16,
}

/// A drone as another one remembers it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Record {
    last: Option<Heard>,
    /// The round in which it was heard, or 0.
    round: u32,
}

/// What one drone remembers of a swarm of at most `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Team<const N: usize> {
    records: [Record; N],
    drones: u16,
    me: u16,
    /// The rounds since the mission began.
    round: u32,
    /// The numbers of the drones that were in radio range when they were last heard.
    near: [u16; N],
    near_count: usize,
}

/// A neighbour in radio range, and the rounds since it was heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbour {
    pub(crate) number: u16,
    pub(crate) position: Point2,
    pub(crate) error: Metres,
    pub(crate) progress: u16,
    pub(crate) age: u16,
}

impl<const N: usize> Team<N> {
    /// Returns the memory of drone `me` of `drones`, which has heard of none so far.
    pub(crate) fn new(me: u16, drones: u16) -> Self {
        let records = [Record { last: None, round: 0 }; N];
        Self { records, drones, me, round: 0, near: [0; N], near_count: 0 }
    }

    fn records(&self) -> &[Record] {
        self.records.get(..usize::from(self.drones)).unwrap_or(&self.records)
    }

    /// Takes in what the drone at `here` heard in one round. A drone in radio range of which only
    /// others pass on the news, because its own packet was lost, is a neighbour like one that is
    /// heard itself.
    pub(crate) fn hear(
        &mut self,
        config: &Config,
        here: Point2,
        heard: impl IntoIterator<Item = Heard>,
    ) {
        self.round = self.round.wrapping_add(1);
        let (before, before_count) = (self.near, self.near_count);
        self.near_count = 0;
        for other in heard {
            if let Some(record) = self.records.get_mut(usize::from(other.number)) {
                *record = Record { last: Some(other), round: self.round };
                if other.hops == 1 || here.distance(other.position) <= config.radio_range {
                    self.add_near(other.number);
                }
            }
        }
        for number in before.into_iter().take(before_count) {
            let Some(record) = self.records.get(usize::from(number)) else { continue };
            if record.round != self.round && self.age(record) <= Self::memory(config) {
                self.add_near(number);
            }
        }
    }

    fn add_near(&mut self, number: u16) {
        if let Some(slot) = self.near.get_mut(self.near_count) {
            *slot = number;
            self.near_count += 1;
        }
    }

    /// Returns the rounds since a drone was heard, or since the mission began.
    fn age(&self, record: &Record) -> u16 {
        u16::try_from(self.round.wrapping_sub(record.round)).unwrap_or(u16::MAX)
    }

    /// Returns how many rounds a drone is remembered.
    fn memory(config: &Config) -> u16 {
        match config.wait {
            Wait::Neighbours => 0,
            Wait::Team(rounds) => rounds,
        }
    }

    /// Returns the neighbours in the air that were in radio range when they were last heard.
    pub(crate) fn neighbours(&self) -> impl Iterator<Item = Neighbour> + Clone {
        self.near.iter().take(self.near_count).filter_map(|number| {
            let record = self.records.get(usize::from(*number))?;
            let Heard { number, position, error, progress, .. } = record.last?;
            let age = self.age(record);
            (progress != DOWN).then_some(Neighbour { number, position, error, progress, age })
        })
    }

    /// Returns the drones that have landed, wherever they are.
    pub(crate) fn landed(&self) -> impl Iterator<Item = Neighbour> {
        let heard = self.records().iter().filter_map(|record| record.last);
        heard.filter(|last| last.progress == DOWN).map(|last| {
            let Heard { number, position, error, progress, .. } = last;
            Neighbour { number, position, error, progress, age: 0 }
        })
    }

    /// Says whether all for which the drone waits are as far as `progress`.
    pub(crate) fn all_reached(&self, config: &Config, progress: u16) -> bool {
        match config.wait {
            Wait::Neighbours => self
                .records()
                .iter()
                .filter(|record| record.round == self.round)
                .filter_map(|record| record.last)
                .all(|other| other.hops > 2 || other.progress >= progress),
            Wait::Team(_) => (0..self.drones).zip(self.records()).all(|(number, record)| {
                let reached = record.last.is_some_and(|last| last.progress >= progress);
                number == self.me || reached || self.age(record) > Self::memory(config)
            }),
        }
    }

    /// Returns the numbers of the drones that fly, in their order, this one among them: all but
    /// those that are taken for lost.
    pub(crate) fn flying(&self, config: &Config) -> impl Iterator<Item = u16> + Clone {
        let (memory, me) = (Self::memory(config), self.me);
        let remembers = matches!(config.wait, Wait::Team(_));
        (0..self.drones).zip(self.records()).filter_map(move |(number, record)| {
            (number == me || !remembers || self.age(record) <= memory).then_some(number)
        })
    }

    /// Returns the numbers of the drones that are taken for lost, and how far each was when it was last
    /// heard.
    pub(crate) fn lost(&self, config: &Config) -> impl Iterator<Item = (u16, u16)> {
        let (memory, me) = (Self::memory(config), self.me);
        let remembers = matches!(config.wait, Wait::Team(_));
        (0..self.drones).zip(self.records()).filter_map(move |(number, record)| {
            let progress = record.last.map_or(0, |last| last.progress);
            (number != me && remembers && self.age(record) > memory).then_some((number, progress))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);

    fn heard(hops: u16, progress: u16) -> Heard {
        let position = Point2::new(0.75, 0.0);
        Heard { number: 1, position, error: Metres(0.0), hops, progress }
    }

    #[test]
    fn a_drone_waits_for_those_at_two_hops() {
        let mut team = Team::<4>::new(0, 2);
        team.hear(&Config::PAPER, HERE, [heard(2, 2)]);
        assert!(team.all_reached(&Config::PAPER, 2));
        assert!(!team.all_reached(&Config::PAPER, 3));
        team.hear(&Config::PAPER, HERE, [heard(3, 2)]);
        assert!(team.all_reached(&Config::PAPER, 3));
    }

    #[test]
    fn a_neighbour_whose_packet_was_lost_stays_a_neighbour() {
        let mut team = Team::<4>::new(0, 2);
        team.hear(&Config::OURS, HERE, [heard(1, 0)]);
        team.hear(&Config::OURS, HERE, [heard(2, 0)]);
        assert_eq!(team.neighbours().map(|other| other.age).next(), Some(0));
        team.hear(&Config::OURS, HERE, []);
        assert_eq!(team.neighbours().map(|other| other.age).next(), Some(1));
    }

    #[test]
    fn a_team_waits_for_a_drone_that_is_not_heard_until_it_is_taken_for_lost() {
        let mut team = Team::<4>::new(0, 2);
        team.hear(&Config::OURS, HERE, [heard(1, 1)]);
        assert!(team.all_reached(&Config::OURS, 1) && !team.all_reached(&Config::OURS, 2));
        for _ in 0..50 {
            team.hear(&Config::OURS, HERE, []);
            assert!(!team.all_reached(&Config::OURS, 2));
        }
        team.hear(&Config::OURS, HERE, []);
        assert!(team.all_reached(&Config::OURS, 2));
        assert_eq!(team.flying(&Config::OURS).count(), 1);
        team.hear(&Config::OURS, HERE, [heard(1, 1)]);
        assert!(!team.all_reached(&Config::OURS, 2), "heard again, it is waited for again");
    }
}

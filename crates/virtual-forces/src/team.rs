//! Remembers what a drone has heard of the others of its swarm.

use units::Point2;

use crate::{Config, Wait};

/// What a drone hears of another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// The number of the other drone, from 0.
    pub number: u16,
    /// Where the other drone is.
    pub position: Point2,
    /// Over how many hops it is heard; 1 is a drone in radio range itself.
    pub hops: u16,
    /// How far it is in the mission: [`crate::Member::progress`].
    pub progress: u16,
}

/// A drone as another one remembers it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Record {
    last: Option<Heard>,
    /// Rounds since it was heard, or since the mission began.
    age: u16,
}

/// What one drone remembers of a swarm of at most `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Team<const N: usize> {
    records: [Record; N],
    drones: u16,
    me: u16,
}

/// A neighbour in radio range, and the rounds since it was heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbour {
    pub(crate) number: u16,
    pub(crate) position: Point2,
    pub(crate) age: u16,
}

impl<const N: usize> Team<N> {
    /// Returns the memory of drone `me` of `drones`, which has heard of none so far.
    pub(crate) fn new(me: u16, drones: u16) -> Self {
        Self { records: [Record { last: None, age: 0 }; N], drones, me }
    }

    fn records(&self) -> &[Record] {
        self.records.get(..usize::from(self.drones)).unwrap_or(&self.records)
    }

    /// Takes in what was heard in one round.
    pub(crate) fn hear(&mut self, heard: impl IntoIterator<Item = Heard>) {
        for record in self.records.iter_mut().take(usize::from(self.drones)) {
            record.age = record.age.saturating_add(1);
        }
        for other in heard {
            if let Some(record) = self.records.get_mut(usize::from(other.number)) {
                *record = Record { last: Some(other), age: 0 };
            }
        }
    }

    /// Returns how many rounds a drone is remembered.
    fn memory(config: &Config) -> u16 {
        match config.wait {
            Wait::Neighbours => 0,
            Wait::Team(rounds) => rounds,
        }
    }

    /// Returns the neighbours that were in radio range when they were last heard.
    pub(crate) fn neighbours(&self, config: &Config) -> impl Iterator<Item = Neighbour> + Clone {
        let memory = Self::memory(config);
        self.records().iter().filter(move |record| record.age <= memory).filter_map(|record| {
            record.last.filter(|last| last.hops == 1).map(|last| Neighbour {
                number: last.number,
                position: last.position,
                age: record.age,
            })
        })
    }

    /// Says whether all for which the drone waits are as far as `progress`.
    pub(crate) fn all_reached(&self, config: &Config, progress: u16) -> bool {
        match config.wait {
            Wait::Neighbours => self
                .records()
                .iter()
                .filter(|record| record.age == 0)
                .filter_map(|record| record.last)
                .all(|other| other.hops > 2 || other.progress >= progress),
            Wait::Team(_) => (0..self.drones).zip(self.records()).all(|(number, record)| {
                let reached = record.last.is_some_and(|last| last.progress >= progress);
                number == self.me || reached || record.age > Self::memory(config)
            }),
        }
    }

    /// Returns the numbers of the drones that fly, in their order, this one among them: all but
    /// those that are taken for lost.
    pub(crate) fn flying(&self, config: &Config) -> impl Iterator<Item = u16> + Clone {
        let (memory, me) = (Self::memory(config), self.me);
        let remembers = matches!(config.wait, Wait::Team(_));
        (0..self.drones).zip(self.records()).filter_map(move |(number, record)| {
            (number == me || !remembers || record.age <= memory).then_some(number)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(hops: u16, progress: u16) -> Heard {
        Heard { number: 1, position: Point2::new(0.75, 0.0), hops, progress }
    }

    #[test]
    fn a_drone_waits_for_those_at_two_hops() {
        let mut team = Team::<4>::new(0, 2);
        team.hear([heard(2, 2)]);
        assert!(team.all_reached(&Config::PAPER, 2));
        assert!(!team.all_reached(&Config::PAPER, 3));
        team.hear([heard(3, 2)]);
        assert!(team.all_reached(&Config::PAPER, 3));
    }

    #[test]
    fn a_team_waits_for_a_drone_that_is_not_heard_until_it_is_taken_for_lost() {
        let mut team = Team::<4>::new(0, 2);
        team.hear([heard(1, 1)]);
        assert!(team.all_reached(&Config::OURS, 1) && !team.all_reached(&Config::OURS, 2));
        for _ in 0..50 {
            team.hear([]);
            assert!(!team.all_reached(&Config::OURS, 2));
        }
        team.hear([]);
        assert!(team.all_reached(&Config::OURS, 2));
        assert_eq!(team.flying(&Config::OURS).count(), 1);
        team.hear([heard(1, 1)]);
        assert!(!team.all_reached(&Config::OURS, 2), "heard again, it is waited for again");
    }
}

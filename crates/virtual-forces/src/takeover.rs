//! Chooses the rows of lost drones that a drone flies over when it has surveyed its own.

use units::Point2;

use crate::Survey;

/// The rows of lost drones that one of those which still fly takes over, in ascending order. Of the rows
/// that are left each drone takes those whose number, divided by the number of drones, leaves its place
/// among them: which rows are whose then depends on nothing but who is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Takeover {
    /// The row that is flown over, or the first that was not looked at.
    row: u16,
    /// The end of the row to which the drone goes.
    far: bool,
    /// Whether the drone has been at the other end.
    is_second: bool,
    /// Whether the drone was kept off one end, and so went to the other one first.
    has_turned: bool,
    /// The number of drones among which the rows were shared out.
    drones: u16,
    /// The rows that were flown over, a bit each: where drones are lost and come back again and again, a
    /// drone flies over none of them twice.
    flown: [u32; ROWS.div_ceil(32)],
}

/// The most rows that are taken over: those of an area of 100 m.
const ROWS: usize = 134;

impl Takeover {
    /// No row was taken over.
    pub(crate) const NONE: Self = Self {
        row: 0,
        far: false,
        is_second: false,
        has_turned: false,
        drones: 0,
        flown: [0; ROWS.div_ceil(32)],
    };

    /// Looks for the next row of drone `me` of `drones`, which is `here`, among those that are left; says
    /// whether there is one. When drones were lost or came back since the last row, all rows are looked at
    /// anew.
    pub(crate) fn next(
        &mut self,
        survey: &Survey,
        (me, drones): (u16, u16),
        here: Point2,
        is_left: impl Fn(u16) -> bool,
    ) -> bool {
        if drones != self.drones {
            *self = Self { drones, flown: self.flown, ..Self::NONE };
        }
        let bit = |row: &u16| 1 << (row % 32);
        let is_new = |row: &u16| {
            self.flown.get(usize::from(row / 32)).is_some_and(|flown| flown & bit(row) == 0)
        };
        let mine = |row: &u16| row.checked_rem(drones) == Some(me) && is_new(row) && is_left(*row);
        let Some(row) = (self.row..survey.rows()).find(mine) else { return false };
        let [near, far] = [false, true].map(|far| here.distance(survey.end(row, far)));
        *self = Self {
            row,
            far: far < near,
            is_second: false,
            has_turned: false,
            drones,
            flown: self.flown,
        };
        true
    }

    /// Returns the number of the row that is flown over.
    pub(crate) const fn row(&self) -> u16 {
        self.row
    }

    /// Returns the end of the row to which the drone goes.
    pub(crate) fn goal(&self, survey: &Survey) -> Point2 {
        survey.end(self.row, self.far)
    }

    /// Sends a drone that others keep off the first end to the other one, once for each row; says whether it
    /// does.
    pub(crate) fn turn(&mut self) -> bool {
        let turns = !self.is_second && !self.has_turned;
        if turns {
            (self.far, self.has_turned) = (!self.far, true);
        }
        turns
    }

    /// Notes that the drone is at the end to which it went; says whether the other one is still to be
    /// flown to.
    pub(crate) fn arrive(&mut self) -> bool {
        let Self { row, far, is_second, flown, .. } = self;
        (*far, *is_second) = (!*far, !*is_second);
        if !*is_second {
            if let Some(flown) = flown.get_mut(usize::from(*row / 32)) {
                *flown |= 1 << (*row % 32);
            }
            *row += 1;
        }
        *is_second
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use units::Metres;

    use super::*;
    use crate::Config;

    /// Drones that were lost and came back again and again had the others fly over the same rows for ever.
    #[test]
    fn no_row_is_flown_over_twice_when_the_number_of_drones_changes() {
        let area = (Metres(9.0), Metres(7.5));
        let survey = Survey::new(&Config::OURS, Point2::default(), area, 4);
        let mut takeover = Takeover::NONE;
        let mut flown = 0;
        for drones in [1, 2].into_iter().cycle().take(100) {
            let here = Point2::default();
            if takeover.next(&survey, (0, drones), here, |row| row < 4) {
                assert!(takeover.arrive() && !takeover.arrive());
                flown += 1;
            }
        }
        assert_eq!(flown, 4);
    }

    #[test]
    fn every_row_that_is_left_is_flown_over_by_one_of_those_that_fly() {
        let area = (Metres(9.0), Metres(7.5));
        let survey = Survey::new(&Config::OURS, Point2::default(), area, 4);
        let left = [1, 2, 5, 9];
        for drones in 1..4 {
            let mut flown = Vec::new();
            for me in 0..drones {
                let mut takeover = Takeover::NONE;
                let here = Point2::new(9.0, 7.5);
                while takeover.next(&survey, (me, drones), here, |row| left.contains(&row)) {
                    let first = takeover.goal(&survey);
                    assert!(takeover.arrive(), "the other end");
                    let second = takeover.goal(&survey);
                    assert!(here.distance(first) < here.distance(second));
                    flown.push(takeover.row);
                    assert!(!takeover.arrive(), "the row is flown over");
                }
            }
            flown.sort_unstable();
            assert_eq!(flown, left, "{drones} drones");
        }
    }
}

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
    /// The number of drones among which the rows were shared out.
    drones: u16,
}

impl Takeover {
    /// No row was taken over.
    pub(crate) const NONE: Self = Self { row: 0, far: false, is_second: false, drones: 0 };

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
            *self = Self { drones, ..Self::NONE };
        }
        let mine = |row: &u16| row.checked_rem(drones) == Some(me) && is_left(*row);
        let Some(row) = (self.row..survey.rows()).find(mine) else { return false };
        let [near, far] = [false, true].map(|far| here.distance(survey.end(row, far)));
        *self = Self { row, far: far < near, is_second: false, drones };
        true
    }

    /// Returns the end of the row to which the drone goes.
    pub(crate) fn goal(&self, survey: &Survey) -> Point2 {
        survey.end(self.row, self.far)
    }

    /// Notes that the drone is at the end to which it went; says whether the other one is still to be
    /// flown to.
    pub(crate) fn arrive(&mut self) -> bool {
        let Self { row, far, is_second, .. } = self;
        (*far, *is_second) = (!*far, !*is_second);
        if !*is_second {
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

//! Lays the goals of a survey in rows over an area.

use units::{Metres, Point2};

use crate::{Config, Rows, Sweep};

/// The mesh over one area (section 4.1 of the paper) for a swarm of a certain size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    corner: Point2,
    cell: Metres,
    rows: u16,
    far: Metres,
    drones: u16,
    sweep: Sweep,
    /// Whether the rows run along the area's length.
    across: bool,
}

impl Survey {
    /// Lays rows of D_int over an area from its `corner`, `length` along x and `width` along y. They
    /// run along y, or along x where that is the shorter way and [`Rows::Shortest`] is wanted. What
    /// remains beyond whole rows is not covered.
    #[must_use]
    pub fn new(
        config: &Config,
        corner: Point2,
        (length, width): (Metres, Metres),
        drones: u16,
    ) -> Self {
        let cell = config.wanted_distance();
        let drones = drones.max(1);
        let lay = |stacked: Metres, run: Metres, across| Self {
            corner,
            cell,
            // A thousandth of a row, so that rounding never loses the last one.
            rows: libm::floorf(stacked.0 / cell.0 + 1e-3) as u16,
            far: Metres((run.0 - 0.5 * cell.0).max(0.5 * cell.0)),
            drones,
            sweep: config.sweep,
            across,
        };
        let (upright, across) = (lay(length, width, false), lay(width, length, true));
        let shorter = across.way() < upright.way() && across.rows >= drones;
        if config.rows == Rows::Shortest && shorter { across } else { upright }
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> u16 {
        self.rows
    }

    /// Returns the number of goals of each drone, at most 65,532, so that a drone can count two
    /// more.
    #[must_use]
    pub fn goals(&self) -> u16 {
        self.rows.div_ceil(self.drones.max(1)).min(32_766) * 2
    }

    /// Returns the way of one drone from its first goal to its last one, with shifted sweeps.
    #[must_use]
    pub fn way(&self) -> Metres {
        let legs = f32::from(self.goals() / 2) * (self.far.0 - 0.5 * self.cell.0);
        Metres(legs + f32::from(self.rows.saturating_sub(self.drones)) * self.cell.0)
    }

    /// Returns the goal number `index` of drone `place` (from 0), or nothing after the last one.
    /// Goals are the two ends of a row in turn.
    #[must_use]
    pub fn goal(&self, place: u16, index: u16) -> Option<Point2> {
        let sweep = index / 2;
        let far = (sweep % 2 == 1) != (index % 2 == 1);
        (index < self.goals()).then(|| self.end(self.row(place, sweep), far))
    }

    /// Returns the row of drone `place` in a sweep. Sweep k of the swarm covers the rows from k times
    /// the number of drones on; the last sweep is shifted back onto the last rows.
    pub(crate) fn row(&self, place: u16, sweep: u16) -> u16 {
        let last = self.rows.saturating_sub(self.drones);
        let within = match self.sweep {
            Sweep::Mirror if sweep % 2 == 1 => self.drones.saturating_sub(1).saturating_sub(place),
            Sweep::Mirror | Sweep::Shift => place,
        };
        sweep.saturating_mul(self.drones).min(last).saturating_add(within)
    }

    /// Returns an end of a row, the far or the near one.
    pub(crate) fn end(&self, row: u16, far: bool) -> Point2 {
        let stacked = (f32::from(row) + 0.5) * self.cell.0;
        let run = if far { self.far.0 } else { 0.5 * self.cell.0 };
        let (x, y) = if self.across { (run, stacked) } else { (stacked, run) };
        Point2::new(self.corner.x + x, self.corner.y + y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: (Metres, Metres) = (Metres(9.0), Metres(7.5));

    #[test]
    fn every_row_is_flown_over_from_end_to_end() {
        for config in [Config::PAPER, Config { sweep: Sweep::Mirror, ..Config::PAPER }] {
            for drones in 1..=12 {
                let survey = Survey::new(&config, Point2::default(), AREA, drones);
                for row in 0..survey.rows() {
                    let x = (f32::from(row) + 0.5) * 0.75;
                    let flown = (0..drones).any(|place| {
                        (0..survey.rows()).any(|sweep| {
                            let ends =
                                [2 * sweep, 2 * sweep + 1].map(|index| survey.goal(place, index));
                            matches!(ends, [Some(a), Some(b)] if a.x == x && b.x == x && a.y != b.y)
                        })
                    });
                    assert!(flown, "row {row} of {drones} drones");
                }
            }
        }
    }

    #[test]
    fn five_drones_fly_along_the_length_in_two_sweeps() {
        let goals = |drones| Survey::new(&Config::OURS, Point2::default(), AREA, drones).goals();
        assert_eq!([4, 5, 6].map(goals), [6, 4, 4]);
    }

    #[test]
    fn an_area_without_bounds_has_goals_that_can_be_counted() {
        let endless = (Metres(f32::INFINITY), Metres(7.5));
        let survey = Survey::new(&Config::PAPER, Point2::default(), endless, 1);
        assert_eq!(survey.goals(), 65_532);
        let none = (Metres(f32::NAN), Metres(-1.0));
        assert_eq!(Survey::new(&Config::OURS, Point2::default(), none, 3).goals(), 0);
    }

    #[test]
    fn the_way_is_the_sum_of_the_ways_between_goals() {
        for drones in 1..=6 {
            let survey = Survey::new(&Config::OURS, Point2::new(-9.0, 2.0), AREA, drones);
            let goals = (0..survey.goals()).filter_map(|index| survey.goal(0, index));
            let way: f32 = goals.clone().zip(goals.skip(1)).map(|(a, b)| a.distance(b).0).sum();
            assert!((way - survey.way().0).abs() < 1e-3, "{drones} drones: {way}");
        }
    }
}

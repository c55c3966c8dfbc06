//! Finds the place of a drone on its path again, wherever on the path near by that is.
//!
//! From round to round the place is looked for only among the next crumbs, as a path may pass close to itself. A
//! drone that has stood before a wall on its way home may be beside a crumb that is farther along the path, and
//! the path is still the best that the drone knows of the way.

use super::{KEPT_HOME, Trail};
use crate::plane::{dot, minus};

/// The place is looked for so many crumbs homeward, 10 m, …
const FARTHEST_HOMEWARD: i32 = 50;
/// … and so many ahead, 2 m. Both are our own numbers, as the next one.
const FARTHEST_AHEAD: i32 = 10;
/// A path with fewer crumbs homeward than this does not tell where home is: 1 m.
const TELLS: i32 = 5;

impl Trail {
    /// Finds the place of a drone on its way home that has looked round: it is at the crumb next to the drone.
    /// Where no crumb is within [`KEPT_HOME`] of the drone, or the path begins within 1 m of that crumb, the
    /// path is forgotten and begins anew.
    pub(crate) fn rejoin(&mut self) {
        let from = self.near.saturating_sub(FARTHEST_HOMEWARD).max(self.first);
        let to = self.near.saturating_add(FARTHEST_AHEAD).min(self.last);
        let distances = (from..=to).map(|number| {
            let off = minus(self.crumb(number).at, self.at);
            (number, dot(off, off))
        });
        let nearest = distances.min_by(|(_, a), (_, b)| a.total_cmp(b));
        match nearest {
            Some((number, square))
                if square <= KEPT_HOME * KEPT_HOME && number - self.first > TELLS =>
            {
                self.turned_at = None;
                (self.near, self.part) = (number, 0.0);
            }
            _ => self.forget(),
        }
    }
}

#[cfg(test)]
mod tests {
    use units::Radians;

    use super::*;
    use crate::trail::Flies;

    /// The path of a drone that has flown east for so many metres, with a crumb each 0.2 m.
    fn straight(metres: i32) -> Trail {
        let mut trail = Trail::new();
        for _ in 0..20 * metres {
            trail.advance([0.05, 0.0], Radians(0.0), Flies::NoseFirst);
        }
        trail
    }

    #[test]
    fn a_drone_that_has_looked_round_keeps_the_path_that_leads_home() {
        let mut trail = straight(10);
        trail.at = [6.0, 0.9];
        trail.rejoin();
        assert!(trail.knows(-5.0) && trail.knows(3.0));
        assert!((trail.off(0.0).0).abs() < 0.01);
    }

    #[test]
    fn a_drone_that_is_far_from_its_path_or_at_its_beginning_forgets_it() {
        for at in [[6.0, 2.5], [0.3, 0.0]] {
            let mut trail = straight(10);
            trail.at = at;
            trail.near = 20;
            trail.rejoin();
            assert!(!trail.knows(-0.5) && !trail.knows(0.5), "{at:?}");
        }
    }
}

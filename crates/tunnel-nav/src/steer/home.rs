//! Leads a drone that flies home back to the path by which it came.
//!
//! Walls lead the drone well where it sees one on each side. In a wide gallery, at a junction and in a room it
//! does not, and there a wall ahead may turn it to where it has not been. Where the path is old and walls would
//! lead, the tail is pointed to a place on it, which is known by dead reckoning. So it is near the end of the
//! path, where the nose was turned on the spot and its heading leads elsewhere, and wherever the drone has come off
//! its path.

use units::MetresPerSecond;

use super::{Bearings, HOVERING, NEAR_END, Navigator, Walls};
use crate::plane::wrapped;

/// The path leads elsewhere than its headings say where the directions differ by more than this, rad: the drone
/// turned at the end of its path, and flew on no farther. Our own number.
const ELSEWHERE: f32 = 1.5;
/// A drone that is farther beside its path than this, m, is not where the headings of the path were flown: at a
/// junction, walls would lead it into the other gallery. Our own number, as `OLD` of the trail: in 1200 drawn places
/// (seeds from 500,000, 560,000 and 620,000) with this one, 4 m for 10 m there and 3 m for 1.7 m of the way beside the
/// path, 1010 missions ended with all drones home, in order and without a touch, where 987 had before. In 400 others
/// (from 2,330,000) no difference can be told: 365 came home whole, for 363, and 28 had a touch, for 25.
const BESIDE_PATH: f32 = 0.5;

impl Navigator {
    /// The angle by which the nose of a drone on its way home is off so that the tail points to its path. It is
    /// `None` where the walls or the headings of the path lead: `off` is the angle by these, or `None` where the
    /// walls decide. It is also `None` while the drone looks round, and without a heading.
    pub(super) fn off_home(
        &self,
        walls: Walls,
        off: Option<f32>,
        bearings: &Bearings,
        speed: MetresPerSecond,
    ) -> Option<f32> {
        bearings.known_heading()?;
        if speed.0 >= -HOVERING || !self.fork.is_homing() || self.scan.is_on() {
            return None;
        }
        let leads = |home: &f32| match off {
            Some(off) => {
                let is_beside = walls != Walls::Both && self.trail.aside().abs() > BESIDE_PATH;
                is_beside
                    || self.trail.is_near_end(NEAR_END) && wrapped(home - off).abs() > ELSEWHERE
            }
            None => self.trail.is_old() && !self.fork.is_chosen() && walls != Walls::Both,
        };
        self.trail.pursues().map(|home| home.0).filter(leads)
    }
}

#[cfg(test)]
mod tests {
    use units::{Metres, Radians};

    use super::*;
    use crate::trail::Flies;
    use crate::{Guide, Homing};

    const BACK: MetresPerSecond = MetresPerSecond(-0.2);
    const EAST: Bearings =
        Bearings { heading: Some(Radians(0.0)), way: Metres::ZERO, aside: Metres::ZERO };

    /// A drone that has flown 15 m east, and so far back again.
    fn back_by(metres: usize) -> Navigator {
        let mut drone = Navigator::new();
        for (rounds, way) in [(300, 0.05), (20 * metres, -0.05)] {
            for _ in 0..rounds {
                let flies = if way > 0.0 { Flies::NoseFirst } else { Flies::Home };
                drone.trail.advance([way, 0.0], Radians(0.0), flies);
            }
        }
        drone.guide(Guide { homing: Homing::Followed, ..Guide::NONE });
        drone
    }

    #[test]
    fn on_old_ground_without_two_walls_the_tail_points_to_the_path() {
        let mut drone = back_by(12);
        for _ in 0..10 {
            drone.trail.advance([0.0, 0.1], Radians(0.0), Flies::Home);
        }
        let off = |drone: &Navigator, walls| drone.off_home(walls, None, &EAST, BACK);
        let right = off(&drone, Walls::Neither).expect("the path leads");
        assert!((0.5..1.0).contains(&right), "the tail turns to the right: {right}");
        assert_eq!(off(&drone, Walls::Both), None);
        assert_eq!(drone.off_home(Walls::Neither, None, &EAST, MetresPerSecond(0.2)), None);
        assert_eq!(drone.off_home(Walls::Neither, None, &Bearings::default(), BACK), None);
        drone.guide(Guide::NONE);
        assert_eq!(off(&drone, Walls::Neither), None);
        assert_eq!(off(&back_by(3), Walls::Neither), None, "the path is new there");
    }

    #[test]
    fn at_the_end_of_the_path_the_tail_points_to_it_though_the_nose_was_turned() {
        let mut drone = back_by(0);
        drone.trail.advance([0.0; 2], Radians(2.5), Flies::Home);
        drone.trail.face();
        let off = drone.off_home(Walls::Neither, Some(0.0), &EAST, BACK).expect("the path leads");
        assert!((-2.6..-2.4).contains(&off), "{off}");
        let farther_back = back_by(5);
        assert_eq!(farther_back.off_home(Walls::Neither, Some(2.5), &EAST, BACK), None);
    }

    #[test]
    fn a_drone_that_waits_beside_its_path_on_the_way_home_keeps_it() {
        let mut drone = back_by(12);
        for _ in 0..15 {
            drone.trail.advance([0.0, 0.1], Radians(0.0), Flies::Home);
        }
        let flies = drone.flies(MetresPerSecond::ZERO);
        drone.trail.advance([0.0; 2], Radians(0.0), flies);
        assert!(drone.trail.knows(-2.0));
    }
}

//! Counts the contacts between drones.

use units::Point2;

/// The largest difference of height at which two drones touch, m: a Crazyflie with guards is 3 cm
/// high, and stands on the ground for a landing drone that is lower than five times that. Ours; a
/// drone that flies at 0.3 m passes over one on the ground without a touch.
const TOUCH_HEIGHT: f32 = 0.15;

/// How often two drones have touched.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    in_air: u32,
    on_ground: u32,
    members: Vec<Member>,
    /// The pairs that touch now, and how.
    touching: Vec<(usize, usize, Touch)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Member {
    at: Point2,
    height: f32,
    /// Whether it has flown in this mission.
    has_flown: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Touch {
    /// Both drones fly.
    InAir,
    /// At least one of them stands on the ground.
    OnGround,
}

impl Touch {
    /// How two members touch, if they do.
    fn of(one: Member, other: Member, least: f32) -> Option<Self> {
        let (dx, dy) = (one.at.x - other.at.x, one.at.y - other.at.y);
        if dx * dx + dy * dy >= least * least {
            return None;
        }
        let is_level = (one.height - other.height).abs() <= TOUCH_HEIGHT;
        if one.height > 0.0 && other.height > 0.0 {
            Some(Self::InAir)
        } else if is_level && (one.has_flown || other.has_flown) {
            Some(Self::OnGround)
        } else {
            None
        }
    }
}

impl Contacts {
    /// How often two flying drones have touched, as seen from above.
    pub(super) const fn in_air(&self) -> u32 {
        self.in_air
    }

    /// How often a drone has touched one that stood on the ground, flying or landed. Drones that
    /// wait where they were put do not touch each other.
    pub(super) const fn on_ground(&self) -> u32 {
        self.on_ground
    }

    /// Takes in where the members are now and how high they fly, 0 on the ground; two that are
    /// nearer than `least` metres touch.
    pub(super) fn look(&mut self, places: impl Iterator<Item = (Point2, f32)>, least: f32) {
        for (n, (at, height)) in places.enumerate() {
            if self.members.len() <= n {
                self.members.push(Member::default());
            }
            let has_flown = self.members[n].has_flown || height > 0.0;
            self.members[n] = Member { at, height, has_flown };
        }
        let Self { in_air, on_ground, members, touching } = self;
        for (a, &one) in members.iter().enumerate() {
            for (b, &other) in members.iter().enumerate().take(a) {
                let touch = Touch::of(one, other, least);
                if touch.is_none() && touching.is_empty() {
                    continue;
                }
                let known = touching.iter().position(|&(c, d, _)| (c, d) == (a, b));
                let before = known.map(|at| touching.swap_remove(at).2);
                touching.extend(touch.map(|touch| (a, b, touch)));
                match (touch, before) {
                    (Some(Touch::InAir), None | Some(Touch::OnGround)) => *in_air += 1,
                    (Some(Touch::OnGround), None) => *on_ground += 1,
                    // Of two that touched in the air one has landed, or nothing has changed.
                    (Some(_), Some(_)) | (None, _) => {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The contacts in the air and on the ground of two drones that are so far apart, and so high,
    /// one moment after the other.
    fn contacts(moments: &[(f32, [f32; 2])]) -> [u32; 2] {
        let mut contacts = Contacts::default();
        for &(x, [here, there]) in moments {
            let places = [(Point2::new(0.0, 0.0), here), (Point2::new(x, 0.0), there)];
            contacts.look(places.into_iter(), 0.2);
        }
        [contacts.in_air(), contacts.on_ground()]
    }

    const UP: f32 = 0.3;

    #[test]
    fn a_contact_counts_once_while_it_lasts() {
        let both = [UP, UP];
        assert_eq!(contacts(&[(1.0, both), (0.1, both), (0.1, both)]), [1, 0]);
        assert_eq!(contacts(&[(0.1, both), (0.3, both), (0.1, both)]), [2, 0], "a second one");
    }

    #[test]
    fn a_drone_that_passes_over_another_does_not_touch_it_and_one_that_lands_on_it_does() {
        assert_eq!(contacts(&[(0.3, [UP, 0.0]), (0.1, [UP, 0.0])]), [0, 0]);
        assert_eq!(contacts(&[(0.1, [UP, 0.0]), (0.1, [0.1, 0.0]), (0.1, [0.0, 0.0])]), [0, 1]);
    }

    #[test]
    fn drones_that_wait_where_they_were_put_do_not_touch() {
        assert_eq!(contacts(&[(0.1, [0.0, 0.0])]), [0, 0]);
        assert_eq!(contacts(&[(1.0, [UP, 0.0]), (0.1, [0.0, 0.0])]), [0, 1], "one has flown");
    }
}

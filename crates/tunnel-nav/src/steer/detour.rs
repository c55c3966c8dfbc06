//! Gets a drone past an obstacle before which it has stood for a while on its way home.

/// A drone stands with less than this part of its speed left: a beam of 0.3 m.
const SLOW: f32 = 0.4;
/// A drone has stood before an obstacle after so many iterations, 3 s. Our own number: a corner that
/// the trail knows takes less.
const STANDS: u8 = 15;
/// The sideways velocity, m/s.
const SIDEWAYS: f32 = 0.1;
/// How far the drone first goes to the side, and how much farther at each turn, m: the corner of a
/// throat, and the drift of the place.
const FIRST: f32 = 0.4;
const MORE: f32 = 0.3;
/// The farthest that it goes, m.
const FARTHEST: f32 = 1.6;
/// A side ends where there is less room than this, m: a little more than the danger distance.
const LEAST_ROOM: f32 = 0.25;

/// The search along an obstacle for the way past it: to the side on which the path is, then to the
/// other, ever farther.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Detour {
    /// For how many iterations the drone has stood, fewer for each in which it did not.
    stood: u8,
    leg: Option<Leg>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    to_left: bool,
    /// The way to the left since take-off at which the search began, m.
    from: f32,
    reach: f32,
}

impl Detour {
    /// A drone that stands nowhere.
    pub(super) const fn new() -> Self {
        Self { stood: 0, leg: None }
    }

    /// Carries out one iteration, in which the part `nearness` of the speed was safe, and returns the
    /// sideways velocity. `aside` is the way to the left since take-off, `off_path` how far the drone is
    /// to the left of its path, and `room` what it sees free to the left and to the right.
    pub(super) fn step(
        &mut self,
        nearness: f32,
        aside: f32,
        off_path: f32,
        room: [f32; 2],
    ) -> Option<f32> {
        let is_blocked = nearness < SLOW;
        self.stood = match is_blocked {
            true => self.stood.saturating_add(1).min(2 * STANDS),
            false => self.stood.saturating_sub(1),
        };
        if self.stood == 0 {
            self.leg = None;
        } else if self.leg.is_none() && self.stood >= STANDS {
            self.leg = Some(Leg { to_left: off_path < 0.0, from: aside, reach: FIRST });
        }
        let leg = self.leg.as_mut()?;
        let [left, right] = room;
        let (gone, room) =
            if leg.to_left { (aside - leg.from, left) } else { (leg.from - aside, right) };
        if gone > leg.reach || room < LEAST_ROOM {
            leg.to_left = !leg.to_left;
            leg.reach = (leg.reach + MORE).min(FARTHEST);
        }
        is_blocked.then_some(if leg.to_left { SIDEWAYS } else { -SIDEWAYS })
    }
}

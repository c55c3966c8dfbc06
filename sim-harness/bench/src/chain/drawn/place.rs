//! Draws a place: legs and bends, widths that change, a hall, dead ends and forks.
//!
//! What is drawn can be flown by a drone with four beams of 2 m that knows no map, if the pilot says
//! which way to take. So a place with a junction, or with a hall whose exit is not straight ahead, has a
//! pilot who chooses a side, and the way on is on that side. What cannot be told by one choice is not
//! drawn: forks to different sides one after the other, but for a dead end that the pilot looks into
//! first.

mod features;
mod legs;

use random::Stream;

use super::plane::{Point, Rectangle, Segment, apart, distance};
use units::Branch;

pub(super) use legs::Legs;

/// What a place has to have room for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// The length of the row in which the drones stand before the base, m.
    pub(super) row_m: f32,
    /// The length of the main gallery is no more than this, m.
    pub(super) longest_m: f32,
    /// The least rock between galleries that do not meet, m.
    pub(super) rock_m: f32,
}

/// What the pilot chooses at junctions and halls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// Nothing.
    None,
    /// The same all the time.
    Always(Branch),
    /// First the dead end, later the way on.
    Changed { first: Branch, then: Branch },
}

impl Choice {
    fn draw(random: &mut Stream) -> Self {
        let side = if random.uniform() < 0.5 { Branch::Left } else { Branch::Right };
        match random.uniform() {
            u if u < 0.50 => Self::None,
            u if u < 0.62 => Self::Always(Branch::Straight),
            u if u < 0.86 => Self::Always(side),
            _ => {
                let other = if side == Branch::Left { Branch::Right } else { Branch::Left };
                Self::Changed { first: other, then: side }
            }
        }
    }

    /// The choice that leads on.
    pub(super) const fn leading(self) -> Option<Branch> {
        match self {
            Self::None => None,
            Self::Always(branch) | Self::Changed { then: branch, .. } => Some(branch),
        }
    }
}

/// A gallery that ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DeadEnd {
    pub(super) line: Segment,
    pub(super) width: f32,
}

impl DeadEnd {
    pub(super) fn length(&self) -> f32 {
        distance(self.line[0], self.line[1])
    }
}

/// A place that was drawn.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The points of the main gallery's centre-line, and its width at each.
    pub(super) main: Vec<(Point, f32)>,
    pub(super) dead_ends: Vec<DeadEnd>,
    pub(super) halls: Vec<Rectangle>,
    pub(super) choice: Choice,
    /// The length along the main gallery of its first bend, m.
    pub(super) first_bend_m: f32,
}

impl Place {
    /// Draws a place; `None` where what was drawn does not fit.
    pub(super) fn draw(random: &mut Stream, wanted: &Wanted) -> Option<Self> {
        let choice = Choice::draw(random);
        let mut legs = Legs::draw(random, wanted, choice)?;
        let dead_ends = features::dead_ends(random, wanted, choice, &legs)?;
        let halls = features::halls(random, wanted, choice, &mut legs, &dead_ends);
        Some(Self {
            first_bend_m: legs.corners.get(1).map_or(0.0, |at| distance(legs.corners[0], *at)),
            main: legs.points,
            dead_ends,
            halls,
            choice,
        })
    }
}

/// A straight piece of a gallery, with half of its largest width and the leg that it belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    line: Segment,
    half: f32,
    leg: usize,
}

impl Piece {
    /// The rock between this piece and another one, m.
    fn rock_to(&self, line: Segment, half: f32) -> f32 {
        apart(self.line, line) - self.half - half
    }
}

/// A number that is uniform between these.
pub(super) fn between(random: &mut Stream, low: f32, high: f32) -> f32 {
    low + (high - low) * random.uniform()
}

//! Notices that a drone that flies tail first, as on its way home, does not come on, and remembers
//! where it has tried to.
//!
//! The place on the path is known by dead reckoning, and at a throat or in a sharp bend the drone may
//! stand before a wall of which its path knows nothing. No wait helps then: it looks round, and flies
//! on into the way that it finds.

use crate::plane::{Vec2, distance};

/// A drone that has not come on for so many iterations has lost its way: 25 s, in which it flies 1.2 m
/// at the least speed, and after which a detour has gone to and fro once. Our own number.
const LOST: u8 = 125;
/// A drone has come on where it is so much farther from where it was, m: a turn to and fro before a wall
/// takes less.
const COME_ON: f32 = 0.6;
/// A drone that slides to and fro along the end of a dead end comes no farther than this, m: half of the
/// widest gallery, and as much again.
const SLIDES: f32 = 2.5;
/// The way that it tried last counts as tried up to this distance from there, m.
const NEARBY: f32 = 2.0;

/// How long a drone that flies tail first has not come on, and what it has tried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lost {
    /// Where it was when it had last come on by [`SLIDES`], by dead reckoning, m.
    from: Vec2,
    /// The farthest from there that counted as having come on, m.
    farthest: f32,
    /// The iterations in which it has flown since then, less those in which it has not.
    idle: u8,
    /// Where it last looked round, and the heading of the way that it took from there, rad.
    tried: Option<(Vec2, f32)>,
}

impl Lost {
    /// A drone that has come on.
    pub(super) const fn new() -> Self {
        Self { from: [0.0; 2], farthest: 0.0, idle: 0, tried: None }
    }

    /// Carries out one iteration of a drone at `at` that `flies` tail first, or does not, and returns
    /// whether it has lost its way.
    pub(super) fn step(&mut self, at: Vec2, flies: bool) -> bool {
        let gone = distance(at, self.from);
        if gone > SLIDES {
            (self.from, self.farthest, self.idle) = (at, 0.0, 0);
        } else if gone > self.farthest + COME_ON {
            (self.farthest, self.idle) = (gone, 0);
        }
        // In a round without flight the drone has not come on, and has not tried to either.
        self.idle =
            if flies { self.idle.saturating_add(1).min(LOST) } else { self.idle.saturating_sub(1) };
        self.idle == LOST
    }

    /// The heading of the way that the drone has tried here, rad.
    pub(super) fn tried(&self, at: Vec2) -> Option<f32> {
        self.tried.filter(|(there, _)| distance(at, *there) < NEARBY).map(|(_, heading)| heading)
    }

    /// Notes that a drone at `at` takes the way with this heading, rad.
    pub(super) const fn take(&mut self, at: Vec2, heading: f32) {
        *self = Self { from: at, farthest: 0.0, idle: 0, tried: Some((at, heading)) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drone_has_lost_its_way_that_trembles_but_not_one_that_creeps_on_or_waits() {
        let lost = |at: fn(u32) -> Vec2, flies: fn(u32) -> bool| {
            let mut lost = Lost::new();
            (0..600).find(|round| lost.step(at(*round), flies(*round)))
        };
        let trembles = |round: u32| [0.2 * (round % 3) as f32, 0.0];
        let slides = |round: u32| [0.0, 0.05 * (round % 80).min(80 - round % 80) as f32];
        assert!(lost(slides, |_| true).is_some(), "to and fro over 2 m along a dead end");
        assert_eq!(lost(trembles, |_| true), Some(u32::from(LOST) - 1));
        assert_eq!(lost(|round| [0.01 * round as f32, 0.0], |_| true), None);
        assert!(
            lost(trembles, |round| round % 50 != 0).is_some(),
            "stopped for a moment now and then"
        );
        assert_eq!(lost(trembles, |round| round % 2 == 0), None, "waits half of the time");
        assert_eq!(lost(trembles, |round| round % 300 < 100), None, "waits longer than it flies");
    }

    #[test]
    fn a_way_counts_as_tried_near_the_place_where_the_drone_took_it() {
        let mut lost = Lost::new();
        assert_eq!(lost.tried([0.0; 2]), None);
        lost.take([0.0; 2], 1.5);
        assert_eq!(lost.tried([0.5, 0.5]), Some(1.5));
        assert_eq!(lost.tried([5.0, 0.0]), None);
    }
}

//! Lays out the compact formations of section 4.2 of the paper, and gives each drone its place.

use units::{Metres, Point2};

use crate::Config;
use crate::geometry::{along, left_of, moved};

/// The narrow way between two areas, as far as a drone knows of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The middle of the entrance.
    pub entrance: Point2,
    /// The width of the entrance.
    pub width: Metres,
    /// The direction of the second area, as a vector of 1 m.
    pub way: Point2,
    /// The distance from the entrance to the second area, along [`Passage::way`].
    pub length: Metres,
}

impl Passage {
    /// Returns the length of the way from `here` to `home`, which lies on this side of the passage: the
    /// straight line, or the one through the entrance for a drone that is in the passage or behind it.
    #[must_use]
    pub fn way_home(&self, here: Point2, home: Point2) -> Metres {
        match along(self.way, self.entrance, here) > 0.0 {
            true => Metres(here.distance(self.entrance).0 + self.entrance.distance(home).0),
            false => here.distance(home),
        }
    }

    /// Returns the four corners of the passage, in metres, in order around it: those of the entrance, left and
    /// right as seen along [`Passage::way`], are the first and the last.
    #[must_use]
    pub fn corners(&self) -> [Point2; 4] {
        let Self { entrance, width, way, length } = *self;
        let half = 0.5 * width.0;
        let beside = |at, left| moved(at, left_of(way), left);
        let exit = moved(entrance, way, length.0);
        [beside(entrance, half), beside(exit, half), beside(exit, -half), beside(entrance, -half)]
    }
}

/// A compact formation. Neighbours in it are D_int apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formation {
    /// One drone behind the other, a in the paper's figure 7.
    Queue,
    /// Two staggered rows, b in figure 7.
    TwoRows,
    /// Three staggered rows, c in figure 7: one drone, two abreast, one, two.
    ThreeRows,
}

impl Formation {
    /// Returns the formation of `drones` drones for a passage that is `width` wide at its entrance
    /// (section 4.2 of the paper). Three drones never form three rows: they would be a path, which
    /// the loss of one link cuts, and two rows make a triangle of them.
    #[must_use]
    pub fn fit(config: &Config, width: Metres, drones: u16) -> Self {
        let (safe, wanted) = (config.safety_distance().0, config.wanted_distance().0);
        let room = (width.0 - 2.0 * safe) / (0.5 * SQRT_3 * wanted);
        match room {
            _ if room > 2.0 && drones != 3 => Self::ThreeRows,
            _ if room > 1.0 => Self::TwoRows,
            _ => Self::Queue,
        }
    }

    /// Returns place number `index` (from 0) before the passage. The first is half of D_int from
    /// the entrance.
    #[must_use]
    pub fn place(self, config: &Config, passage: &Passage, index: u16) -> Point2 {
        let wanted = config.distance_in(self).0;
        let number = f32::from(index);
        // How far behind the first place, and how far to the left, in units of D_int.
        let (behind, left) = match self {
            Self::Queue => (number, 0.0),
            Self::TwoRows => {
                (0.5 * number, if index.is_multiple_of(2) { 0.25 } else { -0.25 } * SQRT_3)
            }
            Self::ThreeRows => {
                let triple = f32::from(index / 3);
                match index % 3 {
                    0 => (triple, 0.0),
                    1 => (triple + 0.5, 0.5 * SQRT_3),
                    _ => (triple + 0.5, -0.5 * SQRT_3),
                }
            }
        };
        let middle = moved(passage.entrance, passage.way, -(0.5 + behind) * wanted);
        moved(middle, left_of(passage.way), left * wanted)
    }
}

const SQRT_3: f32 = 1.732_050_8;

/// Returns the place for the drone number `me` of those that begin at `starts`, after exchanges of two
/// that shorten the sum of the squared ways, from places in the order of the numbers. Every drone that
/// knows the same starts and the same places comes to the same result. There are at most `N` drones,
/// and at most `N` passes over all pairs; every exchange shortens the sum, so any pass leaves a valid
/// result.
#[must_use]
pub(crate) fn exchanged<const N: usize>(
    me: u16,
    starts: impl Iterator<Item = Point2>,
    place: impl Fn(u16) -> Point2,
) -> u16 {
    let mut ways = [Way::default(); N];
    let mut drones = 0;
    for ((way, start), index) in ways.iter_mut().zip(starts).zip(0..) {
        *way = Way { start, end: place(index), place: index };
        drones += 1;
    }
    let ways = ways.get_mut(..drones).unwrap_or_default();
    for _ in 0..N {
        let mut better = false;
        let mut rest = &mut *ways;
        while let Some((one, others)) = rest.split_first_mut() {
            for other in &mut *others {
                better |= one.exchange(other);
            }
            rest = others;
        }
        if !better {
            break;
        }
    }
    ways.get(usize::from(me)).map_or(me, |way| way.place)
}

/// The way of a drone to the place that it has so far.
#[derive(Clone, Copy, Default)]
struct Way {
    start: Point2,
    end: Point2,
    place: u16,
}

impl Way {
    /// Exchanges the places of two drones where that makes the sum of their squared ways shorter by
    /// more than a thousandth of a square metre, so that rounding never exchanges for ever. With
    /// starts a, b and places p, q the sum becomes longer by 2 (a − b)·(p − q).
    fn exchange(&mut self, other: &mut Self) -> bool {
        let (start, end) =
            (Self::between(self.start, other.start), Self::between(self.end, other.end));
        let shortens = start.x * end.x + start.y * end.y < -0.5e-3;
        if shortens {
            core::mem::swap(&mut self.end, &mut other.end);
            core::mem::swap(&mut self.place, &mut other.place);
        }
        shortens
    }

    /// The vector from `from` to `to`.
    fn between(from: Point2, to: Point2) -> Point2 {
        Point2::new(to.x - from.x, to.y - from.y)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const PASSAGE: Passage = Passage {
        entrance: Point2::new(3.0, 1.0),
        width: Metres(1.51),
        way: Point2::new(0.0, 1.0),
        length: Metres(6.0),
    };

    #[test]
    fn the_corners_of_a_passage_go_around_it() {
        let corners = [(2.0, 1.0), (2.0, 7.0), (4.0, 7.0), (4.0, 1.0)];
        let passage = Passage { width: Metres(2.0), ..PASSAGE };
        assert_eq!(passage.corners(), corners.map(|(x, y)| Point2::new(x, y)));
    }

    #[test]
    fn the_widths_choose_the_formation() {
        let fit = |width, drones| Formation::fit(&Config::PAPER, Metres(width), drones);
        assert_eq!(fit(0.95, 6), Formation::Queue);
        assert_eq!(fit(1.51, 6), Formation::TwoRows);
        assert_eq!(fit(2.26, 6), Formation::ThreeRows);
        assert_eq!(fit(2.26, 3), Formation::TwoRows);
    }

    #[test]
    fn neighbours_are_d_int_apart_and_two_links_hold_every_drone_of_a_staggered_formation() {
        for formation in [Formation::Queue, Formation::TwoRows, Formation::ThreeRows] {
            let place = |index| formation.place(&Config::PAPER, &PASSAGE, index);
            for one in 0..24 {
                let gaps = (0..24).filter(|other| *other != one);
                let gaps = gaps.map(|other| place(one).distance(place(other)).0);
                let least = gaps.clone().fold(f32::INFINITY, f32::min);
                assert!((least - 0.75).abs() < 1e-4, "{formation:?} {one}: {least}");
                let links = gaps.filter(|gap| *gap < 1.1).count();
                assert!(links >= if formation == Formation::Queue { 1 } else { 2 });
            }
        }
    }

    #[test]
    fn a_queue_of_ours_is_shorter_and_rows_are_not() {
        let gap = |formation: Formation| {
            let [one, other] = [0, 1].map(|index| formation.place(&Config::OURS, &PASSAGE, index));
            one.distance(other).0
        };
        assert!((gap(Formation::Queue) - 0.85 * 0.75).abs() < 1e-5);
        assert!((gap(Formation::TwoRows) - 0.75).abs() < 1e-5);
    }

    #[test]
    fn the_first_place_is_before_the_entrance() {
        let place = Formation::Queue.place(&Config::PAPER, &PASSAGE, 0);
        assert!(place.distance(Point2::new(3.0, 0.625)).0 < 1e-5);
    }

    #[test]
    fn exchanges_give_every_drone_another_place_and_shorten_the_ways() {
        let starts = || (0_u16..9).map(|index| Point2::new(f32::from(index), 0.0));
        let place = |index: u16| Point2::new(8.0 - f32::from(index), 3.0);
        let mut taken: Vec<_> = (0..9).map(|me| exchanged::<16>(me, starts(), place)).collect();
        assert_eq!(taken, (0..9).rev().collect::<Vec<_>>());
        taken.sort_unstable();
        assert_eq!(taken, (0..9).collect::<Vec<_>>());
    }
}

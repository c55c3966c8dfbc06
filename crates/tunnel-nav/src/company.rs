//! Drones that a beam sees in place of a wall.
//!
//! A ranger sees another drone within half a metre. Taken for a wall, that drone would make this one
//! turn away from it, in a wide place right round. The beams alone do not tell a drone from a wall; but
//! while the radio says that another drone is too near, a beam that has become shorter at once has met
//! that drone. The wall behind it is taken to be where it was, and the drone does not fly towards the
//! other one.

use units::Metres;

use crate::{Diagonals, Range};

/// A drone is seen no farther away than this, m: a Crazyflie fills too little of a beam beyond.
const FARTHEST: f32 = 0.55;
/// A beam that meets a drone becomes shorter by more than this within a round, m, and by what the drone
/// has moved: seven standard deviations of a range.
const JUMP: f32 = 0.15;

/// The beams that see a drone, and what they saw before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Company {
    /// The beams in the order NW, NE, SW, SE.
    walls: [Range; 4],
    drones: [bool; 4],
}

impl Default for Company {
    fn default() -> Self {
        Self::new()
    }
}

impl Company {
    pub(crate) const fn new() -> Self {
        Self { walls: [Range::Invalid; 4], drones: [false; 4] }
    }

    /// The ranges of a drone that has moved by so much since the last round, without what is a drone;
    /// `is_near` says whether one is near.
    pub(crate) fn without(
        &mut self,
        ranges: &Diagonals,
        is_near: bool,
        moved: [Metres; 2],
    ) -> Diagonals {
        let moved = moved[0].0.abs() + moved[1].0.abs();
        let Diagonals { nw, ne, sw, se } = *ranges;
        let beams = self.walls.iter_mut().zip(&mut self.drones);
        for ((wall, drone), now) in beams.zip([nw, ne, sw, se]) {
            let is_short = now.length().is_some_and(|now| now < FARTHEST);
            let before = match *wall {
                Range::Clear => f32::INFINITY,
                // Nothing is known of the wall.
                Range::Invalid => 0.0,
                Range::At(length) => length.0,
            };
            let jumps = now.length().is_some_and(|now| before - now > JUMP + moved);
            *drone = is_near && is_short && (*drone || jumps);
            if !*drone {
                *wall = now;
            }
        }
        let [nw, ne, sw, se] = self.walls;
        Diagonals { nw, ne, sw, se }
    }

    /// Whether one of the leading beams sees a drone, for a drone that flies at this speed.
    pub(crate) fn is_ahead(&self, speed: f32) -> bool {
        let [nw, ne, sw, se] = self.drones;
        if speed < 0.0 { sw || se } else { nw || ne }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALLS: Diagonals = Diagonals {
        nw: Range::At(Metres(0.9)),
        ne: Range::Clear,
        sw: Range::At(Metres(0.9)),
        se: Range::Clear,
    };
    const STILL: [Metres; 2] = [Metres(0.0); 2];

    #[test]
    fn a_beam_that_jumps_to_a_drone_keeps_its_wall_while_the_drone_is_near() {
        let mut company = Company::new();
        assert_eq!(company.without(&WALLS, true, STILL), WALLS);
        for distance in [0.45, 0.4, 0.3, 0.5] {
            let ranges = Diagonals { ne: Range::At(Metres(distance)), ..WALLS };
            assert_eq!(company.without(&ranges, true, STILL), WALLS, "{distance}");
            assert!(company.is_ahead(0.2) && !company.is_ahead(-0.2));
        }
        let ranges = Diagonals { ne: Range::At(Metres(0.5)), ..WALLS };
        assert_eq!(company.without(&ranges, false, STILL), ranges, "the radio says no drone");
        assert!(!company.is_ahead(0.2));
    }

    #[test]
    fn a_wall_that_comes_nearer_is_no_drone() {
        let mut company = Company::new();
        for round in 0..30 {
            let ranges = Diagonals { nw: Range::At(Metres(0.9 - 0.02 * round as f32)), ..WALLS };
            assert_eq!(company.without(&ranges, true, [Metres(0.02), Metres(0.0)]), ranges);
            assert!(!company.is_ahead(0.2));
        }
    }
}

//! The step to one side with which a drone of a chain ends its way home.
//!
//! Drones land in a row along the gallery, and two odometers and a signal tell how far the next one is
//! behind to some 0.2 m, at times to less than the drones must be apart. Even and odd drones therefore
//! step to opposite sides of the middle before they come down: two neighbours of the row are then apart
//! by both steps, wherever they stand along it.

use core::f32::consts::FRAC_1_SQRT_2;

use tunnel_nav::{Diagonals, NavCommand, Range};
use units::{Duration, Metres, MetresPerSecond, NodeId};

/// The length of the step: two neighbours are apart by 0.3 m across, more than the 0.25 m of two radii,
/// propeller guards and a hand's breadth.
const STEP: Metres = Metres(0.15);
/// The velocity of the step, that of the way home.
const PACE: MetresPerSecond = MetresPerSecond(0.2);
/// The wall at that side is left so far away, by its beams across: the drone's guard and half a step.
const ROOM: Metres = Metres(0.25);
/// The drone steps aside and has come to rest after this long, before it descends: three time constants of
/// the velocity loop beside the step.
pub(crate) const LASTS: Duration = Duration::from_millis(1600);

/// The command of a drone that began to land this long ago.
pub(crate) fn command(id: NodeId, elapsed: Duration, ranges: &Diagonals) -> NavCommand {
    let is_left = id.0.is_multiple_of(2);
    let [front, back] = if is_left { [ranges.nw, ranges.sw] } else { [ranges.ne, ranges.se] };
    // The beams look out at 45 degrees.
    let across = |beam: Range| match beam {
        Range::Clear => true,
        Range::At(length) => length.0 * FRAC_1_SQRT_2 > ROOM.0,
        Range::Invalid => false,
    };
    let is_stepping = elapsed.as_secs_f32() * PACE.0 < STEP.0;
    if !is_stepping || !across(front) || !across(back) {
        return NavCommand::STILL;
    }
    let lateral = if is_left { PACE } else { -PACE };
    NavCommand { lateral, ..NavCommand::STILL }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: Range = Range::At(Metres(0.5));
    const GALLERY: Diagonals = Diagonals { nw: WALL, ne: WALL, sw: WALL, se: WALL };

    fn lateral(id: u8, seconds: f32, ranges: &Diagonals) -> f32 {
        command(NodeId(id), Duration::from_millis((seconds * 1000.0) as u64), ranges).lateral.0
    }

    #[test]
    fn neighbours_of_the_row_step_to_opposite_sides_and_then_stay() {
        for (id, pace) in [(0, PACE.0), (1, -PACE.0), (2, PACE.0)] {
            assert_eq!([0.0, 0.6].map(|at| lateral(id, at, &GALLERY)), [pace; 2]);
            assert_eq!([0.8, 1.5].map(|at| lateral(id, at, &GALLERY)), [0.0; 2]);
        }
    }

    #[test]
    fn no_drone_steps_to_a_wall_nor_where_it_does_not_see() {
        let near = Range::At(Metres(0.35));
        for beam in [near, Range::Invalid] {
            let left = [Diagonals { nw: beam, ..GALLERY }, Diagonals { sw: beam, ..GALLERY }];
            assert_eq!(left.map(|ranges| lateral(0, 0.0, &ranges)), [0.0; 2]);
            assert_eq!(left.map(|ranges| lateral(1, 0.0, &ranges)), [-PACE.0; 2]);
        }
        let hall = Diagonals { nw: Range::Clear, sw: Range::Clear, ..GALLERY };
        assert_eq!(lateral(0, 0.0, &hall), PACE.0);
    }
}

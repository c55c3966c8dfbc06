//! Keeps a drone that explores off what its side beams hit, wherever its map has walls.

use tunnel_nav::{Diagonals, Range};
use units::Radians;

use core::f32::consts::FRAC_PI_4;

/// The least length of a beam towards which a drone flies, m. A wall across two beams is then 0.25 m
/// off: the 0.2 m that a way keeps, and half a cell of the map. Our own number.
const CLEARANCE: f32 = 0.35;
/// The time in which a drone may use up what a beam is longer than that, s: a round of 0.2 s, and the
/// 0.3 s by which a drone lags behind its set-point in the simulator. Our own number.
const LAG: f32 = 0.5;

/// The velocity, to the east and to the north in m/s, that a drone with its nose at `yaw` flies in
/// place of `wanted`: along each beam no faster than its length allows, and back from what is nearer
/// than the clearance. Opposite beams with obstacles that are both too near keep the drone in the
/// middle. `speed` bounds the way back.
pub(super) fn off_walls(
    wanted: [f32; 2],
    yaw: Radians,
    ranges: &Diagonals,
    speed: f32,
) -> [f32; 2] {
    let Diagonals { nw, ne, sw, se } = *ranges;
    // The two lines along which the beams lie are at right angles to each other.
    let along = |eighths: f32, ahead: Range, behind: Range| {
        let (sin, cos) = Radians(yaw.0 + eighths * FRAC_PI_4).sin_cos();
        let component = wanted[0] * cos + wanted[1] * sin;
        let allowed = bounded(component, room(ahead), room(behind)).max(-speed).min(speed);
        [allowed * cos, allowed * sin]
    };
    let [one, other] = [along(1.0, nw, se), along(-1.0, ne, sw)];
    [one[0] + other[0], one[1] + other[1]]
}

/// How much longer than the clearance a beam is, m; negative where it is shorter.
fn room(range: Range) -> f32 {
    match range {
        Range::At(distance) => distance.0 - CLEARANCE,
        Range::Clear | Range::Invalid => f32::INFINITY,
    }
}

/// A velocity along a line on which there is so much room ahead and behind.
fn bounded(wanted: f32, ahead: f32, behind: f32) -> f32 {
    if ahead + behind < 0.0 {
        return (ahead - behind) / (2.0 * LAG);
    }
    wanted.min(ahead / LAG).max(-behind / LAG)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use units::Metres;

    use super::*;

    const SPEED: f32 = 0.3;

    fn any_range() -> impl Strategy<Value = Range> {
        prop_oneof![
            (0.0_f32..4.0).prop_map(|metres| Range::At(Metres(metres))),
            Just(Range::Clear),
            Just(Range::Invalid),
        ]
    }

    fn component([east, north]: [f32; 2], yaw: f32, eighths: f32) -> f32 {
        let (sin, cos) = Radians(yaw + eighths * FRAC_PI_4).sin_cos();
        east * cos + north * sin
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// What a drone flies uses up no beam within the lag, unless it is between two near obstacles.
        #[test]
        fn no_beam_is_used_up(
            [nw, ne, sw, se] in [any_range(), any_range(), any_range(), any_range()],
            yaw in -3.1_f32..3.1,
            wanted in [-0.2_f32..0.2, -0.2_f32..0.2],
        ) {
            let flown = off_walls(wanted, Radians(yaw), &Diagonals { nw, ne, sw, se }, SPEED);
            for (eighths, ahead, behind) in [(1.0, nw, se), (-1.0, ne, sw), (3.0, sw, ne), (-3.0, se, nw)] {
                let along = component(flown, yaw, eighths);
                prop_assert!(along.abs() <= SPEED + 1e-4);
                // A way back is no faster than the drone.
                let most = (room(ahead) / LAG).max(-SPEED);
                if room(ahead) + room(behind) >= 0.0 {
                    prop_assert!(along <= most + 1e-4, "{along} of {most}");
                }
            }
        }

        /// Where there is room, a drone flies as it wants.
        #[test]
        fn where_there_is_room_nothing_changes(
            range in 0.5_f32..4.0,
            yaw in -3.1_f32..3.1,
            wanted in [-0.2_f32..0.2, -0.2_f32..0.2],
        ) {
            let all = Range::At(Metres(range));
            let ranges = Diagonals { nw: all, ne: Range::Clear, sw: Range::Invalid, se: all };
            let flown = off_walls(wanted, Radians(yaw), &ranges, SPEED);
            prop_assert!((flown[0] - wanted[0]).abs() < 1e-4 && (flown[1] - wanted[1]).abs() < 1e-4);
        }
    }
}

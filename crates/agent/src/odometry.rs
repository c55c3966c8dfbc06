//! The drone's position by its own reckoning: how far it has flown along the tunnel, and where it
//! is as seen from its take-off.
//!
//! The way along the tunnel adds up the velocity along the nose, whichever way the nose points: a
//! chain is a line, and its links are as long as the way between two drones. The pose adds up both
//! velocities of the body in the direction of the nose by gyro. Both drift: the optic flow has a
//! scale and a noise, the gyro turns by itself. Nothing but the drone's own sensors corrects them.

use core::f32::consts::TAU;

use tunnel_nav::Bearings;
use units::{Duration, Metres, MetresPerSecond, Point2, Pose2, Radians};

use crate::motion::Motion;
use crate::{BodyVelocity, Inputs};

/// Where a drone is by its own reckoning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reckoning {
    /// The drone's way along the tunnel since take-off.
    pub odometer: Metres,
    /// The drone's pose in the frame of its take-off: x along the nose as it pointed there, y to the
    /// left of that.
    pub pose: Pose2,
}

/// How far a drone's odometer may be off, as one standard deviation: 0.12 m, which it drifts and
/// cuts in the corners near its take-off, and 3 % of the way, the error of the scale of optic flow
/// over a measured height. By simulation at both fidelities: 0.03 to 0.14 m within the first metre,
/// 0.15 to 0.33 m at 8 m, 0.28 to 0.48 m at 15 m and 0.38 to 0.66 m at 28 m.
#[must_use]
pub fn odometer_deviation(odometer: Metres) -> Metres {
    let of_scale = 0.03 * odometer.0;
    Metres(libm::sqrtf(0.12 * 0.12 + of_scale * of_scale))
}

/// Keeps a drone's reckoning.
#[derive(Clone, Debug)]
pub(crate) struct Odometry {
    motion: Motion,
    reckoning: Reckoning,
    /// The way to the left since take-off, in the body axes of each moment.
    aside: Metres,
    /// The heading by gyro that is the direction of x; `None` until there is a heading.
    axis: Option<Radians>,
}

impl Odometry {
    /// A drone that has not moved.
    pub(crate) const fn new() -> Self {
        Self {
            motion: Motion::STILL,
            reckoning: Reckoning {
                odometer: Metres::ZERO,
                pose: Pose2 { at: Point2::new(0.0, 0.0), yaw: Radians::ZERO },
            },
            aside: Metres::ZERO,
            axis: None,
        }
    }

    /// Begins anew where the drone is: it takes off here.
    pub(crate) const fn take_off(&mut self) {
        self.reckoning = Self::new().reckoning;
        self.aside = Metres::ZERO;
        self.axis = None;
    }

    /// Takes a place for the drone's own that it knows better than by its reckoning.
    pub(crate) const fn settle(&mut self, way: Metres) {
        self.reckoning.odometer = way;
    }

    /// Where the drone is.
    pub(crate) const fn reckoning(&self) -> Reckoning {
        self.reckoning
    }

    /// The same, as the navigator needs it.
    pub(crate) const fn bearings(&self, heading: Option<Radians>) -> Bearings {
        Bearings { way: self.reckoning.odometer, aside: self.aside, heading }
    }

    /// Notes the velocity that the drone is told to fly at from now on.
    pub(crate) const fn command(&mut self, forward: MetresPerSecond) {
        self.motion.command(forward);
    }

    /// Takes in `dt` of flight, or of standing on the ground, and returns the drone's own estimate of
    /// its mean velocity along the tunnel meanwhile.
    pub(crate) fn step(
        &mut self,
        inputs: &Inputs<'_>,
        is_airborne: bool,
        dt: Duration,
    ) -> MetresPerSecond {
        let forward = if is_airborne {
            self.motion.step(along_tunnel(inputs.velocity, is_airborne), dt)
        } else {
            self.motion = Motion::STILL;
            MetresPerSecond::ZERO
        };
        let lateral = aside_of_tunnel(inputs.velocity, is_airborne);
        self.reckoning.odometer += forward * dt;
        self.aside += lateral * dt;
        self.turn(inputs.heading, [forward * dt, lateral * dt]);
        forward
    }

    /// Moves the pose by a way forward and to the left, on which the nose has turned to `heading`. A
    /// nose without a heading, or with one that is none, is taken to point where it last did.
    fn turn(&mut self, heading: Option<Radians>, [forward, left]: [Metres; 2]) {
        let Pose2 { at, yaw } = self.reckoning.pose;
        let turned = match heading.filter(|heading| heading.0.abs() <= TAU) {
            Some(heading) => {
                let axis = *self.axis.get_or_insert(heading);
                ((heading - axis).wrapped() - yaw).wrapped()
            }
            None => Radians::ZERO,
        };
        let (sin, cos) = (yaw + turned / 2.0).sin_cos();
        let to = Point2 {
            x: at.x + forward.0 * cos - left.0 * sin,
            y: at.y + forward.0 * sin + left.0 * cos,
        };
        // An absurd velocity of one round must not spoil the rest of the flight.
        let at = if to.is_finite() { to } else { at };
        self.reckoning.pose = Pose2 { at, yaw: (yaw + turned).wrapped() };
    }
}

/// The measured velocity along the tunnel: the drone's nose points along it, so it is the body's own
/// forward velocity. `None` without flow, and on the ground, where the flow sees nothing.
pub(crate) fn along_tunnel(
    velocity: Option<BodyVelocity>,
    is_airborne: bool,
) -> Option<MetresPerSecond> {
    let forward = velocity?.forward;
    (is_airborne && forward.0.is_finite()).then_some(forward)
}

/// The drone's velocity to its left. Without flow it is taken to stand still, and on the ground it
/// does.
fn aside_of_tunnel(velocity: Option<BodyVelocity>, is_airborne: bool) -> MetresPerSecond {
    match velocity {
        Some(velocity) if is_airborne && velocity.lateral.0.is_finite() => velocity.lateral,
        _ => MetresPerSecond::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_2, PI};

    use tunnel_nav::{Diagonals, Range};

    use super::*;
    use crate::Fitness;

    const ROUND: Duration = Duration::from_millis(200);
    /// The drone flies at this speed, m/s.
    const SPEED: f32 = 0.5;

    fn inputs(forward: f32, lateral: f32, heading: Option<f32>) -> Inputs<'static> {
        let beam = Range::Clear;
        Inputs {
            ranges: Diagonals { nw: beam, ne: beam, sw: beam, se: beam },
            velocity: Some(BodyVelocity {
                forward: MetresPerSecond(forward),
                lateral: MetresPerSecond(lateral),
            }),
            heading: heading.map(Radians),
            height: Some(Metres(0.3)),
            heard: &[],
            located: None,
            told: &[],
            order: None,
            fitness: Fitness::Fit,
            endurance: None,
        }
    }

    /// A drone that has just taken off and flies at this velocity as it is told to.
    fn flying(forward: f32) -> Odometry {
        let mut odometry = Odometry::new();
        odometry.command(MetresPerSecond(forward));
        // The model of the velocity loop has come to its speed.
        odometry.step(&inputs(forward, 0.0, None), true, Duration::from_secs(1));
        odometry.step(&inputs(forward, 0.0, None), true, Duration::from_secs(1));
        odometry.take_off();
        odometry
    }

    fn is_near(pose: Pose2, [x, y, yaw]: [f32; 3]) -> bool {
        let turned = (pose.yaw - Radians(yaw)).wrapped().0.abs();
        pose.at.distance(Point2::new(x, y)) < Metres(0.05) && turned < 0.01
    }

    /// Four legs of two metres with a quarter turn on the spot between them, whatever heading the
    /// gyro begins with.
    #[test]
    fn a_square_comes_back_to_its_beginning() {
        for first in [0.0, 2.0, -3.0, PI] {
            let mut odometry = flying(SPEED);
            for leg in 0..4 {
                let heading = Radians(first + leg as f32 * FRAC_PI_2).wrapped();
                odometry.step(&inputs(SPEED, 0.0, Some(heading.0)), true, Duration::ZERO);
                (0..20).for_each(|_| {
                    odometry.step(&inputs(SPEED, 0.0, Some(heading.0)), true, ROUND);
                });
                if leg == 0 {
                    assert!(is_near(odometry.reckoning().pose, [2.0, 0.0, 0.0]));
                }
                if leg == 1 {
                    assert!(is_near(odometry.reckoning().pose, [2.0, 2.0, FRAC_PI_2]));
                }
            }
            let Reckoning { odometer, pose } = odometry.reckoning();
            assert!(is_near(pose, [0.0, 0.0, 3.0 * FRAC_PI_2]), "{pose:?}");
            assert!((odometer.0 - 8.0).abs() < 0.05, "the way has no direction: {odometer}");
        }
    }

    #[test]
    fn a_drone_that_is_pushed_aside_is_beside_its_line() {
        let mut odometry = flying(0.0);
        (0..50).for_each(|_| {
            odometry.step(&inputs(0.0, 0.1, Some(1.0)), true, ROUND);
        });
        assert!(is_near(odometry.reckoning().pose, [0.0, 1.0, 0.0]));
    }

    /// A nose that turns while the drone flies draws an arc: half a circle of this radius.
    #[test]
    fn an_arc_ends_across_its_circle() {
        let radius = 1.0;
        let rounds = (PI * radius / (SPEED * 0.2)) as u32;
        let turn = SPEED * 0.2 / radius;
        let mut odometry = flying(SPEED);
        odometry.step(&inputs(SPEED, 0.0, Some(0.0)), true, Duration::ZERO);
        for round in 1..=rounds {
            let heading = Radians(turn * round as f32).wrapped();
            odometry.step(&inputs(SPEED, 0.0, Some(heading.0)), true, ROUND);
        }
        let turned = turn * rounds as f32;
        let (sin, cos) = Radians(turned).sin_cos();
        let there = [radius * sin, radius * (1.0 - cos), turned];
        assert!(is_near(odometry.reckoning().pose, there), "{:?}", odometry.reckoning());
    }

    #[test]
    fn a_gap_in_the_heading_is_flown_straight_and_an_absurd_input_moves_nothing() {
        let mut odometry = flying(SPEED);
        odometry.step(&inputs(SPEED, 0.0, Some(1.0)), true, ROUND);
        (0..19).for_each(|_| {
            odometry.step(&inputs(SPEED, 0.0, None), true, ROUND);
        });
        let pose = odometry.reckoning().pose;
        assert!(is_near(pose, [2.0, 0.0, 0.0]), "{pose:?}");
        for absurd in [f32::NAN, f32::INFINITY, 1e30] {
            odometry.step(&inputs(0.0, 0.0, Some(absurd)), true, Duration::ZERO);
            odometry.step(&inputs(0.0, f32::MAX, None), true, Duration::from_secs(4_000));
            assert_eq!(odometry.reckoning().pose, pose);
        }
    }

    #[test]
    fn a_drone_on_the_ground_stands_still() {
        let mut odometry = Odometry::new();
        odometry.step(&inputs(SPEED, SPEED, Some(0.5)), false, ROUND);
        assert_eq!(odometry.reckoning(), Reckoning::default());
    }
}

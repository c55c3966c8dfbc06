//! Distributes the wanted force and torque over four motors, and converts thrust to motor duty.
//!
//! Where the motors cannot give all of it, the torques that keep the drone upright have priority:
//! roll and pitch are kept, the total thrust is changed to make room for them, and yaw gets the
//! rest.

use crate::airframe::Airframe;
use crate::io::Duties;

/// A force along z in N, and torques about x, y and z in N m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    pub(crate) thrust: f32,
    pub(crate) torque: [f32; 3],
}

impl Wrench {
    /// The wrench of these thrusts of the motors, N.
    #[cfg(feature = "replay")]
    pub(crate) fn of(airframe: &Airframe, thrusts: [f32; 4]) -> Self {
        let mut sum = Self::default();
        for (thrust, [roll, pitch, yaw]) in thrusts.into_iter().zip(MIXING) {
            let [x, y, z] = &mut sum.torque;
            sum.thrust += thrust;
            *x += roll * airframe.arm * thrust;
            *y += pitch * airframe.arm * thrust;
            *z += yaw * airframe.torque_per_thrust * thrust;
        }
        sum
    }

    /// This wrench times a factor.
    pub(crate) fn times(&self, factor: f32) -> Self {
        Self { thrust: factor * self.thrust, torque: self.torque.map(|part| factor * part) }
    }
}

/// The duties of the motors, and how much of the wanted wrench they give.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Mix {
    pub(crate) duties: Duties,
    /// The wrench on the body if every motor gives its thrust.
    pub(crate) achieved: Wrench,
    /// Whether more thrust was wanted than the motors give.
    pub(crate) thrust_short: bool,
    /// Whether roll and pitch had to be reduced.
    pub(crate) tilt_short: bool,
    /// Whether yaw had to be reduced.
    pub(crate) yaw_short: bool,
}

impl Mix {
    pub(crate) const OFF: Self = Self {
        duties: Duties::OFF,
        achieved: Wrench { thrust: 0.0, torque: [0.0; 3] },
        thrust_short: false,
        tilt_short: false,
        yaw_short: false,
    };
}

/// Sign of each motor's effect on roll, pitch and yaw: a motor on the right (−y) lowers the left
/// side, one in front (+x) raises the nose, and one that turns counter-clockwise twists the body
/// clockwise.
const MIXING: [[f32; 3]; 4] =
    [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0]];

/// Distributes a wrench over the motors of `airframe`, fed by a battery of `volts`.
pub(crate) fn mix(airframe: &Airframe, wanted: &Wrench, volts: f32) -> Mix {
    let low = airframe.least_thrust;
    let high = airframe.most_thrust.min(airframe.thrust_at(volts)).max(low);

    let lever = 0.25 / airframe.arm;
    let (roll, pitch) = (lever * wanted.torque[0], lever * wanted.torque[1]);
    let tilt = MIXING.map(|[r, p, _]| r * roll + p * pitch);
    let largest = tilt.iter().fold(0.0, |most: f32, part| most.max(part.abs()));
    let half_range = 0.5 * (high - low);
    let tilt_scale = if largest > half_range { half_range / largest } else { 1.0 };
    let tilt = tilt.map(|part| tilt_scale * part);
    let largest = tilt_scale * largest;

    let mean = 0.25 * wanted.thrust;
    let collective = mean.max(low + largest).min(high - largest);

    let yaw = 0.25 * wanted.torque[2] / airframe.torque_per_thrust;
    // The force that every motor can still change by, in the direction that yaw changes it.
    let yaw_room = tilt.iter().zip(MIXING).fold(f32::MAX, |least, (part, [_, _, sign])| {
        let force = collective + part;
        least.min(if sign * yaw > 0.0 { high - force } else { force - low })
    });
    let achieved_yaw = yaw.max(-yaw_room.max(0.0)).min(yaw_room.max(0.0));

    let mut duties = Duties::OFF;
    for ((duty, part), [_, _, sign]) in duties.0.iter_mut().zip(tilt).zip(MIXING) {
        *duty = duty_for(airframe, collective + part + sign * achieved_yaw, volts);
    }
    Mix {
        duties,
        achieved: Wrench {
            thrust: 4.0 * collective,
            torque: [
                tilt_scale * wanted.torque[0],
                tilt_scale * wanted.torque[1],
                4.0 * airframe.torque_per_thrust * achieved_yaw,
            ],
        },
        thrust_short: mean > collective,
        tilt_short: tilt_scale < 1.0,
        yaw_short: achieved_yaw != yaw,
    }
}

/// The fraction of the battery's voltage at which a motor gives this thrust, N.
fn duty_for(airframe: &Airframe, thrust: f32, volts: f32) -> f32 {
    let [c0, c1, c2, c3] = airframe.thrust_curve;
    // Newton's method on the cubic, from the voltage of a hovering Crazyflie (2.5 V). The slope is
    // positive everywhere for both sets of propellers, and four steps are within a millivolt over
    // the whole range (tests).
    let mut at = 2.5;
    for _ in 0..4 {
        let value = c0 + at * (c1 + at * (c2 + at * c3)) - thrust;
        let slope = c1 + at * (2.0 * c2 + 3.0 * at * c3);
        at = (at - value / slope.max(1e-3)).max(0.0).min(5.0);
    }
    if volts > 0.0 { (at / volts).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: [Airframe; 2] = [Airframe::CRAZYFLIE_2_1, Airframe::CRAZYFLIE_2_1_PLUS];

    /// The wrench that these duties give.
    fn wrench(airframe: &Airframe, duties: Duties, volts: f32) -> Wrench {
        let mut sum = Wrench::default();
        for (duty, [r, p, y]) in duties.0.iter().zip(MIXING) {
            let thrust = airframe.thrust_at(duty * volts);
            sum.thrust += thrust;
            sum.torque[0] += r * airframe.arm * thrust;
            sum.torque[1] += p * airframe.arm * thrust;
            sum.torque[2] += y * airframe.torque_per_thrust * thrust;
        }
        sum
    }

    #[test]
    fn a_feasible_wrench_is_given_exactly() {
        for frame in &FRAMES {
            for step in 0..1_000 {
                let part = |prime: i32| ((step * prime) % 201 - 100) as f32 / 100.0;
                let wanted = Wrench {
                    thrust: 4.0 * frame.hover_thrust() * (1.0 + 0.15 * part(17)),
                    torque: [8e-4 * part(31), 8e-4 * part(43), 3e-5 * part(59)],
                };
                let mix = mix(frame, &wanted, 3.7);
                let done = wrench(frame, mix.duties, 3.7);
                assert!((done.thrust - wanted.thrust).abs() < 1e-3, "{wanted:?} {done:?}");
                for (done, wanted) in done.torque.iter().zip(wanted.torque) {
                    assert!((done - wanted).abs() < 2e-6, "{wanted} {done}");
                }
                assert!(!mix.thrust_short && !mix.tilt_short && !mix.yaw_short);
            }
        }
    }

    #[test]
    fn roll_and_pitch_come_before_thrust_and_thrust_before_yaw() {
        let frame = &Airframe::CRAZYFLIE_2_1;
        let wanted = Wrench { thrust: 2.0, torque: [2e-3, 0.0, 1e-3] };
        let mix = mix(frame, &wanted, 3.7);
        let done = wrench(frame, mix.duties, 3.7);
        assert!(mix.thrust_short && mix.yaw_short && !mix.tilt_short);
        assert!((done.torque[0] - 2e-3).abs() < 1e-5, "{done:?}");
        assert!(done.torque[2] < 1e-3);
        assert_eq!(mix.achieved.torque[0], 2e-3);
    }

    #[test]
    fn any_wrench_and_battery_give_duties_from_0_to_1() {
        let values = [0.0, -1.0, 1.0, 1e9, -1e9, f32::NAN, f32::INFINITY, 1e-12];
        for thrust in values {
            for torque in values {
                for volts in [0.0, 1.0, 3.0, 4.2, f32::NAN, -1.0] {
                    let wanted = Wrench { thrust, torque: [torque; 3] };
                    for duty in mix(&FRAMES[0], &wanted, volts).duties.0 {
                        assert!((0.0..=1.0).contains(&duty), "{wanted:?} at {volts} V: {duty}");
                    }
                }
            }
        }
    }
}

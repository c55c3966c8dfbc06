//! From a wanted force and torque to four motors: who pushes how much, and which part of the
//! battery's voltage that takes.
//!
//! Where the motors cannot do all of it, what keeps the drone upright comes first: roll and pitch
//! keep their part, the total thrust moves to make room for them, and yaw gets what is left.

use crate::airframe::Airframe;
use crate::io::Duties;

/// What the controllers ask of the propellers: newtons along z, newton metres about x, y and z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    pub(crate) thrust: f32,
    pub(crate) torque: [f32; 3],
}

/// What the motors can give of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Mix {
    pub(crate) duties: Duties,
    /// What this does to the body, if every motor does its part.
    pub(crate) given: Wrench,
    /// More thrust was wanted than there is.
    pub(crate) thrust_short: bool,
    /// Roll or pitch had to be cut.
    pub(crate) tilt_short: bool,
    /// Yaw had to be cut.
    pub(crate) yaw_short: bool,
}

impl Mix {
    pub(crate) const OFF: Self = Self {
        duties: Duties::OFF,
        given: Wrench { thrust: 0.0, torque: [0.0; 3] },
        thrust_short: false,
        tilt_short: false,
        yaw_short: false,
    };
}

/// Share of a roll, pitch and yaw torque that each motor takes, by sign: a motor on the right
/// (−y) lowers the left side, one in front (+x) raises the nose, one that turns counter-clockwise
/// twists the body clockwise.
const SIGNS: [[f32; 3]; 4] =
    [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0]];

/// Distributes a wrench over the motors of `airframe`, fed by a battery of `volts`.
pub(crate) fn mix(airframe: &Airframe, wanted: &Wrench, volts: f32) -> Mix {
    let low = airframe.least_thrust;
    let high = airframe.most_thrust.min(airframe.thrust_at(volts)).max(low);

    let lever = 0.25 / airframe.arm;
    let (roll, pitch) = (lever * wanted.torque[0], lever * wanted.torque[1]);
    let tilt = SIGNS.map(|[r, p, _]| r * roll + p * pitch);
    let reach = tilt.iter().fold(0.0, |most: f32, part| most.max(part.abs()));
    let room = 0.5 * (high - low);
    let cut = if reach > room { room / reach } else { 1.0 };
    let tilt = tilt.map(|part| cut * part);
    let reach = cut * reach;

    let mean = 0.25 * wanted.thrust;
    let level = mean.max(low + reach).min(high - reach);

    let yaw = 0.25 * wanted.torque[2] / airframe.torque_per_thrust;
    // Each motor's room in the direction that yaw pushes it.
    let spare = tilt.iter().zip(SIGNS).fold(f32::MAX, |least, (part, [_, _, sign])| {
        let force = level + part;
        least.min(if sign * yaw > 0.0 { high - force } else { force - low })
    });
    let given_yaw = yaw.max(-spare.max(0.0)).min(spare.max(0.0));

    let mut duties = Duties::OFF;
    for ((duty, part), [_, _, sign]) in duties.0.iter_mut().zip(tilt).zip(SIGNS) {
        *duty = duty_for(airframe, level + part + sign * given_yaw, volts);
    }
    Mix {
        duties,
        given: Wrench {
            thrust: 4.0 * level,
            torque: [
                cut * wanted.torque[0],
                cut * wanted.torque[1],
                4.0 * airframe.torque_per_thrust * given_yaw,
            ],
        },
        thrust_short: mean > level,
        tilt_short: cut < 1.0,
        yaw_short: given_yaw != yaw,
    }
}

/// The part of the battery's voltage that makes a motor give this thrust.
fn duty_for(airframe: &Airframe, thrust: f32, volts: f32) -> f32 {
    let [c0, c1, c2, c3] = airframe.thrust_curve;
    // Newton's method on the cubic, from the voltage of a hovering Crazyflie (2.5 V). Its slope is
    // positive everywhere for both sets of propellers; four steps are within a millivolt over the
    // whole range (tests).
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

    /// Force and torques that the thrust of each motor makes.
    fn wrench(airframe: &Airframe, duties: Duties, volts: f32) -> Wrench {
        let mut sum = Wrench::default();
        for (duty, [r, p, y]) in duties.0.iter().zip(SIGNS) {
            let thrust = airframe.thrust_at(duty * volts);
            sum.thrust += thrust;
            sum.torque[0] += r * airframe.arm * thrust;
            sum.torque[1] += p * airframe.arm * thrust;
            sum.torque[2] += y * airframe.torque_per_thrust * thrust;
        }
        sum
    }

    #[test]
    fn what_can_be_done_is_done() {
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
    fn uprightness_comes_before_height_and_height_before_heading() {
        let frame = &Airframe::CRAZYFLIE_2_1;
        let wanted = Wrench { thrust: 2.0, torque: [2e-3, 0.0, 1e-3] };
        let mix = mix(frame, &wanted, 3.7);
        let done = wrench(frame, mix.duties, 3.7);
        assert!(mix.thrust_short && mix.yaw_short && !mix.tilt_short);
        assert!((done.torque[0] - 2e-3).abs() < 1e-5, "{done:?}");
        assert!(done.torque[2] < 1e-3);
        assert_eq!(mix.given.torque[0], 2e-3);
    }

    #[test]
    fn no_wrench_and_no_battery_leads_out_of_the_range() {
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

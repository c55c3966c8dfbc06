//! Couples an emulated board to a body: true values go into the sensors' registers, the motors'
//! duties come from the timers' pins. It works in the same way for any firmware.

use flight::Duties;
use sensors::multi_ranger::Beam;
use sensors::pmw3901::Motion;
use sensors::vl53l1x::Reading;
use virtual_crazyflie::board::{Crazyflie, Flow, Sight};
use virtual_crazyflie::machine::Machine;
use virtual_crazyflie::soc::{Pin, PinOutput};

use crate::craft::outside::{Observed, Wants};

/// Nanoseconds in the millisecond of a craft's step.
const MS: u64 = 1_000_000;

/// The motors' pins, in the order of [`Duties`] (crazyflie-firmware, `motors_def.c`).
const MOTORS: [Pin; 4] = [Pin::new('A', 1), Pin::new('B', 11), Pin::new('A', 15), Pin::new('B', 9)];
/// The side rangers in the order of a craft's beams.
const SIDES: [Beam; 4] = [Beam::Front, Beam::Right, Beam::Back, Beam::Left];

/// Which rangers end a measurement within the next millisecond.
pub fn wants(board: &mut Crazyflie) -> Wants {
    let mut wants = |beam| board.wants_range(beam, MS + MS / 4);
    Wants { down: wants(Beam::Down), sides: SIDES.map(&mut wants) }
}

/// Sets the values that the board's sensors measure from now on.
pub fn show(board: &mut Crazyflie, observed: &Observed) {
    if let (Some(gyro), Some(accel)) = (observed.gyro, observed.accel) {
        board.set_inertia(gyro, accel);
    }
    if let Some(motion) = &observed.flow {
        board.push_flow(ground(motion));
    }
    let sides = SIDES.into_iter().zip(&observed.sides);
    for (beam, reading) in sides.chain([(Beam::Down, &observed.down)]) {
        if let Some(reading) = reading {
            board.set_range(beam, sight(reading));
        }
    }
    if let Some(volts) = observed.volts {
        board.set_battery(volts, false, false);
    }
}

/// The duties of the motors.
pub fn duties(machine: &Machine<Crazyflie>) -> Duties {
    Duties(MOTORS.map(|pin| match machine.output(pin) {
        PinOutput::Pwm { duty, .. } => duty,
        PinOutput::High => 1.0,
        // A gate that is not driven floats; the board's resistor pulls it low.
        PinOutput::Low | PinOutput::Input | PinOutput::Alternate(_) => 0.0,
    }))
}

/// Converts to the axes of the chip.
fn ground(motion: &Motion) -> Flow {
    Flow {
        dx: motion.y.saturating_neg(),
        dy: motion.x.saturating_neg(),
        squal: motion.squal,
        shutter: motion.shutter,
        raw_sum: motion.raw_sum,
        raw_max: motion.raw_max,
        raw_min: motion.raw_min,
    }
}

fn sight(reading: &Reading) -> Sight {
    let Reading { distance, sigma, status, signal, ambient, .. } = *reading;
    Sight { distance, sigma, status, signal, ambient }
}

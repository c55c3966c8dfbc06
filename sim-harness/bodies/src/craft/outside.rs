//! A craft that is flown from outside: by the firmware, in an emulator with its own sensors'
//! registers.
//!
//! Every millisecond has two halves: [`Craft::observe`] gives what the sensors measure, and, once
//! the firmware has computed its motor duties from that, [`Craft::obey`] moves the craft.

use flight::{Duties, Outputs, Status};
use sensors::pmw3901::Motion;
use sensors::vl53l1x::Reading;
use units::{Acceleration, AngularVelocity, Volts};

use super::{Craft, Surroundings};

/// The rangers that are about to finish a measurement: rays are cast for those only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wants {
    pub(crate) down: bool,
    /// The side rangers: front, right, back, left.
    pub(crate) sides: [bool; 4],
}

/// The true values for the sensors.
#[derive(Clone, Copy, Debug)]
pub struct Observed {
    pub(crate) gyro: Option<AngularVelocity>,
    pub(crate) accel: Option<Acceleration>,
    /// The motion of the ground in this millisecond.
    pub(crate) flow: Option<Motion>,
    pub(crate) down: Option<Reading>,
    pub(crate) sides: [Option<Reading>; 4],
    pub(crate) volts: Option<Volts>,
}

impl Craft {
    /// The first half of a millisecond: gives the true values.
    pub fn observe(&mut self, around: Surroundings<'_>, wants: Wants) -> Observed {
        self.now_ms += 1;
        let fault = self.fault();
        let (gyro, accel) = self.sense_inertia();
        self.watch_ground();
        let flow = if self.now_ms.is_multiple_of(super::Flow::PERIOD_MS) {
            self.sense_flow(around, fault)
        } else {
            None
        };
        let down = if wants.down { self.sense_down() } else { None };
        let mut sides = [None; 4];
        for (side, reading) in sides.iter_mut().enumerate() {
            if wants.sides[side] {
                self.sense_side(around, side);
                *reading = self.ranges[side];
            }
        }
        Observed { gyro, accel, flow, down, sides, volts: self.sense_battery() }
    }

    /// The second half: the motors run at these duties; `status` is the firmware's own estimate.
    pub fn obey(&mut self, around: Surroundings<'_>, duties: Duties, status: Option<Status>) {
        let status = status.unwrap_or(self.outputs.status);
        self.outputs = Outputs { duties, status };
        self.move_on(around, self.fault());
    }
}

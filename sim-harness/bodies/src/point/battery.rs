//! The battery of a point: that of a rigid body which hovers for as long as the motors turn.

use agent::Fitness;
use flight::{Airframe, BatteryConfig, Cause};
use units::{Duration, Setpoint, Volts};

use scenario::VehicleSpec;

use super::STEP_S;
use crate::craft::battery::Battery;

/// The lift at hover, N.
const LIFT: f32 = Airframe::CRAZYFLIE_2_1.weight();

/// The battery of a point that explores or flies in a swarm.
#[derive(Clone, Debug)]
pub(super) struct PointBattery(Battery);

impl PointBattery {
    /// A battery with the vehicle's charge and resistance.
    pub(super) fn new(spec: &VehicleSpec) -> Self {
        Self(Battery::aged(spec.charge, spec.battery_ohm))
    }

    /// One physics step under this set-point.
    pub(super) fn advance(&mut self, setpoint: Setpoint) {
        let lift = match setpoint {
            Setpoint::Fly { .. } => LIFT,
            Setpoint::Off | Setpoint::Stop => 0.0,
        };
        self.0.advance_for(lift, STEP_S);
    }

    /// The voltage at its terminals.
    pub(super) fn volts(&self) -> Volts {
        Volts(self.0.volts())
    }

    /// How long it still carries a drone that hovers, until the voltage is critical.
    pub(super) fn endurance(&self) -> Duration {
        let left = self.0.lasts(LIFT, BatteryConfig::DEFAULT.critical);
        // The conversion clamps.
        Duration::from_millis((1e3 * left) as u64)
    }

    /// Whether a drone at that height may fly: as the flight code, it takes off with no less than what the
    /// code asks for, and comes down when the voltage is critical.
    pub(super) fn fitness(&self, height: f32) -> Fitness {
        let BatteryConfig { critical, least_to_fly, .. } = BatteryConfig::DEFAULT;
        if height > 0.0 && self.0.volts() < critical {
            Fitness::Landing(Cause::Battery)
        } else if height == 0.0 && self.0.volts() < least_to_fly {
            Fitness::Unfit
        } else {
            Fitness::Fit
        }
    }
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;

    /// At hover 2.39 A of 900 A s; the voltage is critical with 5.5 % of the charge left: 356 s.
    #[test]
    fn a_full_battery_carries_a_hover_for_six_minutes_and_says_so_before() {
        let mut battery = PointBattery::new(&VehicleSpec::DEFAULT);
        let said = battery.endurance().as_secs_f32();
        let mut flown = 0.0;
        while battery.fitness(0.3) == Fitness::Fit && flown < 1_000.0 {
            battery.advance(Setpoint::hover(Metres(0.3)));
            flown += STEP_S;
        }
        assert!((345.0..370.0).contains(&flown), "{flown} s");
        assert!((said - flown).abs() < 1.0, "{said} s were said, {flown} s flown");
        assert_eq!(battery.fitness(0.3), Fitness::Landing(Cause::Battery));
        assert_eq!(battery.fitness(0.0), Fitness::Unfit);
    }
}

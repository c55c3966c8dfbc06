//! Compares a drone's battery with its way home.

use agent::FlightConfig;
use units::Metres;

use crate::blocks::DroneReport;

/// A drone turns back while its battery lasts for half as much again as the way home takes
/// (`agent`, `FlightConfig::turns_back_below`).
const MARGIN: f32 = 1.5;

/// The time in seconds until a drone that stays where it is turns back by itself, and the whole
/// chain with it; negative where that time is over, `None` where the battery's time is not known.
#[must_use]
pub fn seconds_to_turning_back(report: &DroneReport) -> Option<f32> {
    let FlightConfig { return_speed, reserve, .. } = FlightConfig::DEFAULT;
    let Metres(way) = report.odometer.abs();
    let needed = MARGIN * way / return_speed.0 + reserve.as_secs_f32();
    Some(report.endurance?.as_secs_f32() - needed)
}

#[cfg(test)]
mod tests {
    use units::Duration;

    use super::*;

    #[test]
    fn six_metres_in_a_drone_turns_back_with_65_seconds_left() {
        let report = DroneReport {
            state: 4,
            fault: 0,
            age: Duration::ZERO,
            battery: None,
            endurance: Some(Duration::from_secs(100)),
            back: None,
            odometer: Metres(6.0),
        };
        let spare = seconds_to_turning_back(&report).unwrap();
        assert!((spare - 35.0).abs() < 0.01, "{spare}");
        assert_eq!(seconds_to_turning_back(&DroneReport { endurance: None, ..report }), None);
    }
}
